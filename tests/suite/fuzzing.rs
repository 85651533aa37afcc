//! The corpus of `tests/fuzz`, through the very functions that libFuzzer calls, and each of its inputs a little altered.
//!
//! `UPDATE_GOLDEN=1` writes the seeds of the corpus anew. How to fuzz is said in `tests/fuzz/README.md`.

#![expect(clippy::unwrap_used, reason = "a helper that fails is a test that fails")]

#[expect(unreachable_pub, reason = "it is a library where libFuzzer calls it")]
#[path = "../fuzz/src/lib.rs"]
mod targets;

use std::path::{Path, PathBuf};

use targets::{TARGETS, forged};

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../..");

/// How often each input is altered; ten times as often with `MANIPLE_LONG=1`.
const ALTERED: u64 = 40;

#[test]
fn every_input_of_the_corpus_is_taken() {
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        write_seeds();
    }
    for (name, target) in TARGETS {
        let inputs = corpus(name);
        assert!(!inputs.is_empty(), "{name} has no corpus");
        for (path, input) in inputs {
            let _told = Told(format!("{}", path.display()));
            target(&input);
        }
    }
}

#[test]
fn so_is_every_input_that_was_altered_or_cut() {
    let often = if std::env::var_os("MANIPLE_LONG").is_some() { 10 * ALTERED } else { ALTERED };
    for (name, target) in TARGETS {
        for (path, input) in corpus(name) {
            for seed in 0..often {
                let _told = Told(format!("{}, seed {seed}", path.display()));
                target(&altered(&input, seed));
            }
        }
    }
}

#[test]
fn a_match_goes_on_from_the_snapshots_of_the_corpus() {
    for (path, body) in corpus("snapshot") {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if name.starts_with("cycle_") {
            let snapshot: maniple_referee::Snapshot = maniple_protocol::decode_snapshot(&forged(&body))
                .unwrap_or_else(|error| panic!("{name}: {error}; SNAPSHOT_VERSION rises with the layout"));
            assert_eq!(format!("cycle_{:02}", snapshot.cycle().0), name);
        }
    }
}

#[test]
fn each_target_is_one_of_libfuzzer_and_each_corpus_one_of_a_target() {
    let folder = Path::new(ROOT).join("tests/fuzz");
    let names = |part: &str| -> Vec<String> {
        let entries = std::fs::read_dir(folder.join(part)).unwrap().flatten();
        let mut names: Vec<String> =
            entries.map(|entry| entry.path().file_stem().unwrap().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    };
    let expected: Vec<&str> = TARGETS.iter().map(|(name, _)| *name).collect();
    assert_eq!(names("fuzz_targets"), expected);
    assert_eq!(names("corpus"), expected);
    let manifest = std::fs::read_to_string(folder.join("Cargo.toml")).unwrap();
    for name in expected {
        assert!(manifest.contains(&format!("path = \"fuzz_targets/{name}.rs\"")), "{name}");
    }
}

/// Says what was being read where a test panics.
struct Told(String);

impl Drop for Told {
    fn drop(&mut self) {
        if std::thread::panicking() {
            eprintln!("while reading {}", self.0);
        }
    }
}

fn corpus(name: &str) -> Vec<(PathBuf, Vec<u8>)> {
    let folder = Path::new(ROOT).join("tests/fuzz/corpus").join(name);
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let mut inputs: Vec<(PathBuf, Vec<u8>)> =
        entries.flatten().map(|entry| (entry.path(), std::fs::read(entry.path()).unwrap())).collect();
    inputs.sort();
    inputs
}

/// Returns the bytes with a few of them changed, doubled, left out, or the rest cut off.
fn altered(input: &[u8], seed: u64) -> Vec<u8> {
    let mut state = seed;
    let mut below = |end: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        usize::try_from(state >> 33).unwrap() % end.max(1)
    };
    let mut bytes = input.to_vec();
    for _ in 0..1 + below(4) {
        let at = below(bytes.len());
        let byte = [0, 1, 127, 251, 255, u8::try_from(below(256)).unwrap()][below(6)];
        match below(12) {
            _ if bytes.is_empty() => bytes.push(byte),
            0 => bytes.truncate(at),
            1 => drop(bytes.remove(at)),
            2 => bytes.insert(at, byte),
            3 => {
                let part = bytes[at..bytes.len().min(at + 1 + below(16))].to_vec();
                bytes.splice(at..at, part);
            }
            4..8 => bytes[at] ^= 1 << below(8),
            _ => bytes[at] = byte,
        }
    }
    bytes
}

fn write_seeds() {
    for (target, name, bytes) in seeds() {
        let folder = Path::new(ROOT).join("tests/fuzz/corpus").join(target);
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join(name), bytes).unwrap();
    }
}

/// What the corpus begins with: messages of the golden files, maps and scenarios that ship, and a small match.
fn seeds() -> Vec<(&'static str, String, Vec<u8>)> {
    let read = |path: &str| std::fs::read(Path::new(ROOT).join(path)).unwrap();
    let golden = |name: &str| -> Vec<u8> {
        let text = String::from_utf8(read(&format!("tests/golden/protocol/{name}.hex"))).unwrap();
        let digits: Vec<u8> = text.bytes().filter(u8::is_ascii_hexdigit).collect();
        let byte = |pair: &[u8]| u8::from_str_radix(std::str::from_utf8(pair).unwrap(), 16).unwrap();
        digits.chunks(2).map(byte).collect()
    };
    let line = |name: &str| read(&format!("tests/golden/protocol/{name}.json"));
    let mut seeds = Vec::new();
    let (from_client, from_server) =
        (["hello", "commands", "watch_seat"], ["welcome", "delta", "packed", "ended", "refused_malformed"]);
    for name in from_client {
        seeds.push(("client_message", name.to_owned(), golden(name)[4..].to_vec()));
    }
    for name in from_server {
        seeds.push(("server_message", name.to_owned(), golden(name)[4..].to_vec()));
    }
    for name in from_client.iter().chain(&from_server) {
        seeds.push(("json_line", (*name).to_owned(), line(name).trim_ascii_end().to_vec()));
    }
    let frames = |first: u8, start: &[u8]| {
        [&[first][..], start, &golden("hello"), &golden("commands"), &golden("done")].concat()
    };
    let lines = |first: u8| [&[first][..], &line("hello"), &line("commands"), &line("pause")].concat();
    seeds.push(("inbound", "binary".to_owned(), frames(4, b"MNPL")));
    seeds.push(("inbound", "json".to_owned(), lines(9)));
    seeds.push(("frame", "binary".to_owned(), [&[2][..], &golden("done"), &golden("ping")].concat()));
    seeds.push(("frame", "json".to_owned(), [&[7][..], b"\r\n{}\n\n", &line("done")].concat()));
    seeds.push(("packed", "message".to_owned(), golden("packed")[4..].to_vec()));
    seeds.push(("packed", "motions".to_owned(), vec![0, 1, 2, 0, 0, 8, 1, 2, 3, 4, 5, 6, 7, 8, 9]));
    seeds.push(("replay", "golden".to_owned(), golden("replay")));
    seeds.push(("replay", "header".to_owned(), replay_header(&golden("replay"))));
    for name in ["duel", "orts3", "caves"] {
        seeds.push(("scenario", name.to_owned(), read(&format!("config/scenarios/{name}.toml"))));
    }
    seeds.push(("scenario", "units".to_owned(), read("config/units/racers.toml")));
    seeds.push(("map", "rooms".to_owned(), read("maps/rooms.map")));
    seeds.push(("map", "tiny".to_owned(), b"type octile\nheight 2\nwidth 3\nmap\n.@T\nSW.\n".to_vec()));
    seeds.push(("tmx", "choke".to_owned(), read("maps/choke.tmx")));
    seeds.push(("tmx", "story".to_owned(), read("config/conformance/story.tmx")));
    let (input, snapshots) = targets::played();
    seeds.push(("referee", "story".to_owned(), input));
    for body in snapshots {
        let snapshot: maniple_referee::Snapshot = maniple_protocol::decode_snapshot(&forged(&body)).unwrap();
        seeds.push(("snapshot", format!("cycle_{:02}", snapshot.cycle().0), body));
    }
    seeds
}

/// Returns the body of the first record of a replay, which lies behind magic, version and length.
fn replay_header(replay: &[u8]) -> Vec<u8> {
    let (length, rest) = replay[6..].split_first_chunk::<4>().unwrap();
    rest[..usize::try_from(u32::from_le_bytes(*length)).unwrap()].to_vec()
}
