//! Who breaks the rules of the protocol is told, and nobody else notices.

use std::time::Duration;

use maniple_client::Event;
use maniple_protocol::{Encoding, FRAME_FROM_CLIENT_MAX, HELLO_MAX, Refused, ServerMessage, encode_commands};
use maniple_referee::QUEUED_MAX;
use maniple_view::{ClockMode, Command, Handle, Sequenced};
use tokio::io::AsyncWriteExt;
use tokio::time::timeout;

use super::{LOCKSTEP, check_replay, headless, hello, play, rest, seated, start};
use crate::arena::{Arena, bot, loaded};

#[tokio::test(flavor = "multi_thread")]
async fn who_breaks_the_protocol_is_told_and_nobody_else_notices() {
    let bots = ["straight", "straight"];
    let (expected, views) = headless(&loaded(LOCKSTEP), bots);
    let arena = Arena::open(&loaded(LOCKSTEP), ClockMode::Lockstep);
    let mut silent = arena.raw().await;
    let mut b = arena.client(1).await;
    let Event::Cycle(keyframe) = b.next().await.unwrap() else { panic!("a keyframe comes first") };

    let unknown = hello("0123456789abcdef0123456789abcdef");
    let long_line = format!("{{{}\n", " ".repeat(HELLO_MAX));
    let limit = |limit: usize| Refused::TooLarge { limit: limit.try_into().unwrap() };
    check_refused(&arena, &unknown, &Refused::Token).await;
    check_refused(&arena, &hello(""), &Refused::Token).await;
    check_refused(&arena, "{\"ping\":{\"id\":1}}\n", &Refused::Handshake).await;
    check_refused(&arena, &long_line, &limit(HELLO_MAX)).await;
    check_malformed(&arena, "GET / HTTP/1.1\r\n\r\n", "the first bytes").await;
    check_malformed(&arena, "{\"hello\":{}}\n", "message 1, column 11").await;
    check_half_a_hello(&arena).await;

    check_refused_in_seat(&arena, hello(&arena.tokens[0]).as_bytes(), &Refused::Handshake).await;
    let long_line = format!("{}\n", "x".repeat(FRAME_FROM_CLIENT_MAX + 1));
    check_refused_the_third_time(&arena, &long_line, &limit(FRAME_FROM_CLIENT_MAX)).await;
    let unknown_message = Refused::Malformed {
        place: "message 2, column 8".to_owned(),
        problem:
            "unknown variant `cheat`, expected one of `hello`, `commands`, `done`, `ping`, `pause`, `watch`, \
             `list`, `create`, `enter`"
                .to_owned(),
    };
    check_refused_in_seat(&arena, b"{\"cheat\":1}\n", &unknown_message).await;
    check_half_a_message(&arena).await;

    // Nothing else would end the wait for a refusal that never comes.
    let told = timeout(Duration::from_secs(60), rest(&mut silent)).await.expect("who is silent is refused");
    assert_eq!(told, [ServerMessage::Refused { reason: Refused::Timeout { seconds: 5 } }]);

    let a = tokio::spawn(play(arena.client(0).await, bot(bots[0], 0)));
    let mut bot = bot(bots[1], 1);
    start(&mut *bot, &b);
    let commands = bot.on_cycle(b.view(), &keyframe);
    b.send(commands).await.unwrap();
    b.done().await.unwrap();
    assert_eq!(b.play(|view, delta| bot.on_cycle(view, delta)).await.unwrap(), expected);
    assert_eq!(b.view(), &views[1]);
    assert_eq!(a.await.unwrap().0, expected);
    check_replay(&arena.outcome().await, &expected);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_flood_of_commands_removes_who_sends_it() {
    let arena = Arena::open(&loaded(LOCKSTEP), ClockMode::Lockstep);
    let mut other = arena.client(1).await;
    let mut lines = seated(&arena).await;
    let command = Sequenced { seq: 0, command: Command::Stop { object: Handle(0) } };
    // Some 350 of them are a message, and at least three messages are more than may wait.
    let list = vec![command; QUEUED_MAX + 2000];
    let bytes = encode_commands(Encoding::Json, Default::default(), &list).unwrap();
    lines.write_all(&bytes).await.unwrap();
    lines.shutdown().await.unwrap();
    let messages = rest(&mut lines).await;
    let reason = Refused::TooManyCommands { limit: QUEUED_MAX.try_into().unwrap() };
    let warned = |left| ServerMessage::Warned { reason: reason.clone(), left };
    assert_eq!(messages, [warned(1), warned(0), ServerMessage::Refused { reason: reason.clone() }]);
    assert!(matches!(other.next().await.unwrap(), Event::Cycle(_)));
    arena.client(0).await;
    arena.shut_down().await;
}

/// Checks what a connection that begins with `bytes` is answered.
async fn check_refused(arena: &Arena, bytes: &str, expected: &Refused) {
    let mut lines = arena.raw().await;
    lines.write_all(bytes.as_bytes()).await.unwrap();
    lines.shutdown().await.unwrap();
    assert_eq!(rest(&mut lines).await, [ServerMessage::Refused { reason: expected.clone() }], "{bytes:.60}");
}

async fn check_malformed(arena: &Arena, bytes: &str, expected: &str) {
    let mut lines = arena.raw().await;
    lines.write_all(bytes.as_bytes()).await.unwrap();
    let messages = rest(&mut lines).await;
    let [ServerMessage::Refused { reason: Refused::Malformed { place, .. } }] = messages.as_slice() else {
        panic!("{bytes}: {messages:?}");
    };
    assert_eq!(place, expected, "{bytes}");
}

/// Checks what may happen twice: each time is told, and what comes behind is heard.
async fn check_refused_the_third_time(arena: &Arena, line: &str, expected: &Refused) {
    let mut lines = seated(arena).await;
    let ping = "{\"ping\":{\"id\":1}}\n";
    lines.write_all([line, ping, line, line, ping].concat().as_bytes()).await.unwrap();
    lines.shutdown().await.unwrap();
    let warned = |left| ServerMessage::Warned { reason: expected.clone(), left };
    let pong = ServerMessage::Pong { id: 1, cycle: Default::default(), fraction: 0.0 };
    let refused = ServerMessage::Refused { reason: expected.clone() };
    assert_eq!(rest(&mut lines).await, [warned(1), pong, warned(0), refused]);
}

/// Checks what `bytes` after a good hello at seat 0 are answered.
async fn check_refused_in_seat(arena: &Arena, bytes: &[u8], expected: &Refused) {
    let mut lines = seated(arena).await;
    lines.write_all(bytes).await.unwrap();
    lines.shutdown().await.unwrap();
    assert_eq!(rest(&mut lines).await, [ServerMessage::Refused { reason: expected.clone() }]);
}

async fn check_half_a_hello(arena: &Arena) {
    let mut lines = arena.raw().await;
    let hello = hello(&arena.tokens[0]);
    lines.write_all(&hello.as_bytes()[..hello.len() / 2]).await.unwrap();
    lines.shutdown().await.unwrap();
    assert_eq!(rest(&mut lines).await, []);
}

async fn check_half_a_message(arena: &Arena) {
    let mut lines = seated(arena).await;
    lines.write_all(b"{\"done\":{\"cyc").await.unwrap();
    lines.shutdown().await.unwrap();
    assert_eq!(rest(&mut lines).await, []);
}
