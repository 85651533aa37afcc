//! Matches over real sockets: the same as in one process, whoever disturbs them.

#![allow(clippy::unwrap_used, reason = "a helper that fails is a test that fails")]

mod offences;
mod pace;
mod sameness;
mod seats;

use maniple_bots::Bot;
use maniple_client::{Client, ClientError, Event};
use maniple_game::{Loaded, load};
use maniple_protocol::{Hello, PROTOCOL, ServerMessage, read_replay};
use maniple_referee::Referee;
use maniple_view::{ClockMode, MatchResult, Seat, Sequenced, View};
use tokio::io::{AsyncBufReadExt, AsyncWriteExt, BufReader};
use tokio::net::TcpStream;

use crate::arena::{Arena, NAMES, Outcome, bot};
pub(crate) use pace::ping_until_closed;

/// Seats wait for each other as long as it takes: a slow machine shall not change a result.
const LOCKSTEP: &str = "rate = 8\nlength_seconds = 30\nclock = { time_bank_seconds = 3600 }";

/// Returns how a match of these bots comes out in one process, and the views at its end.
fn headless(loaded: &Loaded, bots: [&str; 2]) -> (MatchResult, Vec<View>) {
    let mut referee = Referee::new(loaded.clone(), ClockMode::Lockstep).unwrap();
    let seats = [Seat(0), Seat(1)];
    let mut bots: Vec<_> = bots.iter().zip(seats).map(|(name, seat)| bot(name, seat.0)).collect();
    for seat in seats {
        referee.handle_join(seat, NAMES[seat.index()]).unwrap();
        bots[seat.index()].on_start(seat, &referee.rules(), referee.terrain());
    }
    while referee.result().is_none() {
        referee.take_records();
        for seat in seats {
            let delta = referee.take_delta(seat).unwrap();
            let commands = bots[seat.index()].on_cycle(referee.view(seat), &delta);
            let numbered = (0..).zip(commands).map(|(seq, command)| Sequenced { seq, command });
            referee.handle_commands(seat, delta.cycle, numbered.collect()).unwrap();
        }
        referee.step();
    }
    (referee.result().unwrap().clone(), seats.map(|seat| referee.view(seat).clone()).to_vec())
}

fn start(bot: &mut dyn Bot, client: &Client) {
    bot.on_start(client.seat(), client.rules(), client.terrain());
}

async fn play(client: Client, bot: Box<dyn Bot + Send>) -> (MatchResult, View) {
    let mut client = client;
    let mut bot = bot;
    start(&mut *bot, &client);
    let result = client.play(|view, delta| bot.on_cycle(view, delta)).await.unwrap();
    (result, client.view().clone())
}

/// Plays to the end, whatever that is.
pub(crate) async fn play_to_the_last(
    mut client: Client,
    mut bot: Box<dyn Bot + Send>,
) -> Result<MatchResult, ClientError> {
    start(&mut *bot, &client);
    client.play(|view, delta| bot.on_cycle(view, delta)).await
}

/// Plays until the delta of cycle `last` has come, and does not answer that.
async fn play_until(client: &mut Client, bot: &mut (dyn Bot + Send), last: u32) {
    loop {
        let Event::Cycle(delta) = client.next().await.unwrap() else { panic!("the match goes on") };
        if delta.cycle.0 == last {
            return;
        }
        let commands = bot.on_cycle(client.view(), &delta);
        client.send(commands).await.unwrap();
        client.done().await.unwrap();
    }
}

fn greeting(token: &str) -> Hello {
    let player = NAMES[0].to_owned();
    Hello { protocol: PROTOCOL, client: "by hand".to_owned(), player, token: token.to_owned() }
}

fn hello(token: &str) -> String {
    format!(
        "{{\"hello\":{{\"protocol\":{PROTOCOL},\"client\":\"by hand\",\"player\":\"{}\",\"token\":\"{token}\"}}}}\n",
        NAMES[0]
    )
}

/// Returns the next message; `None` at the end.
async fn next_line(lines: &mut BufReader<TcpStream>) -> Option<ServerMessage> {
    let mut line = String::new();
    let count = lines.read_line(&mut line).await.unwrap();
    (count > 0).then(|| serde_json::from_str(&line).unwrap())
}

/// Returns all that comes until the server closes the connection.
async fn rest(lines: &mut BufReader<TcpStream>) -> Vec<ServerMessage> {
    let mut messages = Vec::new();
    while let Some(message) = next_line(lines).await {
        messages.push(message);
    }
    messages
}

/// Returns a connection at seat 0 that has got its keyframe.
async fn seated(arena: &Arena) -> BufReader<TcpStream> {
    let mut lines = arena.raw().await;
    lines.write_all(hello(&arena.tokens[0]).as_bytes()).await.unwrap();
    assert!(matches!(next_line(&mut lines).await, Some(ServerMessage::Welcome(_))));
    assert!(matches!(next_line(&mut lines).await, Some(ServerMessage::Delta(_))));
    lines
}

/// Checks that the replay of a match is whole and plays again to the same hashes and result.
fn check_replay(outcome: &Outcome, expected: &MatchResult) {
    let replay = read_replay(&outcome.replay).unwrap();
    assert_eq!(replay.ended.as_ref(), Some(expected));
    let header = &replay.header;
    let files = maniple_server::files(header);
    let again = load(&files, &header.scenario, &maniple_server::overrides(header)).unwrap();
    let mut referee = Referee::new(again, ClockMode::Lockstep).unwrap();
    for event in maniple_server::events(&replay) {
        referee.handle_record(&event).unwrap();
    }
    assert_eq!(referee.result(), Some(expected));
}
