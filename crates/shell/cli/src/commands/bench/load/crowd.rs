//! Those who mean well: bots that play, and spectators that watch.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use maniple_bots::bot_seed;
use maniple_client::{Client, Event, Login};
use maniple_protocol::{ClientMessage, Encoding, PROTOCOL, Watch, encode_client};
use maniple_view::{Digest, Vantage};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::task::JoinSet;

use super::{Counts, destination};

/// Bytes that a spectator reads at once; there are thousands.
const READ_SIZE: usize = 2048;

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
            seated.spawn(Client::connect(destination(&self.address, id), login));
        }
        while let Some(client) = seated.join_next().await {
            let client = client??;
            let counts = Arc::clone(&self.counts);
            tokio::spawn(async move {
                if follow(client, &counts).await.is_err() {
                    counts.disconnected.fetch_add(1, Ordering::Relaxed);
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
            counts.disconnected.fetch_add(1, Ordering::Relaxed);
        });
        Ok(())
    }
}

/// Plays a seat; ends only with an error, or with the match.
async fn follow(mut client: Client, counts: &Counts) -> anyhow::Result<()> {
    let mut bot = maniple_bots::make("random", bot_seed(5, client.seat()))?;
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

/// Counts the frames of a stream.
#[derive(Default)]
struct Frames {
    whole: u64,
    /// Bytes of the length that have come.
    length: Vec<u8>,
    /// Bytes of the body that are to come.
    left: usize,
}

impl Frames {
    fn take(&mut self, mut bytes: &[u8]) {
        while !bytes.is_empty() {
            if self.left > 0 {
                let count = bytes.len().min(self.left);
                self.left -= count;
                self.whole += u64::from(self.left == 0);
                bytes = &bytes[count..];
                continue;
            }
            self.length.push(bytes[0]);
            bytes = &bytes[1..];
            if let Ok(length) = <[u8; 4]>::try_from(&self.length[..]) {
                self.left = u32::from_le_bytes(length) as usize;
                self.length.clear();
            }
        }
    }
}
