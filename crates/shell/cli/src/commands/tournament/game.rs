//! One match of many.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use maniple_bots::Bot;
use maniple_game::{Files, Overrides, load};
use maniple_geometry::Cycle;
use maniple_view::{ClockMode, Digest, EndReason, MatchResult, Seat};
use serde::Serialize;

use crate::commands::tournament::caught::caught;
use crate::commands::tournament::schedule::{Player, Schedule};
use crate::commands::tournament::watched::{Crash, Watched};
use crate::failure::Failure;
use crate::{files, headless, start};

/// Returns the bot of a name, for a seat of a match with a seed.
pub(super) type Make = fn(name: &str, seed: u64, seat: Seat) -> Result<Box<dyn Bot + Send>, Failure>;

/// What all matches have in common.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    /// Every file that matches are made of, so that no match reads any.
    pub(super) files: Files,
    /// The path of the scenario among them.
    pub(super) scenario: String,
    /// What is asked for instead of what it says; each match has a seed of its own.
    pub(super) asked: Overrides,
    /// `None`: the scenario says how long a match is.
    pub(super) cycles_max: Option<Cycle>,
    pub(super) schedule: Schedule,
    /// The bots, in the order of the players.
    pub(super) bots: Vec<String>,
    pub(super) players: Vec<Player>,
    pub(super) make: Make,
    /// The folder for replays.
    pub(super) replays: Option<PathBuf>,
}

/// How a match went.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Row {
    /// Its number, from 0.
    #[serde(rename = "match")]
    pub(super) number: u32,
    pub(super) seed: u64,
    pub(super) seats: Vec<SeatRow>,
    /// `None` if it could not be played.
    pub(super) reason: Option<EndReason>,
    /// Cycles that were played; 0 if it could not be.
    pub(super) cycles: u32,
    pub(super) hash: Option<Digest>,
    pub(super) replay: Option<String>,
    /// Why it could not be played, or not kept.
    pub(super) failure: Option<String>,
}

/// How a match went for a seat.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct SeatRow {
    pub(super) player: Player,
    pub(super) won: bool,
    pub(super) points: u64,
    pub(super) late: u64,
    pub(super) refused: u64,
    pub(super) crash: Option<Crash>,
}

impl Row {
    pub(super) fn is_draw(&self) -> bool {
        self.seats.iter().all(|seat| !seat.won)
    }
}

/// A match that was played to its end.
struct Played {
    result: MatchResult,
    bots: Vec<Watched>,
    replay: Option<String>,
}

/// Plays a match; `progress` is told of each cycle that was played. Also returns how long it took to make the match.
///
/// Whatever goes wrong is in the row: a match cannot end the others.
pub(super) fn play(plan: &Plan, number: u32, progress: impl Fn()) -> (Row, Duration) {
    let (seed, seating) = (plan.schedule.seed(number), plan.schedule.seating(number));
    let mut creation = Duration::ZERO;
    let played = caught(|| played(plan, number, &progress, &mut creation));
    let mut row = Row {
        number,
        seed,
        seats: seating.iter().map(|&player| SeatRow::new(&plan.players[player])).collect(),
        reason: None,
        cycles: 0,
        hash: None,
        replay: None,
        failure: None,
    };
    match played {
        Ok(Ok(Played { result, bots, replay })) => {
            row.reason = Some(result.reason);
            row.cycles = result.cycles.0;
            row.hash = Some(result.hash);
            row.replay = replay;
            for ((seat, score), bot) in row.seats.iter_mut().zip(&result.scores).zip(bots) {
                seat.won = result.winners.contains(&score.seat);
                seat.points = score.points;
                seat.late = bot.late;
                seat.refused = bot.refused;
                seat.crash = bot.crash;
            }
        }
        Ok(Err(failure)) => row.failure = Some(failure.to_string()),
        Err(panic) => row.failure = Some(format!("Maniple itself panicked, please report it: {panic}")),
    }
    (row, creation)
}

impl SeatRow {
    fn new(player: &Player) -> Self {
        Self { player: player.clone(), won: false, points: 0, late: 0, refused: 0, crash: None }
    }
}

fn played(
    plan: &Plan,
    number: u32,
    progress: &impl Fn(),
    creation: &mut Duration,
) -> Result<Played, Failure> {
    let begun = Instant::now();
    let seed = plan.schedule.seed(number);
    let asked = Overrides { seed: Some(seed), ..plan.asked.clone() };
    let mut loaded = load(&plan.files, &plan.scenario, &asked).map_err(Failure::bad_input)?;
    if let Some(cycles) = plan.cycles_max {
        loaded.limit_cycles(cycles);
    }
    let referee = start::referee(loaded, ClockMode::Lockstep)?;
    *creation = begun.elapsed();
    let seating = plan.schedule.seating(number);
    let bot =
        |(seat, &player): (Seat, &usize)| Ok(Watched::new((plan.make)(&plan.bots[player], seed, seat)?));
    let mut bots = (0..).map(Seat).zip(&seating).map(bot).collect::<Result<Vec<Watched>, Failure>>()?;
    let mut bytes = Vec::new();
    let sink = plan.replays.is_some().then_some(&mut bytes);
    let told = |cycle: u32| {
        if cycle > 0 {
            progress();
        }
    };
    let result = headless::play(referee, &mut bots, sink, told, |_| {})?;
    let mut replay = None;
    if let Some(folder) = &plan.replays {
        // At once, so that an interrupt leaves no half of one.
        let path = folder.join(format!("{seed}-{number}.replay"));
        files::write(&path, &bytes)?;
        replay = Some(path.display().to_string());
    }
    Ok(Played { result, bots, replay })
}
