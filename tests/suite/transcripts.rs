//! Whole matches as both sides said them, with the view after each delta: for authors of clients.

use std::cell::RefCell;
use std::fmt::Write as _;
use std::path::PathBuf;
use std::sync::Arc;

use maniple_bots::Bot;
use maniple_game::Loaded;
use maniple_protocol::{
    ClientMessage, Encoding, Outbound, PROTOCOL, ServerMessage, Welcome, encode_client, encode_server,
};
use maniple_referee::Referee;
use maniple_view::{ClockMode, Command, Digest, Handle, Seat, Sequenced, View};
use serde_json::{Value, json};
use tokio::io::AsyncWriteExt;
use tokio::net::TcpListener;

use crate::arena::bot;
use crate::clients::{programs, race};
use crate::commands::ROOT;
use crate::conformance::{Kit, greeting};

const NAMES: [&str; 3] = ["race", "race_grid", "story"];

const TOKEN: &str = "00112233445566778899aabbccddeeff";

/// A message, by who said it.
#[expect(clippy::large_enum_variant, reason = "there are few")]
enum Said {
    Client(ClientMessage),
    Server(ServerMessage),
}

#[test]
fn transcripts_are_what_the_program_says() {
    for (name, said) in NAMES.into_iter().zip([
        played(&race("positions = 'exact'", 6)),
        played(&race("positions = 'grid', grid_bits = 7", 6)),
        led(),
    ]) {
        let path = path(name);
        let found = transcript(&said);
        if std::env::var("UPDATE_GOLDEN").is_ok_and(|value| value == "1") {
            std::fs::write(&path, &found).unwrap();
        }
        let expected = std::fs::read_to_string(&path).unwrap_or_default();
        let first = expected.lines().zip(found.lines()).position(|(expected, found)| expected != found);
        assert!(
            expected == found,
            "{name}: line {first:?} differs; if that is meant, run with UPDATE_GOLDEN=1"
        );
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn each_client_follows_the_transcripts() {
    for program in programs() {
        for name in NAMES {
            let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
            let address = listener.local_addr().unwrap().to_string();
            let bytes = from_server(name, program.encoding);
            let server = tokio::spawn(async move {
                let (stream, _) = listener.accept().await.unwrap();
                let (mut from_client, mut to_client) = stream.into_split();
                to_client.write_all(&bytes).await.unwrap();
                tokio::io::copy(&mut from_client, &mut tokio::io::sink()).await
            });
            let output = program.run(&address, TOKEN, &[]).await;
            let errors = String::from_utf8_lossy(&output.stderr);
            assert!(output.status.success(), "{}, {name}: {errors}", program.name);
            let told: Value = serde_json::from_slice(&output.stdout).unwrap();
            let deltas = lines(name).iter().filter(|line| line.get("view").is_some()).count();
            assert_eq!(told["checks"].as_u64(), u64::try_from(deltas).ok(), "{}, {name}", program.name);
            // However the client left.
            let _ = server.await.unwrap();
        }
    }
}

/// Returns all that the server says in a transcript.
fn from_server(name: &str, encoding: Encoding) -> Vec<u8> {
    let mut bytes = Vec::new();
    for line in lines(name).iter().filter(|line| line["from"] == "server") {
        match encoding {
            Encoding::Json => bytes.extend(format!("{}\n", line["json"]).into_bytes()),
            Encoding::Binary => {
                let digits = line["hex"].as_str().unwrap();
                let byte = |at| u8::from_str_radix(&digits[at..at + 2], 16).unwrap();
                bytes.extend((0..digits.len()).step_by(2).map(byte));
            }
        }
    }
    bytes
}

/// Returns a match of two bots as seat 0 says and hears it.
fn played(loaded: &Loaded) -> Vec<Said> {
    let mut referee = Referee::new(loaded.clone(), ClockMode::Lockstep).unwrap();
    let seats = [Seat(0), Seat(1)];
    for seat in seats {
        referee.handle_join(seat, ["me", "other"][seat.index()]).unwrap();
    }
    let mut bots: Vec<Box<dyn Bot + Send>> = vec![bot("straight", 0), bot("random", 1)];
    for seat in seats {
        bots[seat.index()].on_start(seat, &referee.rules(), referee.terrain());
    }
    let mut said = vec![
        Said::Client(greeting(TOKEN, PROTOCOL, "me")),
        Said::Server(ServerMessage::Welcome(Welcome {
            match_id: Digest(1),
            seat: Some(Seat(0)),
            delay: None,
            seats: 2,
            cycle: referee.cycle(),
            rate: referee.rate(),
            clock: ClockMode::Lockstep,
            rules: referee.rules(),
            terrain: referee.terrain().as_ref().clone(),
        })),
    ];
    loop {
        referee.take_records();
        for seat in seats {
            let delta = referee.take_delta(seat).unwrap();
            let commands = bots[seat.index()].on_cycle(referee.view(seat), &delta);
            let list: Vec<Sequenced> =
                (0..).zip(commands).map(|(seq, command)| Sequenced { seq, command }).collect();
            let cycle = delta.cycle;
            if seat == Seat(0) {
                said.push(Said::Server(ServerMessage::Delta(delta)));
                if !list.is_empty() {
                    said.push(Said::Client(ClientMessage::Commands {
                        seen_cycle: cycle,
                        list: list.clone(),
                    }));
                }
                said.push(Said::Client(ClientMessage::Done { cycle }));
            }
            referee.handle_commands(seat, cycle, list).unwrap();
        }
        if let Some(result) = referee.result() {
            said.push(Said::Server(ServerMessage::Ended { result: result.clone() }));
            return said;
        }
        referee.step();
    }
}

/// Returns the match of `maniple conformance`, of a client that gives commands as long as all are refused.
fn led() -> Vec<Said> {
    let kit = Kit::open(&[]);
    let hello = greeting(&kit.token, PROTOCOL, "me");
    let answers = RefCell::new(Vec::new());
    let heard = kit.lead(Encoding::Json, &encode_client(Encoding::Json, &hello).unwrap(), |turn| {
        let cycle = maniple_geometry::Cycle(turn.cycle);
        let stop = |seq| Sequenced { seq, command: Command::Stop { object: Handle(seq) } };
        let mut answer = vec![ClientMessage::Ping { id: turn.low_half() }, ClientMessage::Done { cycle }];
        if turn.cycle < 4 {
            let list = (0..6).map(stop).collect();
            answer.insert(0, ClientMessage::Commands { seen_cycle: cycle, list });
        }
        let bytes = answer.iter().flat_map(|message| turn.encode(message)).collect();
        answers.borrow_mut().push(answer);
        Some(bytes)
    });
    let mut answers = answers.into_inner().into_iter();
    let mut said = vec![Said::Client(hello)];
    for message in heard {
        let is_delta = matches!(message, ServerMessage::Delta(_));
        said.push(Said::Server(message));
        if is_delta {
            said.extend(answers.next().unwrap().into_iter().map(Said::Client));
        }
    }
    said
}

fn transcript(said: &[Said]) -> String {
    let (mut text, mut outbound, mut view) =
        (String::new(), Outbound::new(Encoding::Binary), View::default());
    for said in said {
        let (from, json, binary) = match said {
            Said::Client(message) => (
                "client",
                encode_client(Encoding::Json, message).unwrap(),
                encode_client(Encoding::Binary, message).unwrap(),
            ),
            Said::Server(message) => {
                ("server", encode_server(Encoding::Json, message).unwrap(), outbound.encode(message).unwrap())
            }
        };
        let json = String::from_utf8(json).unwrap();
        let hex: String = binary.iter().map(|byte| format!("{byte:02x}")).collect();
        writeln!(text, "{{\"from\":\"{from}\",\"json\":{},\"hex\":\"{hex}\"}}", json.trim_end()).unwrap();
        match said {
            Said::Server(ServerMessage::Welcome(welcome)) => {
                view = View::new(&welcome.rules, Arc::new(welcome.terrain.clone()));
            }
            Said::Server(ServerMessage::Delta(delta)) => {
                view.apply(delta).unwrap();
                writeln!(text, "{}", described(&view)).unwrap();
            }
            Said::Server(_) | Said::Client(_) => {}
        }
    }
    text
}

fn described(view: &View) -> Value {
    let object = |(handle, seen): (Handle, &maniple_view::Seen)| {
        let point = seen.base.position(view.cycle());
        json!({ "object": handle, "point": [point.x, point.y], "status": seen.status, "own": seen.own })
    };
    let objects: Vec<Value> = view.objects().map(object).collect();
    let terrain = view.terrain();
    let visible = (0..terrain.height).map(|y| {
        (0..terrain.width).map(|x| if view.is_visible(x, y) { '*' } else { '-' }).collect::<String>()
    });
    json!({ "view": {
        "cycle": view.cycle(),
        "stock": view.stock(),
        "check": view.check(),
        "visible": visible.collect::<Vec<_>>(),
        "objects": objects,
    } })
}

fn lines(name: &str) -> Vec<Value> {
    let text = std::fs::read_to_string(path(name)).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

fn path(name: &str) -> PathBuf {
    PathBuf::from(ROOT).join("tests/golden/transcripts").join(format!("{name}.jsonl"))
}
