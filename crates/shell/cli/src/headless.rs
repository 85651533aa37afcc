//! A match in this process, without a clock.

use std::io::Write;

use anyhow::Context;
use maniple_bots::{Bot, bot_seed};
use maniple_game::Loaded;
use maniple_referee::{self as referee, Referee};
use maniple_server::Recording;
use maniple_view::{MatchResult, Seat, Sequenced};

use crate::failure::Failure;

/// Returns the bots of a match: those that are named, then those of the scenario.
pub(crate) fn bots(loaded: &Loaded, names: &[String]) -> Result<Vec<Box<dyn Bot + Send>>, Failure> {
    let names = bot_names(loaded, names)?;
    let seat_bot = |(seat, name): (Seat, &String)| bot(name, loaded.scenario.seed, seat);
    (0..).map(Seat).zip(&names).map(seat_bot).collect()
}

/// Returns the names of the bots of a match: those that are named, then those of the scenario. Each is that of a bot.
pub(crate) fn bot_names(loaded: &Loaded, names: &[String]) -> Result<Vec<String>, Failure> {
    let seats = &loaded.scenario.seats;
    if names.len() > seats.len() {
        return Err(Failure::usage(format!(
            "{} bots for {} seats; name --bot at most once a seat",
            names.len(),
            seats.len()
        )));
    }
    let checked = |name: &String| maniple_bots::make(name, 0).map(|_| name.clone());
    let seat_bot = |(number, default): (usize, Option<&String>)| match (names.get(number), default) {
        (Some(name), _) => {
            checked(name).map_err(|error| Failure::usage(format!("--bot for seat {number}: {error}")))
        }
        (None, Some(name)) => checked(name)
            .with_context(|| format!("{}, seat {number}", scenario_path(loaded)))
            .map_err(Failure::BadInput),
        (None, None) => Err(Failure::usage(format!(
            "{} names no bot for seat {number}; name one with --bot",
            scenario_path(loaded)
        ))),
    };
    seats.iter().map(|start| start.bot.as_ref()).enumerate().map(seat_bot).collect()
}

/// Returns the bot of this name for a seat of a match with this seed.
pub(crate) fn bot(name: &str, seed: u64, seat: Seat) -> Result<Box<dyn Bot + Send>, Failure> {
    maniple_bots::make(name, bot_seed(seed, seat)).map_err(Failure::failed)
}

/// Returns the path of the scenario, which is the first file of a match.
pub(crate) fn scenario_path(loaded: &Loaded) -> &str {
    loaded.files.0.first().map_or("the scenario", |file| &file.path)
}

/// The parts of a cycle of a match in this process.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    /// What bots think.
    Bots,
    /// What is written of the match.
    Recording,
    /// A part of the referee's work.
    Referee(referee::Part),
}

/// Plays a match to its end, from a referee whom nobody has joined yet. The replay goes to `replay`, if one is wanted;
/// `progress` is told the number of cycles played, `done` each part of a cycle when it is done.
pub(crate) fn play<B: Bot>(
    mut referee: Referee,
    bots: &mut [B],
    replay: Option<impl Write>,
    progress: impl Fn(u32),
    mut done: impl FnMut(Part),
) -> Result<MatchResult, Failure> {
    let recording = replay.map(|sink| Recording::begin(referee.loaded(), sink)).transpose();
    let mut recording = recording.map_err(Failure::failed)?;
    for (seat, bot) in (0..).map(Seat).zip(&*bots) {
        referee.handle_join(seat, bot.name()).map_err(Failure::failed)?;
    }
    let rules = referee.rules();
    for (seat, bot) in (0..).map(Seat).zip(&mut *bots) {
        bot.on_start(seat, &rules, referee.terrain());
    }
    let mut sequence = 0;
    loop {
        for (seat, bot) in (0..).map(Seat).zip(&mut *bots) {
            let Some(delta) = referee.take_delta(seat) else { continue };
            let commands = bot.on_cycle(referee.view(seat), &delta);
            let numbered = commands.into_iter().map(|command| {
                sequence += 1;
                Sequenced { seq: sequence, command }
            });
            let batch = numbered.collect();
            referee.handle_commands(seat, delta.cycle, batch).map_err(Failure::failed)?;
        }
        done(Part::Bots);
        let records = referee.take_records();
        if let Some(recording) = &mut recording {
            recording.extend(records).map_err(Failure::failed)?;
        }
        done(Part::Recording);
        progress(referee.cycle().0);
        if let Some(result) = referee.result() {
            recording.map(Recording::finish).transpose().map_err(Failure::failed)?;
            return Ok(result.clone());
        }
        referee.step_by_parts(|part| done(Part::Referee(part)));
    }
}
