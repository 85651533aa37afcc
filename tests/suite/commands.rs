//! The program as its users run it: output, errors and exit codes.

use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use maniple_protocol::{Record, Replay, ReplayHeader, ReplayWriter, read_replay};
use serde_json::Value;

pub(crate) const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../..");

/// Maps that the project may not ship; they lie beside its checkout.
const REAL_MAPS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../../shared/maps");

/// Returns the program with arguments, to be run in the root of the project.
pub(crate) fn maniple(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_maniple"));
    command.args(arguments).current_dir(ROOT).stdin(Stdio::null());
    command
}

pub(crate) fn run(arguments: &[&str]) -> Output {
    maniple(arguments).output().expect("the program runs")
}

/// Runs a command that succeeds and returns the JSON that it prints.
pub(crate) fn json(arguments: &[&str]) -> Value {
    let output = run(arguments);
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{arguments:?}: {error}"))
}

/// Runs a command that fails, and returns what it writes to standard error.
pub(crate) fn fails(arguments: &[&str], code: i32) -> String {
    let output = run(arguments);
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {error}");
    error
}

/// Says that something was not tested. The test harness captures what `eprintln!` writes, but not this.
pub(crate) fn skipped(what: &str) {
    let said = writeln!(std::io::stderr(), "SKIPPED: {what}");
    said.expect("standard error takes a line");
}

/// A folder for the files of one test; emptied at the start.
pub(crate) fn folder(test: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(test);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("the folder can be made");
    folder
}

pub(crate) fn file(folder: &Path, name: &str, text: &str) -> String {
    let path = folder.join(name);
    std::fs::write(&path, text).expect("the file can be written");
    path.display().to_string()
}

#[test]
fn every_command_has_help_with_an_example() {
    for command in [
        "map",
        "map info",
        "map check",
        "map render",
        "map generate",
        "simulate",
        "match",
        "serve",
        "admin",
        "bot",
        "conformance",
        "conformance serve",
        "replay",
        "replay info",
        "replay verify",
        "replay snapshot",
        "replay view",
        "replay render",
        "watch",
        "bench",
        "bench scale",
        "bench tradeoff",
        "bench path",
    ] {
        let arguments: Vec<&str> = command.split(' ').chain(["--help"]).collect();
        let output = run(&arguments);
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(output.status.success() && text.contains(&format!("Example: maniple {command}")), "{text}");
    }
}

#[test]
fn what_cannot_be_meant_is_a_usage_error() {
    fails(&["mtach"], 2);
    fails(&["map", "info"], 2);
    fails(&["match", "--cycles", "0"], 2);
    fails(&["serve", "--replay", "x"], 2);
    fails(&["bot", "straight", "--connect", "nowhere"], 2);
    let error = fails(&["match", "--bot", "strait"], 2);
    assert!(
        error.contains(
            "alone, auto, commander, focus, follow, gather, idle, macro, random, replan, rush, straight"
        ),
        "{error}"
    );
    let error = fails(&["match", "--bot", "idle", "--bot", "idle", "--bot", "idle"], 2);
    assert!(error.contains("3 bots for 2 seats"), "{error}");
    let error = fails(&["--log", "a=b=c", "match"], 2);
    assert!(error.contains("--log"), "{error}");
}

#[test]
fn an_unknown_bot_of_a_scenario_is_bad_input_with_file_and_seat() {
    let folder = folder("bad_bot");
    let scenario =
        std::fs::read_to_string(Path::new(ROOT).join("config/scenarios/duel.toml")).expect("it ships");
    let map = Path::new(ROOT).join("maps/choke.tmx").display().to_string();
    let (first, second) = scenario.rsplit_once("straight").expect("a bot");
    let scenario = file(&folder, "bad.toml", &format!("{first}strait{second}"));
    let error = fails(&["match", &scenario, "--map", &map], 3);
    for named in [
        "bad.toml",
        "seat 1",
        "strait",
        "alone, auto, commander, focus, follow, gather, idle, macro, random, replan, rush, straight",
    ] {
        assert!(error.contains(named), "{error} does not name {named}");
    }
    let error = fails(&["match", &scenario, "--map", &map, "--bot", "idle", "--bot", "straits"], 2);
    assert!(error.contains("--bot"), "{error}");
}

#[test]
fn map_info_prints_the_figures_of_a_map() {
    let folder = folder("map_info");
    // A closed room of 2 x 2 tiles in the corner, a pillar, and 14 + 4 tiles that are open.
    let map =
        file(&folder, "small.map", "type octile\nheight 4\nwidth 6\nmap\n..@...\n..@.@.\n@@@...\n......\n");
    let figures = serde_json::json!({
        "width": 6,
        "height": 4,
        "passable_tiles": 18,
        // The edge of the room is 8 long. The border of the large region is 24 - 8 + 2 around, and 4 around the pillar.
        "segments": 4 + 6 + 4,
        "wall_length": 32.0,
        "loops": 3,
        "regions": 2,
        "largest_region_tiles": 14,
        "spawns": 0,
    });
    assert_eq!(json(&["map", "info", &map, "--json"]), figures);
    let text = String::from_utf8(run(&["map", "info", &map]).stdout).expect("text");
    let lines = [
        "6 x 4 tiles, 18 of them passable",
        "14 wall segments, 32.0 tile edges long, in 3 loops",
        "2 regions, the largest with 14 tiles",
        "0 spawns",
    ];
    assert_eq!(text.lines().collect::<Vec<_>>(), lines);
    assert_eq!(json(&["map", "info", "maps/diamond.tmx", "--json"])["spawns"], 4);
}

#[test]
fn map_check_fails_where_something_is_odd() {
    let folder = folder("map_check");
    let map = file(&folder, "two.map", "type octile\nheight 3\nwidth 5\nmap\n..@..\n..@..\n..@..\n");
    let output = run(&["map", "check", &map, "--json"]);
    assert_eq!(output.status.code(), Some(1));
    let found: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(found["findings"][0]["kind"], "region_cut_off", "{found}");
    assert_eq!((&found["findings"][0]["x"], &found["findings"][0]["y"]), (&3.into(), &0.into()));
    assert!(run(&["map", "check", "maps/choke.tmx", "--radius", "0.45"]).status.success());
    assert!(fails(&["map", "check", "maps/choke.tmx", "--radius", "3"], 1).contains("finding"));
    fails(&["map", "check", "maps/choke.tmx", "--radius", "-1"], 2);
}

#[test]
fn foreign_objects_are_counted_and_no_failure() {
    let folder = folder("foreign");
    let map = file(
        &folder,
        "warp.tmx",
        r#"<map version="1.10" orientation="orthogonal" width="3" height="2" tilewidth="16" tileheight="16">
        <objectgroup id="1"><object id="7" class="warp" x="40" y="8"/><object id="8" x="0" y="0"/></objectgroup></map>"#,
    );
    let found = json(&["map", "check", &map, "--json"]);
    assert_eq!((&found["findings"], &found["foreign_objects"]), (&serde_json::json!([]), &2.into()));
    let text = String::from_utf8(run(&["map", "check", &map]).stdout).expect("text");
    assert!(text.contains("tile (2, 0): object 7 is ignored"), "{text}");
    assert!(text.ends_with("foreign_objects: 2\n"), "{text}");
}

#[test]
fn a_bad_map_is_bad_input_with_its_place() {
    let folder = folder("bad_map");
    let map = file(&folder, "bad.map", "type octile\nheight 2\nwidth 3\nmap\n...\n.x.\n");
    let error = fails(&["map", "info", &map], 3);
    assert!(error.contains("bad.map") && error.contains("line 6") && error.contains("column 2"), "{error}");
    fails(&["map", "info", "no/such.map"], 3);
    fails(&["match", "--map", &map], 3);
}

#[test]
fn an_own_map_and_its_tilesets_come_from_disk_whatever_ships_under_their_names() {
    let folder = folder("own_map");
    std::fs::create_dir(folder.join("maps")).expect("the folder can be made");
    let shipped =
        |name: &str| std::fs::read_to_string(Path::new(ROOT).join("maps").join(name)).expect("it ships");
    let tiles = file(&folder, "maps/tiles.tsx", &shipped("tiles.tsx").replace("\"nw\"", "\"up\""));
    file(&folder, "maps/mine.tmx", &shipped("choke.tmx"));
    file(&folder, "maps/choke.tmx", "damaged");
    let check = |arguments: &[&str], named: &str| {
        let output = maniple(arguments).current_dir(&folder).output().expect("the program runs");
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(3), "{arguments:?}: {error}");
        assert!(error.contains(named), "{arguments:?}: {error}");
    };
    for command in [&["match", "--cycles", "1"][..], &["serve", "--listen", "127.0.0.1:0", "--once"]] {
        check(&[command, &["--map", "maps/choke.tmx"]].concat(), "maps/choke.tmx");
        check(&[command, &["--map", "maps/mine.tmx"]].concat(), "diagonal");
        check(&[command, &["--map", "config/scenarios/duel.toml"]].concat(), "config/scenarios/duel.toml");
    }
    std::fs::remove_file(tiles).expect("it is there");
    check(&["match", "--cycles", "1", "--map", "maps/mine.tmx"], "tiles.tsx");
    let shipped =
        maniple(&["match", "--cycles", "1"]).current_dir(&folder).output().expect("the program runs");
    assert!(shipped.status.success(), "the shipped scenario needs no file");
}

#[test]
fn pictures_are_png_files_of_the_size_that_was_asked_for() {
    let folder = folder("pictures");
    let out = folder.join("map.png").display().to_string();
    assert!(run(&["map", "render", "maps/choke.tmx", "--out", &out, "--scale", "4"]).status.success());
    assert_eq!(png_size(&out), (192, 128));
    let replay = folder.join("match.replay").display().to_string();
    json(&["match", "--cycles", "20", "--replay", &replay, "--json"]);
    let out = folder.join("match.png").display().to_string();
    assert!(run(&["replay", "render", &replay, "--cycle", "7", "--out", &out]).status.success());
    assert_eq!(png_size(&out), (48 * 21, 32 * 21));
    let error = fails(&["replay", "render", &replay, "--cycle", "21", "--out", &out], 2);
    assert!(error.contains("0 to 20"), "{error}");
    let error = fails(&["map", "render", "maps/choke.tmx", "--out", "/no/such/folder/x.png"], 1);
    assert!(error.contains("/no/such/folder/x.png"), "{error}");
}

fn png_size(path: &str) -> (u32, u32) {
    let bytes = std::fs::read(path).expect("the picture is there");
    assert_eq!(&bytes[..8], b"\x89PNG\r\n\x1a\n");
    let number = |at: usize| u32::from_be_bytes(bytes[at..at + 4].try_into().expect("4 bytes"));
    (number(16), number(20))
}

#[test]
fn a_match_repeats_to_the_bit_and_its_replay_verifies() {
    let folder = folder("match");
    let replay = folder.join("match.replay").display().to_string();
    let arguments = ["match", "--cycles", "150", "--bot", "random", "--seed", "9", "--json"];
    let first = json(&[&arguments[..], &["--replay", &replay]].concat());
    let second = json(&arguments);
    assert_eq!(first["hash"], second["hash"]);
    assert_eq!(
        (&first["seed"], &first["cycles"], &first["replay"]),
        (&9.into(), &150.into(), &replay.clone().into())
    );
    for key in ["scenario", "winners", "scores", "cycles_per_second"] {
        assert!(first.get(key).is_some(), "{key} is not in {first}");
    }
    let verdict = json(&["replay", "verify", &replay, "--json"]);
    assert_eq!((&verdict["verified"], &verdict["hash"]), (&true.into(), &first["hash"]));
    let info = json(&["replay", "info", &replay, "--json"]);
    assert_eq!(info["players"], serde_json::json!(["random", "straight"]));
    assert_eq!(info["result"]["hash"], first["hash"]);
    assert_ne!(json(&["match", "--cycles", "150", "--seed", "10", "--json"])["hash"], first["hash"]);
}

#[test]
fn what_a_match_says_to_do_next_can_be_done_anywhere() {
    let folder = folder("next");
    let text = |arguments: &[&str]| {
        let output = maniple(arguments).current_dir(&folder).output().expect("the program runs");
        assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).expect("text")
    };
    let mut said = text(&["match", "--cycles", "3"]);
    for _ in 0..2 {
        let next =
            said.lines().find_map(|line| line.strip_prefix("next: maniple ")).expect("a hint").to_owned();
        said = text(&next.split(' ').collect::<Vec<_>>());
    }
    assert!(folder.join("match.png").exists());
}

#[test]
fn a_replay_that_plays_differently_is_told_with_the_first_cycle() {
    let folder = folder("difference");
    let path = folder.join("match.replay").display().to_string();
    json(&["match", "--cycles", "30", "--replay", &path, "--json"]);
    alter_replay(&path, |_, records| {
        for record in records {
            if let Record::Cycle { cycle, hash } = record
                && cycle.0 >= 17
            {
                hash.0 ^= 1;
            }
        }
    });
    let output = run(&["replay", "verify", &path, "--json"]);
    assert_eq!(output.status.code(), Some(1));
    let verdict: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(
        (&verdict["verified"], &verdict["first_difference"]),
        (&false.into(), &17.into()),
        "{verdict}"
    );
    assert_eq!(verdict["cycles"], 16);
    let error = fails(&["replay", "verify", &path], 1);
    assert!(error.contains("match.replay") && error.contains("cycle 17"), "{error}");
}

#[test]
fn a_difference_from_a_snapshot_is_told_with_object_and_field() {
    let folder = folder("snapshot");
    let [path, out] = ["match.replay", "match.snapshot"].map(|name| folder.join(name).display().to_string());
    json(&["match", "--cycles", "60", "--replay", &path, "--json"]);
    assert!(run(&["replay", "snapshot", &path, "--cycle", "40", "--out", &out]).status.success());
    let verdict = json(&["replay", "verify", &path, "--snapshot", &out, "--json"]);
    assert_eq!((&verdict["verified"], &verdict["differences"]), (&true.into(), &Value::Array(vec![])));
    alter_replay(&path, |_, records| {
        let is_left_out = |record: &Record| matches!(record, Record::Commands { cycle, seat, .. } if (20..30).contains(&cycle.0) && seat.0 == 0);
        records.retain(|record| !is_left_out(record));
    });
    let output = run(&["replay", "verify", &path, "--snapshot", &out, "--json"]);
    assert_eq!(output.status.code(), Some(1));
    let verdict: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let first = verdict["first_difference"].as_u64().expect("a cycle");
    assert!((21..=30).contains(&first), "{verdict}");
    let first = verdict["differences"][0].as_str().expect("a text");
    assert!(first.starts_with("world/field/objects/"), "{first}");
    json(&["match", "--cycles", "60", "--seed", "8", "--replay", &path, "--json"]);
    assert!(fails(&["replay", "verify", &path, "--snapshot", &out], 3).contains("of another match"));
    std::fs::write(&out, "MNPS").expect("the folder is there");
    assert!(fails(&["replay", "verify", &path, "--snapshot", &out], 3).contains("cut or altered"));
}

#[test]
fn a_replay_whose_header_cannot_be_is_bad_input() {
    let folder = folder("bad_header");
    let path = folder.join("match.replay").display().to_string();
    let check = |alter: fn(&mut ReplayHeader), named: &[&str]| {
        json(&["match", "--cycles", "3", "--replay", &path, "--json"]);
        alter_replay(&path, |header, _| alter(header));
        let error = fails(&["replay", "verify", &path], 3);
        for named in named.iter().chain(&["match.replay"]) {
            assert!(error.contains(named), "{error} does not name {named}");
        }
    };
    check(|header| header.cycles_max = 0, &["byte 6", "0 cycles"]);
    check(|header| header.seats = 3, &["3 seats", "2"]);
    check(|header| header.map_hash.0 ^= 1, &["map hashes to"]);
    check(|header| header.map_override = Some("none.tmx".to_owned()), &["none.tmx"]);
}

/// Writes a replay anew, with the right checksums, after a change.
fn alter_replay(path: &str, alter: impl FnOnce(&mut ReplayHeader, &mut Vec<Record>)) {
    let bytes = std::fs::read(path).expect("the replay is there");
    let Replay { mut header, mut records, ended } = read_replay(&bytes).expect("a replay");
    alter(&mut header, &mut records);
    records.extend(ended.map(|result| Record::Ended { result }));
    let (mut writer, mut bytes) = ReplayWriter::begin(&header).expect("it fits");
    for record in &records {
        bytes.extend(writer.push(record).expect("it fits"));
    }
    std::fs::write(path, bytes).expect("the file can be written");
}

#[test]
fn a_replay_that_cannot_be_written_is_told_with_its_path() {
    let path = "/no/such/folder/match.replay";
    // Before anybody has to wait for players.
    for command in [&["match"][..], &["serve", "--listen", "127.0.0.1:0", "--once"]] {
        let error = fails(&[command, &["--replay", path]].concat(), 1);
        assert!(error.contains(path), "{error}");
    }
    if Path::new("/dev/full").exists() {
        let error = fails(&["match", "--cycles", "3", "--replay", "/dev/full"], 1);
        assert!(error.contains("the replay cannot be written: /dev/full"), "{error}");
    }
}

#[test]
fn a_replay_that_was_cut_or_altered_is_bad_input_with_its_place() {
    let folder = folder("bad_replay");
    let replay = folder.join("match.replay");
    json(&["match", "--cycles", "30", "--replay", &replay.display().to_string(), "--json"]);
    let bytes = std::fs::read(&replay).expect("the replay is there");
    let cut = folder.join("cut.replay");
    std::fs::write(&cut, &bytes[..bytes.len() * 2 / 3]).expect("the file can be written");
    let error = fails(&["replay", "verify", &cut.display().to_string()], 3);
    assert!(error.contains("cut.replay") && error.contains("byte") && error.contains("cycle"), "{error}");
    let mut altered = bytes.clone();
    let middle = altered.len() * 2 / 3;
    altered[middle] ^= 1;
    std::fs::write(&cut, &altered).expect("the file can be written");
    let error = fails(&["replay", "verify", &cut.display().to_string()], 3);
    assert!(error.contains("byte") && error.contains("cycle"), "{error}");
    fails(&["replay", "info", "README.md"], 3);
}

#[test]
fn a_match_over_tcp_ends_with_the_hash_of_the_headless_one() {
    let real: Vec<PathBuf> = ["movingai/dao/arena.map", "tiled/tmw/maps/007-2.tmx"]
        .map(|map| Path::new(REAL_MAPS).join(map))
        .into_iter()
        .filter(|map| {
            let is_there = map.exists();
            if !is_there {
                skipped(&format!("the real map {} is not there", map.display()));
            }
            is_there
        })
        .collect();
    let folder = folder("tcp");
    let scenario = file(&folder, "short.toml", &short_scenario());
    let mut maps = vec![Path::new(ROOT).join("maps/choke.tmx"), Path::new(ROOT).join("maps/rooms.map")];
    maps.extend(real);
    for map in maps {
        let map = map.display().to_string();
        let headless = json(&["match", &scenario, "--map", &map, "--bot", "random", "--seed", "3", "--json"]);
        let (mut server, address, tokens) =
            serve(&["--scenario", &scenario, "--map", &map, "--seed", "3", "--clock", "lockstep", "--once"]);
        let bots: Vec<Child> = ["random", "straight"]
            .iter()
            .zip(&tokens)
            .map(|(bot, token)| {
                let mut command =
                    maniple(&["bot", bot, "--connect", &address, "--token", token, "--seed", "3"]);
                command.arg("--json").stdout(Stdio::piped()).spawn().expect("the bot runs")
            })
            .collect();
        for bot in bots {
            let output = bot.wait_with_output().expect("the bot ends");
            let ended: Value = serde_json::from_slice(&output.stdout).expect("JSON");
            assert_eq!(ended["result"]["hash"], headless["hash"], "{map}");
            assert_eq!(ended["result"]["scores"], headless["scores"], "{map}");
        }
        assert!(server.wait().expect("the server ends").success());
    }
}

#[cfg(unix)]
#[test]
fn an_interrupted_command_ends_with_130() {
    let folder = folder("interrupted");
    let duel = short_scenario().replace("rate = 8", "rate = 1000");
    let scenario = file(&folder, "day.toml", &duel.replace("length_seconds = 25", "length_seconds = 86400"));
    let replay = folder.join("day.replay");
    let path = replay.display().to_string();
    let arguments =
        ["match", &scenario, "--map", "maps/choke.tmx", "--bot", "idle", "--bot", "idle", "--replay", &path];
    let mut running = maniple(&arguments).stdout(Stdio::null()).spawn().expect("the program runs");
    let begun = Instant::now();
    while !replay.exists() {
        assert!(begun.elapsed() < Duration::from_secs(60), "the match does not begin");
        std::thread::sleep(Duration::from_millis(5));
    }
    interrupt(&running);
    assert_eq!(running.wait().expect("it ends").code(), Some(130));
}

#[cfg(unix)]
#[test]
fn an_interrupted_server_that_nobody_plays_at_ends_with_0() {
    for clock in ["lockstep", "realtime"] {
        let (mut server, _, _) = serve(&["--clock", clock]);
        interrupt(&server);
        assert_eq!(server.wait().expect("it ends").code(), Some(0), "{clock}");
    }
}

#[cfg(unix)]
fn interrupt(child: &Child) {
    let kill = Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill runs");
    assert!(kill.success());
}

#[cfg(unix)]
#[test]
fn a_log_that_goes_to_no_terminal_has_no_colours() {
    let mut command = maniple(&["serve", "--listen", "127.0.0.1:0", "--json", "--log", "debug"]);
    let mut server =
        command.env_remove("NO_COLOR").stderr(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    let (address, _) = opened(&mut server);
    fails(&["bot", "idle", "--connect", &address, "--token", &"0".repeat(32)], 1);
    interrupt(&server);
    let log = server.wait_with_output().expect("it ends").stderr;
    let log = String::from_utf8(log).expect("text");
    assert!(log.contains("refused") && !log.contains('\x1b'), "{log:?}");
}

#[test]
fn a_bot_without_a_token_is_told_what_the_server_says() {
    let (mut server, address, _) = serve(&["--clock", "lockstep"]);
    let mut bot = maniple(&["bot", "idle", "--connect", &address]);
    let output = bot.env_remove("MANIPLE_TOKEN").output().expect("the program runs");
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{error}");
    assert!(error.contains("the server refused"), "{error}");
    server.kill().expect("it runs");
    server.wait().expect("it ends");
}

/// The shipped duel, cut to 200 cycles.
fn short_scenario() -> String {
    let duel = std::fs::read_to_string(Path::new(ROOT).join("config/scenarios/duel.toml")).expect("the duel");
    let lines = duel.lines().map(|line| {
        if line.starts_with("length_seconds") { "length_seconds = 25".to_owned() } else { line.to_owned() }
    });
    lines.collect::<Vec<_>>().join("\n")
}

/// Starts a daemon on any free port; returns it, its address and the tokens of its seats.
pub(crate) fn serve(arguments: &[&str]) -> (Child, String, Vec<String>) {
    let all = [&["serve", "--listen", "127.0.0.1:0", "--json"], arguments].concat();
    let mut server = maniple(&all).stdout(Stdio::piped()).spawn().expect("the server runs");
    let (address, tokens) = opened(&mut server);
    (server, address, tokens)
}

/// Waits until a daemon says where it listens; returns its address and the tokens of its seats.
pub(crate) fn opened(server: &mut Child) -> (String, Vec<String>) {
    let mut lines = BufReader::new(server.stdout.take().expect("a pipe")).lines();
    let line = lines.next().expect("the server says where it listens").expect("text");
    let opened: Value = serde_json::from_str(&line).expect("JSON");
    let seats = opened["seats"].as_array().expect("seats");
    let tokens = seats.iter().map(|seat| seat["token"].as_str().expect("a token").to_owned()).collect();
    // What it says at the end has to go somewhere.
    std::thread::spawn(move || lines.for_each(drop));
    (opened["address"].as_str().expect("an address").to_owned(), tokens)
}
