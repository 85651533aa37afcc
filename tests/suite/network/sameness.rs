//! The match over sockets is the match in one process, in each encoding and whoever comes back to it.

use std::sync::Arc;

use maniple_bots::Bot;
use maniple_client::ClientError;
use maniple_protocol::{Refused, ServerMessage};
use maniple_view::{ClockMode, MatchResult, Positions, View};
use tokio::io::{AsyncWriteExt, BufReader};
use tokio::net::TcpStream;

use super::{LOCKSTEP, check_replay, headless, hello, next_line, play, play_until, start};
use crate::arena::{Arena, bot, loaded};

#[tokio::test(flavor = "multi_thread")]
async fn a_match_over_sockets_is_the_match_in_one_process() {
    let bots = ["straight", "random"];
    let (expected, views) = headless(&loaded(LOCKSTEP), bots);
    let arena = Arena::open(&loaded(LOCKSTEP), ClockMode::Lockstep);
    let a = tokio::spawn(play(arena.client(0).await, bot(bots[0], 0)));
    let b = tokio::spawn(play(arena.client(1).await, bot(bots[1], 1)));
    for (player, view) in [a, b].into_iter().zip(&views) {
        let (result, mirrored) = player.await.unwrap();
        assert_eq!(result, expected);
        assert_eq!(&mirrored, view);
    }
    let outcome = arena.outcome().await;
    assert_eq!(outcome.result.as_ref(), Some(&expected));
    check_replay(&outcome, &expected);
}

#[tokio::test(flavor = "multi_thread")]
async fn json_lines_play_the_same_match() {
    let bots = ["straight", "random"];
    let (expected, views) = headless(&loaded(LOCKSTEP), bots);
    let arena = Arena::open(&loaded(LOCKSTEP), ClockMode::Lockstep);
    let a = tokio::spawn(play_json(arena.raw().await, arena.tokens[0].clone(), bot(bots[0], 0)));
    let b = tokio::spawn(play(arena.client(1).await, bot(bots[1], 1)));
    for (player, view) in [a, b].into_iter().zip(&views) {
        assert_eq!(player.await.unwrap(), (expected.clone(), view.clone()));
    }
    assert_eq!(arena.outcome().await.result, Some(expected));
}

#[tokio::test(flavor = "multi_thread")]
async fn on_a_grid_and_in_single_precision_every_client_mirrors_the_view_of_the_server() {
    let traded = "view = { positions = 'grid', grid_bits = 8 }\nkinematics = { scalar = 'f32' }";
    let loaded = loaded(&format!("{LOCKSTEP}\n{traded}"));
    let bots = ["straight", "random"];
    let (expected, views) = headless(&loaded, bots);
    let on_grid = |x: f64| (x * 256.0).floor() == x * 256.0;
    for view in &views {
        assert!(view.objects().all(|(_, seen)| on_grid(seen.base.point.x) && on_grid(seen.base.point.y)));
    }
    let arena = Arena::open(&loaded, ClockMode::Lockstep);
    let a = tokio::spawn(play_json(arena.raw().await, arena.tokens[0].clone(), bot(bots[0], 0)));
    let mut bot = bot(bots[1], 1);
    for last in [5, 23] {
        let mut client = arena.client(1).await;
        assert_eq!(client.rules().positions, Positions::Grid { bits: 8 });
        start(&mut *bot, &client);
        play_until(&mut client, &mut *bot, last).await;
    }
    assert_eq!(play(arena.client(1).await, bot).await, (expected.clone(), views[1].clone()));
    assert_eq!(a.await.unwrap(), (expected.clone(), views[0].clone()));
    check_replay(&arena.outcome().await, &expected);
}

#[tokio::test(flavor = "multi_thread")]
async fn who_drops_out_comes_back_to_the_same_match() {
    let bots = ["random", "straight"];
    let (expected, views) = headless(&loaded(LOCKSTEP), bots);
    let arena = Arena::open(&loaded(LOCKSTEP), ClockMode::Lockstep);
    let b = tokio::spawn(play(arena.client(1).await, bot(bots[1], 1)));
    let mut bot = bot(bots[0], 0);
    for last in [3, 17, 18, 40] {
        let mut client = arena.client(0).await;
        start(&mut *bot, &client);
        play_until(&mut client, &mut *bot, last).await;
        drop(client);
    }
    assert_eq!(play(arena.client(0).await, bot).await, (expected.clone(), views[0].clone()));
    assert_eq!(b.await.unwrap(), (expected.clone(), views[1].clone()));
    check_replay(&arena.outcome().await, &expected);
}

#[tokio::test(flavor = "multi_thread")]
async fn the_same_token_takes_a_seat_over() {
    let bots = ["random", "straight"];
    let (expected, _) = headless(&loaded(LOCKSTEP), bots);
    let arena = Arena::open(&loaded(LOCKSTEP), ClockMode::Lockstep);
    let b = tokio::spawn(play(arena.client(1).await, bot(bots[1], 1)));
    let mut first = arena.client(0).await;
    let mut bot = bot(bots[0], 0);
    start(&mut *bot, &first);
    play_until(&mut first, &mut *bot, 9).await;
    let second = arena.client(0).await;
    assert_eq!(second.welcome().cycle.0, 9);
    assert!(matches!(first.next().await, Err(ClientError::Refused(Refused::Replaced))));
    assert_eq!(play(second, bot).await.0, expected);
    b.await.unwrap();
    arena.outcome().await;
}

/// Plays a whole match with lines that are written by hand.
async fn play_json(
    mut lines: BufReader<TcpStream>,
    token: String,
    mut bot: Box<dyn Bot + Send>,
) -> (MatchResult, View) {
    lines.write_all(hello(&token).as_bytes()).await.unwrap();
    let mut view = View::default();
    loop {
        match next_line(&mut lines).await.unwrap() {
            ServerMessage::Welcome(welcome) => {
                bot.on_start(welcome.seat.unwrap(), &welcome.rules, &welcome.terrain);
                view = View::new(&welcome.rules, Arc::new(welcome.terrain));
            }
            ServerMessage::Delta(delta) => {
                view.apply(&delta).unwrap();
                let cycle = delta.cycle.0;
                let mut answer = String::new();
                for command in bot.on_cycle(&view, &delta) {
                    let command = serde_json::to_string(&command).unwrap();
                    answer += &format!(
                        "{{\"commands\":{{\"seen_cycle\":{cycle},\"list\":[{{\"seq\":1,\"command\":{command}}}]}}}}\r\n"
                    );
                }
                answer += &format!("\n{{\"done\":{{\"cycle\":{cycle}}}}}\n");
                // The last answer may come after the end.
                let _ = lines.write_all(answer.as_bytes()).await;
            }
            ServerMessage::Packed(_) => panic!("JSON has doubles"),
            ServerMessage::Matches { .. } | ServerMessage::Created { .. } => panic!("nobody asked the lobby"),
            ServerMessage::Ended { result } => return (result, view),
            other @ (ServerMessage::Refused { .. }
            | ServerMessage::Pong { .. }
            | ServerMessage::Paused { .. }
            | ServerMessage::Keyframe {}
            | ServerMessage::Warned { .. }) => panic!("{other:?}"),
        }
    }
}
