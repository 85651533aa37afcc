//! The server's side of a connection: from the first bytes over the hello to the messages of the match.

use maniple_geometry::Cycle;
use maniple_view::{Digest, Seat, Sequenced};

use crate::encoding::{Encoding, decode_client};
use crate::frame::{FrameDecoder, FrameError};
use crate::limits::{FRAME_FROM_CLIENT_MAX, HELLO_MAX, NAME_MAX, SKIPPED_MAX, TOKEN_DIGITS};
use crate::message::{ClientMessage, Create, Hello, PROTOCOL, Watch};
use crate::refused::Refused;

/// What a connection gave.
#[derive(Clone, Debug, PartialEq)]
pub enum Input {
    /// The hello: comes first, comes once, and fits the protocol and the limits. Its token is empty or
    /// [`TOKEN_DIGITS`] hex digits; whether it opens a seat is for the match to say.
    Hello(Hello),
    /// Commands for the next cycle.
    Commands {
        /// The last cycle that the client had seen.
        seen_cycle: Cycle,
        /// The commands, in order.
        list: Vec<Sequenced>,
    },
    /// The client has said all that it wants to say in this cycle.
    Done {
        /// The cycle.
        cycle: Cycle,
    },
    /// Asks for a pong.
    Ping {
        /// The number that goes back.
        id: u32,
    },
    /// Wants a pause, or none.
    Pause {
        /// Whether it wants one.
        on: bool,
    },
    /// The watch of a spectator, in place of a hello: fits the protocol and the limits. Whether the view may be watched is
    /// for the match to say. Nothing but pings comes after.
    Watch(Watch),
    /// Before the hello or watch: asks which matches there are.
    List,
    /// Before the hello or watch: wants a match; fits the protocol and the limits.
    Create(Create),
    /// Before the hello or watch: chooses the match that it is for.
    Enter {
        /// The number of the match.
        match_id: Digest,
        /// The open seat that is wanted.
        seat: Option<Seat>,
    },
    /// The client said too much at once, and it was dropped: warn it. What it says next comes after.
    Dropped(Refused),
    /// The client broke the protocol: send it this reason and close. Nothing comes after.
    Violation(Refused),
}

/// Turns what one client sends into checked messages.
///
/// Hand in bytes, then take out inputs until there is none. How the bytes are split makes no difference. It keeps
/// one message of at most [`HELLO_MAX`] bytes before the hello and of a spectator, and of [`FRAME_FROM_CLIENT_MAX`] after
/// the hello.
#[derive(Clone, Debug)]
pub struct Inbound {
    stage: Stage,
}

#[derive(Clone, Debug)]
enum Stage {
    /// Fewer bytes than show the encoding.
    Detecting(Vec<u8>),
    /// The stream of messages, how many were taken from it, and who talks.
    Talking(FrameDecoder, u64, Peer),
    /// Nothing more is read.
    Closed(Encoding),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Peer {
    /// Has not said it yet: the first message is a hello or a watch.
    Unknown,
    Player,
    Spectator,
}

impl Inbound {
    /// Returns the state of a connection from which nothing came yet.
    #[must_use]
    pub fn new() -> Self {
        Self { stage: Stage::Detecting(Vec::new()) }
    }

    /// Takes bytes that came in; forgets them after a violation.
    ///
    /// # Panics
    /// When [`Self::poll`] was not called until it gave `None` since the last bytes.
    pub fn handle_bytes(&mut self, bytes: &[u8]) {
        match &mut self.stage {
            Stage::Detecting(first_bytes) => {
                assert!(first_bytes.len() < 4, "all inputs are taken out before more bytes come in");
                first_bytes.extend_from_slice(bytes);
            }
            Stage::Talking(frames, ..) => frames.handle_bytes(bytes),
            Stage::Closed(_) => {}
        }
    }

    /// Returns what the bytes say next; `None` until more have come in, or for ever after a violation.
    pub fn poll(&mut self) -> Option<Input> {
        match self.try_poll() {
            Ok(input) => input,
            Err(refused @ Refused::TooLarge { .. }) if self.skip().is_some() => Some(Input::Dropped(refused)),
            Err(refused) => {
                self.stage = Stage::Closed(self.encoding());
                Some(Input::Violation(refused))
            }
        }
    }

    /// Returns the encoding in which the client is answered: its own, or JSON, which a person can read, as long as
    /// it has not shown.
    #[must_use]
    pub fn encoding(&self) -> Encoding {
        match &self.stage {
            Stage::Detecting(_) => Encoding::Json,
            Stage::Talking(frames, ..) => frames.encoding(),
            Stage::Closed(encoding) => *encoding,
        }
    }

    fn try_poll(&mut self) -> Result<Option<Input>, Refused> {
        self.detect()?;
        let Stage::Talking(frames, messages, peer) = &mut self.stage else { return Ok(None) };
        let Some(message) = next_message(frames, *messages + 1)? else { return Ok(None) };
        *messages += 1;
        match (*peer, message) {
            (Peer::Unknown, ClientMessage::Hello(hello)) => {
                check_hello(&hello)?;
                frames.change_limit(FRAME_FROM_CLIENT_MAX);
                *peer = Peer::Player;
                Ok(Some(Input::Hello(hello)))
            }
            (Peer::Unknown, ClientMessage::Watch(watch)) => {
                check_watch(&watch)?;
                *peer = Peer::Spectator;
                Ok(Some(Input::Watch(watch)))
            }
            (Peer::Unknown, ClientMessage::List { protocol }) => {
                check_version(protocol)?;
                Ok(Some(Input::List))
            }
            (Peer::Unknown, ClientMessage::Create(create)) => {
                check_version(create.protocol)?;
                check_name("scenario", &create.scenario)?;
                Ok(Some(Input::Create(create)))
            }
            (Peer::Unknown, ClientMessage::Enter { match_id, seat }) => {
                Ok(Some(Input::Enter { match_id, seat }))
            }
            (
                Peer::Player | Peer::Spectator,
                ClientMessage::Hello(_)
                | ClientMessage::Watch(_)
                | ClientMessage::List { .. }
                | ClientMessage::Create(_)
                | ClientMessage::Enter { .. },
            ) => Err(Refused::Handshake),
            (
                Peer::Unknown,
                ClientMessage::Commands { .. }
                | ClientMessage::Done { .. }
                | ClientMessage::Ping { .. }
                | ClientMessage::Pause { .. },
            ) => Err(Refused::Handshake),
            (Peer::Player | Peer::Spectator, ClientMessage::Ping { id }) => Ok(Some(Input::Ping { id })),
            (
                Peer::Spectator,
                ClientMessage::Commands { .. } | ClientMessage::Done { .. } | ClientMessage::Pause { .. },
            ) => Err(Refused::Spectator),
            (Peer::Player, ClientMessage::Commands { seen_cycle, list }) => {
                Ok(Some(Input::Commands { seen_cycle, list }))
            }
            (Peer::Player, ClientMessage::Done { cycle }) => Ok(Some(Input::Done { cycle })),
            (Peer::Player, ClientMessage::Pause { on }) => Ok(Some(Input::Pause { on })),
        }
    }

    /// Drops a message that is too large of somebody who may be heard further; `None` of all others.
    fn skip(&mut self) -> Option<()> {
        match &mut self.stage {
            Stage::Talking(frames, messages, Peer::Player | Peer::Spectator) => {
                *messages += 1;
                frames.skip(SKIPPED_MAX).ok()
            }
            Stage::Talking(_, _, Peer::Unknown) | Stage::Detecting(_) | Stage::Closed(_) => None,
        }
    }

    fn detect(&mut self) -> Result<(), Refused> {
        let Stage::Detecting(first_bytes) = &self.stage else { return Ok(()) };
        let detected = Encoding::detect(first_bytes)
            .map_err(|error| malformed("the first bytes".to_owned(), error.to_string()))?;
        let Some(encoding) = detected else { return Ok(()) };
        let mut frames = FrameDecoder::new(encoding, HELLO_MAX);
        frames.handle_bytes(&first_bytes[encoding.preamble().len()..]);
        self.stage = Stage::Talking(frames, 0, Peer::Unknown);
        Ok(())
    }
}

impl Default for Inbound {
    fn default() -> Self {
        Self::new()
    }
}

/// Returns the next message, which would be number `number` of its connection, counted from 1.
fn next_message(frames: &mut FrameDecoder, number: u64) -> Result<Option<ClientMessage>, Refused> {
    let encoding = frames.encoding();
    let body = match frames.poll() {
        Ok(Some(body)) => body,
        Ok(None) => return Ok(None),
        Err(FrameError::TooLarge { limit }) => return Err(Refused::TooLarge { limit: limit_of(limit) }),
        Err(error @ FrameError::Empty) => {
            return Err(malformed(format!("message {number}"), error.to_string()));
        }
    };
    decode_client(encoding, body)
        .map(Some)
        .map_err(|error| malformed(format!("message {number}, {}", error.place), error.problem))
}

/// Checks what must hold for every match; the version first, because the rest may mean something else in another.
fn check_hello(hello: &Hello) -> Result<(), Refused> {
    check_version(hello.protocol)?;
    check_name("client", &hello.client)?;
    check_name("player", &hello.player)?;
    if hello.player.is_empty() {
        return Err(malformed("the handshake".to_owned(), "`player` is empty".to_owned()));
    }
    let is_token =
        hello.token.len() == TOKEN_DIGITS && hello.token.bytes().all(|byte| byte.is_ascii_hexdigit());
    if hello.token.is_empty() || is_token { Ok(()) } else { Err(Refused::Token) }
}

/// As [`check_hello`].
fn check_watch(watch: &Watch) -> Result<(), Refused> {
    check_version(watch.protocol)?;
    check_name("client", &watch.client)
}

fn check_version(protocol: u32) -> Result<(), Refused> {
    if protocol == PROTOCOL { Ok(()) } else { Err(Refused::Protocol { supported: PROTOCOL }) }
}

fn check_name(field: &str, name: &str) -> Result<(), Refused> {
    if name.len() > NAME_MAX {
        return Err(Refused::NameTooLong { limit: limit_of(NAME_MAX) });
    }
    if name.chars().any(char::is_control) {
        let problem = format!("`{field}` holds a control character");
        return Err(malformed("the handshake".to_owned(), problem));
    }
    Ok(())
}

fn malformed(place: String, problem: String) -> Refused {
    Refused::Malformed { place, problem }
}

fn limit_of(limit: usize) -> u32 {
    u32::try_from(limit).expect("limits of messages and names are below 2^32")
}

#[cfg(test)]
mod tests {
    use maniple_view::Seat;

    use super::*;
    use crate::arbitrary::Random;
    use crate::encoding::encode_client;

    const ENCODINGS: [Encoding; 2] = [Encoding::Binary, Encoding::Json];

    #[test]
    fn a_hello_opens_and_the_match_follows() {
        for encoding in ENCODINGS {
            let commands = ClientMessage::Commands { seen_cycle: Cycle(7), list: Vec::new() };
            let messages = [
                ClientMessage::Hello(hello()),
                commands,
                ClientMessage::Done { cycle: Cycle(7) },
                ClientMessage::Ping { id: 3 },
                ClientMessage::Pause { on: true },
            ];
            let expected = [
                Input::Hello(hello()),
                Input::Commands { seen_cycle: Cycle(7), list: Vec::new() },
                Input::Done { cycle: Cycle(7) },
                Input::Ping { id: 3 },
                Input::Pause { on: true },
            ];
            assert_eq!(inputs(&[&stream(encoding, &messages)]), (expected.to_vec(), encoding));
        }
    }

    #[test]
    fn the_first_message_and_only_the_first_is_a_hello() {
        for encoding in ENCODINGS {
            let ping = ClientMessage::Ping { id: 1 };
            let hello = ClientMessage::Hello(hello());
            check_violation(&stream(encoding, std::slice::from_ref(&ping)), &Refused::Handshake);
            check_violation(&stream(encoding, &[hello.clone(), hello]), &Refused::Handshake);
        }
    }

    #[test]
    fn a_watch_opens_too_and_nothing_but_pings_may_follow() {
        for encoding in ENCODINGS {
            let watch = Watch { protocol: PROTOCOL, client: "test 1.0".to_owned(), view: Seat(1).into() };
            let (opening, ping) = (ClientMessage::Watch(watch.clone()), ClientMessage::Ping { id: 3 });
            let (taken, _) = inputs(&[&stream(encoding, &[opening.clone(), ping.clone(), ping.clone()])]);
            assert_eq!(taken, [Input::Watch(watch.clone()), Input::Ping { id: 3 }, Input::Ping { id: 3 }]);
            let check = |message: ClientMessage, expected: Refused| {
                check_violation(&stream(encoding, &[opening.clone(), ping.clone(), message]), &expected);
            };
            check(ClientMessage::Commands { seen_cycle: Cycle(0), list: Vec::new() }, Refused::Spectator);
            check(ClientMessage::Done { cycle: Cycle(0) }, Refused::Spectator);
            check(ClientMessage::Pause { on: true }, Refused::Spectator);
            check(ClientMessage::Hello(hello()), Refused::Handshake);
            check(opening.clone(), Refused::Handshake);
            let hello_first = [ClientMessage::Hello(hello()), opening.clone()];
            check_violation(&stream(encoding, &hello_first), &Refused::Handshake);
            let check = |watch: Watch, expected: Refused| {
                check_violation(&stream(encoding, &[ClientMessage::Watch(watch)]), &expected);
            };
            let other = Watch { protocol: PROTOCOL + 1, ..watch.clone() };
            check(other, Refused::Protocol { supported: PROTOCOL });
            check(Watch { client: "a".repeat(65), ..watch.clone() }, Refused::NameTooLong { limit: 64 });
            let long = vec![b'a'; HELLO_MAX + 1];
            let bytes = [stream(encoding, std::slice::from_ref(&opening)), frame(encoding, &long)].concat();
            let dropped = Input::Dropped(Refused::TooLarge { limit: limit_of(HELLO_MAX) });
            assert_eq!(inputs(&[&bytes]).0, [Input::Watch(watch.clone()), dropped]);
        }
    }

    #[test]
    fn a_hello_is_checked() {
        let check = |change: fn(&mut Hello), expected: Refused| {
            let mut hello = hello();
            change(&mut hello);
            for encoding in ENCODINGS {
                check_violation(&stream(encoding, &[ClientMessage::Hello(hello.clone())]), &expected);
            }
        };
        let malformed = |problem: &str| malformed("the handshake".to_owned(), problem.to_owned());
        check(|hello| hello.protocol = PROTOCOL + 1, Refused::Protocol { supported: PROTOCOL });
        check(|hello| hello.protocol = 0, Refused::Protocol { supported: PROTOCOL });
        check(|hello| hello.player = "a".repeat(65), Refused::NameTooLong { limit: 64 });
        check(|hello| hello.client = "é".repeat(33), Refused::NameTooLong { limit: 64 });
        check(|hello| hello.player = String::new(), malformed("`player` is empty"));
        check(|hello| hello.client = "a\nb".to_owned(), malformed("`client` holds a control character"));
        check(|hello| hello.token = "secret".to_owned(), Refused::Token);
        check(|hello| hello.token = "g".repeat(32), Refused::Token);
        check(|hello| hello.token = "0".repeat(33), Refused::Token);
    }

    #[test]
    fn names_at_the_limit_and_a_whole_token_are_taken() {
        let hello =
            Hello { player: "a".repeat(64), token: "0123456789abcdefABCDEF0123456789".to_owned(), ..hello() };
        for encoding in ENCODINGS {
            let (inputs, _) = inputs(&[&stream(encoding, &[ClientMessage::Hello(hello.clone())])]);
            assert_eq!(inputs, [Input::Hello(hello.clone())]);
        }
    }

    #[test]
    fn first_bytes_of_another_protocol_are_answered_in_json() {
        for first_bytes in ["GET / HTTP/1.1\r\n", "MNPX", "\n{}", "[", "\u{16}\u{3}\u{1}"] {
            let (inputs, encoding) = inputs(&[first_bytes.as_bytes()]);
            assert_eq!(inputs.len(), 1, "{first_bytes:?}");
            assert!(matches!(&inputs[0], Input::Violation(Refused::Malformed { place, .. })
                if place == "the first bytes"));
            assert_eq!(encoding, Encoding::Json);
        }
    }

    #[test]
    fn a_message_has_one_limit_before_the_hello_and_another_after_it() {
        let long_line = |length: usize| [b"{".as_slice(), &vec![b' '; length - 1], b"\n"].concat();
        check_violation(&long_line(HELLO_MAX + 1), &Refused::TooLarge { limit: 4096 });
        check_violation(b"MNPL\x01\x10\0\0", &Refused::TooLarge { limit: 4096 });
        let greeting = stream(Encoding::Json, &[ClientMessage::Hello(hello())]);
        let ping = stream(Encoding::Json, &[ClientMessage::Ping { id: 3 }]);
        let after = [greeting.clone(), long_line(FRAME_FROM_CLIENT_MAX + 1), ping].concat();
        let expected = [Input::Dropped(Refused::TooLarge { limit: 16_384 }), Input::Ping { id: 3 }];
        assert_eq!(inputs(&[&after]).0[1..], expected);
        assert_eq!(inputs(&after.chunks(1000).collect::<Vec<_>>()).0[1..], expected);
        // Nobody is heard out for ever.
        let far_too_long = u32::try_from(SKIPPED_MAX + 1).unwrap().to_le_bytes();
        let greeting = stream(Encoding::Binary, &[ClientMessage::Hello(hello())]);
        check_violation(&[&greeting, &far_too_long[..]].concat(), &Refused::TooLarge { limit: 16_384 });
    }

    #[test]
    fn a_problem_names_message_and_place() {
        let greeting = stream(Encoding::Json, &[ClientMessage::Hello(hello())]);
        let stream = [&greeting, b"{\"ping\":{\"id\":1}}\n{\"ping\":{\"it\":1}}\n".as_slice()].concat();
        let (inputs, _) = inputs(&[&stream]);
        let Some(Input::Violation(refused)) = inputs.last() else { panic!("{inputs:?}") };
        assert_eq!(refused.to_string(), "message 3, column 13: unknown field `it`, expected `id`");
    }

    #[test]
    fn nothing_comes_after_a_violation() {
        let mut inbound = Inbound::new();
        inbound.handle_bytes(b"MNPL\0\0\0\0");
        assert!(matches!(inbound.poll(), Some(Input::Violation(_))));
        for _ in 0..100 {
            inbound.handle_bytes(&stream(Encoding::Binary, &[ClientMessage::Hello(hello())]));
            assert_eq!(inbound.poll(), None);
        }
        assert_eq!(inbound.encoding(), Encoding::Binary);
    }

    #[test]
    fn how_bytes_are_split_makes_no_difference() {
        for seed in 0..400 {
            let mut random = Random::new(seed);
            let encoding = ENCODINGS[random.below(2)];
            let mut messages = vec![ClientMessage::Hello(hello())];
            messages.extend(random.list(Random::client_message));
            let mut bytes = stream(encoding, &messages);
            if random.coin() {
                bytes.extend(random.bytes(40));
            }
            if random.coin() {
                let place = random.below(bytes.len());
                bytes[place] = random.number().to_le_bytes()[0];
            }
            let whole = inputs(&[&bytes]);
            let single: Vec<&[u8]> = bytes.chunks(1).collect();
            assert_eq!(inputs(&single), whole, "byte by byte, seed {seed}");
            assert_eq!(inputs(&random.split(&bytes)), whole, "seed {seed}");
        }
    }

    #[test]
    fn random_bytes_give_at_most_one_violation_and_no_panic() {
        for seed in 0..2000 {
            let mut random = Random::new(seed);
            let mut bytes = if random.coin() { b"MNPL".to_vec() } else { b"{".to_vec() };
            bytes.extend(random.bytes(200));
            let (inputs, _) = inputs(&[&bytes]);
            assert!(inputs.len() <= 1, "seed {seed}");
        }
    }

    fn hello() -> Hello {
        Hello {
            protocol: PROTOCOL,
            client: "test 1.0".to_owned(),
            player: "Ada".to_owned(),
            token: String::new(),
        }
    }

    fn frame(encoding: Encoding, body: &[u8]) -> Vec<u8> {
        match encoding {
            Encoding::Binary => [&limit_of(body.len()).to_le_bytes(), body].concat(),
            Encoding::Json => [body, b"\n"].concat(),
        }
    }

    fn stream(encoding: Encoding, messages: &[ClientMessage]) -> Vec<u8> {
        let mut bytes = encoding.preamble().to_vec();
        for message in messages {
            bytes.extend(encode_client(encoding, message).unwrap());
        }
        bytes
    }

    fn inputs(pieces: &[&[u8]]) -> (Vec<Input>, Encoding) {
        let mut inbound = Inbound::new();
        let mut inputs = Vec::new();
        for piece in pieces {
            inbound.handle_bytes(piece);
            while let Some(input) = inbound.poll() {
                inputs.push(input);
            }
        }
        (inputs, inbound.encoding())
    }

    fn check_violation(bytes: &[u8], expected: &Refused) {
        let (inputs, _) = inputs(&[bytes]);
        assert_eq!(inputs.last(), Some(&Input::Violation(expected.clone())));
    }
}
