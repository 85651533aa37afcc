//! A match over sockets that is led by hand, and connections of which every byte is looked at.

use std::sync::Arc;

use maniple_bots::Bot;
use maniple_game::Loaded;
use maniple_protocol::{
    ClientMessage, Encoding, FRAME_FROM_SERVER_MAX, FrameDecoder, Hello, PROTOCOL, ServerMessage, Watch,
    Welcome, decode_server, encode_client,
};
use maniple_view::{ClockMode, Delta, MatchResult, Seat, Sequenced, Vantage, View};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

use crate::arena::{Arena, NAMES, Outcome, bot};

/// A match over sockets whose players are led by hand: seat 0 speaks JSON, seat 1 binary.
pub(crate) struct Show {
    pub(crate) arena: Arena,
    players: Vec<(Tap, Box<dyn Bot + Send>)>,
    /// By seat and cycle.
    pub(crate) views: [Vec<View>; 2],
    /// The last message of each, which is not answered yet.
    last: Vec<Delta>,
}

impl Show {
    /// Opens it and plays to no cycle yet.
    pub(crate) async fn open(scenario: &Loaded) -> Self {
        let arena = Arena::open(scenario, ClockMode::Lockstep);
        let mut players = Vec::new();
        for (seat, encoding) in [(0, Encoding::Json), (1, Encoding::Binary)] {
            let first = ClientMessage::Hello(hello(&arena, seat));
            let tap = Tap::open(&arena, encoding, first, Vantage::Seat(Seat(seat.try_into().unwrap()))).await;
            let mut bot = bot(["straight", "random"][seat], seat.try_into().unwrap());
            bot.on_start(tap.welcome.seat.unwrap(), &tap.welcome.rules, &tap.welcome.terrain);
            players.push((tap, bot));
        }
        let mut show = Self { arena, players, views: [vec![], vec![]], last: vec![] };
        show.take().await;
        show
    }

    /// Takes the next delta of each seat; returns whether the match goes on.
    async fn take(&mut self) -> bool {
        self.last.clear();
        for (seat, (tap, _)) in self.players.iter_mut().enumerate() {
            if let ServerMessage::Ended { result } = tap.next().await.unwrap().1 {
                tap.result = Some(result);
                continue;
            }
            self.views[seat].push(tap.view.clone());
            self.last.push(tap.delta.clone().unwrap());
        }
        !self.last.is_empty()
    }

    async fn answer(&mut self) {
        for ((tap, bot), delta) in self.players.iter_mut().zip(&self.last) {
            let commands = bot.on_cycle(&tap.view, delta);
            let list = (0..).zip(commands).map(|(seq, command)| Sequenced { seq, command }).collect();
            tap.say(&ClientMessage::Commands { seen_cycle: delta.cycle, list }).await;
            tap.say(&ClientMessage::Done { cycle: delta.cycle }).await;
        }
    }

    /// Plays until the match is at the start of this cycle, where it stays.
    pub(crate) async fn play_to(&mut self, cycle: u32) {
        while self.last[0].cycle.0 < cycle {
            self.answer().await;
            assert!(self.take().await, "the match lasts longer");
        }
    }

    pub(crate) async fn pause(&mut self) {
        for (place, on) in [(0, false), (1, true)] {
            self.players[place].0.say(&ClientMessage::Pause { on: true }).await;
            self.hear_pause(on).await;
        }
    }

    pub(crate) async fn go_on(&mut self) {
        self.players[0].0.say(&ClientMessage::Pause { on: false }).await;
        self.hear_pause(false).await;
    }

    async fn hear_pause(&mut self, expected: bool) {
        for (tap, _) in &mut self.players {
            let (_, message) = tap.next().await.unwrap();
            assert!(matches!(message, ServerMessage::Paused { on, .. } if on == expected), "{message:?}");
        }
    }

    /// Plays to the end; returns what each seat was told, its views by cycle, and the outcome. Spectators keep up, since who lags is told less
    /// often.
    pub(crate) async fn play_out(
        mut self,
        spectators: &mut [Tap],
    ) -> (Vec<Vec<Vec<u8>>>, [Vec<View>; 2], Outcome) {
        loop {
            self.answer().await;
            if !self.take().await {
                break;
            }
            if self.last[0].cycle.0.is_multiple_of(7) {
                for tap in spectators.iter_mut() {
                    tap.news().await;
                }
            }
        }
        let told = self.players.into_iter().map(|(tap, _)| tap.told).collect();
        (told, self.views, self.arena.outcome().await)
    }
}

/// A connection of which every byte is looked at.
pub(crate) struct Tap {
    pub(crate) encoding: Encoding,
    pub(crate) vantage: Vantage,
    stream: TcpStream,
    frames: FrameDecoder,
    pub(crate) welcome: Welcome,
    pub(crate) view: View,
    /// The bodies of all deltas.
    pub(crate) told: Vec<Vec<u8>>,
    /// The last of them.
    delta: Option<Delta>,
    pub(crate) result: Option<MatchResult>,
}

impl Tap {
    pub(crate) async fn watch(arena: &Arena, encoding: Encoding, vantage: Vantage) -> Self {
        Self::open(arena, encoding, watch(vantage), vantage).await
    }

    pub(crate) async fn open(
        arena: &Arena,
        encoding: Encoding,
        first: ClientMessage,
        vantage: Vantage,
    ) -> Self {
        let mut stream = TcpStream::connect(&arena.address).await.unwrap();
        stream.set_nodelay(true).unwrap();
        stream.write_all(&opening(encoding, &first)).await.unwrap();
        let mut frames = FrameDecoder::new(encoding, FRAME_FROM_SERVER_MAX);
        let (_, message) = read(&mut stream, &mut frames).await.unwrap();
        let ServerMessage::Welcome(welcome) = message else { panic!("{message:?}") };
        let view = View::new(&welcome.rules, Arc::new(welcome.terrain.clone()));
        Self { encoding, vantage, stream, frames, welcome, view, told: vec![], delta: None, result: None }
    }

    pub(crate) async fn say(&mut self, message: &ClientMessage) {
        let bytes = encode_client(self.encoding, message).unwrap();
        // At the end nobody may be there to hear it.
        let _ = self.stream.write_all(&bytes).await;
    }

    /// Returns the next message, with its bytes; a delta is taken in. `None` at the end.
    pub(crate) async fn next(&mut self) -> Option<(Vec<u8>, ServerMessage)> {
        let (body, message) = read(&mut self.stream, &mut self.frames).await?;
        let message = if let ServerMessage::Packed(packed) = message {
            ServerMessage::Delta(packed.unpack(&self.view, &self.welcome.rules).unwrap())
        } else {
            message
        };
        if let ServerMessage::Delta(delta) = &message {
            let delta = delta.clone();
            self.view.apply(&delta).unwrap();
            self.told.push(body.clone());
            self.delta = Some(delta);
        }
        Some((body, message))
    }

    /// Returns the cycles of all deltas that have come, and checks that nothing else has, and what a ping is answered.
    pub(crate) async fn news(&mut self) -> Vec<u32> {
        self.say(&ClientMessage::Ping { id: 9 }).await;
        let mut cycles = Vec::new();
        loop {
            let message = self.next().await.unwrap().1;
            if let ServerMessage::Delta(delta) = &message {
                cycles.push(delta.cycle.0);
                continue;
            }
            let expected = ServerMessage::Pong { id: 9, cycle: self.view.cycle(), fraction: 0.0 };
            assert_eq!(message, expected);
            return cycles;
        }
    }

    pub(crate) async fn read_to_the_end(&mut self) {
        while let Some((_, message)) = self.next().await {
            if let ServerMessage::Ended { result } = message {
                self.result = Some(result);
            }
        }
    }
}

async fn read(stream: &mut TcpStream, frames: &mut FrameDecoder) -> Option<(Vec<u8>, ServerMessage)> {
    let mut buffer = [0; 4096];
    loop {
        if let Some(body) = frames.poll().unwrap() {
            let body = body.to_vec();
            let message = decode_server(frames.encoding(), &body).unwrap();
            return Some((body, message));
        }
        let count = stream.read(&mut buffer).await.unwrap();
        if count == 0 {
            return None;
        }
        frames.handle_bytes(&buffer[..count]);
    }
}

/// Returns the first bytes of a connection.
pub(crate) fn opening(encoding: Encoding, first: &ClientMessage) -> Vec<u8> {
    [encoding.preamble(), &encode_client(encoding, first).unwrap()].concat()
}

pub(crate) fn watch(view: Vantage) -> ClientMessage {
    ClientMessage::Watch(Watch { protocol: PROTOCOL, client: "by hand".to_owned(), view })
}

pub(crate) fn hello(arena: &Arena, seat: usize) -> Hello {
    let token = arena.tokens[seat].clone();
    Hello { protocol: PROTOCOL, client: "by hand".to_owned(), player: NAMES[seat].to_owned(), token }
}
