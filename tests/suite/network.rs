//! Matches over real sockets: the same as in one process, whoever disturbs them.

#![allow(clippy::unwrap_used, reason = "a helper that fails is a test that fails")]

use std::future::pending;
use std::process::{Child, Stdio};
use std::sync::Arc;
use std::time::Duration;

use maniple_bots::Bot;
use maniple_client::{Client, ClientError, Event};
use maniple_game::{Loaded, load};
use maniple_protocol::{
    ClientMessage, Encoding, FRAME_FROM_CLIENT_MAX, HELLO_MAX, Hello, PROTOCOL, Record, Refused,
    ServerMessage, encode_client, encode_commands, read_partial, read_replay,
};
use maniple_referee::{QUEUED_MAX, Referee};
use maniple_server::{Access, Match, Server};
use maniple_view::{ClockMode, Command, Handle, MatchResult, Positions, Seat, Sequenced, View};
use tokio::io::{AsyncBufReadExt, AsyncReadExt, AsyncWriteExt, BufReader};
use tokio::net::{TcpSocket, TcpStream};
use tokio::time::timeout;

use crate::arena::{Arena, NAMES, Outcome, bot, loaded, login};
use crate::commands::maniple;

/// Seats wait for each other as long as it takes: a slow machine shall not change a result.
const LOCKSTEP: &str = "rate = 8\nlength_seconds = 30\nclock = { time_bank_seconds = 3600 }";

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

/// Returns a connection at seat 0 that has got its keyframe.
async fn seated(arena: &Arena) -> BufReader<TcpStream> {
    let mut lines = arena.raw().await;
    lines.write_all(hello(&arena.tokens[0]).as_bytes()).await.unwrap();
    assert!(matches!(next_line(&mut lines).await, Some(ServerMessage::Welcome(_))));
    assert!(matches!(next_line(&mut lines).await, Some(ServerMessage::Delta(_))));
    lines
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
