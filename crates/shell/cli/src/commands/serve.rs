//! `maniple serve`: matches that clients join over TCP.

mod check;
mod operate;

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::net::TcpListener;
use std::path::Path;
use std::thread::available_parallelism;

use anyhow::Context;
use maniple_game::scenario::{Spectators, Views};
use maniple_game::{Loaded, Overrides};
use maniple_server::settings::{Configuration, MayCreate, Settings};
use maniple_server::tls;
use maniple_server::{Access, House, Journals, Match, Offer, Server};
use maniple_view::{ClockMode, Digest, MatchResult, Seat};
use serde::Serialize;

use crate::arguments::Serve;
use crate::commands::serve::operate::Operators;
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
    /// Where health, metrics and matches are asked for; null: nowhere.
    http: Option<String>,
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
    refuse_what_does_not_go_together(arguments, &settings)?;
    if arguments.configuration.print_config {
        return check::print_configuration(arguments, configuration);
    }
    if arguments.configuration.check {
        return check::check(arguments, configuration, &settings);
    }
    let inherited = operate::inherited()?;
    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build();
    runtime.map_err(Failure::failed)?.block_on(serve(arguments, &settings, inherited))
}

/// Returns an error for flags that say nothing to what the configuration says.
fn refuse_what_does_not_go_together(arguments: &Serve, settings: &Settings) -> Result<(), Failure> {
    if settings.journal.directory.is_some() && arguments.replay.is_some() {
        let text =
            "--replay: with journal.directory the replay is in its folder `finished`; leave --replay away";
        return Err(Failure::usage(text.to_owned()));
    }
    let of_one_match = [
        ("--scenario", arguments.scenario.is_some()),
        ("--map", arguments.map.is_some()),
        ("--seed", arguments.seed.is_some()),
        ("--once", arguments.once),
    ];
    match of_one_match.iter().find(|(_, is_given)| *is_given && has_lobby(arguments, settings)) {
        Some((flag, _)) => Err(Failure::usage(format!(
            "{flag} is for one match after the other, but lobby.scenarios lets clients create them; leave one of the two away"
        ))),
        None => Ok(()),
    }
}

/// Returns whether clients create the matches.
fn has_lobby(arguments: &Serve, settings: &Settings) -> bool {
    !arguments.lobby.is_empty() || !settings.lobby.scenarios.is_empty()
}

async fn serve(
    arguments: &Serve,
    settings: &Settings,
    inherited: Option<TcpListener>,
) -> Result<(), Failure> {
    let interrupt = Interrupt::listen().await;
    let server = open(arguments, settings, inherited)?;
    // To read journals takes a while, in which operators want to know that it goes on.
    let operators = Operators::admit(arguments, settings, &server, interrupt.clone()).await?;
    let resumed = server.house().lobby().resume().map_err(Failure::failed)?;
    for error in &resumed.errors {
        note(&format!("a match is not taken up: {error}"));
    }
    let outcome = attend(arguments, settings, &operators, &server, (resumed.matches, interrupt)).await;
    operators.dismiss().await;
    outcome
}

async fn attend(
    arguments: &Serve,
    settings: &Settings,
    operators: &Operators,
    server: &Server,
    (resumed, interrupt): (Vec<Match>, Interrupt),
) -> Result<(), Failure> {
    let is_kept = settings.journal.directory.is_some();
    if !has_lobby(arguments, settings) {
        let outcome = play(arguments, operators, server, (resumed, interrupt, is_kept)).await;
        // Whatever the outcome, the clients have been told something.
        server.wait_closed().await;
        return outcome;
    }
    for game in resumed {
        note(&format!("match {} goes on at cycle {}", game.id(), game.cycle()));
        server.house().lobby().take_in(game).map_err(Failure::failed)?;
    }
    let address = server.local_addr().map_err(Failure::failed)?.to_string();
    let listening = Listening { address, http: operators.http() };
    operators.tell_ready(&listening.address);
    print(Format::of(&arguments.json), &listening, |it| format!("listening {}\n", it.address))?;
    let (mut first, mut second) = (interrupt.clone(), interrupt);
    server.serve(first.wait(), second.wait_again(is_kept)).await;
    Ok(())
}

/// Where a server with a lobby listens.
#[derive(Debug, Serialize)]
struct Listening {
    address: String,
    /// Where health, metrics and matches are asked for; null: nowhere.
    http: Option<String>,
}

fn open(arguments: &Serve, settings: &Settings, inherited: Option<TcpListener>) -> Result<Server, Failure> {
    let kept = settings.journal.directory.as_deref();
    let journals = kept.map(|folder| Journals::open(folder, settings.journal.sync_interval));
    let journals = journals.transpose().map_err(Failure::failed)?;
    let mut offers = BTreeMap::new();
    for path in &arguments.lobby {
        let (name, offer) = offer(path)?;
        offers.insert(name, offer);
    }
    for (name, path) in &settings.lobby.scenarios {
        offers.insert(name.clone(), offer(path)?.1);
    }
    let threads = available_parallelism().map_or(1, usize::from);
    let house = House::new(settings.limits, offers, journals, threads).map_err(Failure::failed)?;
    let house = match &settings.listen.tls {
        Some(files) => house.encrypted(tls::acceptor(files).map_err(Failure::bad_input)?),
        None => house,
    };
    let house = match settings.lobby.create {
        MayCreate::Anyone => house,
        MayCreate::Admin => house.closed_to_clients(),
    };
    if let Some(listener) = inherited {
        return Server::over(listener, house).map_err(Failure::failed);
    }
    let address = settings.listen.address;
    Server::open(address, house)
        .with_context(|| format!("cannot listen on {address}"))
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
    operators: &Operators,
    server: &Server,
    (resumed, interrupt, is_kept): (Vec<Match>, Interrupt, bool),
) -> Result<(), Failure> {
    let mut seed = arguments.seed;
    let mut access = None;
    let mut resumed = resumed.into_iter();
    loop {
        let game = match resumed.next() {
            Some(game) => {
                seed = Some(game.seed().wrapping_add(1));
                note(&format!("match {} goes on at cycle {}", game.id(), game.cycle()));
                tell(arguments, operators, &game, server)?;
                game
            }
            None => {
                let game = prepare(arguments, seed, access.take())?;
                seed = Some(game.seed().wrapping_add(1));
                tell(arguments, operators, &game, server)?;
                game
            }
        };
        let id = game.id();
        access = Some(game.access().to_vec());
        let broken_off = to_break_off(server, id, (interrupt.clone(), is_kept));
        let result = server.run(game, broken_off).await.map_err(Failure::failed)?;
        let Some(result) = result else {
            if interrupt.has_come_again() && !is_kept {
                return Err(Failure::Interrupted);
            }
            if interrupt.has_come() {
                return Ok(());
            }
            if arguments.once || server.house().lobby().is_draining() {
                return Ok(());
            }
            // Whoever runs the server has ended this one.
            continue;
        };
        print(Format::of(&arguments.json), &Ended { id, result }, Ended::text)?;
        if arguments.once || server.house().lobby().is_draining() {
            return Ok(());
        }
    }
}

/// Waits until a match is to be broken off: an interrupt lets one that has begun come to its end, if it is not kept in a journal, and a
/// second does not.
async fn to_break_off(server: &Server, id: Digest, (mut interrupt, is_kept): (Interrupt, bool)) {
    interrupt.wait().await;
    let lobby = server.house().lobby();
    lobby.drain();
    if !is_kept && lobby.has_begun(id) {
        note("the match comes to its end before the server; interrupt it again to break it off");
        interrupt.wait_again(is_kept).await;
    }
}

/// Loads the next match, with the tokens of the match before if there was one.
fn prepare(arguments: &Serve, seed: Option<u64>, access: Option<Vec<Access>>) -> Result<Match, Failure> {
    let asked =
        Overrides { map: start::map_path(arguments.map.as_deref()), seed, ..arguments.profile.overrides()? };
    let loaded = start::loaded(arguments.scenario.as_deref(), &asked)?;
    note(&models::line(&loaded));
    let referee = start::referee(loaded, arguments.clock.mode())?;
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
fn tell(arguments: &Serve, operators: &Operators, game: &Match, server: &Server) -> Result<(), Failure> {
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
        http: operators.http(),
    };
    operators.tell_ready(&opened.address);
    print(Format::of(&arguments.json), &opened, Opened::text)
}

/// Returns how a match ended, in a line.
pub(crate) fn summary(result: &MatchResult) -> String {
    let winners = outcome::winners(&result.winners);
    format!("{winners} after {} cycles, state hash {}\n", result.cycles, result.hash)
}
