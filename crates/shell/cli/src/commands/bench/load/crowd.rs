//! Those who mean well: bots that play, and spectators that watch.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use maniple_bots::{Bot, bot_seed, random};
use maniple_client::{Client, ClientError, Event, Login};
use maniple_protocol::{
    ClientMessage, Encoding, PROTOCOL, ServerMessage, Watch, decode_server, encode_client,
};
use maniple_server::metrics::{Counted, Kind, Traffic};
use maniple_view::{Digest, Vantage};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::task::JoinSet;

use super::Counts;

/// Bytes that a spectator reads at once; there are thousands.
const READ_SIZE: usize = 2048;

/// A frame is no longer than this if it says why a connection is closed.
const REFUSAL_SIZE_MAX: usize = 512;

/// The reason of who was told none.
const CLOSED: &str = "closed";

/// Everybody who means well.
pub(super) struct Crowd {
    address: String,
    counts: Arc<Counts>,
}

impl Crowd {
    pub(super) fn new(address: String, counts: Arc<Counts>) -> Self {
        Self { address, counts }
    }

    /// Lets two bots play each match; returns when all are seated.
    pub(super) async fn play_all(&self, ids: &[Digest]) -> anyhow::Result<()> {
        let mut seated = JoinSet::new();
        // At the same time: a match lets its players in one after the other.
        for &id in ids.iter().chain(ids) {
            let login = Login { client: "load".to_owned(), player: "load".to_owned(), token: String::new() };
            let (address, counts) = (self.address.clone(), Arc::clone(&self.counts));
            seated.spawn(async move {
                let stream = TcpStream::connect(address).await?;
                stream.set_nodelay(true)?;
                Client::over(Counted::new(stream, Received(counts)), Some(id), login).await
            });
        }
        while let Some(client) = seated.join_next().await {
            let client = client??;
            let counts = Arc::clone(&self.counts);
            tokio::spawn(async move {
                if let Err(error) = follow(client, &counts).await {
                    let told = if let ClientError::Refused(reason) = error { reason.kind() } else { CLOSED };
                    counts.note_disconnected(told);
                }
            });
        }
        Ok(())
    }

    /// Lets a spectator watch everything of a match. It counts what comes and does not look into it.
    pub(super) async fn watch(&self, id: Digest) -> anyhow::Result<()> {
        let mut stream = TcpStream::connect(&self.address).await?;
        stream.write_all(&watch(id)?).await?;
        let counts = Arc::clone(&self.counts);
        tokio::spawn(async move {
            let mut frames = Frames::default();
            let mut buffer = [0; READ_SIZE];
            while let Ok(count @ 1..) = stream.read(&mut buffer).await {
                let before = frames.whole;
                frames.take(&buffer[..count]);
                // The welcome and the keyframe.
                if before < 2 && frames.whole >= 2 {
                    counts.watching.fetch_add(1, Ordering::Relaxed);
                }
                counts.messages.fetch_add(frames.whole - before, Ordering::Relaxed);
                counts.bytes.fetch_add(count as u64, Ordering::Relaxed);
            }
            counts.note_disconnected(frames.reason().unwrap_or(CLOSED));
        });
        Ok(())
    }
}

/// Plays a seat; ends only with an error, or with the match.
async fn follow(mut client: Client, counts: &Counts) -> Result<(), ClientError> {
    let mut bot = random(bot_seed(5, client.seat()));
    bot.on_start(client.seat(), client.rules(), client.terrain());
    loop {
        match client.next().await? {
            Event::Cycle(delta) => {
                counts.messages.fetch_add(1, Ordering::Relaxed);
                let commands = bot.on_cycle(client.view(), &delta);
                if !commands.is_empty() {
                    client.send(commands).await?;
                }
            }
            Event::Pong { .. } | Event::Paused { .. } | Event::Warned { .. } => {}
            Event::Ended(_) => return Ok(()),
        }
    }
}

/// Returns what a spectator says to watch everything of a match.
pub(super) fn watch(id: Digest) -> anyhow::Result<Vec<u8>> {
    let enter = ClientMessage::Enter { match_id: id, seat: None };
    let watch = Watch { protocol: PROTOCOL, client: "load".to_owned(), view: Vantage::Everything };
    let mut bytes = Encoding::Binary.preamble().to_vec();
    for message in [enter, ClientMessage::Watch(watch)] {
        bytes.extend(encode_client(Encoding::Binary, &message)?);
    }
    Ok(bytes)
}

/// The bytes that come to everybody.
#[derive(Debug)]
struct Received(Arc<Counts>);

impl Traffic for Received {
    fn note_received(&self, bytes: u64) {
        self.0.bytes.fetch_add(bytes, Ordering::Relaxed);
    }

    fn note_sent(&self, _bytes: u64) {}
}

/// Counts the frames of a stream.
#[derive(Default)]
struct Frames {
    whole: u64,
    /// Bytes of the length that have come.
    length: Vec<u8>,
    /// Bytes of the body that are to come.
    left: usize,
    /// The body of the last frame, if it can be a refusal, or what has come of it.
    short: Vec<u8>,
}

impl Frames {
    fn take(&mut self, mut bytes: &[u8]) {
        while !bytes.is_empty() {
            if self.left > 0 {
                let count = bytes.len().min(self.left);
                self.left -= count;
                if self.short.len() + self.left + count <= REFUSAL_SIZE_MAX {
                    self.short.extend_from_slice(&bytes[..count]);
                }
                self.whole += u64::from(self.left == 0);
                bytes = &bytes[count..];
                continue;
            }
            self.length.push(bytes[0]);
            bytes = &bytes[1..];
            if let Ok(length) = <[u8; 4]>::try_from(&self.length[..]) {
                self.left = u32::from_le_bytes(length) as usize;
                self.length.clear();
                self.short.clear();
            }
        }
    }

    /// Returns why the connection was closed, if the last frame says so.
    fn reason(&self) -> Option<&'static str> {
        match decode_server(Encoding::Binary, &self.short) {
            Ok(ServerMessage::Refused { reason }) => Some(reason.kind()),
            Ok(_) | Err(_) => None,
        }
    }
}
