//! The server, two players and a spectator in one process, in simulated time and over a simulated network that fails.
//!
//! Everything follows from a seed. Faults come for a while: partitions, losses one way, resets, readers that stop, storms of connections,
//! crashes of the server, which goes on from its journal, and jumps of its clock. Then they stop, and everybody has to see the match to its
//! end, in which all agree.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::net::{IpAddr, Ipv4Addr};
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::time::Duration;

use maniple_client::{Client, Event, Spectator};
use maniple_game::{Files, Loaded, LoadedFile, Overrides, load};
use maniple_geometry::Cycle;
use maniple_protocol::read_replay;
use maniple_referee::Referee;
use maniple_server::{Access, House, Journals, Limits, Match, Token, events};
use maniple_view::{ClockMode, Digest, MatchResult, Seat, Vantage, View};
use tokio::time::{Instant, sleep, timeout};
use tokio_util::sync::CancellationToken;
use turmoil::net::{TcpListener, TcpStream};
use turmoil::{Builder, Sim};

use crate::arena::{bot, login, tiny};
use crate::commands::folder;

/// Seeds of the ordinary run; `MANIPLE_SEEDS=1000` plays as many, `MANIPLE_SEED=7` the one with this number.
const SEEDS: u64 = 100;

const PORT: u16 = 7171;

/// The match.
const SCENARIO: &str = "rate = 8\nlength_seconds = 40\nspectators = { views = 'all', delay_seconds = 0 }";

/// Until when faults begin, in simulated time.
const FAULTS_END: Duration = Duration::from_secs(24);

/// Simulated time in which all must be over: a server that crashes loses time, not cycles.
const LONGEST: Duration = Duration::from_secs(400);

/// A client that gets nothing for so long connects again.
const PATIENCE: Duration = Duration::from_secs(3);

const PLAYERS: [&str; 2] = ["ada", "bob"];

const SPECTATOR: &str = "eve";

#[test]
fn whatever_fails_all_see_the_match_to_its_end_and_agree() {
    let number = |name: &str| std::env::var(name).ok().map(|text| text.parse::<u64>().unwrap());
    let seeds = match number("MANIPLE_SEED") {
        Some(seed) => seed..seed + 1,
        None => 0..number("MANIPLE_SEEDS").unwrap_or(SEEDS),
    };
    let count = seeds.end - seeds.start;
    let mut fired = BTreeMap::<Fault, u64>::new();
    for seed in seeds {
        let played = std::panic::catch_unwind(|| play(seed));
        let played = played.unwrap_or_else(|panic| {
            eprintln!("with MANIPLE_SEED={seed} the test plays this seed alone");
            std::panic::resume_unwind(panic)
        });
        for fault in played {
            *fired.entry(fault).or_default() += 1;
        }
    }
    println!("{count} seeds: {fired:?}");
    for fault in Fault::ALL {
        let times = fired.get(&fault).copied().unwrap_or(0);
        assert!(count < SEEDS || times >= count / 10, "{fault:?} {times} times in {count} seeds");
    }
}

/// What fails.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Fault {
    /// Nothing gets through between the server and a client.
    Partition,
    /// Nothing gets through one way.
    OneWay,
    /// A client loses its connection.
    Reset,
    /// A client stops reading.
    SlowReader,
    /// A client connects again and again.
    Storm,
    /// The server is gone, and comes back with what its journal has.
    Crash,
    /// The clock of the server jumps.
    ClockJump,
}

impl Fault {
    const ALL: [Self; 7] = [
        Self::Partition,
        Self::OneWay,
        Self::Reset,
        Self::SlowReader,
        Self::Storm,
        Self::Crash,
        Self::ClockJump,
    ];
}

/// Numbers that follow from a seed.
struct Dice(u64);

impl Dice {
    fn below(&mut self, limit: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % limit
    }

    fn below_usize(&mut self, limit: u64) -> usize {
        usize::try_from(self.below(limit)).unwrap()
    }
}

/// What all in a simulation share.
#[derive(Default)]
struct Shared {
    /// Number of the match and tokens of the seats.
    opened: Option<(Digest, Vec<String>)>,
    /// By client, what is left of a fault that it has to play itself: reading nothing for so long, and connections to be made.
    slow: BTreeMap<String, Duration>,
    storms: BTreeMap<String, usize>,
    clock_jump: Option<Duration>,
    fired: Vec<Fault>,
    /// By client, what it saw last.
    ended: BTreeMap<String, (MatchResult, View)>,
    /// By client, the last cycle of which it was told.
    told: BTreeMap<String, Cycle>,
    /// By client, whether it has been welcomed since the last fault of its own.
    is_connected: BTreeMap<String, bool>,
    /// By client, why it did not get in the last time that it did not.
    refusals: BTreeMap<String, String>,
}

impl Shared {
    fn text(&self) -> String {
        format!(
            "{:?} have ended; {:?}; {:?}; {:?}",
            self.ended.keys(),
            self.fired,
            self.is_connected,
            self.refusals
        )
    }
}

type Board = Rc<RefCell<Shared>>;

/// Plays a seed; returns the faults that were really felt.
fn play(seed: u64) -> Vec<Fault> {
    let folder = folder(&format!("faults/{seed}"));
    let board = Board::default();
    let mut builder = Builder::new();
    builder.rng_seed(seed).tick_duration(Duration::from_millis(5)).tcp_capacity(1 << 16);
    builder.simulation_duration(LONGEST).max_message_latency(Duration::from_millis(40));
    let mut sim = builder.build();
    let (kept, shared) = (folder.join("kept"), Rc::clone(&board));
    sim.host("server", move || serve(kept.clone(), Rc::clone(&shared)));
    for (seat, name) in (0u16..).zip(PLAYERS) {
        let shared = Rc::clone(&board);
        sim.host(name, move || player(seat, Rc::clone(&shared)));
    }
    let shared = Rc::clone(&board);
    sim.host(SPECTATOR, move || spectator(Rc::clone(&shared)));
    let mut dice = Dice(seed);
    let mut next = Duration::from_secs(2);
    let mut healing: Vec<(Duration, Healing)> = Vec::new();
    while board.borrow().ended.len() < 3 {
        assert!(sim.elapsed() < LONGEST, "seed {seed}: not over for all: {}", board.borrow().text());
        sim.step().unwrap_or_else(|error| panic!("seed {seed}: {error}"));
        let now = sim.elapsed();
        for (_, healing) in healing.extract_if(.., |(at, _)| *at <= now) {
            healing.heal(&mut sim);
        }
        if now >= next && now < FAULTS_END {
            next = now + Duration::from_millis(500 + dice.below(2500));
            healing.extend(strike(&mut sim, &mut dice, &board));
        }
    }
    check(seed, &folder, &board);
    drop(sim);
    std::fs::remove_dir_all(&folder).unwrap();
    board.borrow().fired.clone()
}

/// Returns the start of the match, which lasts its whole length whatever the players do.
fn start() -> Loaded {
    let (scenario, map) = tiny(SCENARIO);
    let scenario = scenario.replace("kind = 'race', zone_size = 3", "kind = 'resources'");
    let file = |path: &str, text: String| LoadedFile { path: path.to_owned(), bytes: text.into_bytes() };
    let files = Files(vec![file("tiny.toml", scenario), file("tiny.map", map)]);
    load(&files, "tiny.toml", &Overrides::default()).unwrap()
}

/// What has to be done so that a fault is over.
enum Healing {
    Repair(&'static str),
    Restart,
}

impl Healing {
    fn heal(self, sim: &mut Sim<'_>) {
        match self {
            Self::Repair(client) => sim.repair("server", client),
            Self::Restart => sim.bounce("server"),
        }
    }
}

/// Lets something fail; returns when it is over, and how, if it does not end by itself.
fn strike(sim: &mut Sim<'_>, dice: &mut Dice, board: &Board) -> Option<(Duration, Healing)> {
    let client = [PLAYERS[0], PLAYERS[1], SPECTATOR][dice.below_usize(3)];
    let fault = Fault::ALL[dice.below_usize(7)];
    let until = sim.elapsed() + Duration::from_millis(300 + dice.below(6000));
    let is_connected = board.borrow().is_connected.get(client).copied().unwrap_or(false);
    if !is_connected || !sim.is_host_running("server") {
        return None;
    }
    match fault {
        Fault::Partition => sim.partition("server", client),
        Fault::OneWay if dice.below(2) == 0 => sim.partition_oneway("server", client),
        Fault::OneWay => sim.partition_oneway(client, "server"),
        Fault::Reset => sim.bounce(client),
        Fault::Crash => sim.crash("server"),
        Fault::SlowReader => {
            board.borrow_mut().slow.insert(client.to_owned(), Duration::from_millis(dice.below(8000)));
        }
        Fault::Storm => {
            board.borrow_mut().storms.insert(client.to_owned(), 5 + dice.below_usize(20));
        }
        Fault::ClockJump => {
            board.borrow_mut().clock_jump = Some(Duration::from_millis(dice.below(5000)));
        }
    }
    match fault {
        Fault::Partition | Fault::OneWay => {
            board.borrow_mut().fired.push(fault);
            Some((until, Healing::Repair(client)))
        }
        Fault::Crash => {
            board.borrow_mut().fired.push(fault);
            Some((until, Healing::Restart))
        }
        Fault::Reset => {
            board.borrow_mut().fired.push(fault);
            None
        }
        // Noted by whoever does it.
        Fault::SlowReader | Fault::Storm | Fault::ClockJump => None,
    }
}

/// The server: the match of its journal, or a new one.
async fn serve(kept: PathBuf, board: Board) -> turmoil::Result {
    let journals = Journals::open(&kept, Duration::from_millis(100))?;
    let house = House::new(Limits::default(), BTreeMap::new(), Some(journals), 0)?;
    let resumed = house.lobby().resume()?;
    assert!(resumed.errors.is_empty(), "{:?}", resumed.errors);
    let mut games = resumed.matches;
    let has_begun = board.borrow().opened.is_some();
    if !has_begun {
        let referee = Referee::new(start(), ClockMode::Realtime)?;
        let tokens = [Token::random()?, Token::random()?];
        let game = Match::new(referee, tokens.map(Access::Token).to_vec())?;
        let told = (game.id(), tokens.iter().map(Token::to_string).collect());
        board.borrow_mut().opened = Some(told);
        games.push(game);
    }
    for game in games {
        house.lobby().take_in(game)?;
    }
    let listener = TcpListener::bind((IpAddr::V4(Ipv4Addr::UNSPECIFIED), PORT)).await?;
    let closing = CancellationToken::new();
    loop {
        let accepted = timeout(Duration::from_millis(50), listener.accept()).await;
        if let Ok(accepted) = accepted {
            let (stream, peer) = accepted?;
            house.receive(stream, peer, &closing);
        }
        let jump = board.borrow_mut().clock_jump.take();
        if let Some(by) = jump {
            board.borrow_mut().fired.push(Fault::ClockJump);
            tokio::time::advance(by).await;
        }
    }
}

/// A player, who comes back whenever the connection is lost, or nothing is heard for a while.
async fn player(seat: u16, board: Board) -> turmoil::Result {
    let name = PLAYERS[usize::from(seat)];
    loop {
        let Some((id, tokens)) = opened(&board).await else { continue };
        storm(name, &board).await;
        let Some(stream) = connect().await else { continue };
        let login = login(usize::from(seat), &tokens[usize::from(seat)]);
        let mut client = match timeout(PATIENCE, Client::over(stream, Some(id), login)).await {
            Ok(Ok(client)) => client,
            other => {
                note_refusal(name, &board, &format!("{other:?}"));
                rest().await;
                continue;
            }
        };
        let mut bot = bot("random", seat);
        bot.on_start(client.seat(), client.rules(), client.terrain());
        note_connected(name, &board, true);
        while let Ok(Ok(event)) = timeout(PATIENCE, client.next()).await {
            match event {
                Event::Cycle(delta) => {
                    note_cycle(name, &board, delta.cycle);
                    let commands = bot.on_cycle(client.view(), &delta);
                    if client.send(commands).await.is_err() {
                        break;
                    }
                    if dawdle(name, &board).await == Going::Away {
                        break;
                    }
                }
                Event::Ended(result) => {
                    board.borrow_mut().ended.insert(name.to_owned(), (result, client.view().clone()));
                    return Ok(());
                }
                Event::Pong { .. } | Event::Paused { .. } | Event::Warned { .. } => {}
            }
        }
        note_connected(name, &board, false);
    }
}

/// A spectator of everything, who comes back, too.
async fn spectator(board: Board) -> turmoil::Result {
    loop {
        let Some((id, _)) = opened(&board).await else { continue };
        storm(SPECTATOR, &board).await;
        let Some(stream) = connect().await else { continue };
        let watch = Spectator::over(stream, Some(id), "suite", Vantage::Everything);
        let mut spectator = match timeout(PATIENCE, watch).await {
            Ok(Ok(spectator)) => spectator,
            other => {
                note_refusal(SPECTATOR, &board, &format!("{other:?}"));
                rest().await;
                continue;
            }
        };
        note_connected(SPECTATOR, &board, true);
        while let Ok(Ok(event)) = timeout(PATIENCE, spectator.next()).await {
            if let Event::Ended(result) = &event {
                let seen = (result.clone(), spectator.view().clone());
                board.borrow_mut().ended.insert(SPECTATOR.to_owned(), seen);
                return Ok(());
            }
            if let Event::Cycle(delta) = &event {
                note_cycle(SPECTATOR, &board, delta.cycle);
            }
            if dawdle(SPECTATOR, &board).await == Going::Away {
                break;
            }
        }
        note_connected(SPECTATOR, &board, false);
    }
}

async fn opened(board: &Board) -> Option<(Digest, Vec<String>)> {
    let opened = board.borrow().opened.clone();
    if opened.is_none() {
        rest().await;
    }
    opened
}

async fn rest() {
    sleep(Duration::from_millis(100)).await;
}

async fn connect() -> Option<TcpStream> {
    match timeout(PATIENCE, TcpStream::connect(("server", PORT))).await {
        Ok(Ok(stream)) => Some(stream),
        Ok(Err(_)) | Err(_) => {
            rest().await;
            None
        }
    }
}

fn note_connected(name: &str, board: &Board, is_connected: bool) {
    board.borrow_mut().is_connected.insert(name.to_owned(), is_connected);
}

/// Notes that a client was told of a cycle. Time never goes back, whatever has happened: what was told is not taken back.
fn note_cycle(name: &str, board: &Board, cycle: Cycle) {
    let before = board.borrow_mut().told.insert(name.to_owned(), cycle);
    assert!(before.is_none_or(|before| before <= cycle), "{name}: {before:?}, then {cycle}");
}

/// Keeps the last reason why a client did not get in.
fn note_refusal(name: &str, board: &Board, reason: &str) {
    let note = format!("at {:?}: {reason}", turmoil::sim_elapsed());
    board.borrow_mut().refusals.insert(name.to_owned(), note);
}

/// Makes all connections of a storm, and leaves them.
async fn storm(name: &str, board: &Board) {
    let connections = board.borrow_mut().storms.remove(name).unwrap_or(0);
    for _ in 0..connections {
        drop(connect().await);
    }
    if connections > 0 {
        board.borrow_mut().fired.push(Fault::Storm);
    }
}

/// Whether a client stays.
#[derive(PartialEq, Eq)]
enum Going {
    On,
    Away,
}

/// Reads nothing for as long as a fault wants it, and leaves for a storm.
async fn dawdle(name: &str, board: &Board) -> Going {
    let slow = board.borrow_mut().slow.remove(name);
    if let Some(time) = slow {
        board.borrow_mut().fired.push(Fault::SlowReader);
        let start = Instant::now();
        sleep(time).await;
        assert!(start.elapsed() >= time);
    }
    if board.borrow().storms.contains_key(name) { Going::Away } else { Going::On }
}

/// Checks that all agree with what the server has kept.
fn check(seed: u64, folder: &Path, board: &Board) {
    let finished = folder.join("kept/finished");
    let mut replays: Vec<_> =
        std::fs::read_dir(finished).unwrap().map(|entry| entry.unwrap().path()).collect();
    assert_eq!(replays.len(), 1, "seed {seed}");
    let replay = read_replay(&std::fs::read(replays.remove(0)).unwrap()).unwrap();
    let mut referee = Referee::new(start(), ClockMode::Realtime).unwrap();
    referee.open_stands();
    for event in events(&replay) {
        referee.handle_record(&event).unwrap();
    }
    let result = referee.result().unwrap();
    for (name, (told, view)) in &board.borrow().ended {
        assert_eq!(told, result, "seed {seed}: {name}");
        let seat = PLAYERS.iter().position(|player| player == name);
        let expected = match seat {
            Some(seat) => referee.view(Seat(u16::try_from(seat).unwrap())),
            None => referee.stand(Vantage::Everything).unwrap().view(),
        };
        assert_eq!(view, expected, "seed {seed}: {name}");
    }
}
