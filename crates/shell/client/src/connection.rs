//! A connection to a match, and the view that it keeps.

use std::sync::Arc;

use maniple_protocol::{
    ClientMessage, Encoding, FRAME_FROM_SERVER_MAX, FrameDecoder, Refused, ServerMessage, Welcome,
    decode_server, encode_client,
};
use maniple_view::{Delta, MatchResult, Seat, View};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

use crate::error::ClientError;

/// Bytes that are read at once: a few of the usual deltas.
const READ_SIZE: usize = 16 * 1024;

/// What the server said.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// A cycle has passed, or several for who is too slow for each: the delta has been applied to the view, and the views of both
    /// sides are the same. Who is too far behind for that gets a new view: then the delta is a keyframe.
    Cycle(Box<Delta>),
    /// The answer to a ping.
    Pong {
        /// The ping's number.
        id: u32,
        /// The cycle that ran; to a spectator that of the view.
        cycle: u32,
        /// How much of its wall-clock time had passed, `0.0..=1.0`; 0 in lock-step and in a pause.
        fraction: f64,
    },
    /// Who wants a pause, and whether there is one; spectators are not told.
    Paused {
        /// The seats that want it, in their order; once there is one, those that had asked for it.
        seats: Vec<Seat>,
        /// Whether the clock stands still.
        on: bool,
    },
    /// The client broke a rule, and what it said was dropped.
    Warned {
        /// Which rule.
        reason: Refused,
        /// How often it may still do so.
        left: u32,
    },
    /// The match has ended; nothing comes after.
    Ended(MatchResult),
}

/// A connection that the server has welcomed.
#[derive(Debug)]
pub(crate) struct Connection {
    stream: TcpStream,
    frames: FrameDecoder,
    buffer: Vec<u8>,
    pub(crate) welcome: Welcome,
    pub(crate) view: View,
    /// The view with which who comes begins.
    beginning: View,
}

impl Connection {
    /// Connects, says `first` and waits for the welcome.
    pub(crate) async fn open(address: &str, first: &ClientMessage) -> Result<Self, ClientError> {
        let connected = TcpStream::connect(address).await;
        let mut stream =
            connected.map_err(|source| ClientError::Connect { address: address.to_owned(), source })?;
        stream.set_nodelay(true)?;
        let mut bytes = Encoding::Binary.preamble().to_vec();
        bytes.extend(encode_client(Encoding::Binary, first)?);
        write(&mut stream, &bytes).await?;
        let mut frames = FrameDecoder::new(Encoding::Binary, FRAME_FROM_SERVER_MAX);
        let mut buffer = vec![0; READ_SIZE];
        let welcome = match read(&mut stream, &mut frames, &mut buffer).await? {
            ServerMessage::Welcome(welcome) => welcome,
            ServerMessage::Refused { reason } => return Err(ClientError::Refused(reason)),
            ServerMessage::Delta(_) | ServerMessage::Packed(_) => {
                return Err(unexpected("a delta", "the welcome"));
            }
            ServerMessage::Pong { .. } => return Err(unexpected("a pong", "the welcome")),
            ServerMessage::Paused { .. } => return Err(unexpected("a pause", "the welcome")),
            ServerMessage::Ended { .. } => return Err(unexpected("the end", "the welcome")),
            ServerMessage::Keyframe {} => return Err(unexpected("`keyframe`", "the welcome")),
            ServerMessage::Warned { .. } => return Err(unexpected("a warning", "the welcome")),
        };
        let view = View::new(&welcome.rules, Arc::new(welcome.terrain.clone()));
        Ok(Self { stream, frames, buffer, welcome, beginning: view.clone(), view })
    }

    /// Waits for what the server says next. Can be given up and called again: nothing is lost.
    pub(crate) async fn next(&mut self) -> Result<Event, ClientError> {
        let mut message = read(&mut self.stream, &mut self.frames, &mut self.buffer).await?;
        if let ServerMessage::Keyframe {} = message {
            // Nothing is to be told before the keyframe has come.
            self.view = self.beginning.clone();
            message = read(&mut self.stream, &mut self.frames, &mut self.buffer).await?;
        }
        match message {
            ServerMessage::Delta(delta) => self.take_in(delta),
            ServerMessage::Packed(packed) => {
                let delta = packed.unpack(&self.view, &self.welcome.rules)?;
                self.take_in(delta)
            }
            ServerMessage::Ended { result } => Ok(Event::Ended(result)),
            ServerMessage::Pong { id, cycle, fraction } => Ok(Event::Pong { id, cycle: cycle.0, fraction }),
            ServerMessage::Paused { seats, on } => Ok(Event::Paused { seats, on }),
            ServerMessage::Refused { reason } => Err(ClientError::Refused(reason)),
            ServerMessage::Warned { reason, left } => Ok(Event::Warned { reason, left }),
            ServerMessage::Keyframe {} => Err(unexpected("a second `keyframe`", "a delta")),
            ServerMessage::Welcome(_) => Err(unexpected("a second welcome", "a delta")),
        }
    }

    /// Sends a message.
    pub(crate) async fn say(&mut self, message: &ClientMessage) -> Result<(), ClientError> {
        let bytes = encode_client(Encoding::Binary, message)?;
        self.write(&bytes).await
    }

    /// Sends messages that are written already.
    pub(crate) async fn write(&mut self, bytes: &[u8]) -> Result<(), ClientError> {
        write(&mut self.stream, bytes).await
    }

    fn take_in(&mut self, delta: Delta) -> Result<Event, ClientError> {
        self.view.apply(&delta)?;
        Ok(Event::Cycle(Box::new(delta)))
    }
}

/// Waits for the next message. A wait that is given up loses nothing.
async fn read(
    stream: &mut TcpStream,
    frames: &mut FrameDecoder,
    buffer: &mut [u8],
) -> Result<ServerMessage, ClientError> {
    loop {
        if let Some(body) = frames.poll()? {
            return Ok(decode_server(Encoding::Binary, body)?);
        }
        let count = stream.read(buffer).await?;
        if count == 0 {
            return Err(ClientError::Closed);
        }
        frames.handle_bytes(&buffer[..count]);
    }
}

/// Writes to a server that may have closed the connection: its reason can still be read then.
async fn write(stream: &mut TcpStream, bytes: &[u8]) -> Result<(), ClientError> {
    use std::io::ErrorKind::{BrokenPipe, ConnectionAborted, ConnectionReset};
    match stream.write_all(bytes).await {
        Err(error) if matches!(error.kind(), BrokenPipe | ConnectionAborted | ConnectionReset) => Ok(()),
        written => Ok(written?),
    }
}

pub(crate) fn unexpected(found: &'static str, expected: &'static str) -> ClientError {
    ClientError::Unexpected { found, expected }
}
