//! Clients that are slow, deaf or silent, and what is answered at which moment.

use std::time::Duration;

use maniple_client::Event;
use maniple_protocol::{ClientMessage, Encoding, Refused, ServerMessage, encode_client};
use maniple_view::{ClockMode, Command, Handle, Seat};
use tokio::io::{AsyncReadExt, AsyncWriteExt, BufReader};
use tokio::net::{TcpSocket, TcpStream};

use super::{LOCKSTEP, check_replay, greeting, hello, next_line, play, rest};
use crate::arena::{Arena, bot, loaded};

#[tokio::test(flavor = "multi_thread")]
async fn a_hello_may_come_byte_by_byte_in_both_encodings() {
    let arena = Arena::open(&loaded(LOCKSTEP), ClockMode::Lockstep);
    let mut json = arena.raw().await;
    for byte in hello(&arena.tokens[0]).as_bytes() {
        json.write_all(&[*byte]).await.unwrap();
        tokio::task::yield_now().await;
    }
    assert!(matches!(next_line(&mut json).await, Some(ServerMessage::Welcome(_))));
    assert!(matches!(next_line(&mut json).await, Some(ServerMessage::Delta(_))));

    let mut binary = arena.raw().await;
    let message = ClientMessage::Hello(greeting(&arena.tokens[1]));
    let frame = encode_client(Encoding::Binary, &message).unwrap();
    for byte in b"MNPL".iter().chain(&frame) {
        binary.write_all(&[*byte]).await.unwrap();
        tokio::task::yield_now().await;
    }
    let mut start = [0; 5];
    binary.read_exact(&mut start).await.unwrap();
    assert_eq!(start[4], 0, "the tag of a welcome");
    drop(binary);
    assert_eq!(arena.shut_down().await.result, None);
    let shutdown = ServerMessage::Refused { reason: Refused::Shutdown };
    assert_eq!(rest(&mut json).await, [shutdown]);
}

#[tokio::test(flavor = "multi_thread")]
async fn who_does_not_read_is_cut_off_and_may_come_back() {
    let arena = Arena::open(&loaded(LOCKSTEP), ClockMode::Lockstep);
    let socket = TcpSocket::new_v4().unwrap();
    socket.set_recv_buffer_size(4096).unwrap();
    let mut deaf = socket.connect(arena.address.parse().unwrap()).await.unwrap();
    deaf.write_all(hello(&arena.tokens[0]).as_bytes()).await.unwrap();
    let mut other = arena.client(1).await;
    assert!(matches!(other.next().await.unwrap(), Event::Cycle(_)));

    ping_until_closed(&mut deaf).await;

    other.ping(3).await.unwrap();
    assert_eq!(other.next().await.unwrap(), Event::Pong { id: 3, cycle: 0, fraction: 0.0 });
    let mut back = arena.client(0).await;
    assert!(matches!(back.next().await.unwrap(), Event::Cycle(_)));
    arena.shut_down().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn who_is_behind_at_the_end_still_gets_the_result() {
    let arena = Arena::open(&loaded(LOCKSTEP), ClockMode::Lockstep);
    let socket = TcpSocket::new_v4().unwrap();
    socket.set_recv_buffer_size(4096).unwrap();
    let stream = socket.connect(arena.address.parse().unwrap()).await.unwrap();
    let mut slow = BufReader::new(stream);
    slow.write_all(hello(&arena.tokens[0]).as_bytes()).await.unwrap();
    let mut other = arena.client(1).await;
    assert!(matches!(other.next().await.unwrap(), Event::Cycle(_)));
    // Answers that it has yet to read, and more than its side of the socket holds.
    let pings = "{\"ping\":{\"id\":1}}\n".repeat(400);
    slow.write_all(pings.as_bytes()).await.unwrap();
    other.send(vec![Command::Resign]).await.unwrap();
    other.done().await.unwrap();
    slow.write_all(b"{\"done\":{\"cycle\":0}}\n").await.unwrap();
    while !matches!(other.next().await.unwrap(), Event::Ended(_)) {}
    drop(other);
    // It still answers what it has not seen to be the last.
    for _ in 0..3 {
        tokio::time::sleep(Duration::from_millis(700)).await;
        slow.write_all(b"{\"done\":{\"cycle\":1}}\n").await.unwrap();
    }
    let messages = rest(&mut slow).await;
    assert!(matches!(messages.last(), Some(ServerMessage::Ended { .. })), "{:?}", messages.last());
    arena.outcome().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn real_time_runs_on_without_a_client_that_says_nothing() {
    let scenario = loaded("rate = 200\nlength_seconds = 0.2");
    let arena = Arena::open(&scenario, ClockMode::Realtime);
    let mut idle = arena.client(0).await;
    let b = tokio::spawn(play(arena.client(1).await, bot("straight", 1)));
    let mut cycles = Vec::new();
    let result = loop {
        match idle.next().await.unwrap() {
            Event::Cycle(delta) => cycles.push(delta.cycle.0),
            Event::Pong { .. } | Event::Paused { .. } | Event::Warned { .. } => {}
            Event::Ended(result) => break result,
        }
    };
    assert_eq!(cycles, (0..=40).collect::<Vec<u32>>());
    assert_eq!(result.cycles.0, 40);
    assert_eq!(b.await.unwrap().0, result);
    check_replay(&arena.outcome().await, &result);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_ping_is_answered_with_the_running_cycle() {
    let arena = Arena::open(&loaded(LOCKSTEP), ClockMode::Lockstep);
    let mut client = arena.client(0).await;
    assert!(matches!(client.next().await.unwrap(), Event::Cycle(_)));
    client.ping(7).await.unwrap();
    assert_eq!(client.next().await.unwrap(), Event::Pong { id: 7, cycle: 0, fraction: 0.0 });
    arena.shut_down().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn results_carry_the_numbers_of_their_commands_however_many_there_are() {
    let arena = Arena::open(&loaded(LOCKSTEP), ClockMode::Lockstep);
    let (mut a, mut b) = (arena.client(0).await, arena.client(1).await);
    for client in [&mut a, &mut b] {
        assert!(matches!(client.next().await.unwrap(), Event::Cycle(_)));
    }
    let stops = vec![Command::Stop { object: Handle(9999) }; 10_000];
    assert_eq!(a.send(stops).await.unwrap(), 0);
    assert_eq!(a.send(vec![Command::Resign]).await.unwrap(), 10_000);
    a.done().await.unwrap();
    b.done().await.unwrap();
    let Event::Cycle(delta) = a.next().await.unwrap() else { panic!("a cycle has passed") };
    let numbers: Vec<u32> = delta.results.iter().map(|result| result.seq).collect();
    assert_eq!(numbers, (0..=10_000).collect::<Vec<u32>>());
    let Event::Ended(result) = a.next().await.unwrap() else { panic!("who resigns ends the match") };
    assert_eq!(result.winners, [Seat(1)]);
    drop((a, b));
    arena.outcome().await;
}

/// Asks for answers that nobody reads, which pile up until the server closes the connection.
pub(crate) async fn ping_until_closed(deaf: &mut TcpStream) {
    let pings = "{\"ping\":{\"id\":1}}\n".repeat(100);
    // Many times what the server keeps, the system takes, and who has to go may still say.
    for _ in 0..3000 {
        if deaf.write_all(pings.as_bytes()).await.is_err() {
            return;
        }
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    panic!("there is no end to the answers that nobody reads");
}
