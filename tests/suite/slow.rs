//! Clients that are too slow for each delta: one for all that they missed, then a keyframe, then the end; and nobody else notices.

#![allow(clippy::unwrap_used, reason = "a helper that fails is a test that fails")]

use std::collections::BTreeMap;

use maniple_client::{Client, Event, Spectator};
use maniple_geometry::Cycle;
use maniple_protocol::{
    CYCLES_UNSEEN_MAX, CYCLES_WITHHELD_MAX, ClientMessage, Encoding, Feed, FrameDecoder, Hello,
    MERGED_CYCLES_MAX, PROTOCOL, Refused, ServerMessage, decode_server, encode_client,
};
use maniple_view::{Changed, ClockMode, Delta, Handle, Merge, Moved, Rules, Seat, Stopped, Vantage, View};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpSocket, TcpStream};

use crate::arena::{Arena, NAMES, bot, loaded, login};
use crate::mirror::views_of_the_server;
use crate::spectators::{at_the_start, whole_games};

/// A match that nobody waits for, with a view to all.
const FAST: &str = "rate = 1000\nlength_seconds = 4\nspectators = { views = 'all', delay_seconds = 0 }";

#[test]
fn deltas_of_whole_games_in_one_give_the_same_view_and_all_news() {
    for (mut game, cycles) in whole_games() {
        let mut told: Vec<Vec<Delta>> =
            game.players.iter().map(|player| vec![player.delta.clone()]).collect();
        let mut views: Vec<Vec<View>> = game.players.iter().map(|player| vec![player.view.clone()]).collect();
        for _ in 0..cycles {
            assert!(game.step(), "the game lasts longer");
            for (seat, player) in game.players.iter().enumerate() {
                told[seat].push(player.delta.clone());
                views[seat].push(player.view.clone());
            }
        }
        for (told, views) in told.iter().zip(&views) {
            for last in (1..told.len()).step_by(7) {
                let mut merge = Merge::new(&told[last]);
                for first in (last.saturating_sub(80).max(1)..=last).rev() {
                    if first < last {
                        merge.precede(&told[first]);
                    }
                    let merged = merge.delta();
                    let mut view = views[first - 1].clone();
                    view.apply(&merged).unwrap();
                    assert_eq!(view, views[last], "{first} to {last}");
                    check_lists(&merged, &told[first..=last], &views[first - 1], &views[last]);
                }
            }
        }
    }
}

#[test]
fn whoever_gets_a_feed_at_whatever_times_has_the_view_of_the_server() {
    for (mut game, cycles) in whole_games() {
        for encoding in [Encoding::Json, Encoding::Binary] {
            let rules = game.referee.rules_of(Vantage::Seat(Seat(0)));
            let start = at_the_start(&game, Vantage::Seat(Seat(0)));
            let mut feed = Feed::new(encoding, &rules);
            let mut receivers: Vec<Receiver> =
                [1, 2, 3, 5, 17, 63, 64, 100].map(|pace| Receiver::new(pace, &start)).into();
            let bytes = feed.begin(game.players[0].view.keyframe()).unwrap();
            for receiver in &mut receivers {
                receiver.take_in(encoding, &rules, &bytes);
            }
            for _ in 0..cycles / 2 {
                assert!(game.step(), "the game lasts longer");
                let player = &game.players[0];
                feed.push([player.delta.clone()]).unwrap();
                receivers.sort_by_key(|receiver| std::cmp::Reverse(receiver.view.cycle()));
                for receiver in &mut receivers {
                    if player.view.cycle().0 % receiver.pace == 0 {
                        let told = receiver.view.cycle();
                        let bytes = feed.next(Some(told), |_| player.view.keyframe()).unwrap();
                        let again = feed.next(Some(told), |_| panic!("it is written once")).unwrap();
                        assert!(std::ptr::eq(&raw const *bytes, &raw const *again));
                        receiver.take_in(encoding, &rules, &bytes);
                        assert_eq!(receiver.view, player.view, "pace {}", receiver.pace);
                    }
                }
                feed.forget(receivers.iter().map(|receiver| receiver.view.cycle()).min());
            }
            for receiver in &receivers {
                let pace = usize::try_from(receiver.pace).unwrap();
                let expected = pace > MERGED_CYCLES_MAX && pace <= cycles / 2;
                assert_eq!(receiver.keyframes > 0, expected, "pace {}", receiver.pace);
            }
        }
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn who_stops_reading_gets_one_delta_for_many_then_a_keyframe_and_ends_with_the_view_of_the_server() {
    let scenario = loaded(FAST);
    let arena = Arena::open(&scenario, ClockMode::Realtime);
    let stream = narrow(&arena.address).await;
    let mut client = Client::over(stream, None, login(0, &arena.tokens[0])).await.unwrap();
    let mut other = arena.client(1).await;
    let stream = narrow(&arena.address).await;
    let mut spectator = Spectator::over(stream, None, "suite", Vantage::Seat(Seat(1))).await.unwrap();
    let mut bot = bot("random", 0);
    bot.on_start(client.seat(), client.rules(), client.terrain());
    let (mut played, mut watched) = (Mirror::default(), Mirror::default());
    // How much the system takes before it says so is for the system to say.
    for stop in [120, 400, 450, 500, 900] {
        let wake = other.view().cycle().0 + stop;
        while other.view().cycle().0 < wake {
            other.next().await.unwrap();
        }
        while client.view().cycle().0 < wake {
            played.take(client.next().await.unwrap(), client.view());
            let commands = bot.on_cycle(client.view(), &played.deltas[played.deltas.len() - 1]);
            client.send(commands).await.unwrap();
        }
        while spectator.view().cycle().0 < wake {
            watched.take(spectator.next().await.unwrap(), spectator.view());
        }
    }
    while !played.has_ended {
        played.take(client.next().await.unwrap(), client.view());
    }
    while !watched.has_ended {
        watched.take(spectator.next().await.unwrap(), spectator.view());
    }
    let outcome = arena.outcome().await;
    for (mirror, seat) in [(played, Seat(0)), (watched, Seat(1))] {
        let views = views_of_the_server(&scenario, &outcome.replay, seat);
        for view in &mirror.views {
            assert_eq!(view, &views[view.cycle().0 as usize], "{seat}");
        }
        assert_eq!(mirror.views.last(), views.last(), "{seat}");
        let (merged, keyframes) = mirror.leaps(seat);
        println!("{seat}: {merged} merged deltas and {keyframes} keyframes");
        // When a spectator lags is for the system to say, so only the player meets both for certain.
        assert!(
            keyframes > 0 && (merged > 0 || seat == Seat(1)),
            "{seat}: {merged} merged deltas and {keyframes} keyframes"
        );
        if seat == Seat(0) {
            mirror.check_results();
        }
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn who_never_reads_is_closed_and_nobody_else_misses_a_cycle() {
    let arena = Arena::open(&loaded(FAST), ClockMode::Realtime);
    let mut deaf = narrow(&arena.address).await;
    deaf.write_all(format!("{}\n", hello(&arena.tokens[0])).as_bytes()).await.unwrap();
    let mut other = arena.client(1).await;
    // More than any system takes, and the cycles that the server waits.
    let mut seen = None;
    while other.view().cycle().0 < 2 * CYCLES_WITHHELD_MAX {
        if let Event::Cycle(delta) = other.next().await.unwrap() {
            assert!(seen.is_none_or(|seen| delta.cycle == Cycle::next(seen)), "{seen:?} {}", delta.cycle);
            seen = Some(delta.cycle);
        }
    }
    let mut told = String::new();
    deaf.read_to_string(&mut told).await.unwrap();
    let last = told.lines().next_back().unwrap();
    let last = decode_server(Encoding::Json, last.as_bytes()).unwrap();
    assert_eq!(last, ServerMessage::Refused { reason: Refused::TooSlow });
    // It may come back.
    drop(arena.client(0).await);
    arena.shut_down().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn who_says_what_it_has_seen_is_taken_at_its_word_and_hears_what_is_no_delta_at_once() {
    let arena = Arena::open(&loaded(FAST), ClockMode::Realtime);
    let mut other = arena.client(1).await;
    let mut slow = Lines::open(&arena).await;
    slow.say(&ClientMessage::Done { cycle: Cycle(0) }).await;
    let last = slow.deltas_until_silence(&mut other).await;
    assert!((CYCLES_UNSEEN_MAX..=CYCLES_UNSEEN_MAX + 1).contains(&last.0), "{last}");
    slow.say(&ClientMessage::Ping { id: 5 }).await;
    assert!(matches!(slow.next().await, ServerMessage::Pong { id: 5, .. }));

    // It has taken in all that was sent: one delta for the rest, and no more until it has taken in that.
    slow.say(&ClientMessage::Done { cycle: last }).await;
    let ServerMessage::Delta(merged) = slow.next().await else { panic!("a delta is next") };
    assert!(merged.cycle.0 > last.0 + 1, "{}", merged.cycle);
    slow.say(&ClientMessage::Ping { id: 6 }).await;
    assert!(matches!(slow.next().await, ServerMessage::Pong { id: 6, .. }));
    advance(&mut other, merged.cycle.0 + u32::try_from(2 * MERGED_CYCLES_MAX).unwrap()).await;
    slow.say(&ClientMessage::Done { cycle: merged.cycle }).await;
    assert_eq!(slow.next().await, ServerMessage::Keyframe {});
    let ServerMessage::Delta(keyframe) = slow.next().await else { panic!("a keyframe is next") };
    assert!(keyframe.appeared.len() >= 5, "{keyframe:?}");
    advance(&mut other, keyframe.cycle.0 + 3 * CYCLES_WITHHELD_MAX / 2).await;
    assert_eq!(slow.next().await, ServerMessage::Refused { reason: Refused::TooSlow });
    arena.shut_down().await;
}

/// Checks a merged delta against the obvious: each object is looked up in all the deltas.
fn check_lists(merged: &Delta, deltas: &[Delta], before: &View, after: &View) {
    let concatenated =
        |list: &dyn Fn(&Delta) -> Vec<String>| -> Vec<String> { deltas.iter().flat_map(list).collect() };
    type List<'a> = &'a dyn Fn(&Delta) -> Vec<String>;
    let news: [List<'_>; 3] = [
        &|delta| delta.results.iter().map(|item| format!("{item:?}")).collect(),
        &|delta| delta.shots.iter().map(|item| format!("{item:?}")).collect(),
        &|delta| delta.ended.iter().map(|item| format!("{item:?}")).collect(),
    ];
    for list in news {
        assert_eq!(list(merged), concatenated(list));
    }
    let died = |object: &Handle| deltas.iter().any(|delta| delta.died.contains(object));
    let left = |object: &Handle| died(object) || deltas.iter().any(|delta| delta.vanished.contains(object));
    let gone: Vec<Handle> = before.objects().map(|(object, _)| object).filter(left).collect();
    let (dead, vanished): (Vec<Handle>, Vec<Handle>) = gone.iter().partition(|object| died(object));
    assert_eq!((&merged.died, &merged.vanished), (&dead, &vanished));
    let is_new = |object: &Handle| before.object(*object).is_none() || gone.contains(object);
    let new: Vec<Handle> = after.objects().map(|(object, _)| object).filter(is_new).collect();
    assert_eq!(merged.appeared.iter().map(|new| new.object).collect::<Vec<_>>(), new);
    let (mut moved, mut stopped) = (BTreeMap::<Handle, Moved>::new(), BTreeMap::<Handle, Stopped>::new());
    let mut changed = BTreeMap::<Handle, Changed>::new();
    for delta in deltas {
        for last in &delta.moved {
            moved.insert(last.object, *last);
            stopped.remove(&last.object);
        }
        for last in &delta.stopped {
            stopped.insert(last.object, *last);
            moved.remove(&last.object);
        }
        for last in &delta.changed {
            let known = changed.entry(last.object).or_insert(*last);
            (known.status, known.own) = (last.status.or(known.status), last.own.or(known.own));
        }
    }
    let stays = |object: &Handle| after.object(*object).is_some() && !new.contains(object);
    moved.retain(|object, _| stays(object));
    stopped.retain(|object, _| stays(object));
    changed.retain(|object, _| stays(object));
    assert_eq!(merged.moved, moved.into_values().collect::<Vec<_>>());
    assert_eq!(merged.stopped, stopped.into_values().collect::<Vec<_>>());
    assert_eq!(merged.changed, changed.into_values().collect::<Vec<_>>());
}

/// Somebody who takes what a feed has every so many cycles.
struct Receiver {
    pace: u32,
    start: View,
    view: View,
    keyframes: u32,
}

impl Receiver {
    fn new(pace: u32, start: &View) -> Self {
        Self { pace, start: start.clone(), view: start.clone(), keyframes: 0 }
    }

    fn take_in(&mut self, encoding: Encoding, rules: &Rules, bytes: &[u8]) {
        let mut frames = FrameDecoder::new(encoding, usize::MAX / 2);
        frames.handle_bytes(bytes);
        while let Some(body) = frames.poll().unwrap() {
            match decode_server(encoding, body).unwrap() {
                ServerMessage::Keyframe {} => {
                    self.view = self.start.clone();
                    self.keyframes += 1;
                }
                ServerMessage::Delta(delta) => self.view.apply(&delta).unwrap(),
                ServerMessage::Packed(packed) => {
                    let delta = packed.unpack(&self.view, rules).unwrap();
                    self.view.apply(&delta).unwrap();
                }
                other @ (ServerMessage::Welcome(_)
                | ServerMessage::Refused { .. }
                | ServerMessage::Pong { .. }
                | ServerMessage::Ended { .. }
                | ServerMessage::Paused { .. }
                | ServerMessage::Matches { .. }
                | ServerMessage::Created { .. }
                | ServerMessage::Warned { .. }) => panic!("{other:?}"),
            }
        }
    }
}

/// What a client was told, and its view after each delta.
#[derive(Default)]
struct Mirror {
    deltas: Vec<Delta>,
    views: Vec<View>,
    has_ended: bool,
}

impl Mirror {
    fn take(&mut self, event: Event, view: &View) {
        match event {
            Event::Cycle(delta) => {
                self.deltas.push(*delta);
                self.views.push(view.clone());
            }
            Event::Ended(_) => self.has_ended = true,
            Event::Pong { .. } | Event::Paused { .. } | Event::Warned { .. } => panic!("{event:?}"),
        }
    }

    /// Returns how many deltas stood for several, and how many keyframes came behind the first: only they bring own objects, which
    /// nobody makes here.
    fn leaps(&self, seat: Seat) -> (usize, usize) {
        let (mut merged, mut keyframes) = (0, 0);
        for (before, delta) in self.views.iter().zip(&self.deltas[1..]) {
            let is_leap = delta.cycle.0 > before.cycle().0 + 1;
            match delta.appeared.iter().any(|new| new.owner == Some(seat)) {
                true => keyframes += 1,
                false => merged += usize::from(is_leap),
            }
        }
        (merged, keyframes)
    }

    /// Checks that each command has its result, once and in its order.
    fn check_results(&self) {
        let seqs: Vec<u32> =
            self.deltas.iter().flat_map(|delta| &delta.results).map(|result| result.seq).collect();
        assert!(seqs.len() > 100, "{}", seqs.len());
        assert_eq!(seqs, (0..).take(seqs.len()).collect::<Vec<u32>>());
    }
}

/// A client of JSON lines that is told nothing by this one.
struct Lines {
    stream: TcpStream,
    frames: FrameDecoder,
}

impl Lines {
    async fn open(arena: &Arena) -> Self {
        let stream = TcpStream::connect(&arena.address).await.unwrap();
        let mut lines = Self { stream, frames: FrameDecoder::new(Encoding::Json, 1 << 24) };
        lines.stream.write_all(format!("{}\n", hello(&arena.tokens[0])).as_bytes()).await.unwrap();
        assert!(matches!(lines.next().await, ServerMessage::Welcome(_)));
        assert!(matches!(lines.next().await, ServerMessage::Delta(_)));
        lines
    }

    async fn say(&mut self, message: &ClientMessage) {
        self.stream.write_all(&encode_client(Encoding::Json, message).unwrap()).await.unwrap();
    }

    async fn next(&mut self) -> ServerMessage {
        loop {
            if let Some(body) = self.frames.poll().unwrap() {
                return decode_server(Encoding::Json, body).unwrap();
            }
            let mut buffer = [0; 4096];
            let count = self.stream.read(&mut buffer).await.unwrap();
            assert!(count > 0, "the server says more");
            self.frames.handle_bytes(&buffer[..count]);
        }
    }

    /// Takes what comes in a while, in which the other lives on; returns the cycle of the last delta.
    async fn deltas_until_silence(&mut self, other: &mut Client) -> Cycle {
        advance(other, 3 * CYCLES_UNSEEN_MAX).await;
        self.say(&ClientMessage::Ping { id: 0 }).await;
        let mut last = Cycle(0);
        loop {
            match self.next().await {
                ServerMessage::Delta(delta) => last = delta.cycle,
                ServerMessage::Pong { .. } => return last,
                other @ (ServerMessage::Welcome(_)
                | ServerMessage::Refused { .. }
                | ServerMessage::Ended { .. }
                | ServerMessage::Packed(_)
                | ServerMessage::Paused { .. }
                | ServerMessage::Matches { .. }
                | ServerMessage::Created { .. }
                | ServerMessage::Keyframe {}
                | ServerMessage::Warned { .. }) => panic!("{other:?}"),
            }
        }
    }
}

/// Lets a client go on to a cycle.
async fn advance(client: &mut Client, cycle: u32) {
    while client.view().cycle().0 < cycle {
        client.next().await.unwrap();
    }
}

/// Returns a connection whose side of the socket takes next to nothing.
async fn narrow(address: &str) -> TcpStream {
    let socket = TcpSocket::new_v4().unwrap();
    socket.set_recv_buffer_size(4096).unwrap();
    socket.connect(address.parse().unwrap()).await.unwrap()
}

fn hello(token: &str) -> String {
    let hello = Hello {
        protocol: PROTOCOL,
        client: "suite".to_owned(),
        player: NAMES[0].to_owned(),
        token: token.to_owned(),
    };
    let line = encode_client(Encoding::Json, &ClientMessage::Hello(hello)).unwrap();
    String::from_utf8(line).unwrap().trim_end().to_owned()
}
