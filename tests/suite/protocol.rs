//! The protocol as others see it: golden vectors of every message, and examples in the document that decode.

#![allow(clippy::unwrap_used, reason = "a helper that fails is a test that fails")]

mod messages;

use std::collections::BTreeSet;
use std::path::PathBuf;

use maniple_game::scenario::DELAY_CYCLES_MAX;
use maniple_protocol::{
    BYTES_UNTAKEN_MAX, CYCLES_UNSEEN_MAX, CYCLES_WITHHELD_MAX, DELTAS_UNTAKEN_MAX, Encoding,
    FRAME_FROM_CLIENT_MAX, FRAME_FROM_SERVER_MAX, HELLO_MAX, MERGED_CYCLES_MAX, MERGED_ENTRIES_MAX, NAME_MAX,
    Outbound, PROTOCOL, REPLAY_RECORD_MAX, REPLAY_VERSION, Refused, ReplayWriter, SKIPPED_MAX, ServerMessage,
    TOKEN_DIGITS, decode_client, decode_server, encode_client, encode_server, read_replay,
};
use maniple_referee::{HELD_ENTRIES_MAX, PAUSES_MAX};
use maniple_server::metrics::Kind;
use maniple_server::{ASKS_MAX, CONTROLS_WAITING_MAX, NEWS_WAITING_MAX, SPECTATORS_MAX, VIOLATIONS_MAX};
use maniple_view::{COMMANDS_A_CYCLE_MAX, View, WAYPOINTS_MAX};
use messages::{client_messages, replay, result, server_messages};

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../..");

#[test]
fn client_messages_have_their_golden_bytes() {
    for (name, message) in client_messages() {
        let binary = encode_client(Encoding::Binary, &message).unwrap();
        let json = encode_client(Encoding::Json, &message).unwrap();
        check_golden(name, &binary, &json);
        assert_eq!(decode_client(Encoding::Binary, &golden_hex(name)[4..]).as_ref(), Ok(&message), "{name}");
        let line = golden_json(name);
        assert_eq!(
            decode_client(Encoding::Json, line.trim_end().as_bytes()).as_ref(),
            Ok(&message),
            "{name}"
        );
    }
}

#[test]
fn every_reason_to_refuse_has_its_golden_bytes() {
    let names: BTreeSet<String> = server_messages().iter().map(|(name, _)| (*name).to_owned()).collect();
    for kind in <Refused as Kind>::ALL {
        assert!(names.contains(&format!("refused_{kind}")), "{kind}");
    }
}

#[test]
fn server_messages_have_their_golden_bytes() {
    for (name, message) in server_messages() {
        let binary = encode_server(Encoding::Binary, &message).unwrap();
        let json = encode_server(Encoding::Json, &message).unwrap();
        check_golden(name, &binary, &json);
        assert_eq!(decode_server(Encoding::Binary, &golden_hex(name)[4..]).as_ref(), Ok(&message), "{name}");
        let line = golden_json(name);
        assert_eq!(
            decode_server(Encoding::Json, line.trim_end().as_bytes()).as_ref(),
            Ok(&message),
            "{name}"
        );
    }
}

#[test]
fn a_replay_has_its_golden_bytes() {
    let (header, records) = replay();
    let (mut writer, mut bytes) = ReplayWriter::begin(&header).unwrap();
    for record in &records {
        bytes.extend(writer.push(record).unwrap());
    }
    check_file("replay.hex", &hex(&bytes));
    let read = read_replay(&golden_hex("replay")).unwrap();
    assert_eq!(read.header, header);
    assert_eq!(read.records, records[..records.len() - 1]);
    assert_eq!(read.ended, Some(result()));
}

#[test]
fn every_golden_file_belongs_to_a_message() {
    let names = client_messages().into_iter().map(|(name, _)| name);
    let names = names.chain(server_messages().into_iter().map(|(name, _)| name));
    let mut expected: BTreeSet<String> =
        names.flat_map(|name| [format!("{name}.hex"), format!("{name}.json")]).collect();
    expected.insert("replay.hex".to_owned());
    let folder = std::fs::read_dir(golden_path("")).unwrap();
    let found: BTreeSet<String> =
        folder.map(|file| file.unwrap().file_name().into_string().unwrap()).collect();
    assert_eq!(found, expected);
}

#[test]
fn the_examples_of_the_document_decode() {
    let mut count = 0;
    for line in fenced("json").lines() {
        let client = decode_client(Encoding::Json, line.as_bytes());
        let server = decode_server(Encoding::Json, line.as_bytes());
        assert!(client.is_ok() || server.is_ok(), "{line}\n{client:?}\n{server:?}");
        count += 1;
    }
    assert!(count >= 10, "only {count} examples were found");
}

#[test]
fn the_bytes_of_the_document_are_the_ones_of_its_messages() {
    let bytes: String =
        fenced("hex").lines().map(|line| line.split('#').next().unwrap_or_default().trim()).collect();
    let mut rest = &unhex(&bytes)[..];
    let mut expected: Vec<Vec<u8>> = vec![Encoding::Binary.preamble().to_vec()];
    let messages = fenced("json");
    let find = |start: &str| messages.lines().find(|line| line.starts_with(start)).unwrap();
    for start in ["{\"hello\"", "{\"commands\""] {
        let message = decode_client(Encoding::Json, find(start).as_bytes()).unwrap();
        expected.push(encode_client(Encoding::Binary, &message).unwrap());
    }
    let server = messages.lines().filter_map(|line| decode_server(Encoding::Json, line.as_bytes()).ok());
    let mut outbound = Outbound::new(Encoding::Binary);
    for message in server.take(4) {
        let frame = outbound.encode(&message).unwrap();
        if matches!(message, ServerMessage::Delta(_)) {
            expected.push(frame);
        }
    }
    for frame in expected {
        let (head, tail) = rest.split_at_checked(frame.len()).unwrap();
        assert_eq!(hex(head), hex(&frame));
        rest = tail;
    }
    assert!(rest.is_empty(), "{} bytes are left over", rest.len());
}

#[test]
fn the_deltas_of_the_document_follow_each_other() {
    let mut view = View::default();
    let mut count = 0;
    for line in fenced("json").lines() {
        if let Ok(ServerMessage::Delta(delta)) = decode_server(Encoding::Json, line.as_bytes()) {
            assert_eq!(view.apply(&delta), Ok(()), "{line}");
            count += 1;
        }
    }
    assert!(count >= 2, "only {count} deltas were found");
}

#[test]
fn the_document_states_the_limits_as_they_are() {
    let document = document();
    let limits = [
        ("version of the protocol", usize::try_from(PROTOCOL).unwrap()),
        ("version of the replay file", usize::from(REPLAY_VERSION)),
        ("bytes of the hello", HELLO_MAX),
        ("bytes of a message from a client", FRAME_FROM_CLIENT_MAX),
        ("bytes of a message from the server", FRAME_FROM_SERVER_MAX),
        ("bytes of a name", NAME_MAX),
        ("hex digits of a token", TOKEN_DIGITS),
        ("commands of a seat in a cycle", COMMANDS_A_CYCLE_MAX),
        ("waypoints behind a motion", WAYPOINTS_MAX),
        ("requests to the lobby of a connection", usize::try_from(ASKS_MAX).unwrap()),
        ("pauses that a seat asks for in a match", usize::try_from(PAUSES_MAX).unwrap()),
        ("spectators of a match", SPECTATORS_MAX),
        ("deltas that wait to be sent", DELTAS_UNTAKEN_MAX),
        ("bytes of deltas that wait to be sent", BYTES_UNTAKEN_MAX),
        ("cycles that a client may be behind what it was sent", usize::try_from(CYCLES_UNSEEN_MAX).unwrap()),
        ("cycles that are told in one delta", MERGED_CYCLES_MAX),
        ("entries of deltas that are kept for that", MERGED_ENTRIES_MAX),
        ("cycles in which nothing can be sent", usize::try_from(CYCLES_WITHHELD_MAX).unwrap()),
        ("results and tasks that wait to be told", NEWS_WAITING_MAX),
        ("other messages that wait to be sent", CONTROLS_WAITING_MAX),
        ("rules that a client may break", usize::try_from(VIOLATIONS_MAX).unwrap()),
        ("bytes of a message that is dropped as too long", SKIPPED_MAX),
        ("cycles by which spectators are behind", usize::try_from(DELAY_CYCLES_MAX).unwrap()),
        ("changes that are held back for spectators", HELD_ENTRIES_MAX),
        ("bytes of a record of a replay", REPLAY_RECORD_MAX),
    ];
    for (what, limit) in limits {
        let row = format!("| {what} | {limit} |");
        assert!(document.contains(&row), "docs/PROTOCOL.md lacks the row `{row}`");
    }
}

fn check_golden(name: &str, binary: &[u8], json: &[u8]) {
    check_file(&format!("{name}.hex"), &hex(binary));
    check_file(&format!("{name}.json"), std::str::from_utf8(json).unwrap());
}

/// Compares with a golden file, or writes it where `UPDATE_GOLDEN=1` is set.
fn check_file(file: &str, found: &str) {
    let path = golden_path(file);
    if std::env::var("UPDATE_GOLDEN").is_ok_and(|value| value == "1") {
        std::fs::write(&path, found).unwrap();
    }
    let expected = std::fs::read_to_string(&path).unwrap_or_default();
    assert_eq!(found, expected, "{file} differs; if that is meant, PROTOCOL rises: run with UPDATE_GOLDEN=1");
}

fn golden_hex(name: &str) -> Vec<u8> {
    unhex(&std::fs::read_to_string(golden_path(&format!("{name}.hex"))).unwrap())
}

fn golden_json(name: &str) -> String {
    std::fs::read_to_string(golden_path(&format!("{name}.json"))).unwrap()
}

fn golden_path(file: &str) -> PathBuf {
    PathBuf::from(ROOT).join("tests/golden/protocol").join(file)
}

fn document() -> String {
    std::fs::read_to_string(PathBuf::from(ROOT).join("docs/PROTOCOL.md")).unwrap()
}

/// Returns the lines of all blocks of the document that are marked with this language.
fn fenced(language: &str) -> String {
    let (open, mut is_inside, mut lines) = (format!("```{language}"), false, String::new());
    for line in document().lines() {
        if line.starts_with("```") {
            is_inside = line == open;
        } else if is_inside {
            lines.push_str(line);
            lines.push('\n');
        }
    }
    lines
}

/// Returns 16 bytes a line, each as two digits.
fn hex(bytes: &[u8]) -> String {
    let line =
        |bytes: &[u8]| bytes.iter().map(|byte| format!("{byte:02x}")).collect::<Vec<_>>().join(" ") + "\n";
    bytes.chunks(16).map(line).collect()
}

fn unhex(text: &str) -> Vec<u8> {
    let digits: Vec<u8> = text.bytes().filter(|byte| !byte.is_ascii_whitespace()).collect();
    let pair = |pair: &[u8]| u8::from_str_radix(std::str::from_utf8(pair).unwrap(), 16).unwrap();
    digits.chunks(2).map(pair).collect()
}
