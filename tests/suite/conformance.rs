//! `maniple conformance`: the clients that ship pass, and a client that is wrong is told how.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Stdio};
use std::sync::Arc;

use maniple_geometry::Cycle;
use maniple_protocol::{
    ClientMessage, Encoding, FRAME_FROM_SERVER_MAX, FrameDecoder, Hello, PROTOCOL, ServerMessage,
    decode_server, encode_client,
};
use maniple_view::{Command, Handle, Rules, Sequenced, UnitTypeId, View};
use serde_json::Value;

use crate::clients::programs;
use crate::commands::maniple;

/// The kit, waiting for a client.
pub(crate) struct Kit {
    child: Child,
    lines: BufReader<std::process::ChildStdout>,
    address: String,
    pub(crate) token: String,
}

/// What a scripted client knows when it answers a delta.
pub(crate) struct Turn<'a> {
    pub(crate) cycle: u32,
    encoding: Encoding,
    view: &'a View,
}

#[tokio::test(flavor = "multi_thread")]
async fn the_clients_that_ship_pass() {
    for program in programs() {
        for options in [&[][..], &["--reconnect"]] {
            let kit = Kit::open(options);
            let output = program.run(&kit.address, &kit.token, &["--conformance"]).await;
            let errors = String::from_utf8_lossy(&output.stderr).into_owned();
            let (verdict, code) = kit.verdict();
            assert!(output.status.success(), "{}: {errors} {verdict}", program.name);
            assert_eq!(
                (code, &verdict["passed"]),
                (Some(0), &Value::Bool(true)),
                "{}: {verdict}",
                program.name
            );
            assert_eq!(verdict["proved"], verdict["deltas"], "{}", program.name);
            for what in
                ["moved", "segment", "object", "vanished", "died", "shots", "walls", "stock", "refused"]
            {
                assert!(verdict["told"][what].as_u64() > Some(0), "{}, {what}: {verdict}", program.name);
            }
        }
    }
}

#[test]
fn a_client_that_does_not_tell_its_check_is_judged_on_the_rest() {
    let kit = Kit::open(&[]);
    kit.lead(Encoding::Json, &hello(&kit.token), |turn| Some(turn.done(turn.cycle)));
    let (verdict, code) = kit.verdict();
    assert_eq!(code, Some(0), "{verdict}");
    assert_eq!((verdict["proved"].as_u64(), verdict["deltas"].as_u64()), (Some(0), Some(120)));
}

#[test]
fn a_hello_that_is_wrong_is_told() {
    let check = |greeting: &dyn Fn(&str) -> Vec<u8>, expected: (&str, &str)| {
        let kit = Kit::open(&[]);
        kit.lead(Encoding::Json, &greeting(&kit.token), |_| None);
        check_verdict(kit, expected);
    };
    check(&|_| b"GET / HTTP/1.1\r\n".to_vec(), ("violation", "the first bytes"));
    check(&|_| b"{\"done\":{\"cycle\":0}}\n".to_vec(), ("violation", "`hello`"));
    check(&|token| hello_of(token, PROTOCOL + 1, "me"), ("violation", "speaks protocol"));
    check(&|token| hello_of(token, PROTOCOL, &"n".repeat(65)), ("violation", "at most 64 bytes"));
    check(&|token| hello_of(token, PROTOCOL, ""), ("violation", "`player` is empty"));
    check(&|_| hello(""), ("token", "opens no seat"));
    check(&|_| hello("123"), ("violation", "opens no seat"));
    check(
        &|_| b"{\"hello\":{\"protocol\":3}}\n".to_vec(),
        ("violation", "message 1, column 23: missing field"),
    );
}

#[test]
fn a_client_that_is_wrong_in_mid_match_is_told() {
    let line = |text: &str| format!("{text}\n").into_bytes();
    wrong_once(("violation", "unknown field `it`"), |_| Some(line("{\"ping\":{\"it\":1}}")));
    wrong_once(("violation", "at most 16384 bytes"), |_| Some(line(&format!("{{{}", " ".repeat(16_384)))));
    wrong_once(("violation", "`hello`"), |_| Some(hello("")));
    wrong_once(("seen_cycle", "seen_cycle 8"), |turn| {
        Some([turn.command(turn.cycle - 1, stop(1)), turn.good()].concat())
    });
    wrong_once(("done_cycle", "cycle 10"), |turn| Some([turn.proof(), turn.done(turn.cycle + 1)].concat()));
    wrong_once(("done_twice", "once more"), |turn| Some([turn.done(turn.cycle - 1), turn.good()].concat()));
    wrong_once(("unknown_handle", "object 99"), |turn| {
        Some([turn.command(turn.cycle, stop(99)), turn.good()].concat())
    });
    // The crystal is in sight, but nobody's.
    wrong_once(("unknown_handle", "object 7"), |turn| {
        Some([turn.command(turn.cycle, stop(7)), turn.good()].concat())
    });
    wrong_once(("unknown_target", "target 77"), |turn| {
        let attack = Command::Attack { object: Handle(1), target: Handle(77) };
        Some([turn.command(turn.cycle, attack), turn.good()].concat())
    });
    wrong_once(("check", "ends in 00000000"), |turn| Some([turn.ping(0), turn.done(turn.cycle)].concat()));
    wrong_once(("no_proof", "no ping"), |turn| Some(turn.done(turn.cycle)));
    wrong_once(("resigned", "resigned"), |turn| {
        Some([turn.command(turn.cycle, Command::Resign), turn.good()].concat())
    });
    wrong_once(("silent", "for 1 s"), |_| Some(Vec::new()));
    wrong_once(("closed", "closed"), |_| None);
}

#[test]
fn what_json_cannot_say_is_told_in_binary() {
    let check = |expected, wrong: &dyn Fn(&Turn<'_>) -> Vec<u8>| {
        let kit = Kit::open(&[]);
        let greeting = encode_client(Encoding::Binary, &greeting(&kit.token, PROTOCOL, "me")).unwrap();
        let greeting = [Encoding::Binary.preamble(), &greeting].concat();
        kit.lead(Encoding::Binary, &greeting, |turn| {
            let before = if turn.cycle == 9 { wrong(turn) } else { Vec::new() };
            Some([before, turn.done(turn.cycle)].concat())
        });
        check_verdict(kit, expected);
    };
    check(("not_finite", "command 5"), &|turn| {
        let (object, unit_type) = (Handle(6), UnitTypeId(3));
        turn.command(turn.cycle, Command::Build { object, unit_type, x: f64::NAN, y: 1.0 })
    });
    check(("violation", "byte 1"), &|_| vec![1, 0, 0, 0, 9]);
    check(("too_many_commands", "more than 16384"), &|turn| {
        let list: Vec<Sequenced> = (0..2000).map(|seq| Sequenced { seq, command: stop(1) }).collect();
        let message = ClientMessage::Commands { seen_cycle: Cycle(turn.cycle), list };
        turn.encode(&message).repeat(9)
    });
}

#[test]
fn a_pause_that_the_client_asks_for_is_granted_and_ended() {
    let kit = Kit::open(&[]);
    let heard = kit.lead(Encoding::Json, &hello(&kit.token), |turn| {
        let pause = turn.encode(&ClientMessage::Pause { on: true });
        Some(if turn.cycle == 9 { [pause, turn.good()].concat() } else { turn.good() })
    });
    let is_on = |message: &ServerMessage| match message {
        ServerMessage::Paused { on, .. } => Some(*on),
        ServerMessage::Welcome(_)
        | ServerMessage::Refused { .. }
        | ServerMessage::Delta(_)
        | ServerMessage::Packed(_)
        | ServerMessage::Pong { .. }
        | ServerMessage::Ended { .. }
        | ServerMessage::Matches { .. }
        | ServerMessage::Created { .. }
        | ServerMessage::Keyframe {}
        | ServerMessage::Warned { .. } => None,
    };
    let told: Vec<bool> = heard.iter().filter_map(is_on).collect();
    // The wish of the other seat comes later.
    assert_eq!(told, [true, false, false, false]);
    let (verdict, code) = kit.verdict();
    assert_eq!(code, Some(0), "{verdict}");
}

#[test]
fn who_says_much_and_is_never_done_is_told() {
    let kit = Kit::open(&["--patience", "1"]);
    kit.lead(Encoding::Json, &hello(&kit.token), |turn| {
        let pings = turn.proof().repeat(1000);
        Some(if turn.cycle == 9 { pings } else { turn.good() })
    });
    check_verdict(kit, ("silent", "for 1 s"));
}

#[test]
fn who_does_not_come_back_is_told() {
    let kit = Kit::open(&["--reconnect", "--patience", "1"]);
    kit.lead(Encoding::Json, &hello(&kit.token), |turn| Some(turn.good()));
    check_verdict(kit, ("no_return", "did not connect again"));
}

/// Plays with a client that is right but for the answer to the delta of cycle 9, and checks that this is told and
/// nothing else.
fn wrong_once(expected: (&str, &str), wrong: impl Fn(&Turn<'_>) -> Option<Vec<u8>>) {
    let kit = Kit::open(&["--patience", "1"]);
    kit.lead(Encoding::Json, &hello(&kit.token), |turn| {
        if turn.cycle == 9 { wrong(turn) } else { Some(turn.good()) }
    });
    check_verdict(kit, expected);
}

fn check_verdict(kit: Kit, (mistake, what): (&str, &str)) {
    let (verdict, code) = kit.verdict();
    let findings = verdict["findings"].as_array().unwrap();
    assert_eq!((code, findings.len()), (Some(1), 1), "{mistake}: {verdict}");
    let text = |field: &str| findings[0][field].as_str().unwrap();
    assert_eq!(text("mistake"), mistake, "{verdict}");
    assert!(text("what").contains(what), "{mistake}: {verdict}");
    assert!(!text("expected").is_empty() && !text("remedy").is_empty(), "{verdict}");
}

impl Kit {
    pub(crate) fn open(options: &[&str]) -> Self {
        let words = [&["conformance", "serve", "--listen", "127.0.0.1:0", "--json"], options].concat();
        let mut child = maniple(&words).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        let mut lines = BufReader::new(child.stdout.take().unwrap());
        let mut line = String::new();
        lines.read_line(&mut line).unwrap();
        let opened: Value = serde_json::from_str(&line).unwrap();
        let text = |field: &str| opened[field].as_str().unwrap().to_owned();
        Self { child, lines, address: text("address"), token: text("token") }
    }

    /// Returns the verdict and the exit code.
    fn verdict(mut self) -> (Value, Option<i32>) {
        let mut text = String::new();
        self.lines.read_to_string(&mut text).unwrap();
        let code = self.child.wait().unwrap().code();
        (serde_json::from_str(&text).unwrap(), code)
    }

    /// Plays as a client that greets so and gives these answers, until one is `None` or the connection ends. Returns
    /// what it heard, each message as a body.
    pub(crate) fn lead(
        &self,
        encoding: Encoding,
        greeting: &[u8],
        answer: impl Fn(&Turn<'_>) -> Option<Vec<u8>>,
    ) -> Vec<ServerMessage> {
        let mut stream = TcpStream::connect(&self.address).unwrap();
        stream.set_nodelay(true).unwrap();
        stream.write_all(greeting).unwrap();
        let mut frames = FrameDecoder::new(encoding, FRAME_FROM_SERVER_MAX);
        let (mut buffer, mut heard, mut view, mut rules) = ([0; 4096], Vec::new(), View::default(), None);
        while let Ok(count @ 1..) = stream.read(&mut buffer) {
            frames.handle_bytes(&buffer[..count]);
            while let Some(body) = frames.poll().unwrap() {
                let message = decode_server(encoding, body).unwrap();
                if take_in(&message, &mut view, &mut rules) {
                    let turn = Turn { cycle: view.cycle().0, encoding, view: &view };
                    let Some(bytes) = answer(&turn) else { return heard };
                    // The end may have come meanwhile.
                    let _ = stream.write_all(&bytes);
                }
                heard.push(message);
            }
        }
        heard
    }
}

/// Brings a view up to date; returns whether there was a delta.
fn take_in(message: &ServerMessage, view: &mut View, rules: &mut Option<Rules>) -> bool {
    match message {
        ServerMessage::Welcome(welcome) => {
            *view = View::new(&welcome.rules, Arc::new(welcome.terrain.clone()));
            *rules = Some(welcome.rules.clone());
            false
        }
        ServerMessage::Delta(delta) => {
            view.apply(delta).unwrap();
            true
        }
        ServerMessage::Packed(packed) => {
            let delta = packed.clone().unpack(view, rules.as_ref().unwrap()).unwrap();
            view.apply(&delta).unwrap();
            true
        }
        ServerMessage::Refused { .. }
        | ServerMessage::Pong { .. }
        | ServerMessage::Paused { .. }
        | ServerMessage::Ended { .. }
        | ServerMessage::Matches { .. }
        | ServerMessage::Created { .. }
        | ServerMessage::Keyframe {}
        | ServerMessage::Warned { .. } => false,
    }
}

impl Turn<'_> {
    /// Returns a right answer that commands nothing.
    pub(crate) fn good(&self) -> Vec<u8> {
        [self.proof(), self.done(self.cycle)].concat()
    }

    fn proof(&self) -> Vec<u8> {
        self.ping(self.low_half())
    }

    /// Returns the low half of the check.
    pub(crate) fn low_half(&self) -> u32 {
        u32::try_from(self.view.check().0 & u64::from(u32::MAX)).unwrap()
    }

    fn ping(&self, id: u32) -> Vec<u8> {
        self.encode(&ClientMessage::Ping { id })
    }

    fn done(&self, cycle: u32) -> Vec<u8> {
        self.encode(&ClientMessage::Done { cycle: Cycle(cycle) })
    }

    fn command(&self, seen_cycle: u32, command: Command) -> Vec<u8> {
        let list = vec![Sequenced { seq: 5, command }];
        self.encode(&ClientMessage::Commands { seen_cycle: Cycle(seen_cycle), list })
    }

    pub(crate) fn encode(&self, message: &ClientMessage) -> Vec<u8> {
        encode_client(self.encoding, message).unwrap()
    }
}

fn stop(object: u32) -> Command {
    Command::Stop { object: Handle(object) }
}

pub(crate) fn greeting(token: &str, protocol: u32, player: &str) -> ClientMessage {
    let client = "scripted".to_owned();
    ClientMessage::Hello(Hello { protocol, client, player: player.to_owned(), token: token.to_owned() })
}

fn hello(token: &str) -> Vec<u8> {
    hello_of(token, PROTOCOL, "me")
}

fn hello_of(token: &str, protocol: u32, player: &str) -> Vec<u8> {
    encode_client(Encoding::Json, &greeting(token, protocol, player)).unwrap()
}
