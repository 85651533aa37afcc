//! Heavy mode: beside a match goes a twin that is thrown away again and again, and made anew from the bytes of its snapshot. It has to
//! come to the same hashes, and tell each seat and each stand the same, byte for byte.
//!
//! In an ordinary run the twin is renewed in each of the first cycles, and then now and then; with `MANIPLE_LONG=1` in every cycle of
//! whole matches.

#![expect(clippy::unwrap_used, reason = "a helper that fails is a test that fails")]

use std::sync::Arc;
use std::time::Duration;

use maniple_game::{Files, Loaded, Overrides, load};
use maniple_geometry::Cycle;
use maniple_protocol::{
    Encoding, Fingerprint, ServerMessage, decode_snapshot, encode_server, encode_snapshot,
};
use maniple_referee::{RecordedEvent, Referee, Snapshot};
use maniple_view::{ClockMode, Delta, Handle, Positions, Scalar, Seat, Sequenced, Solver, Vantage};

use crate::matches::{Game, open, shipped, tiny};

/// Cycles at the start of a match in each of which the twin is renewed.
const EACH_CYCLES: u32 = 150;

/// After them it is renewed in each so many, a prime number, so that it is no multiple of anything.
const STEP_CYCLES: u32 = 23;

/// Cycles that an ordinary run plays.
const SHORT_CYCLES: u32 = 1200;

/// Snapshots are kept in each so many cycles, from which the replay is played.
const KEPT_CYCLES: u32 = 131;

/// Cycles by which spectators are behind.
const DELAY: u32 = 5;

#[test]
fn duel_goes_on_from_each_snapshot() {
    check(shipped("config/scenarios/duel.toml", Some(3)));
}

#[test]
fn diamond_goes_on_from_each_snapshot() {
    check(shipped("config/scenarios/diamond.toml", Some(3)));
}

#[test]
fn caves_goes_on_from_each_snapshot() {
    check(shipped("config/scenarios/caves.toml", Some(3)));
}

#[test]
fn choke_goes_on_from_each_snapshot() {
    check(shipped("config/scenarios/choke.toml", Some(3)));
}

#[test]
fn orts1_goes_on_from_each_snapshot() {
    check(shipped("config/scenarios/orts1.toml", Some(3)));
}

#[test]
fn orts2_goes_on_from_each_snapshot() {
    check(shipped("config/scenarios/orts2.toml", Some(3)));
}

#[test]
fn orts3_goes_on_from_each_snapshot() {
    check(shipped("config/scenarios/orts3.toml", Some(3)));
}

#[test]
fn orts4_goes_on_from_each_snapshot() {
    check(shipped("config/scenarios/orts4.toml", Some(3)));
}

#[test]
fn so_does_the_whole_game_in_unknown_land_with_sheep_and_persistent_handles() {
    let sheep = "[neutral]\ngroups = [{ unit = \"sheep\", count = 10 }]\n[vision]\nwalls_block = true\n\
                 identity = \"persistent\"\nterrain = \"explored\"";
    check(altered(
        "config/scenarios/orts3.toml",
        "[vision]\nterrain = \"known\"",
        sheep,
        Overrides::default(),
    ));
}

#[test]
fn so_it_does_in_single_precision_on_a_grid_and_by_steps() {
    let profile = |scalar, solver, positions| Overrides {
        scalar: Some(scalar),
        solver: Some(solver),
        positions: Some(positions),
        ..Overrides::default()
    };
    let [single, stepped] = [
        profile(Scalar::F32, Solver::Event, Positions::Grid { bits: 8 }),
        profile(Scalar::F64, Solver::Stepped { substeps: 3 }, Positions::Exact),
    ];
    check(altered("config/scenarios/orts4.toml", "", "", single));
    check(altered("config/scenarios/orts4.toml", "", "", stepped));
}

#[test]
fn every_shipped_scenario_is_played_here() {
    let text = include_str!("heavy.rs");
    let folder =
        std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../config/scenarios")).unwrap();
    for entry in folder {
        let name = entry.unwrap().file_name().into_string().unwrap();
        assert!(text.contains(&format!("check(shipped(\"config/scenarios/{name}\"")), "{name}");
    }
}

#[test]
fn time_banks_pauses_and_seats_that_are_out_go_on_from_each_snapshot() {
    let loaded = || Arc::new(tiny("clock = { time_bank_seconds = 1, stall = 'forfeit' }", &open()));
    let mut referee = Referee::new(loaded(), ClockMode::Lockstep).unwrap();
    let seats = [Seat(0), Seat(1)];
    for seat in seats {
        referee.handle_join(seat, "player").unwrap();
    }
    let mut twin = None;
    let mut story = Vec::new();
    for round in 0..40u64 {
        let tell = |referee: &mut Referee| {
            for seat in seats {
                referee.take_delta(seat);
            }
            referee.take_records();
            referee.handle_time(Duration::from_millis(100 * round));
            match round {
                3 => referee.handle_pause(Seat(0)),
                4 => referee.handle_pause(Seat(1)),
                9 => referee.handle_go_on(Seat(1)),
                12 => referee.handle_pause(Seat(1)),
                30 => referee.forfeit(Seat(0)),
                _ => {}
            }
            referee.handle_done(Seat(0), referee.cycle());
            if round % 2 == 0 {
                referee.handle_done(Seat(1), referee.cycle());
            }
            let said =
                (referee.pause(), referee.take_pause_change(), referee.poll_timeout(), referee.is_ready());
            if referee.is_ready() {
                referee.step();
            }
            (said, referee.take_records(), referee.hash(), referee.result().cloned())
        };
        let said = tell(&mut referee);
        if let Some(twin) = &mut twin {
            assert_eq!(tell(twin), said, "round {round}");
        }
        story.push(said.0);
        let mut renewed = renewed(&referee.snapshot(), &loaded());
        assert_eq!(renewed.time(), referee.time());
        for seat in seats {
            renewed.handle_join(seat, "player").unwrap();
        }
        twin = Some(renewed);
    }
    assert!(story.iter().any(|said| said.0.on) && referee.result().is_some(), "{story:?}");
}

#[test]
fn who_was_forfeited_before_a_snapshot_is_gone_after_the_next_cycle() {
    let loaded = Arc::new(tiny("", &open()));
    let mut referee = Referee::new(Arc::clone(&loaded), ClockMode::Realtime).unwrap();
    referee.forfeit(Seat(0));
    referee.take_records();
    let mut twin = renewed(&referee.snapshot(), &loaded);
    for referee in [&mut referee, &mut twin] {
        referee.take_delta(Seat(0));
        referee.take_delta(Seat(1));
        referee.step();
    }
    assert_eq!(referee.world().dead().len(), 3);
    assert_eq!(twin.world().dead(), referee.world().dead());
    assert_eq!((twin.hash(), twin.result()), (referee.hash(), referee.result()));
}

#[test]
fn a_snapshot_of_another_match_is_refused() {
    let snapshot = |loaded: Loaded| {
        let mut referee = Referee::new(loaded, ClockMode::Lockstep).unwrap();
        referee.take_records();
        referee.snapshot()
    };
    let duel = snapshot(shipped("config/scenarios/duel.toml", Some(3)));
    for (path, seed) in [("config/scenarios/diamond.toml", 3), ("config/scenarios/duel.toml", 4)] {
        let error = Referee::resume(shipped(path, Some(seed)), ClockMode::Lockstep, &duel).err().unwrap();
        assert!(error.to_string().contains("is of another match"), "{error}");
    }
    assert!(
        Referee::resume(shipped("config/scenarios/duel.toml", Some(3)), ClockMode::Lockstep, &duel).is_ok()
    );
}

#[test]
fn a_difference_is_named_by_object_and_field() {
    let played = |stop: bool| {
        let mut game = Game::new(shipped("config/scenarios/duel.toml", Some(3)), &["straight", "straight"]);
        for _ in 0..20 {
            game.step();
        }
        if stop {
            let object = game.players[1].view.objects_of(Seat(1)).find(|(_, seen)| seen.base.is_moving());
            let command =
                maniple_view::Command::Stop { object: object.map_or(Handle(0), |(object, _)| object) };
            let list = vec![Sequenced { seq: 0, command }];
            game.referee.handle_commands(Seat(1), Cycle(20), list).unwrap();
        }
        game.step();
        Fingerprint::of(&game.referee.snapshot())
    };
    let found = played(false).differences(&played(true), 5);
    let first = &found.first().unwrap().path;
    assert!(first.starts_with("world/field/objects/"), "{found:?}");
    assert!(played(false).differences(&played(false), 5).is_empty());
}

/// Plays a match with the bots that its scenario names, and a twin beside it.
fn check(loaded: Loaded) {
    let is_long = std::env::var_os("MANIPLE_LONG").is_some();
    let loaded = Arc::new(loaded);
    let bots: Vec<String> = loaded.scenario.seats.iter().map(|seat| seat.bot.clone().unwrap()).collect();
    let bots: Vec<&str> = bots.iter().map(String::as_str).collect();
    let mut game = Game::new((*loaded).clone(), &bots);
    let vantages: Vec<Vantage> =
        (0..bots.len()).map(|seat| Vantage::Seat(Seat(seat.try_into().unwrap()))).collect();
    let vantages = [vantages, vec![Vantage::Everything]].concat();
    for &vantage in &vantages {
        game.referee.open_stand(vantage, DELAY);
    }
    let mut twin = renewed(&game.referee.snapshot(), &loaded);
    let mut kept: Vec<(usize, Vec<u8>)> = Vec::new();
    let mut longest = 0;
    while is_long || game.referee.cycle() < Cycle(SHORT_CYCLES) {
        let cycle = game.referee.cycle().0;
        if is_long || cycle < EACH_CYCLES || cycle.is_multiple_of(STEP_CYCLES) {
            let (first, second) = (game.referee.snapshot(), twin.snapshot());
            if first != second {
                let found = Fingerprint::of(&first).differences(&Fingerprint::of(&second), 5);
                panic!("cycle {cycle}: {found:#?}");
            }
            twin = renewed(&second, &loaded);
            for &vantage in &vantages {
                let (stand, expected) = (twin.stand(vantage).unwrap(), game.referee.stand(vantage).unwrap());
                assert_eq!(stand.keyframe(), expected.keyframe(), "cycle {cycle}, {vantage}");
            }
            longest = longest.max(encode_snapshot(&first).unwrap().len());
        }
        if cycle.is_multiple_of(KEPT_CYCLES) {
            kept.push((game.records.len(), encode_snapshot(&game.referee.snapshot()).unwrap()));
        }
        let records = game.records.len();
        let goes_on = game.step();
        let told: Vec<Delta> = game.players.iter().map(|player| player.delta.clone()).collect();
        go(&mut twin, &game.records[records..], &told);
        for &vantage in &vantages {
            let (shown, expected) = (twin.stand(vantage).unwrap(), game.referee.stand(vantage).unwrap());
            assert_eq!(bytes(shown.shown()), bytes(expected.shown()), "cycle {cycle}, {vantage}");
            assert_eq!(shown.keyframe(), expected.keyframe(), "cycle {cycle}, {vantage}");
        }
        assert_eq!(twin.result(), game.referee.result());
        if !goes_on {
            break;
        }
    }
    let cycles = game.referee.cycle();
    println!("{}: {cycles} cycles, snapshots of up to {longest} bytes", loaded.scenario.name);
    for (records, bytes) in kept {
        let mut replayed = renewed(&decode_snapshot(&bytes).unwrap(), &loaded);
        for record in &game.records[records..] {
            replayed.handle_record(record).unwrap();
        }
        assert_eq!((replayed.cycle(), replayed.hash()), (cycles, game.referee.hash()));
        assert_eq!(replayed.result(), game.referee.result());
    }
}

/// Plays the cycle of these records, in which the seats were told this.
fn go(twin: &mut Referee, records: &[RecordedEvent], told: &[Delta]) {
    for seat in (0..).map(Seat).take(told.len()) {
        if !twin.is_connected(seat) {
            twin.handle_join(seat, "again").unwrap();
            let keyframe = twin.take_delta(seat).unwrap();
            assert_eq!(bytes(&[keyframe]), bytes(&[twin.keyframe(seat)]));
        }
        twin.handle_done(seat, twin.cycle());
    }
    for record in records {
        if let RecordedEvent::Commands { seat, seen_cycle, commands, .. } = record {
            twin.handle_commands(*seat, *seen_cycle, commands.clone()).unwrap();
        }
    }
    assert!(twin.is_ready());
    twin.step();
    assert_eq!(twin.take_records(), records, "the same is recorded, and the same hash");
    for (seat, expected) in (0..).map(Seat).zip(told) {
        let delta = twin.take_delta(seat).unwrap();
        let is_same = bytes(std::slice::from_ref(&delta)) == bytes(std::slice::from_ref(expected));
        assert!(is_same, "seat {seat} is told\n{delta:?}\nand should be told\n{expected:?}");
    }
}

fn renewed(snapshot: &Snapshot, loaded: &Arc<Loaded>) -> Referee {
    let bytes = encode_snapshot(snapshot).unwrap();
    let read: Snapshot = decode_snapshot(&bytes).unwrap();
    assert_eq!(&read, snapshot);
    let renewed = Referee::resume(Arc::clone(loaded), ClockMode::Lockstep, &read);
    renewed.unwrap_or_else(|error| panic!("cycle {}: {error}", read.cycle()))
}

fn bytes(deltas: &[Delta]) -> Vec<Vec<u8>> {
    let frame =
        |delta: &Delta| encode_server(Encoding::Binary, &ServerMessage::Delta(delta.clone())).unwrap();
    deltas.iter().map(frame).collect()
}

/// Returns a shipped match with a text of its scenario replaced by another.
fn altered(path: &str, old: &str, new: &str, overrides: Overrides) -> Loaded {
    let mut files: Files = shipped(path, Some(3)).files;
    let text = String::from_utf8(files.0[0].bytes.clone()).unwrap();
    assert!(text.contains(old));
    files.0[0].bytes = text.replacen(old, new, 1).into_bytes();
    let seed = Some(3);
    load(&files, path, &Overrides { seed, ..overrides }).unwrap_or_else(|error| panic!("{error}"))
}
