//! `maniple match --count`: many matches, with the seats switched, and what they come to.

mod caught;
mod crew;
mod estimate;
mod game;
mod rows;
mod schedule;
mod summary;
mod text;
mod watched;

use std::io::Write;
use std::num::NonZero;
use std::thread;

use anyhow::anyhow;
use maniple_game::Overrides;
use maniple_geometry::Cycle;

use crate::arguments::Match;
use crate::commands::tournament::crew::{Outcome, play_all};
use crate::commands::tournament::game::{Plan, Row};
use crate::commands::tournament::schedule::{Schedule, players};
use crate::commands::tournament::summary::{Summary, Timing, length, of_players, of_seats};
use crate::failure::Failure;
use crate::output::{Format, note, print};
use crate::{files, headless, models, start};

/// Plays `count` matches.
pub(crate) fn run(arguments: &Match, count: u32) -> Result<(), Failure> {
    let asked = Overrides {
        map: start::map_path(arguments.map.as_deref()),
        seed: arguments.seed,
        ..arguments.profile.overrides()?
    };
    let loaded = start::loaded(arguments.scenario.as_deref(), &asked)?;
    let bots = headless::bot_names(&loaded, &arguments.bots)?;
    let schedule = Schedule { seed: loaded.scenario.seed, seats: bots.len() };
    let scenario = loaded.scenario.name.clone();
    note(&models::line(&loaded));
    let csv = arguments.many.csv.as_deref().map(files::create).transpose()?;
    if let Some(folder) = &arguments.many.replays {
        files::make_folder(folder)?;
    }
    let plan = Plan {
        scenario: headless::scenario_path(&loaded).to_owned(),
        files: loaded.files,
        asked,
        cycles_max: arguments.cycles.map(Cycle),
        schedule,
        players: players(&bots),
        bots,
        make: headless::bot,
        replays: arguments.many.replays.clone(),
    };
    let jobs = arguments.many.jobs.unwrap_or_else(processors).min(count);
    let outcome = play_all(plan.clone(), count, jobs)?;
    if let Some(mut file) = csv {
        let written = file.write_all(rows::csv(&outcome.rows, schedule.seats).as_bytes());
        written.and_then(|()| file.flush()).map_err(Failure::failed)?;
    }
    let summary = summary(&plan, scenario, (count, jobs), outcome);
    print(Format::of(&arguments.json), &summary, |summary| text::text(summary, &plan, arguments))?;
    verdict(&summary)
}

fn processors() -> u32 {
    let found = thread::available_parallelism().map_or(1, NonZero::get);
    u32::try_from(found).unwrap_or(u32::MAX)
}

fn summary(plan: &Plan, scenario: String, (count, jobs): (u32, u32), outcome: Outcome) -> Summary {
    let Outcome { rows, is_interrupted, took, creation: (created, longest) } = outcome;
    let of = |is_meant: fn(&&Row) -> bool| {
        u32::try_from(rows.iter().filter(is_meant).count()).expect("matches are counted in 32 bits")
    };
    let (played, failed) = (of(|row| row.failure.is_none()), of(|row| row.failure.is_some()));
    let cycles: u64 = rows.iter().map(|row| u64::from(row.cycles)).sum();
    let seconds = took.as_secs_f64();
    Summary {
        scenario,
        seed: plan.schedule.seed,
        count,
        played,
        failed,
        interrupted: is_interrupted,
        draws: of(|row| row.failure.is_none() && row.is_draw()),
        length: length(&rows),
        players: of_players(&rows, &plan.players),
        seats: of_seats(&rows, plan.schedule.seats),
        timing: Timing {
            jobs,
            seconds,
            matches_per_second: f64::from(played) / seconds,
            cycles_per_second: cycles as f64 / seconds,
            creation_ms_mean: 1e3 * created.as_secs_f64() / rows.len().max(1) as f64,
            creation_ms_max: 1e3 * longest.as_secs_f64(),
        },
        matches: rows,
    }
}

/// Returns how the command ends: matches that could not be played are no success, whatever the others were.
fn verdict(summary: &Summary) -> Result<(), Failure> {
    if summary.interrupted {
        return Err(Failure::Interrupted);
    }
    let first = summary.matches.iter().find_map(|row| row.failure.as_ref().map(|failure| (row, failure)));
    match first {
        None => Ok(()),
        Some((Row { number, seed, .. }, failure)) => Err(Failure::failed(anyhow!(
            "{} of {} matches could not be played; the first is match {number}, seed {seed}: {failure}",
            summary.failed,
            summary.matches.len(),
        ))),
    }
}
