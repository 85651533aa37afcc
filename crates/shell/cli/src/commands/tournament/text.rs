//! What all matches come to, for people.

use std::fmt::Write as _;

use crate::arguments::Match;
use crate::commands::tournament::crew::whole;
use crate::commands::tournament::estimate::Spread;
use crate::commands::tournament::game::{Plan, Row};
use crate::commands::tournament::schedule::Player;
use crate::commands::tournament::summary::{Standing, Summary};
use crate::output::grouped;

/// Most crashes, and most failures, that are told one by one; all are in JSON and CSV.
const TOLD_MAX: usize = 10;

/// Returns the tables, what went wrong, and how to look at a match.
pub(super) fn text(summary: &Summary, plan: &Plan, arguments: &Match) -> String {
    let Summary { scenario, seed, count, played, draws, timing, .. } = summary;
    let mut text = format!(
        "{scenario}, from seed {seed}: {} of {} matches played, {} drawn; {} cycles long\n\n",
        grouped(u64::from(*played)),
        grouped(u64::from(*count)),
        grouped(u64::from(*draws)),
        spread(&summary.length),
    );
    let width =
        plan.players.iter().map(|player| player.to_string().chars().count()).max().unwrap_or(0).max(8);
    text += &heading("player", width);
    for standing in &summary.players {
        text += &line(&standing.who.player.to_string(), width, standing);
    }
    text += "\n";
    text += &heading("at seat", width);
    for standing in &summary.seats {
        text += &line(&standing.who.seat.to_string(), width, standing);
    }
    let _ = writeln!(
        text,
        "\n{} cycles a second, {:.1} matches a second with {} jobs; a match is made in {:.2} ms",
        grouped(whole(timing.cycles_per_second)),
        timing.matches_per_second,
        timing.jobs,
        timing.creation_ms_mean,
    );
    let again = Again { plan, arguments };
    text += &crashes(&summary.matches, &again);
    text += &failures(&summary.matches, &again);
    if let Some(row) = summary.matches.first() {
        let _ = writeln!(text, "next: {} --replay match.replay", again.command(row));
    }
    text
}

fn heading(who: &str, width: usize) -> String {
    format!(
        "{who:<width$} {:>7} {:>7} {:>7} {:>8} {:>8} {:>17} {:>20} {:>7} {:>8} {:>8}\n",
        "wins", "draws", "losses", "score", "won", "95 % interval", "points", "crashes", "late", "refused",
    )
}

fn line<Who>(who: &str, width: usize, standing: &Standing<Who>) -> String {
    let percent = |share: f64| format!("{:.1} %", 100.0 * share);
    let share = |share: Option<f64>| share.map_or_else(|| "-".to_owned(), percent);
    let (low, high) = standing.win_rate_interval;
    format!(
        "{who:<width$} {:>7} {:>7} {:>7} {:>8} {:>8} {:>17} {:>20} {:>7} {:>8} {:>8}\n",
        standing.wins,
        standing.draws,
        standing.losses,
        share(standing.score),
        share(standing.win_rate),
        format!("{} - {}", percent(low), percent(high)),
        spread(&standing.points),
        standing.crashes,
        standing.late,
        standing.refused,
    )
}

fn spread(spread: &Spread) -> String {
    match (spread.mean, spread.deviation) {
        (None, _) => "-".to_owned(),
        (Some(mean), None) => format!("{mean:.1}"),
        (Some(mean), Some(deviation)) => format!("{mean:.1} +- {deviation:.1}"),
    }
}

/// The command that plays one of the matches again, alone.
struct Again<'a> {
    plan: &'a Plan,
    arguments: &'a Match,
}

impl Again<'_> {
    fn command(&self, row: &Row) -> String {
        let Match { scenario, map, cycles, profile, .. } = self.arguments;
        let mut command = "maniple match".to_owned();
        if let Some(scenario) = scenario {
            let _ = write!(command, " {}", scenario.display());
        }
        if let Some(map) = map {
            let _ = write!(command, " --map {}", map.display());
        }
        command += &profile.flags();
        if let Some(cycles) = cycles {
            let _ = write!(command, " --cycles {cycles}");
        }
        let _ = write!(command, " --seed {}", row.seed);
        for &player in &self.plan.schedule.seating(row.number) {
            let _ = write!(command, " --bot {}", self.plan.bots[player]);
        }
        command
    }
}

fn crashes(rows: &[Row], again: &Again<'_>) -> String {
    let crashed = rows.iter().flat_map(|row| row.seats.iter().enumerate().map(move |seat| (row, seat)));
    let told = crashed.filter_map(|(row, (place, seat))| {
        let crash = seat.crash.as_ref()?;
        let (number, player, cycle): (u32, &Player, u32) = (row.number, &seat.player, crash.cycle);
        Some(format!(
            "crash: match {number}, {player} at seat {place}, cycle {cycle}: {}\n  again: {}\n",
            crash.message,
            again.command(row),
        ))
    });
    limited(told, "crashes")
}

fn failures(rows: &[Row], again: &Again<'_>) -> String {
    let told = rows.iter().filter_map(|row| {
        let failure = row.failure.as_ref()?;
        Some(format!("not played: match {}: {failure}\n  again: {}\n", row.number, again.command(row)))
    });
    limited(told, "matches that could not be played")
}

/// Returns the first of some texts, and how many more there are.
fn limited(told: impl Iterator<Item = String>, what: &str) -> String {
    let told: Vec<String> = told.collect();
    let mut text: String = told.iter().take(TOLD_MAX).map(String::as_str).collect();
    if told.len() > TOLD_MAX {
        let _ = writeln!(text, "and {} more {what}: see --json or --csv", told.len() - TOLD_MAX);
    }
    text
}
