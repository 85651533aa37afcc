//! Who gets a seat, and what is left of a match that is broken off.

use std::future::pending;
use std::process::{Child, Stdio};
use std::sync::Arc;

use maniple_client::{Client, ClientError};
use maniple_protocol::{Record, Refused, read_partial};
use maniple_referee::Referee;
use maniple_server::{Access, Match, Server};
use maniple_view::ClockMode;

use super::{LOCKSTEP, headless, play, play_to_the_last, play_until, start};
use crate::arena::{Arena, bot, loaded, login};
use crate::commands::maniple;

#[tokio::test(flavor = "multi_thread")]
async fn open_seats_take_whoever_comes_and_one_match_follows_the_other() {
    let server = Arc::new(Server::bind("127.0.0.1:0".parse().unwrap()).unwrap());
    let address = server.local_addr().unwrap().to_string();
    let (expected, _) = headless(&loaded(LOCKSTEP), ["straight", "straight"]);
    for _ in 0..2 {
        let referee = Referee::new(loaded(LOCKSTEP), ClockMode::Lockstep).unwrap();
        let game = Match::new(referee, vec![Access::Open; 2]).unwrap();
        let running = tokio::spawn({
            let server = Arc::clone(&server);
            async move { server.run(game, pending()).await }
        });
        let mut players = Vec::new();
        for seat in 0..2 {
            let client = Client::connect(&address, login(seat, "")).await.unwrap();
            assert_eq!(client.seat().index(), seat);
            players.push(client);
        }
        let full = Client::connect(&address, login(0, "")).await.err();
        assert!(matches!(full, Some(ClientError::Refused(Refused::Full))));
        let players: Vec<_> = (0..)
            .zip(players)
            .map(|(seat, client)| tokio::spawn(play(client, bot("straight", seat))))
            .collect();
        for player in players {
            assert_eq!(player.await.unwrap().0, expected);
        }
        assert_eq!(running.await.unwrap().unwrap().as_ref(), Some(&expected));
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_shipped_bot_takes_an_open_seat_without_a_token() {
    let server = Server::bind("127.0.0.1:0".parse().unwrap()).unwrap();
    let address = server.local_addr().unwrap().to_string();
    let (expected, _) = headless(&loaded(LOCKSTEP), ["straight", "straight"]);
    let referee = Referee::new(loaded(LOCKSTEP), ClockMode::Lockstep).unwrap();
    let game = Match::new(referee, vec![Access::Open; 2]).unwrap();
    let bots: Vec<Child> = (0..2)
        .map(|_| {
            let mut bot = maniple(&["bot", "straight", "--connect", &address, "--seed", "5", "--json"]);
            bot.env_remove("MANIPLE_TOKEN").stdout(Stdio::piped()).spawn().unwrap()
        })
        .collect();
    let running = tokio::spawn(async move { server.run(game, pending()).await });
    for bot in bots {
        let output = tokio::task::spawn_blocking(|| bot.wait_with_output()).await.unwrap().unwrap();
        let ended: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(ended["result"]["hash"], expected.hash.to_string());
    }
    assert_eq!(running.await.unwrap().unwrap().unwrap().hash, expected.hash);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_match_that_is_broken_off_leaves_a_replay_up_to_there() {
    let arena = Arena::open(&loaded(LOCKSTEP), ClockMode::Lockstep);
    let b = tokio::spawn(play_to_the_last(arena.client(1).await, bot("straight", 1)));
    let mut client = arena.client(0).await;
    let mut bot = bot("straight", 0);
    start(&mut *bot, &client);
    play_until(&mut client, &mut *bot, 12).await;
    let written = read_partial(&arena.replay.bytes()).unwrap().replay.records;
    let is_hash = |record: &&Record| matches!(record, Record::Cycle { .. });
    assert_eq!(written.iter().filter(is_hash).count(), 13, "what has happened is written, not kept");
    let outcome = arena.shut_down().await;
    assert_eq!(outcome.result, None);
    assert!(matches!(client.next().await, Err(ClientError::Refused(Refused::Shutdown))));
    assert!(matches!(b.await.unwrap(), Err(ClientError::Refused(Refused::Shutdown))));
    let partial = read_partial(&outcome.replay).unwrap();
    assert_eq!(partial.whole_bytes, outcome.replay.len());
    let mut referee = Referee::new(loaded(LOCKSTEP), ClockMode::Lockstep).unwrap();
    for event in maniple_server::events(&partial.replay) {
        referee.handle_record(&event).unwrap();
    }
    assert_eq!(referee.cycle().0, 12);
}
