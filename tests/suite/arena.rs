//! A server with one match, for tests.

use std::future::pending;
use std::io::{self, Write};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use maniple_bots::{Bot, bot_seed, make};
use maniple_client::{Client, Login};
use maniple_game::{Files, Loaded, LoadedFile, Overrides, load};
use maniple_referee::Referee;
use maniple_server::{Access, Match, RunError, Server};
use maniple_view::{ClockMode, MatchResult, Seat};
use tokio::io::BufReader;
use tokio::net::TcpStream;
use tokio::sync::oneshot;
use tokio::task::JoinHandle;
use tokio::time::timeout;

/// The players, by seat.
pub(crate) const NAMES: [&str; 2] = ["Ada", "Bob"];

/// A server with one match.
pub(crate) struct Arena {
    pub(crate) address: String,
    pub(crate) tokens: Vec<String>,
    shutdown: oneshot::Sender<()>,
    running: JoinHandle<Result<Option<MatchResult>, RunError>>,
    pub(crate) replay: Shared,
}

/// How a match came out, and what is written of it.
pub(crate) struct Outcome {
    pub(crate) result: Option<MatchResult>,
    pub(crate) replay: Vec<u8>,
}

/// Bytes that can be looked at while they are written.
#[derive(Clone, Default)]
pub(crate) struct Shared(Arc<Mutex<Vec<u8>>>);

impl Shared {
    pub(crate) fn bytes(&self) -> Vec<u8> {
        self.0.lock().unwrap().clone()
    }
}

impl Write for Shared {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().unwrap().extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Arena {
    pub(crate) fn open(loaded: &Loaded, mode: ClockMode) -> Self {
        Self::open_with(loaded, mode, |game| game)
    }

    /// Opens it for a match that is changed first.
    pub(crate) fn open_with(loaded: &Loaded, mode: ClockMode, change: impl FnOnce(Match) -> Match) -> Self {
        let server = Server::bind("127.0.0.1:0".parse().unwrap()).unwrap();
        let address = server.local_addr().unwrap().to_string();
        let game = Match::with_random_tokens(Referee::new(loaded.clone(), mode).unwrap()).unwrap();
        let replay = Shared::default();
        let game = change(game.recorded_to(replay.clone()));
        let token = |access: &Access| match access {
            Access::Token(token) => token.to_string(),
            Access::Open => String::new(),
        };
        let tokens = game.access().iter().map(token).collect();
        let (shutdown, asked) = oneshot::channel::<()>();
        let running = tokio::spawn(async move {
            let shutdown = async {
                if asked.await.is_err() {
                    pending::<()>().await;
                }
            };
            server.run(game, shutdown).await
        });
        Self { address, tokens, shutdown, running, replay }
    }

    pub(crate) async fn client(&self, seat: usize) -> Client {
        Client::connect(&self.address, login(seat, &self.tokens[seat])).await.unwrap()
    }

    pub(crate) async fn raw(&self) -> BufReader<TcpStream> {
        BufReader::new(TcpStream::connect(&self.address).await.unwrap())
    }

    pub(crate) async fn outcome(self) -> Outcome {
        Outcome { result: self.running.await.unwrap().unwrap(), replay: self.replay.bytes() }
    }

    pub(crate) async fn shut_down(self) -> Outcome {
        self.shutdown.send(()).unwrap();
        // Nothing else would end the wait for a server that does not go down.
        let ended = timeout(Duration::from_secs(60), self.running).await.expect("it goes down");
        Outcome { result: ended.unwrap().unwrap(), replay: self.replay.bytes() }
    }
}

/// Returns the start of a race of two seats with five units each on an open field.
pub(crate) fn loaded(clock: &str) -> Loaded {
    let (scenario, map) = tiny(clock);
    let file = |path: &str, text: String| LoadedFile { path: path.to_owned(), bytes: text.into_bytes() };
    let files = Files(vec![file("tiny.toml", scenario), file("tiny.map", map)]);
    load(&files, "tiny.toml", &Overrides::default()).unwrap()
}

/// Returns its scenario, and its map `tiny.map`, as texts.
pub(crate) fn tiny(clock: &str) -> (String, String) {
    let seat = "{ groups = [{ unit = 'a', count = 3 }, { unit = 'b', count = 2 }] }";
    let scenario = format!(
        "name = 'tiny'\nmap = 'tiny.map'\nseed = 5\n{clock}\nseat = [{seat}, {seat}]\n\
         vision = {{}}\nobjective = {{ kind = 'race', zone_size = 3 }}\n\
         unit.a = {{ radius = 0.3, speed = 4, sight = 5 }}\nunit.b = {{ radius = 0.45, speed = 3, sight = 7 }}\n"
    );
    let map = format!("type octile\nheight 12\nwidth 24\nmap\n{}", "........................\n".repeat(12));
    (scenario, map)
}

pub(crate) fn bot(name: &str, seat: u16) -> Box<dyn Bot + Send> {
    make(name, bot_seed(5, Seat(seat))).unwrap()
}

pub(crate) fn login(seat: usize, token: &str) -> Login {
    Login { client: "suite".to_owned(), player: NAMES[seat].to_owned(), token: token.to_owned() }
}
