//! Pauses by agreement, over real sockets.

#![allow(clippy::unwrap_used, reason = "a helper that fails is a test that fails")]

use std::time::Duration;

use maniple_client::{Client, Event};
use maniple_game::Loaded;
use maniple_protocol::read_replay;
use maniple_referee::Referee;
use maniple_view::{ClockMode, Command, MatchResult, Seat};

use crate::arena::{Arena, NAMES, loaded};

const LOCKSTEP: &str = "rate = 8\nlength_seconds = 2\nclock = { time_bank_seconds = 3600 }";

/// Short cycles, of which a few hundred would pass in the time for which a test waits.
const REALTIME: &str = "rate = 1000\nlength_seconds = 86400";

#[tokio::test(flavor = "multi_thread")]
async fn a_lock_step_match_stands_still_while_all_want_it_and_comes_out_the_same() {
    let scenario = loaded(LOCKSTEP);
    let expected = unpaused(&scenario);
    let arena = Arena::open(&scenario, ClockMode::Lockstep);
    let (mut a, mut b) = (arena.client(0).await, arena.client(1).await);
    for client in [&mut a, &mut b] {
        assert!(matches!(client.next().await.unwrap(), Event::Cycle(_)));
    }
    a.pause().await.unwrap();
    for client in [&mut a, &mut b] {
        assert_eq!(client.next().await.unwrap(), paused(&[0], false));
    }
    // Asked again, the one who asks is answered and nobody else.
    a.pause().await.unwrap();
    assert_eq!(a.next().await.unwrap(), paused(&[0], false));
    b.pause().await.unwrap();
    for client in [&mut a, &mut b] {
        assert_eq!(client.next().await.unwrap(), paused(&[0, 1], true));
        client.done().await.unwrap();
        stands_still(client, 0).await;
    }
    // Whoever loses the connection finds the pause again.
    drop(a);
    let mut a = arena.client(0).await;
    assert!(matches!(a.next().await.unwrap(), Event::Cycle(_)));
    assert_eq!(a.next().await.unwrap(), paused(&[0, 1], true));
    a.done().await.unwrap();
    stands_still(&mut a, 0).await;
    a.go_on().await.unwrap();
    assert_eq!(b.next().await.unwrap(), paused(&[], false));
    let played = tokio::join!(a.play(|_, _| Vec::new()), b.play(|_, _| Vec::new()));
    assert_eq!((played.0.unwrap(), played.1.unwrap()), (expected.clone(), expected.clone()));
    let outcome = arena.outcome().await;
    assert_eq!(read_replay(&outcome.replay).unwrap().ended, Some(expected));
}

#[tokio::test(flavor = "multi_thread")]
async fn a_real_time_match_stands_still_while_all_want_it_and_goes_on_with_the_next_cycle() {
    let arena = Arena::open(&loaded(REALTIME), ClockMode::Realtime);
    let (mut a, mut b) = (arena.client(0).await, arena.client(1).await);
    a.pause().await.unwrap();
    b.pause().await.unwrap();
    let cycle = until_paused(&mut a).await;
    assert_eq!(until_paused(&mut b).await, cycle);
    stands_still(&mut a, cycle).await;
    tokio::time::sleep(Duration::from_millis(300)).await;
    stands_still(&mut b, cycle).await;
    b.go_on().await.unwrap();
    for client in [&mut a, &mut b] {
        assert_eq!(client.next().await.unwrap(), paused(&[], false));
        let Event::Cycle(delta) = client.next().await.unwrap() else { panic!("the match goes on") };
        assert_eq!(delta.cycle.0, cycle + 1);
    }
    // Nobody is left who could end this one.
    a.pause().await.unwrap();
    b.pause().await.unwrap();
    let cycle = until_paused(&mut a).await;
    drop((a, b));
    let mut a = loop {
        // It may be back before the server has noticed that both are gone; then there still is somebody.
        let mut back = arena.client(0).await;
        let Event::Cycle(keyframe) = back.next().await.unwrap() else { panic!("a keyframe comes first") };
        if keyframe.cycle.0 > cycle {
            break back;
        }
    };
    a.send(vec![Command::Resign]).await.unwrap();
    while !matches!(a.next().await.unwrap(), Event::Ended(_)) {}
    arena.outcome().await;
}

fn paused(seats: &[u16], on: bool) -> Event {
    Event::Paused { seats: seats.iter().copied().map(Seat).collect(), on }
}

/// Checks that the next thing that a client is told is what it asks for, and that the match is still at `cycle`.
async fn stands_still(client: &mut Client, cycle: u32) {
    client.ping(7).await.unwrap();
    assert_eq!(client.next().await.unwrap(), Event::Pong { id: 7, cycle, fraction: 0.0 });
}

/// Waits for a pause; returns the cycle at whose start it is.
async fn until_paused(client: &mut Client) -> u32 {
    loop {
        match client.next().await.unwrap() {
            Event::Paused { on: true, .. } => return client.view().cycle().0,
            Event::Paused { on: false, .. } | Event::Cycle(_) | Event::Pong { .. } | Event::Warned { .. } => {
            }
            Event::Ended(result) => panic!("the match has ended: {result:?}"),
        }
    }
}

/// Plays the match without a pause, and without a command.
fn unpaused(loaded: &Loaded) -> MatchResult {
    let mut referee = Referee::new(loaded.clone(), ClockMode::Lockstep).unwrap();
    let seats = [Seat(0), Seat(1)];
    for seat in seats {
        referee.handle_join(seat, NAMES[seat.index()]).unwrap();
    }
    while referee.result().is_none() {
        referee.take_records();
        for seat in seats {
            referee.take_delta(seat);
        }
        referee.step();
    }
    referee.result().unwrap().clone()
}
