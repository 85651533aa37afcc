//! The clients in `clients/`, as whoever copies them runs them: in whole matches against the real server.

use std::process::{Command, Output, Stdio};
use std::sync::{Arc, OnceLock};

use maniple_game::{Files, Loaded, LoadedFile, Overrides, load};
use maniple_protocol::{
    Encoding, FRAME_FROM_SERVER_MAX, FrameDecoder, Outbound, ServerMessage, Welcome, decode_server,
    encode_server,
};
use maniple_view::{ClockMode, Delta, MatchResult, Rules, View};
use serde_json::json;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};

use crate::arena::{Arena, bot};
use crate::commands::{ROOT, folder, skipped};
use crate::network::play_to_the_last;

/// A client, and how it is run.
#[derive(Clone)]
pub(crate) struct Program {
    pub(crate) name: &'static str,
    words: Vec<String>,
    options: &'static [&'static str],
    pub(crate) encoding: Encoding,
}

#[tokio::test(flavor = "multi_thread")]
async fn each_client_races_through_fog_and_walls_that_it_explores() {
    for program in programs() {
        play_to_the_end(&program, &race("positions = 'exact'", 40), "straight").await;
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn each_client_understands_positions_on_a_grid() {
    for program in programs() {
        play_to_the_end(&program, &race("positions = 'grid', grid_bits = 7", 40), "straight").await;
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn each_client_fights_trains_and_loses_units() {
    for program in programs() {
        let result = play_to_the_end(&program, &skirmish(), "commander").await;
        let tally = &result.scores[0].tally;
        let (made, lost, destroyed) = (tally.made, tally.units_lost, tally.units_destroyed);
        assert!(made > 0 && lost > 0 && destroyed > 0, "{}: {tally:?}", program.name);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn each_client_stops_when_a_single_bit_of_its_view_is_wrong() {
    for program in programs() {
        let arena = Arena::open(&race("positions = 'exact'", 40), ClockMode::Lockstep);
        let other = tokio::spawn(play_to_the_last(arena.client(1).await, bot("straight", 1)));
        let (encoding, mut is_flipped) = (program.encoding, false);
        let flipping = move |mut message| {
            is_flipped = is_flipped || flip(&mut message);
            encode_server(encoding, &message).unwrap()
        };
        let address = retold(&arena.address, encoding, flipping).await;
        let output = program.run(&address, &arena.tokens[0], &[]).await;
        let told = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{}: {told}", program.name);
        assert!(told.contains("the view hashes to"), "{}: {told}", program.name);
        arena.shut_down().await;
        assert!(other.await.unwrap().is_err());
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn each_client_begins_anew_at_a_keyframe_in_the_middle_of_a_match() {
    for program in programs() {
        let arena = Arena::open(&race("positions = 'exact'", 40), ClockMode::Lockstep);
        let other = tokio::spawn(play_to_the_last(arena.client(1).await, bot("straight", 1)));
        let mut anew = Anew { encoding: program.encoding, mirrored: None };
        let address = retold(&arena.address, program.encoding, move |message| anew.retell(message)).await;
        let output = program.run(&address, &arena.tokens[0], &[]).await;
        assert!(output.status.success(), "{}: {}", program.name, String::from_utf8_lossy(&output.stderr));
        let found: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        let result = arena.outcome().await.result.unwrap();
        let expected = (json!(result.hash), json!(result.cycles.0 + 1));
        assert_eq!((&found["hash"], &found["checks"]), (&expected.0, &expected.1), "{}", program.name);
        assert_eq!(other.await.unwrap().unwrap(), result);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn each_client_says_why_the_server_refused_it() {
    for program in programs() {
        let arena = Arena::open(&race("positions = 'exact'", 40), ClockMode::Lockstep);
        let output = program.run(&arena.address, "not a token", &[]).await;
        let told = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{}: {told}", program.name);
        assert!(told.contains("refused: ") && told.contains("token"), "{}: {told}", program.name);
        arena.shut_down().await;
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn the_bot_that_the_readme_of_the_clients_shows_plays_a_match_to_its_end() {
    if !is_there("python3") {
        return skipped("the bot of clients/README.md needs python3, which is not here");
    }
    let arena = Arena::open(&race("positions = 'exact'", 10), ClockMode::Lockstep);
    let other = tokio::spawn(play_to_the_last(arena.client(1).await, bot("straight", 1)));
    let readme = std::fs::read_to_string(format!("{ROOT}/clients/README.md")).unwrap();
    let shown = readme.split("```python\n").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    let (_, port) = arena.address.split_once(':').unwrap();
    let code = shown.replace("7171", port).replace("TOKEN", &arena.tokens[0]);
    let mut command = Command::new("python3");
    command.args(["-B", "-c", &code]).env("PYTHONPATH", format!("{ROOT}/clients"));
    let output = tokio::task::spawn_blocking(move || command.output().unwrap()).await.unwrap();
    let told = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let result = arena.outcome().await.result.unwrap();
    assert!(told.contains(&result.hash.to_string()), "{told}");
    assert_eq!(other.await.unwrap().unwrap(), result);
}

/// Plays a match in lock-step at seat 0 against a bot, and checks that the client tells the end as the server does, and
/// that all its checks agreed.
async fn play_to_the_end(program: &Program, loaded: &Loaded, opponent: &str) -> MatchResult {
    let arena = Arena::open(loaded, ClockMode::Lockstep);
    let other = tokio::spawn(play_to_the_last(arena.client(1).await, bot(opponent, 1)));
    let output = program.run(&arena.address, &arena.tokens[0], &[]).await;
    let (told, errors) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{}: {errors}", program.name);
    let found: serde_json::Value = serde_json::from_str(&told).unwrap();
    let result = arena.outcome().await.result.unwrap();
    let expected = json!({
        "seat": 0,
        "winners": result.winners,
        "cycles": result.cycles,
        "hash": result.hash,
        "checks": result.cycles.0 + 1,
    });
    assert_eq!(found, expected, "{}", program.name);
    assert_eq!(other.await.unwrap().unwrap(), result);
    result
}

/// Lets a client in at another address, and tells it what `retell` makes of each message of the server. Returns the address.
async fn retold(
    server: &str,
    encoding: Encoding,
    mut retell: impl FnMut(ServerMessage) -> Vec<u8> + Send + 'static,
) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let server = server.to_owned();
    tokio::spawn(async move {
        let (client, _) = listener.accept().await.unwrap();
        let (mut from_client, mut to_client) = client.into_split();
        let (mut from_server, mut to_server) = TcpStream::connect(server).await.unwrap().into_split();
        tokio::spawn(async move { tokio::io::copy(&mut from_client, &mut to_server).await });
        let mut frames = FrameDecoder::new(encoding, FRAME_FROM_SERVER_MAX);
        let mut buffer = vec![0; 4096];
        while let Ok(count @ 1..) = from_server.read(&mut buffer).await {
            frames.handle_bytes(&buffer[..count]);
            while let Some(body) = frames.poll().unwrap() {
                let retold = retell(decode_server(encoding, body).unwrap());
                if to_client.write_all(&retold).await.is_err() {
                    return;
                }
            }
        }
    });
    address
}

/// Tells a client keyframes where the server tells it deltas, as it does one that has lagged.
struct Anew {
    encoding: Encoding,
    /// From the welcome on.
    mirrored: Option<(Welcome, View, Outbound)>,
}

impl Anew {
    /// Cycles from one keyframe to the next.
    const INTERVAL: u32 = 70;

    fn retell(&mut self, message: ServerMessage) -> Vec<u8> {
        let encoding = self.encoding;
        let outbound = |rules: &Rules| Outbound::for_deltas(encoding, rules);
        if let ServerMessage::Welcome(welcome) = &message {
            let view = View::new(&welcome.rules, Arc::new(welcome.terrain.clone()));
            self.mirrored = Some((welcome.clone(), view, outbound(&welcome.rules)));
        }
        let Some((Welcome { rules, .. }, view, packing)) = &mut self.mirrored else {
            return encode_server(encoding, &message).unwrap();
        };
        let delta = if let ServerMessage::Delta(delta) = message {
            delta
        } else if let ServerMessage::Packed(packed) = message {
            packed.unpack(view, rules).unwrap()
        } else {
            return encode_server(encoding, &message).unwrap();
        };
        view.apply(&delta).unwrap();
        if view.cycle().0 == 0 || !view.cycle().0.is_multiple_of(Self::INTERVAL) {
            return packing.encode(&ServerMessage::Delta(delta)).unwrap();
        }
        *packing = outbound(rules);
        let keyframe = Delta { results: delta.results, ended: delta.ended, ..view.keyframe() };
        let announced = encode_server(encoding, &ServerMessage::Keyframe {}).unwrap();
        [announced, packing.encode(&ServerMessage::Delta(keyframe)).unwrap()].concat()
    }
}

/// Flips a bit of the first coordinate in a keyframe; returns whether there is one.
fn flip(message: &mut ServerMessage) -> bool {
    match message {
        ServerMessage::Delta(delta) => {
            let Some(appeared) = delta.appeared.first_mut() else { return false };
            appeared.base.point.x = f64::from_bits(appeared.base.point.x.to_bits() ^ 1);
            true
        }
        ServerMessage::Packed(packed) => {
            // Behind the flags of the first motion.
            let Some(byte) = packed.motions.get_mut(1) else { return false };
            *byte ^= 1;
            true
        }
        ServerMessage::Welcome(_)
        | ServerMessage::Refused { .. }
        | ServerMessage::Pong { .. }
        | ServerMessage::Ended { .. }
        | ServerMessage::Paused { .. }
        | ServerMessage::Matches { .. }
        | ServerMessage::Created { .. }
        | ServerMessage::Keyframe {}
        | ServerMessage::Warned { .. } => false,
    }
}

impl Program {
    /// Runs it to its end.
    pub(crate) async fn run(&self, address: &str, token: &str, options: &[&str]) -> Output {
        let (host, port) = address.split_once(':').unwrap();
        let mut command = Command::new(&self.words[0]);
        command.args(&self.words[1..]).args([host, port, token]).args(self.options).args(options);
        command.current_dir(ROOT).stdin(Stdio::null());
        tokio::task::spawn_blocking(move || command.output().unwrap()).await.unwrap()
    }
}

/// Returns the clients that this machine can run, and says which it cannot.
pub(crate) fn programs() -> Vec<Program> {
    let program = |name, words: &[&str], options, encoding| Program {
        name,
        words: words.iter().map(|&word| word.to_owned()).collect(),
        options,
        encoding,
    };
    let mut programs = Vec::new();
    let python = ["python3", "clients/maniple.py"];
    let node = ["node", "clients/maniple.mjs"];
    if is_there("python3") {
        programs.push(program("Python, JSON", &python, &[], Encoding::Json));
        programs.push(program("Python, binary", &python, &["--binary"], Encoding::Binary));
    } else {
        skipped("clients/maniple.py needs python3, which is not here");
    }
    if is_there("node") {
        programs.push(program("JavaScript, JSON", &node, &[], Encoding::Json));
        programs.push(program("JavaScript, binary", &node, &["--binary"], Encoding::Binary));
    } else {
        skipped("clients/maniple.mjs needs node, which is not here");
    }
    match compiled() {
        Some(path) => programs.push(program("C, JSON", &[path], &[], Encoding::Json)),
        None => skipped("clients/maniple.c needs the compiler cc, which is not here"),
    }
    programs
}

/// Returns the client in C, compiled once for all tests; `None` where there is no compiler.
fn compiled() -> Option<&'static str> {
    static COMPILED: OnceLock<Option<String>> = OnceLock::new();
    let compile = || {
        is_there("cc").then(|| {
            let path = folder("client_in_c").join("maniple-c").display().to_string();
            let warnings = ["-std=c99", "-Wall", "-Wextra", "-Werror"];
            let mut compiler = Command::new("cc");
            compiler.args(["-O2", "-ffp-contract=off"]).args(warnings);
            compiler.args(["-o", &path, "clients/maniple.c", "-lm"]).current_dir(ROOT);
            let output = compiler.output().unwrap();
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
            path
        })
    };
    COMPILED.get_or_init(compile).as_deref()
}

fn is_there(program: &str) -> bool {
    Command::new(program).arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok()
}

/// Returns a race of so many seconds over obstacles that nobody knows at the start, with this `[view]`.
pub(crate) fn race(view: &str, seconds: u32) -> Loaded {
    let seat = "{ groups = [{ unit = 'scout', count = 6 }] }";
    scenario(&format!(
        "name = 'race'\nlength_seconds = {seconds}\nseed = 3\nobjective = {{ kind = 'race' }}\nseat = [{seat}, {seat}]\n\
         vision = {{ terrain = 'explored', walls_block = true }}\nview = {{ {view} }}\n\
         unit.scout = {{ radius = 0.3, speed = 3, sight = 6 }}\n\
         [generate]\nkind = 'obstacles'\nwidth = 32\nheight = 32\n"
    ))
}

/// Returns a match in which units are trained, switched, shot at and shot.
fn skirmish() -> Loaded {
    let unit = |name: &str, count: u32| format!("{{ unit = '{name}', count = {count} }}");
    let groups = [
        unit("control_center", 1),
        unit("barracks", 1),
        unit("worker", 4),
        unit("marine", 4),
        unit("siege_tank", 2),
    ];
    let seat = format!("{{ stock = 600, groups = [{}] }}", groups.join(", "));
    scenario(&format!(
        "name = 'skirmish'\nlength_seconds = 75\nseed = 3\nunits = ['orts.toml']\n\
         objective = {{ kind = 'buildings' }}\nseat = [{seat}, {seat}]\nvision = {{ terrain = 'explored' }}\n\
         combat = {{}}\nharvest = {{ patch = 'mineral' }}\nproduction = {{}}\nmodes = {{}}\n\
         [generate]\nkind = 'obstacles'\nwidth = 48\nheight = 48\nclusters = 3\npatches = 4\namount = 300\n"
    ))
}

fn scenario(text: &str) -> Loaded {
    let units = std::fs::read(format!("{ROOT}/config/units/orts.toml")).unwrap();
    let files = Files(vec![
        LoadedFile { path: "scenario.toml".to_owned(), bytes: text.as_bytes().to_vec() },
        LoadedFile { path: "orts.toml".to_owned(), bytes: units },
    ]);
    load(&files, "scenario.toml", &Overrides::default()).unwrap()
}
