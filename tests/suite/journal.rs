//! What is left of a match is taken up again, or said to be damaged, whatever happened to its journal.

use std::fs;
use std::future::pending;
use std::path::{Path, PathBuf};
use std::time::Duration;

use maniple_client::{Client, Event};
use maniple_protocol::{Record, encode_snapshot, read_partial};
use maniple_referee::Referee;
use maniple_server::{Access, House, JournalError, Journals, Limits, Match, RETURN_TIMEOUT, Server};
use maniple_view::{ClockMode, Seat};
use tokio::sync::oneshot;
use tokio::time::Instant;
use tokio_util::sync::CancellationToken;

use crate::arena::{bot, loaded, login};
use crate::commands::folder;

/// Bytes at the end of a journal of which each may be the last that is left.
const TAIL: usize = 4096;

#[tokio::test(flavor = "multi_thread")]
async fn a_journal_that_is_cut_anywhere_goes_on_at_its_last_whole_cycle_and_a_flipped_bit_is_named() {
    let folder = folder("journal_cut");
    let (id, bytes) = broken_off(&folder, 60).await;
    let whole = read_partial(&bytes).unwrap();
    let hashes: Vec<_> = whole
        .replay
        .records
        .iter()
        .filter_map(|record| match record {
            Record::Cycle { cycle, hash } => Some((*cycle, *hash)),
            Record::Joined { .. }
            | Record::Commands { .. }
            | Record::Absent { .. }
            | Record::Ended { .. } => None,
        })
        .collect();
    let path = folder.join(&id).join("journal");
    let mut goes_on_at = Vec::new();
    for length in bytes.len().saturating_sub(TAIL)..=bytes.len() {
        fs::write(&path, &bytes[..length]).unwrap();
        let resumed = journals(&folder).resume().unwrap();
        let [game] = &resumed.matches[..] else { panic!("cut to {length}: {:?}", resumed.errors) };
        let kept = fs::read(&path).unwrap();
        assert_eq!(kept, bytes[..kept.len()], "cut to {length}");
        let partial = read_partial(&kept).unwrap();
        let is_hash = |record: &Record| matches!(record, Record::Cycle { .. });
        assert!(partial.replay.records.last().is_some_and(is_hash), "cut to {length}: half a cycle");
        let cycle = game.cycle();
        assert_eq!((cycle, game.hash()), hashes[cycle.0 as usize], "cut to {length}");
        goes_on_at.push(cycle.0);
    }
    assert!(goes_on_at.is_sorted() && goes_on_at.first() < goes_on_at.last());
    // What a disk had made room for when the power went.
    fs::write(&path, [&bytes[..], &[0; 512]].concat()).unwrap();
    assert_eq!(journals(&folder).resume().unwrap().matches.len(), 1);
    let mut at = 0;
    let mut flips = 0;
    while at < bytes.len() {
        let mut altered = bytes.clone();
        altered[at] ^= 1 << (flips % 8);
        fs::write(&path, &altered).unwrap();
        let resumed = journals(&folder).resume().unwrap();
        assert!(resumed.matches.is_empty(), "byte {at}: it goes on");
        let [JournalError::Altered { path: named, problem }] = &resumed.errors[..] else {
            panic!("byte {at}: {:?}", resumed.errors)
        };
        assert_eq!((named, fs::read(&path).unwrap() == altered), (&path, true), "{problem}");
        flips += 1;
        at += 1 + flips % 7;
    }
    assert!(flips > bytes.len() / 8);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_match_is_taken_up_with_its_tokens_and_waits_for_its_players() {
    let folder = folder("journal_resumed");
    let (id, _) = broken_off(&folder, 20).await;
    let resumed = journals(&folder).resume().unwrap();
    let [game] = &resumed.matches[..] else { panic!("{:?}", resumed.errors) };
    assert_eq!((game.id().to_string(), game.clock()), (id, ClockMode::Lockstep));
    let tokens: Vec<String> = game.access().iter().map(token).collect();
    drop(resumed);
    // To its end, by the same players.
    let server = server(&folder);
    let address = server.local_addr().unwrap().to_string();
    let game = server.house().lobby().resume().unwrap().matches.pop().unwrap();
    let cycle = game.cycle();
    let running = tokio::spawn(async move { server.run(game, pending()).await });
    let mut first = Client::connect(&address, login(0, &tokens[0])).await.unwrap();
    let Event::Cycle(keyframe) = first.next().await.unwrap() else { panic!("a keyframe") };
    assert_eq!(keyframe.cycle, cycle);
    first.done().await.unwrap();
    // Nothing is played before the other is back.
    assert!(tokio::time::timeout(Duration::from_millis(200), first.next()).await.is_err());
    let second = Client::connect(&address, login(1, &tokens[1])).await.unwrap();
    let players = [(first, 0), (second, 1)].map(|(mut client, seat)| {
        tokio::spawn(async move {
            let mut bot = bot("straight", seat);
            bot.on_start(client.seat(), client.rules(), client.terrain());
            client.done().await.unwrap();
            client.play(|view, delta| bot.on_cycle(view, delta)).await.unwrap()
        })
    });
    for player in players {
        player.await.unwrap();
    }
    let result = running.await.unwrap().unwrap().unwrap();
    let mut finished = fs::read_dir(folder.join("finished")).unwrap();
    let replay = fs::read(finished.next().unwrap().unwrap().path()).unwrap();
    let replay = maniple_protocol::read_replay(&replay).unwrap();
    let mut referee = Referee::new(loaded(LOCKSTEP), ClockMode::Lockstep).unwrap();
    for event in maniple_server::events(&replay) {
        referee.handle_record(&event).unwrap();
    }
    assert_eq!(referee.result(), Some(&result));
    assert!(journals(&folder).resume().unwrap().matches.is_empty(), "nothing is left");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_match_goes_on_from_a_snapshot_and_without_one_where_it_is_of_no_use() {
    let folder = folder("journal_snapshot");
    let (id, bytes) = broken_off(&folder, 40).await;
    let partial = read_partial(&bytes).unwrap();
    let mut referee = Referee::new(loaded(LOCKSTEP), ClockMode::Lockstep).unwrap();
    referee.open_stands();
    let (path, journal) = (folder.join(&id).join("snapshot"), folder.join(&id).join("journal"));
    let mut ends = Vec::new();
    for event in maniple_server::events(&partial.replay) {
        referee.handle_record(&event).unwrap();
        if referee.cycle().0 == 20 && ends.is_empty() {
            let snapshot = encode_snapshot(&referee.snapshot()).unwrap();
            let altered = [&snapshot[..40], b"?", &snapshot[41..]].concat();
            ends.extend([snapshot, altered, b"nonsense".to_vec()]);
        }
    }
    for snapshot in ends {
        fs::write(&path, &snapshot).unwrap();
        let resumed = journals(&folder).resume().unwrap();
        let [game] = &resumed.matches[..] else { panic!("{:?}", resumed.errors) };
        assert_eq!((game.cycle(), game.hash()), (referee.cycle(), referee.hash()));
        // From a snapshot, what is before it is not looked at.
        assert_eq!(fs::read(&journal).unwrap().len(), partial.whole_bytes);
    }
}

#[test]
fn a_folder_is_used_by_one_daemon_at_a_time() {
    let folder = folder("journal_locked");
    let first = journals(&folder);
    let second = Journals::open(&folder, INTERVAL).err();
    assert!(matches!(second, Some(JournalError::Locked { .. })), "{second:?}");
    drop(first);
    journals(&folder);
}

/// As that of a daemon that was killed a moment ago, or of a process that is just being started.
#[test]
fn a_lock_that_goes_soon_is_waited_for() {
    let folder = folder("journal_lock_goes");
    let first = journals(&folder);
    let going = std::thread::spawn(move || {
        std::thread::sleep(Duration::from_millis(200));
        drop(first);
    });
    journals(&folder);
    going.join().expect("it ends");
}

const LOCKSTEP: &str = "length_seconds = 30";

const INTERVAL: Duration = Duration::from_millis(10);

fn journals(folder: &Path) -> Journals {
    Journals::open(folder, INTERVAL).unwrap()
}

fn server(folder: &Path) -> Server {
    let house = House::new(Limits::default(), [].into(), Some(journals(folder)), 1).unwrap();
    Server::open("127.0.0.1:0".parse().unwrap(), house).unwrap()
}

fn token(access: &Access) -> String {
    match access {
        Access::Token(token) => token.to_string(),
        Access::Open => String::new(),
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn no_time_passes_before_the_players_of_a_match_that_is_taken_up_are_back() {
    let folder = folder("journal_waits");
    let (_, _) = broken_off_of(&folder, 20, (REALTIME, ClockMode::Realtime)).await;
    let server = server(&folder);
    let address = server.local_addr().unwrap().to_string();
    let game = server.house().lobby().resume().unwrap().matches.pop().unwrap();
    let tokens: Vec<String> = game.access().iter().map(token).collect();
    let running = tokio::spawn(async move { server.run(game, pending()).await });
    let mut first = Client::connect(&address, login(0, &tokens[0])).await.unwrap();
    let Event::Cycle(keyframe) = first.next().await.unwrap() else { panic!("a keyframe") };
    // Fifteen cycles long.
    assert!(tokio::time::timeout(Duration::from_millis(300), first.next()).await.is_err());
    let second = Client::connect(&address, login(1, &tokens[1])).await.unwrap();
    let Event::Cycle(delta) = first.next().await.unwrap() else { panic!("a delta") };
    assert_eq!(delta.cycle, keyframe.cycle.next());
    drop((first, second));
    running.abort();
}

#[test]
fn a_match_that_is_taken_up_goes_on_without_who_does_not_come_back() {
    let folder = folder("journal_alone");
    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build().unwrap();
    runtime.block_on(broken_off_of(&folder, 20, (REALTIME, ClockMode::Realtime)));
    let mut simulated = tokio::runtime::Builder::new_current_thread();
    simulated.enable_all().start_paused(true).build().unwrap().block_on(async {
        let house = House::new(Limits::default(), [].into(), Some(journals(&folder)), 0).unwrap();
        let game = house.lobby().resume().unwrap().matches.pop().unwrap();
        let (id, token) = (game.id(), token(&game.access()[0]));
        house.lobby().take_in(game).unwrap();
        let begun = Instant::now();
        let (nearby, far) = tokio::io::duplex(1 << 16);
        house.receive(nearby, "192.0.2.1:9".parse().unwrap(), &CancellationToken::new());
        let mut alone = Client::over(far, Some(id), login(0, &token)).await.unwrap();
        let Event::Cycle(keyframe) = alone.next().await.unwrap() else { panic!("a keyframe") };
        let next = tokio::time::timeout(10 * RETURN_TIMEOUT, alone.next()).await;
        let Event::Cycle(delta) = next.expect("it goes on").unwrap() else { panic!("a delta") };
        assert_eq!(delta.cycle, keyframe.cycle.next());
        let waited = begun.elapsed();
        assert!((RETURN_TIMEOUT..RETURN_TIMEOUT + Duration::from_secs(1)).contains(&waited), "{waited:?}");
    });
}

/// A match of which a cycle is played every 20 ms.
const REALTIME: &str = "rate = 50\nlength_seconds = 3600";

/// Plays so many cycles of a match in lock-step and breaks it off; returns the folder that is left of it, and its journal.
async fn broken_off(folder: &Path, cycles: u32) -> (String, Vec<u8>) {
    broken_off_of(folder, cycles, (LOCKSTEP, ClockMode::Lockstep)).await
}

/// Plays so many cycles of a match and breaks it off; returns the folder that is left of it, and its journal.
async fn broken_off_of(folder: &Path, cycles: u32, (clock, mode): (&str, ClockMode)) -> (String, Vec<u8>) {
    let server = server(folder);
    let address = server.local_addr().unwrap().to_string();
    let game = Match::with_random_tokens(Referee::new(loaded(clock), mode).unwrap()).unwrap();
    let id = game.id().to_string();
    let tokens: Vec<String> = game.access().iter().map(token).collect();
    let (stop, stopped) = oneshot::channel();
    let running = tokio::spawn(async move {
        let shutdown = async {
            if stopped.await.is_err() {
                pending::<()>().await;
            }
        };
        server.run(game, shutdown).await
    });
    let mut clients = Vec::new();
    for (seat, token) in (0..).zip(&tokens) {
        clients.push((
            Client::connect(&address, login(usize::from(seat), token)).await.unwrap(),
            bot("straight", seat),
        ));
    }
    for (client, bot) in &mut clients {
        bot.on_start(client.seat(), client.rules(), client.terrain());
    }
    while clients[0].0.view().cycle().0 < cycles {
        for (client, bot) in &mut clients {
            let Event::Cycle(delta) = client.next().await.unwrap() else { continue };
            let commands = bot.on_cycle(client.view(), &delta);
            client.send(commands).await.unwrap();
            client.done().await.unwrap();
        }
    }
    stop.send(()).unwrap();
    assert_eq!(running.await.unwrap().unwrap(), None);
    let journal: PathBuf = folder.join(&id).join("journal");
    assert_eq!(Seat(0), clients[0].0.seat());
    (id, fs::read(journal).unwrap())
}
