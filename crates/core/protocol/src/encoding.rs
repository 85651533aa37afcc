//! The two ways to write a message, and the messages written in them.

use maniple_geometry::Cycle;
use maniple_view::Sequenced;
use serde::Serialize;
use serde::de::DeserializeOwned;
use thiserror::Error;

use crate::codec;
use crate::limits::{FRAME_FROM_CLIENT_MAX, FRAME_FROM_SERVER_MAX};
use crate::message::{ClientMessage, ServerMessage};

/// What a binary connection begins with, from client to server.
const MAGIC: &[u8; 4] = b"MNPL";

/// Bytes of a problem's text that are told: enough to say what is wrong, too few to make a log grow.
const PROBLEM_MAX: usize = 200;

/// How the messages of a connection are written. The client chooses with its first bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// `MNPL`, then frames: a length of 4 bytes, little-endian, and a body.
    Binary,
    /// One JSON object a line.
    Json,
}

/// First bytes that belong to no encoding.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[error("a connection begins with `{{` (JSON lines) or `MNPL` (binary frames)")]
pub struct EncodingError;

/// A message that cannot be sent.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum EncodeError {
    /// The receiver would refuse it for its length.
    #[error("the message has {length} bytes, {limit} are allowed; send less at once")]
    TooLarge {
        /// Its length in bytes.
        length: usize,
        /// The largest length in bytes.
        limit: usize,
    },
    /// JSON has neither NaN nor infinity.
    #[error("command {seq} holds a number that is not finite, which JSON cannot say")]
    NotFinite {
        /// The number of the command.
        seq: u32,
    },
}

/// A body that is no message.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("{place}: {problem}")]
pub struct DecodeError {
    /// Where: `column 17` of a line, `byte 17` of a body.
    pub place: String,
    /// What is wrong there, at most 200 bytes without control characters.
    pub problem: String,
}

impl Encoding {
    /// Returns the encoding of a connection that begins with `first_bytes`; `None` as long as more of them are
    /// needed: 1 for JSON, 4 for binary.
    ///
    /// # Errors
    /// First bytes that belong to no encoding.
    pub fn detect(first_bytes: &[u8]) -> Result<Option<Self>, EncodingError> {
        if first_bytes.first() == Some(&b'{') {
            Ok(Some(Self::Json))
        } else if first_bytes.starts_with(MAGIC) {
            Ok(Some(Self::Binary))
        } else if MAGIC.starts_with(first_bytes) {
            Ok(None)
        } else {
            Err(EncodingError)
        }
    }

    /// Returns what a client sends before its first message, to choose this encoding.
    #[must_use]
    pub fn preamble(self) -> &'static [u8] {
        match self {
            Self::Binary => MAGIC,
            Self::Json => &[],
        }
    }
}

/// Returns the whole frame or line of a client's message.
///
/// # Errors
/// A message that the server would refuse: longer than [`FRAME_FROM_CLIENT_MAX`], or, as JSON, with numbers that
/// are not finite.
pub fn encode_client(encoding: Encoding, message: &ClientMessage) -> Result<Vec<u8>, EncodeError> {
    if let (Encoding::Json, ClientMessage::Commands { list, .. }) = (encoding, message) {
        check_finite(list)?;
    }
    encode(encoding, message, FRAME_FROM_CLIENT_MAX)
}

/// Returns the frames or lines of as many messages as it takes to say these commands; nothing for none.
///
/// # Errors
/// A single command that is too long for a message, and as JSON numbers that are not finite.
pub fn encode_commands(
    encoding: Encoding,
    seen_cycle: Cycle,
    list: &[Sequenced],
) -> Result<Vec<u8>, EncodeError> {
    if list.is_empty() {
        return Ok(Vec::new());
    }
    let whole = encode_client(encoding, &ClientMessage::Commands { seen_cycle, list: list.to_vec() });
    match whole {
        Err(EncodeError::TooLarge { .. }) if list.len() > 1 => {
            let (first, second) = list.split_at(list.len() / 2);
            let mut bytes = encode_commands(encoding, seen_cycle, first)?;
            bytes.extend(encode_commands(encoding, seen_cycle, second)?);
            Ok(bytes)
        }
        Ok(_) | Err(EncodeError::TooLarge { .. } | EncodeError::NotFinite { .. }) => whole,
    }
}

/// Returns the whole frame or line of a server's message.
///
/// # Errors
/// A message that the client would refuse: longer than [`FRAME_FROM_SERVER_MAX`].
pub fn encode_server(encoding: Encoding, message: &ServerMessage) -> Result<Vec<u8>, EncodeError> {
    encode(encoding, message, FRAME_FROM_SERVER_MAX)
}

/// Returns the client's message of a body, which is a frame without its length or a line without its end.
///
/// # Errors
/// A body that is no such message, or has bytes left over.
pub fn decode_client(encoding: Encoding, body: &[u8]) -> Result<ClientMessage, DecodeError> {
    decode(encoding, body)
}

/// Returns the server's message of a body, which is a frame without its length or a line without its end.
///
/// # Errors
/// A body that is no such message, or has bytes left over.
pub fn decode_server(encoding: Encoding, body: &[u8]) -> Result<ServerMessage, DecodeError> {
    decode(encoding, body)
}

fn encode<T: Serialize>(encoding: Encoding, message: &T, limit: usize) -> Result<Vec<u8>, EncodeError> {
    let (bytes, length) = match encoding {
        Encoding::Binary => {
            let mut bytes = vec![0; 4];
            codec::encode_onto(&mut bytes, message);
            let length = bytes.len() - 4;
            let prefix = u32::try_from(length).unwrap_or(u32::MAX);
            bytes[..4].copy_from_slice(&prefix.to_le_bytes());
            (bytes, length)
        }
        Encoding::Json => {
            let mut bytes = serde_json::to_vec(message).expect("no map of ours has keys that are not texts");
            let length = bytes.len();
            bytes.push(b'\n');
            (bytes, length)
        }
    };
    if length <= limit { Ok(bytes) } else { Err(EncodeError::TooLarge { length, limit }) }
}

fn decode<T: DeserializeOwned>(encoding: Encoding, body: &[u8]) -> Result<T, DecodeError> {
    match encoding {
        Encoding::Binary => codec::decode(body).map_err(|error| DecodeError {
            place: format!("byte {}", error.offset),
            problem: excerpt(&error.problem),
        }),
        Encoding::Json => serde_json::from_slice(body).map_err(|error| {
            let text = error.to_string();
            let suffix = format!(" at line {} column {}", error.line(), error.column());
            DecodeError {
                place: format!("column {}", error.column()),
                problem: excerpt(text.strip_suffix(&suffix).unwrap_or(&text)),
            }
        }),
    }
}

/// The text quotes what the other side sent, and ends in logs and terminals.
fn excerpt(text: &str) -> String {
    let printable = |c: char| if c.is_control() { '\u{fffd}' } else { c };
    let mut short = String::new();
    for c in text.chars().map(printable) {
        if short.len() + c.len_utf8() > PROBLEM_MAX {
            break;
        }
        short.push(c);
    }
    short
}

/// The writer would put `null` for such a number, which is another command: at the object's own speed.
fn check_finite(list: &[Sequenced]) -> Result<(), EncodeError> {
    match list.iter().find(|sequenced| !sequenced.command.is_finite()) {
        Some(sequenced) => Err(EncodeError::NotFinite { seq: sequenced.seq }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use std::fmt::Debug;

    use maniple_view::{Command, Handle};

    use super::*;
    use crate::arbitrary::Random;
    use crate::frame::FrameDecoder;

    const ENCODINGS: [Encoding; 2] = [Encoding::Binary, Encoding::Json];

    #[test]
    fn every_message_reads_back_to_the_same_bytes() {
        for seed in 0..3000 {
            let mut random = Random::new(seed);
            check_round_trip(seed, &random.client_message(), encode_client, decode_client);
            check_round_trip(seed, &random.server_message(), encode_server, decode_server);
        }
    }

    #[test]
    fn doubles_read_back_to_the_same_bits() {
        let mut random = Random::new(1);
        for _ in 0..20_000 {
            let x = random.double();
            let message = ServerMessage::Pong { id: 0, cycle: Cycle(0), fraction: x };
            for encoding in ENCODINGS {
                let bytes = encode_server(encoding, &message).unwrap();
                let decoded = decode_server(encoding, body(encoding, &bytes)).unwrap();
                let ServerMessage::Pong { fraction, .. } = decoded else { panic!("another message") };
                assert_eq!(fraction.to_bits(), x.to_bits(), "{x:?}");
            }
        }
    }

    #[test]
    fn a_body_that_was_cut_is_an_error() {
        for seed in 0..200 {
            let mut random = Random::new(seed);
            let message = random.server_message();
            for encoding in ENCODINGS {
                let bytes = encode_server(encoding, &message).unwrap();
                let body = body(encoding, &bytes);
                for length in 0..body.len() {
                    assert!(decode_server(encoding, &body[..length]).is_err(), "seed {seed}, {length} bytes");
                }
            }
        }
    }

    #[test]
    fn bytes_behind_a_message_are_an_error() {
        let error = decode_client(Encoding::Binary, &[3, 1, 0]).unwrap_err();
        assert_eq!(error.to_string(), "byte 2: 1 bytes are left over");
        let error = decode_client(Encoding::Json, br#"{"ping":{"id":1}} x"#).unwrap_err();
        assert_eq!(error.to_string(), "column 19: trailing characters");
    }

    #[test]
    fn altered_bodies_and_random_ones_never_panic() {
        for seed in 0..3000 {
            let mut random = Random::new(seed);
            let message = random.client_message();
            for encoding in ENCODINGS {
                let bytes = encode_client(encoding, &message).unwrap();
                let mut altered = body(encoding, &bytes).to_vec();
                let place = random.below(altered.len());
                altered[place] = random.number().to_le_bytes()[0];
                let _ = decode_client(encoding, &altered);
                let _ = decode_server(encoding, &altered);
                let _ = decode_client(encoding, &random.bytes(64));
                let _ = decode_server(encoding, &random.bytes(64));
            }
        }
    }

    #[test]
    fn unknown_missing_and_double_fields_are_errors() {
        check_json_error(r#"{"ping":{"id":1,"x":2}}"#, "column 19: unknown field `x`, expected `id`");
        check_json_error(r#"{"ping":{}}"#, "column 10: missing field `id`");
        check_json_error(r#"{"ping":{"id":1,"id":2}}"#, "column 20: duplicate field `id`");
        check_json_error(r#"{"ping":{"id":-1}}"#, "column 16: invalid value: integer `-1`, expected u32");
        check_json_error(
            r#"{"ping":{"id":1.0}}"#,
            "column 17: invalid type: floating point `1.0`, expected u32",
        );
        check_json_error(
            r#"{"pong":{"id":1}}"#,
            "column 7: unknown variant `pong`, expected one of `hello`, `commands`, `done`, `ping`, `pause`, `watch`, `list`, `create`, `enter`",
        );
        check_json_error(r#"{"ping":{"id":1},"done":{"cycle":1}}"#, "column 16: expected value");
    }

    #[test]
    fn numbers_that_are_no_finite_doubles_are_errors() {
        for number in ["NaN", "Infinity", "1e999", "-1e999", "null", "\"1\""] {
            let line = format!(
                r#"{{"commands":{{"seen_cycle":0,"list":[{{"seq":0,"command":{{"move":{{"object":1,"x":{number},"y":0}}}}}}]}}}}"#
            );
            assert!(decode_client(Encoding::Json, line.as_bytes()).is_err(), "{number}");
        }
    }

    #[test]
    fn deep_nesting_is_an_error() {
        for open in ["[", "{\"commands\":", "{\"hello\":{\"token\":["] {
            let line = open.repeat(5000);
            assert!(decode_client(Encoding::Json, line.as_bytes()).is_err());
            assert!(decode_server(Encoding::Json, line.as_bytes()).is_err());
        }
    }

    #[test]
    fn a_forged_length_inside_of_a_message_is_an_error() {
        for length in [1u64 << 63, u64::MAX, 1 << 32, 1 << 28, 100_000] {
            let mut bytes = vec![1, 7, 253];
            bytes.extend_from_slice(&length.to_le_bytes());
            bytes.extend_from_slice(&[3; 60]);
            assert!(decode_client(Encoding::Binary, &bytes).is_err(), "{length} commands");
            bytes[0] = 0;
            assert!(decode_client(Encoding::Binary, &bytes).is_err(), "{length} bytes of a name");
        }
    }

    #[test]
    fn a_problem_quotes_little_and_nothing_that_steers_a_terminal() {
        let line = format!(r#"{{"\u001b[2J{}":1}}"#, "a".repeat(4000));
        let error = decode_client(Encoding::Json, line.as_bytes()).unwrap_err();
        assert!(error.problem.len() <= PROBLEM_MAX);
        assert!(!error.problem.chars().any(char::is_control), "{}", error.problem);
    }

    #[test]
    fn optional_fields_may_be_left_out_of_json() {
        let line = br#"{"commands":{"seen_cycle":0,"list":[{"seq":5,"command":{"move":{"object":1,"x":2,"y":3.5}}}]}}"#;
        let command = Command::Move { object: Handle(1), x: 2.0, y: 3.5, s: None, queue: false, start: None };
        let list = vec![Sequenced { seq: 5, command }];
        let expected = ClientMessage::Commands { seen_cycle: Cycle(0), list };
        assert_eq!(decode_client(Encoding::Json, line), Ok(expected));
    }

    #[test]
    fn many_commands_are_split_over_as_many_messages_as_it_takes() {
        let mut random = Random::new(4);
        let list: Vec<Sequenced> = (0..3000).map(|_| random.sequenced()).collect();
        for encoding in ENCODINGS {
            let bytes = encode_commands(encoding, Cycle(9), &list).unwrap();
            let mut decoder = FrameDecoder::new(encoding, FRAME_FROM_CLIENT_MAX);
            decoder.handle_bytes(&bytes);
            let mut found = Vec::new();
            while let Some(body) = decoder.poll().unwrap() {
                let ClientMessage::Commands { seen_cycle, list } = decode_client(encoding, body).unwrap()
                else {
                    panic!("another message");
                };
                assert_eq!(seen_cycle, Cycle(9));
                found.extend(list);
            }
            assert_eq!(found, list);
            assert_eq!(decoder.buffered(), 0);
        }
        assert_eq!(encode_commands(Encoding::Json, Cycle(9), &[]), Ok(Vec::new()));
    }

    #[test]
    fn what_the_receiver_would_refuse_is_not_sent() {
        let stop = Sequenced { seq: 1, command: Command::Stop { object: Handle(1) } };
        let message = ClientMessage::Commands { seen_cycle: Cycle(0), list: vec![stop; 10_000] };
        for encoding in ENCODINGS {
            assert!(matches!(encode_client(encoding, &message), Err(EncodeError::TooLarge { .. })));
        }
        let path = Command::Path { object: Handle(1), points: vec![(0.0, 0.0, None); 10_000], start: None };
        let path = [Sequenced { seq: 1, command: path }];
        assert!(matches!(
            encode_commands(Encoding::Json, Cycle(0), &path),
            Err(EncodeError::TooLarge { .. })
        ));
    }

    #[test]
    fn json_refuses_to_say_a_number_that_is_not_finite() {
        let command =
            Command::Move { object: Handle(1), x: 0.0, y: 0.0, s: Some(f64::NAN), queue: false, start: None };
        let message =
            ClientMessage::Commands { seen_cycle: Cycle(0), list: vec![Sequenced { seq: 3, command }] };
        assert_eq!(encode_client(Encoding::Json, &message), Err(EncodeError::NotFinite { seq: 3 }));
        assert!(encode_client(Encoding::Binary, &message).is_ok());
    }

    fn check_json_error(line: &str, expected: &str) {
        assert_eq!(decode_client(Encoding::Json, line.as_bytes()).unwrap_err().to_string(), expected);
    }

    fn check_round_trip<T: PartialEq + Debug>(
        seed: u64,
        message: &T,
        encode: impl Fn(Encoding, &T) -> Result<Vec<u8>, EncodeError>,
        decode: impl Fn(Encoding, &[u8]) -> Result<T, DecodeError>,
    ) {
        for encoding in ENCODINGS {
            let bytes = encode(encoding, message).unwrap();
            let decoded = decode(encoding, body(encoding, &bytes)).unwrap();
            assert_eq!(&decoded, message, "{encoding:?}, seed {seed}");
            assert_eq!(encode(encoding, &decoded).unwrap(), bytes, "{encoding:?}, seed {seed}");
        }
    }

    fn body(encoding: Encoding, bytes: &[u8]) -> &[u8] {
        match encoding {
            Encoding::Binary => &bytes[4..],
            Encoding::Json => &bytes[..bytes.len() - 1],
        }
    }
}
