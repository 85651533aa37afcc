//! What a match costs, part by part.

use std::fmt::Write as _;
use std::time::{Duration, Instant};

use maniple_game::{self as game, Loaded};
use maniple_kinematics as kinematics;
use maniple_referee as referee;

use crate::headless::Part;
use crate::models;
use crate::output::grouped;

/// The time that each part of a match has taken.
pub(crate) struct Costs {
    since: Instant,
    /// In the order in which the parts first came.
    parts: Vec<(Part, Duration)>,
}

/// A line of the table: what is modelled, how, and the time, where it has one of its own.
struct Row {
    name: &'static str,
    how: String,
    time: Option<Duration>,
}

impl Costs {
    /// Returns the costs of a match that begins now.
    pub(crate) fn begin() -> Self {
        Self { since: Instant::now(), parts: Vec::new() }
    }

    /// Takes that a part is done that began when the one before was.
    pub(crate) fn done(&mut self, part: Part) {
        let now = Instant::now();
        let time = now - self.since;
        self.since = now;
        match self.parts.iter_mut().find(|(known, _)| *known == part) {
            Some((_, sum)) => *sum += time,
            None => self.parts.push((part, time)),
        }
    }

    /// Returns the table of what a match models and what that costs a cycle.
    pub(crate) fn table(&self, loaded: &Loaded, cycles: u32) -> String {
        let total: Duration = self.parts.iter().map(|(_, time)| *time).sum();
        let mut text =
            format!("{:<14} {:<44} {:>12} {:>7}\n", "part", "what is modelled", "ns a cycle", "share");
        let each = |time: Duration| time.as_nanos() / u128::from(cycles.max(1));
        for Row { name, how, time } in self.rows(loaded) {
            let (cost, share) = match time {
                Some(time) => {
                    let share = 100.0 * time.as_secs_f64() / total.as_secs_f64().max(f64::MIN_POSITIVE);
                    (grouped(u64::try_from(each(time)).unwrap_or(u64::MAX)), format!("{share:.1} %"))
                }
                None => (String::new(), String::new()),
            };
            let line = format!("{name:<14} {how:<44} {cost:>12} {share:>7}");
            let _ = writeln!(text, "{}", line.trim_end());
        }
        let whole = grouped(u64::try_from(each(total)).unwrap_or(u64::MAX));
        let cycles = format!("mean of {} cycles", grouped(u64::from(cycles)));
        let _ = writeln!(text, "{:<14} {cycles:<44} {whole:>12} 100.0 %", "all");
        text
    }

    fn rows(&self, loaded: &Loaded) -> Vec<Row> {
        let profile = &loaded.scenario.profile;
        let row = |name, how: String, time| Row { name, how, time };
        let of = |part: Part| Some(self.of(|known| known == part));
        let world = |part: game::Part| of(Part::Referee(referee::Part::World(part)));
        let in_kinematics =
            |part: Part| matches!(part, Part::Referee(referee::Part::World(game::Part::Kinematics(_))));
        let mut rows = vec![
            row("bots", String::new(), of(Part::Bots)),
            row("commands", String::new(), of(Part::Referee(referee::Part::Commands))),
            row("kinematics", models::kinematics(profile), Some(self.of(in_kinematics))),
        ];
        for part in kinematics::Part::ALL {
            rows.push(row(name(part), String::new(), world(game::Part::Kinematics(part))));
        }
        rows.extend([
            row("  radii", models::radii(loaded), None),
            row("  layers", models::layers(loaded), None),
            row("  walls", models::segments(loaded), None),
            row("tasks", String::new(), world(game::Part::Tasks)),
            row("rules", models::rules(loaded), world(game::Part::Rules)),
            row("sightings", String::new(), world(game::Part::Sightings)),
            row("vision", models::vision(loaded), world(game::Part::Vision)),
            row("views", models::positions(profile), of(Part::Referee(referee::Part::Views))),
            row("result", String::new(), of(Part::Referee(referee::Part::Result))),
            row("recording", String::new(), of(Part::Recording)),
        ]);
        rows
    }

    fn of(&self, is_meant: impl Fn(Part) -> bool) -> Duration {
        self.parts.iter().filter(|(part, _)| is_meant(*part)).map(|(_, time)| *time).sum()
    }
}

fn name(part: kinematics::Part) -> &'static str {
    match part {
        kinematics::Part::Order => "  order",
        kinematics::Part::Spheres => "  spheres",
        kinematics::Part::Sectors => "  sectors",
        kinematics::Part::Graph => "  graph",
        kinematics::Part::Components => "  components",
        kinematics::Part::Queue => "  queue",
        kinematics::Part::Outcome => "  outcome",
    }
}
