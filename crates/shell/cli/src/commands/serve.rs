//! `maniple serve`: matches that clients join over TCP.

mod check;

use std::fmt::Write as _;

use anyhow::Context;
use maniple_game::Overrides;
use maniple_game::scenario::{Spectators, Views};
use maniple_server::settings::{Configuration, Settings};
use maniple_server::{Access, Match, Server};
use maniple_view::{ClockMode, Digest, MatchResult, Seat};
use serde::Serialize;

use crate::arguments::{Clock, Serve};
use crate::configuration::failure;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::output::{Format, note, print};
use crate::{files, models, outcome, start};

/// What clients have to know to join a match.
#[derive(Debug, Serialize)]
struct Opened {
    address: String,
    #[serde(rename = "match")]
    id: Digest,
    scenario: String,
    seed: u64,
    clock: ClockMode,
    seats: Vec<OpenSeat>,
    /// What may be watched; null: nothing.
    spectators: Option<Watchable>,
}

/// What spectators may watch.
#[derive(Debug, Serialize)]
struct Watchable {
    /// `seats`, or `all`: everything, too.
    views: &'static str,
    /// Cycles by which they are behind.
    delay: u32,
}

impl Watchable {
    fn of(Spectators { views, delay }: Spectators) -> Self {
        let views = match views {
            Views::Seats => "seats",
            Views::All => "all",
        };
        Self { views, delay }
    }
}

#[derive(Debug, Serialize)]
struct OpenSeat {
    seat: Seat,
    /// 32 hex digits; null for a seat that anybody may take.
    token: Option<String>,
}

impl Opened {
    fn text(&self) -> String {
        let clock = match self.clock {
            ClockMode::Realtime => "realtime",
            ClockMode::Lockstep => "lockstep",
        };
        let mut text = format!("listening {}\n", self.address);
        let _ = write!(text, "match {}: {}, seed {}, {clock}", self.id, self.scenario, self.seed);
        if let Some(Watchable { views, delay }) = &self.spectators {
            let _ = write!(text, "; spectators may watch {views}, {delay} cycles behind");
        }
        text.push('\n');
        for OpenSeat { seat, token } in &self.seats {
            let _ = writeln!(text, "seat {seat} token {}", token.as_deref().unwrap_or("-"));
        }
        text
    }
}

/// How a match ended, as it is printed.
#[derive(Debug, Serialize)]
struct Ended {
    #[serde(rename = "match")]
    id: Digest,
    result: MatchResult,
}

impl Ended {
    fn text(&self) -> String {
        format!("match {}: {}", self.id, summary(&self.result))
    }
}

/// Runs `maniple serve`.
pub(crate) fn run(arguments: &Serve, configuration: &Configuration) -> Result<(), Failure> {
    let settings = configuration.settings().map_err(failure)?;
    if arguments.configuration.print_config {
        return check::print_configuration(arguments, configuration);
    }
    if arguments.configuration.check {
        return check::check(arguments, configuration, &settings);
    }
    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build();
    runtime.map_err(Failure::failed)?.block_on(serve(arguments, &settings))
}

async fn serve(arguments: &Serve, settings: &Settings) -> Result<(), Failure> {
    let interrupt = Interrupt::listen().await;
    let address = settings.listen.address;
    let server = Server::bind(address)
        .with_context(|| format!("cannot listen on {address}"))
        .map_err(Failure::Failed)?;
    let outcome = play(arguments, &server, interrupt).await;
    // Whatever the outcome, the clients have been told something.
    server.wait_closed().await;
    outcome
}

/// Plays one match after the other.
async fn play(arguments: &Serve, server: &Server, mut interrupt: Interrupt) -> Result<(), Failure> {
    let mut seed = arguments.seed;
    let mut access = None;
    loop {
        let (game, next_seed) = prepare(arguments, seed, access.take(), server)?;
        let id = game.id();
        access = Some(game.access().to_vec());
        let result = server.run(game, interrupt.wait()).await.map_err(Failure::failed)?;
        let result = result.ok_or(Failure::Interrupted)?;
        print(Format::of(&arguments.json), &Ended { id, result }, Ended::text)?;
        if arguments.once {
            return Ok(());
        }
        if interrupt.has_come() {
            return Err(Failure::Interrupted);
        }
        seed = Some(next_seed);
    }
}

/// Loads the next match and tells who may join it, with the tokens of the match before if there was one. Also returns
/// the seed of the match after it.
fn prepare(
    arguments: &Serve,
    seed: Option<u64>,
    access: Option<Vec<Access>>,
    server: &Server,
) -> Result<(Match, u64), Failure> {
    let clock = match arguments.clock {
        Clock::Realtime => ClockMode::Realtime,
        Clock::Lockstep => ClockMode::Lockstep,
    };
    let asked =
        Overrides { map: start::map_path(arguments.map.as_deref()), seed, ..arguments.profile.overrides()? };
    let loaded = start::loaded(arguments.scenario.as_deref(), &asked)?;
    note(&models::line(&loaded));
    let (scenario, seed) = (loaded.scenario.name.clone(), loaded.scenario.seed);
    let spectators = loaded.scenario.spectators.map(Watchable::of);
    let referee = start::referee(loaded, clock)?;
    let game = match access {
        Some(access) => Match::new(referee, access),
        None => Match::with_random_tokens(referee),
    };
    let mut game = game.map_err(Failure::failed)?;
    if let Some(path) = &arguments.replay {
        game = game.recorded_to(files::create(path)?);
    }
    let open_seat = |(seat, access): (u16, &Access)| OpenSeat {
        seat: Seat(seat),
        token: match access {
            Access::Open => None,
            Access::Token(token) => Some(token.to_string()),
        },
    };
    let opened = Opened {
        address: server.local_addr().map_err(Failure::failed)?.to_string(),
        id: game.id(),
        scenario,
        seed,
        clock,
        seats: (0..).zip(game.access()).map(open_seat).collect(),
        spectators,
    };
    print(Format::of(&arguments.json), &opened, Opened::text)?;
    Ok((game, seed.wrapping_add(1)))
}

/// Returns how a match ended, in a line.
pub(crate) fn summary(result: &MatchResult) -> String {
    let winners = outcome::winners(&result.winners);
    format!("{winners} after {} cycles, state hash {}\n", result.cycles, result.hash)
}
