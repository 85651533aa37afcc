//! The daemon is killed, again and again, in the middle of a match with real sockets.

use std::io::{BufRead, BufReader};
use std::net::TcpListener;
use std::path::Path;
use std::process::{Child, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

use glam::DVec2;
use maniple_client::{Client, Event};
use maniple_game::{Loaded, Overrides, load};
use maniple_protocol::{Record, read_replay};
use maniple_referee::Referee;
use maniple_tilemap::Resolver;
use maniple_view::{ClockMode, Command, Handle, MatchResult, Seat, Sequenced, View};
use tokio::task::{JoinHandle, spawn_blocking};

use crate::arena::{NAMES, login, tiny};
use crate::commands::{folder, maniple};

/// How often it is killed.
const KILLS: u32 = 50;

/// Cycles from one kill to the next, about.
const CYCLES_APART: u32 = 12;

#[tokio::test(flavor = "multi_thread")]
async fn a_match_goes_on_to_the_same_end_however_often_the_daemon_is_killed() {
    let folder = folder("crash");
    write_scenario(&folder);
    let expected = uninterrupted(&folder);
    let address = free_address();
    let mut daemon = Daemon::start(&folder, &address);
    let tokens = daemon.tokens.clone();
    let seen = Arc::new(AtomicU32::new(0));
    let players: Vec<JoinHandle<MatchResult>> = (0..2)
        .map(|seat| tokio::spawn(play(address.clone(), seat, tokens[seat].clone(), Arc::clone(&seen))))
        .collect();
    for kill in 1..=KILLS {
        while seen.load(Ordering::Relaxed) < kill * CYCLES_APART {
            assert!(!players.iter().any(JoinHandle::is_finished), "a player has gone; what it says is below");
            tokio::time::sleep(Duration::from_micros(200)).await;
        }
        // At another place of a cycle each time.
        tokio::time::sleep(Duration::from_micros(u64::from(kill * 37 % 400))).await;
        daemon.kill();
        daemon = Daemon::start(&folder, &address);
        assert_eq!(daemon.tokens, tokens);
    }
    for player in players {
        assert_eq!(player.await.unwrap(), expected);
    }
    spawn_blocking(move || daemon.process.wait()).await.unwrap().unwrap();
    let finished: Vec<_> = std::fs::read_dir(folder.join("kept/finished")).unwrap().collect();
    let [Ok(replay)] = &finished[..] else { panic!("{finished:?}") };
    let replay = read_replay(&std::fs::read(replay.path()).unwrap()).unwrap();
    assert_eq!(replay.ended.as_ref(), Some(&expected));
    let is_hash = |record: &&Record| matches!(record, Record::Cycle { .. });
    assert_eq!(replay.records.iter().filter(is_hash).count(), expected.cycles.0 as usize + 1);
}

/// The program under test.
struct Daemon {
    process: Child,
    tokens: Vec<String>,
}

impl Daemon {
    fn start(folder: &Path, address: &str) -> Self {
        let scenario = folder.join("tiny.toml");
        let kept = folder.join("kept");
        let arguments = ["serve", "--scenario", scenario.to_str().unwrap(), "--clock", "lockstep"];
        let mut command = maniple(&arguments);
        command.args(["--journal", kept.to_str().unwrap(), "--listen", address, "--once", "--json"]);
        let mut process = command.stdout(Stdio::piped()).spawn().unwrap();
        let mut lines = BufReader::new(process.stdout.take().unwrap()).lines();
        let line = lines.next().expect("it tells who may join").unwrap();
        let opened: serde_json::Value = serde_json::from_str(&line).unwrap();
        let token = |seat: &serde_json::Value| seat["token"].as_str().unwrap().to_owned();
        let tokens = opened["seats"].as_array().unwrap().iter().map(token).collect();
        // It has the end to tell yet.
        std::thread::spawn(move || lines.for_each(drop));
        Self { process, tokens }
    }

    /// Kills it as nothing can be prepared for.
    fn kill(mut self) {
        self.process.kill().unwrap();
        self.process.wait().unwrap();
    }
}

/// Plays a seat to the end of the match, and comes back each time that the connection breaks.
async fn play(address: String, seat: usize, token: String, seen: Arc<AtomicU32>) -> MatchResult {
    let mut told = 0;
    loop {
        let Ok(mut client) = Client::connect(&address, login(seat, &token)).await else {
            tokio::time::sleep(Duration::from_millis(2)).await;
            continue;
        };
        while let Ok(event) = client.next().await {
            match event {
                Event::Cycle(delta) => {
                    seen.fetch_max(delta.cycle.0, Ordering::Relaxed);
                    assert!(delta.cycle.0 >= told, "told of cycle {told}, and then of {}", delta.cycle);
                    told = delta.cycle.0;
                    let commands = decide(client.view(), client.seat());
                    if client.send(commands).await.is_err() || client.done().await.is_err() {
                        break;
                    }
                }
                Event::Ended(result) => return result,
                Event::Pong { .. } | Event::Paused { .. } | Event::Warned { .. } => {}
            }
        }
    }
}

/// Returns what a seat commands in a cycle: a function of its view and nothing else, so that who comes back says the same again.
fn decide(view: &View, seat: Seat) -> Vec<Command> {
    let own: Vec<Handle> = view.objects_of(seat).map(|(handle, _)| handle).collect();
    let cycle = view.cycle().0;
    let chosen = own.iter().filter(|handle| (handle.0 * 7 + cycle).is_multiple_of(5));
    let goal = |handle: &Handle| {
        let mix = (cycle * 31 + handle.0 * 17 + u32::from(seat.0) * 11) % 97;
        DVec2::new(8.0 + f64::from(mix % 8), 1.5 + f64::from(mix % 9))
    };
    let order = |handle: &Handle| {
        let DVec2 { x, y } = goal(handle);
        Command::Move { object: *handle, x, y, s: None, queue: false, start: None }
    };
    chosen.map(order).collect()
}

/// Returns how the match ends where nothing happens to it.
fn uninterrupted(folder: &Path) -> MatchResult {
    let mut referee = Referee::new(loaded(folder), ClockMode::Lockstep).unwrap();
    for seat in 0..2 {
        referee.handle_join(Seat(seat), NAMES[usize::from(seat)]).unwrap();
    }
    while referee.result().is_none() {
        for seat in [Seat(0), Seat(1)] {
            let commands = decide(referee.view(seat), seat);
            let sequenced = (0..).zip(commands).map(|(seq, command)| Sequenced { seq, command }).collect();
            let cycle = referee.cycle();
            referee.take_delta(seat);
            referee.handle_commands(seat, cycle, sequenced).unwrap();
            referee.handle_done(seat, cycle);
        }
        referee.take_records();
        referee.step();
    }
    referee.result().cloned().unwrap()
}

fn write_scenario(folder: &Path) {
    let cycles = (KILLS + 3) * CYCLES_APART;
    let (scenario, map) = tiny(&format!("rate = 8\nlength_seconds = {}", f64::from(cycles) / 8.0));
    std::fs::write(folder.join("tiny.toml"), scenario).unwrap();
    std::fs::write(folder.join("tiny.map"), map).unwrap();
}

fn loaded(folder: &Path) -> Loaded {
    struct Disk;
    impl Resolver for Disk {
        fn resolve(&self, path: &str) -> Result<Vec<u8>, String> {
            std::fs::read(path).map_err(|error| error.to_string())
        }
    }
    load(&Disk, folder.join("tiny.toml").to_str().unwrap(), &Overrides::default()).unwrap()
}

/// Returns an address that is free now.
fn free_address() -> String {
    TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().to_string()
}
