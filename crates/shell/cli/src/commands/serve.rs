//! `maniple serve`: matches that clients join over TCP.

use std::fmt::Write as _;
use std::path::Path;
use std::thread::available_parallelism;

use anyhow::Context;
use maniple_game::scenario::{Spectators, Views};
use maniple_game::{Loaded, Overrides};
use maniple_server::{Access, House, Journals, Limits, Match, Offer, SYNC_INTERVAL, Server};
use maniple_view::{ClockMode, Digest, MatchResult, Seat};
use serde::Serialize;

use crate::arguments::{Clock, Serve};
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
pub(crate) fn run(arguments: &Serve) -> Result<(), Failure> {
    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build();
    runtime.map_err(Failure::failed)?.block_on(serve(arguments))
}

async fn serve(arguments: &Serve) -> Result<(), Failure> {
    let interrupt = Interrupt::listen().await;
    let server = open(arguments)?;
    let resumed = server.house().lobby().resume().map_err(Failure::failed)?;
    for error in &resumed.errors {
        note(&format!("a match is not taken up: {error}"));
    }
    if arguments.lobby.is_empty() {
        let outcome = play(arguments, &server, resumed.matches, interrupt).await;
        // Whatever the outcome, the clients have been told something.
        server.wait_closed().await;
        return outcome;
    }
    for game in resumed.matches {
        note(&format!("match {} goes on at cycle {}", game.id(), game.cycle()));
        server.house().lobby().go_on(game).map_err(Failure::failed)?;
    }
    let address = server.local_addr().map_err(Failure::failed)?.to_string();
    print(Format::of(&arguments.json), &Listening { address }, |it| format!("listening {}\n", it.address))?;
    let (mut first, mut second) = (interrupt.clone(), interrupt);
    server.serve(first.wait(), second.wait_again(arguments.journal.is_some())).await;
    Ok(())
}

/// Where a server with a lobby listens.
#[derive(Debug, Serialize)]
struct Listening {
    address: String,
}

fn open(arguments: &Serve) -> Result<Server, Failure> {
    let journals = arguments.journal.as_deref().map(|folder| Journals::open(folder, SYNC_INTERVAL));
    let journals = journals.transpose().map_err(Failure::failed)?;
    let offers = arguments.lobby.iter().map(|path| offer(path)).collect::<Result<_, _>>()?;
    let threads = available_parallelism().map_or(1, usize::from);
    let house = House::new(Limits::default(), offers, journals, threads).map_err(Failure::failed)?;
    Server::open(arguments.listen, house)
        .with_context(|| format!("cannot listen on {}", arguments.listen))
        .map_err(Failure::Failed)
}

/// Returns the name and the files of a scenario of which clients may create matches.
fn offer(path: &Path) -> Result<(String, Offer), Failure> {
    let Loaded { scenario, files, .. } = start::loaded(Some(path), &Overrides::default())?;
    Ok((scenario.name.clone(), Offer { files, scenario: path.to_string_lossy().into_owned() }))
}

/// Plays one match after the other.
async fn play(
    arguments: &Serve,
    server: &Server,
    resumed: Vec<Match>,
    mut interrupt: Interrupt,
) -> Result<(), Failure> {
    let mut seed = arguments.seed;
    let mut access = None;
    let mut resumed = resumed.into_iter();
    loop {
        let game = match resumed.next() {
            Some(game) => {
                seed = Some(game.seed().wrapping_add(1));
                note(&format!("match {} goes on at cycle {}", game.id(), game.cycle()));
                tell(arguments, &game, server)?;
                game
            }
            None => {
                let game = prepare(arguments, seed, access.take())?;
                seed = Some(game.seed().wrapping_add(1));
                tell(arguments, &game, server)?;
                game
            }
        };
        let id = game.id();
        access = Some(game.access().to_vec());
        let result = server.run(game, interrupt.wait()).await.map_err(Failure::failed)?;
        let Some(result) = result else {
            return if arguments.journal.is_some() { Ok(()) } else { Err(Failure::Interrupted) };
        };
        print(Format::of(&arguments.json), &Ended { id, result }, Ended::text)?;
        if arguments.once {
            return Ok(());
        }
        if interrupt.has_come() {
            return Err(Failure::Interrupted);
        }
    }
}

/// Loads the next match, with the tokens of the match before if there was one.
fn prepare(arguments: &Serve, seed: Option<u64>, access: Option<Vec<Access>>) -> Result<Match, Failure> {
    let clock = match arguments.clock {
        Clock::Realtime => ClockMode::Realtime,
        Clock::Lockstep => ClockMode::Lockstep,
    };
    let asked =
        Overrides { map: start::map_path(arguments.map.as_deref()), seed, ..arguments.profile.overrides()? };
    let loaded = start::loaded(arguments.scenario.as_deref(), &asked)?;
    note(&models::line(&loaded));
    let referee = start::referee(loaded, clock)?;
    let game = match access {
        Some(access) => Match::new(referee, access),
        None => Match::with_random_tokens(referee),
    };
    let game = game.map_err(Failure::failed)?;
    match &arguments.replay {
        Some(path) => Ok(game.recorded_to(files::create(path)?)),
        None => Ok(game),
    }
}

/// Tells who may join a match.
fn tell(arguments: &Serve, game: &Match, server: &Server) -> Result<(), Failure> {
    let open_seat = |(seat, access): (u16, &Access)| OpenSeat {
        seat: Seat(seat),
        token: match access {
            Access::Open => None,
            Access::Token(token) => Some(token.to_string()),
        },
    };
    let scenario = &game.loaded().scenario;
    let opened = Opened {
        address: server.local_addr().map_err(Failure::failed)?.to_string(),
        id: game.id(),
        scenario: scenario.name.clone(),
        seed: scenario.seed,
        clock: game.clock(),
        seats: (0..).zip(game.access()).map(open_seat).collect(),
        spectators: scenario.spectators.map(Watchable::of),
    };
    print(Format::of(&arguments.json), &opened, Opened::text)
}

/// Returns how a match ended, in a line.
pub(crate) fn summary(result: &MatchResult) -> String {
    let winners = outcome::winners(&result.winners);
    format!("{winners} after {} cycles, state hash {}\n", result.cycles, result.hash)
}
