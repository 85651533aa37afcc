//! `maniple replay`: what a match was, and that it is so again.

mod verify;
mod view;

use std::fmt::Write as _;
use std::path::Path;

use anyhow::Context;
use maniple_geometry::Cycle;
use maniple_protocol::{Record, Replay, encode_snapshot, read_replay};
use maniple_referee::{RecordedEvent, Referee};
use maniple_view::{ClockMode, Digest, MatchResult, Objective, Rules, Seat};
use serde::Serialize;

use crate::arguments::{ReplayCommand, ReplayFile, ReplayRender, ReplaySnapshot};
use crate::failure::Failure;
use crate::output::{Format, grouped, print};
use crate::picture::Picture;
use crate::{files, outcome, start};

/// Runs `maniple replay`.
pub(crate) fn run(command: &ReplayCommand) -> Result<(), Failure> {
    match command {
        ReplayCommand::Info(arguments) => info(arguments),
        ReplayCommand::Verify(arguments) => verify::run(arguments),
        ReplayCommand::Snapshot(arguments) => snapshot(arguments),
        ReplayCommand::View(arguments) => view::run(arguments),
        ReplayCommand::Render(arguments) => render(arguments),
    }
}

/// What a replay holds.
#[derive(Debug, Serialize)]
struct Info {
    build: String,
    protocol: u32,
    scenario: String,
    seed: u64,
    map_hash: Digest,
    seats: u16,
    players: Vec<String>,
    commands: usize,
    bytes: usize,
    result: Option<MatchResult>,
}

impl Info {
    fn of(replay: &Replay, bytes: usize) -> Self {
        let header = &replay.header;
        let mut players = vec![String::new(); usize::from(header.seats)];
        let mut commands = 0;
        for record in &replay.records {
            match record {
                Record::Joined { seat, name, .. } => {
                    if let Some(player) = players.get_mut(seat.index()) {
                        player.clone_from(name);
                    }
                }
                Record::Commands { list, .. } => commands += list.len(),
                Record::Absent { .. } | Record::Cycle { .. } | Record::Ended { .. } => {}
            }
        }
        Self {
            build: header.build.clone(),
            protocol: header.protocol,
            scenario: header.scenario_name.clone(),
            seed: header.seed,
            map_hash: header.map_hash,
            seats: header.seats,
            players,
            commands,
            bytes,
            result: replay.ended.clone(),
        }
    }

    fn text(&self) -> String {
        let mut text = format!(
            "{}, seed {}, {} bytes, recorded by {} (protocol {})\nmap {}\n",
            self.scenario,
            self.seed,
            grouped(self.bytes as u64),
            self.build,
            self.protocol,
            self.map_hash
        );
        let _ = writeln!(text, "players: {}", self.players.join(", "));
        let _ = writeln!(text, "{} commands", grouped(self.commands as u64));
        if let Some(result) = &self.result {
            let winners = outcome::winners(&result.winners);
            let cycles = grouped(u64::from(result.cycles.0));
            let _ = writeln!(text, "{winners} after {cycles} cycles, state hash {}", result.hash);
        }
        text
    }
}

fn info(arguments: &ReplayFile) -> Result<(), Failure> {
    let (replay, bytes) = read(&arguments.file)?;
    print(Format::of(&arguments.json), &Info::of(&replay, bytes), Info::text)
}

fn render(arguments: &ReplayRender) -> Result<(), Failure> {
    let referee = played_to(&arguments.file, Cycle(arguments.cycle))?;
    let picture = match arguments.seat {
        Some(seat) => drawn_as_seen(&referee, known_seat(seat, &referee)?, arguments.scale)?,
        None => drawn(&referee, arguments.scale)?,
    };
    files::write(&arguments.out, &picture.png()?)
}

fn snapshot(arguments: &ReplaySnapshot) -> Result<(), Failure> {
    let referee = played_to(&arguments.file, Cycle(arguments.cycle))?;
    files::write(&arguments.out, &encode_snapshot(&referee.snapshot()).map_err(Failure::failed)?)
}

/// Returns the match of a replay at the start of a cycle.
fn played_to(file: &Path, wanted: Cycle) -> Result<Referee, Failure> {
    let (replay, _) = read(file)?;
    let mut referee = beginning(&replay, file)?;
    for event in maniple_server::events(&replay) {
        let is_beyond = matches!(&event, RecordedEvent::Hash { cycle, .. } if *cycle > wanted);
        if is_beyond {
            break;
        }
        referee.handle_record(&event).with_context(|| file.display().to_string()).map_err(Failure::Failed)?;
    }
    if referee.cycle() != wanted {
        return Err(Failure::usage(format!(
            "--cycle {wanted}: the match has cycles 0 to {}",
            referee.cycle()
        )));
    }
    referee.take_records();
    Ok(referee)
}

/// Returns the picture of what a seat sees.
fn drawn_as_seen(referee: &Referee, seat: Seat, scale: Option<u32>) -> Result<Picture, Failure> {
    let view = referee.view(seat);
    let mut picture = Picture::of_view(&referee.loaded().map, view, scale)?;
    let rules = referee.rules();
    draw_zones(&mut picture, &rules);
    for (_, seen) in view.objects() {
        let shape = rules.unit_types[usize::from(seen.unit_type.0)].shape;
        picture.draw_object(seen.base.position(view.cycle()), shape, seen.owner);
    }
    Ok(picture)
}

fn drawn(referee: &Referee, scale: Option<u32>) -> Result<Picture, Failure> {
    let mut picture = Picture::of(&referee.loaded().map, scale)?;
    let rules = referee.rules();
    draw_zones(&mut picture, &rules);
    // Each seat's view has all its own objects, in fog too.
    for seat in (0..).map(Seat).take(referee.seats()) {
        let view = referee.view(seat);
        for (_, seen) in view.objects() {
            if seen.owner == Some(seat) || seen.owner.is_none() {
                let shape = rules.unit_types[usize::from(seen.unit_type.0)].shape;
                picture.draw_object(seen.base.position(view.cycle()), shape, seen.owner);
            }
        }
    }
    Ok(picture)
}

fn draw_zones(picture: &mut Picture, rules: &Rules) {
    if let Objective::Race { zones } = &rules.objective {
        for zone in zones {
            picture.draw_zone(zone);
        }
    }
}

/// Returns a seat that was asked for.
fn known_seat(seat: u16, referee: &Referee) -> Result<Seat, Failure> {
    let seats = referee.seats();
    if usize::from(seat) < seats {
        return Ok(Seat(seat));
    }
    Err(Failure::usage(format!("--seat {seat}: the match has seats 0 to {}", seats.saturating_sub(1))))
}

fn read(path: &Path) -> Result<(Replay, usize), Failure> {
    let bytes = files::read(path)?;
    let replay =
        read_replay(&bytes).with_context(|| path.display().to_string()).map_err(Failure::BadInput)?;
    Ok((replay, bytes.len()))
}

/// Returns the referee at the start of the recorded match.
fn beginning(replay: &Replay, path: &Path) -> Result<Referee, Failure> {
    let loaded = maniple_server::loaded(&replay.header)
        .with_context(|| path.display().to_string())
        .map_err(Failure::BadInput)?;
    start::referee(loaded, ClockMode::Lockstep).map_err(|failure| failure.within(path))
}
