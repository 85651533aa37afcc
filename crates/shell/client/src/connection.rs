//! A connection to a match, and the view that it keeps.

use std::sync::Arc;

use maniple_protocol::{
    ClientMessage, Encoding, FRAME_FROM_SERVER_MAX, FrameDecoder, Refused, ServerMessage, Welcome,
    decode_server, encode_client,
};
use maniple_view::{Delta, MatchResult, Seat, View};
use tokio::io::{AsyncReadExt, AsyncWriteExt};

use crate::destination::{Destination, Stream};
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

/// A connection to a server, and what has come in of a message.
#[derive(Debug)]
pub(crate) struct Talk {
    stream: Box<dyn Stream>,
    frames: FrameDecoder,
    buffer: Vec<u8>,
    /// Whether the encoding has been chosen.
    has_begun: bool,
}

impl Talk {
    pub(crate) async fn connect(destination: &Destination) -> Result<Self, ClientError> {
        Ok(Self::new(destination.open().await?))
    }

    pub(crate) fn over(stream: impl Stream) -> Self {
        Self::new(Box::new(stream))
    }

    fn new(stream: Box<dyn Stream>) -> Self {
        let frames = FrameDecoder::new(Encoding::Binary, FRAME_FROM_SERVER_MAX);
        Self { stream, frames, buffer: vec![0; READ_SIZE], has_begun: false }
    }

    /// Sends a message.
    pub(crate) async fn say(&mut self, message: &ClientMessage) -> Result<(), ClientError> {
        let bytes = encode_client(Encoding::Binary, message)?;
        if std::mem::replace(&mut self.has_begun, true) {
            return self.write(&bytes).await;
        }
        let bytes = [Encoding::Binary.preamble(), &bytes].concat();
        self.write(&bytes).await
    }

    /// Writes to a server that may have closed the connection: its reason can still be read then.
    pub(crate) async fn write(&mut self, bytes: &[u8]) -> Result<(), ClientError> {
        use std::io::ErrorKind::{BrokenPipe, ConnectionAborted, ConnectionReset};
        // What is encrypted waits in a buffer.
        let written = async {
            self.stream.write_all(bytes).await?;
            self.stream.flush().await
        };
        match written.await {
            Err(error) if matches!(error.kind(), BrokenPipe | ConnectionAborted | ConnectionReset) => Ok(()),
            written => Ok(written?),
        }
    }

    /// Waits for the next message, which is no refusal.
    pub(crate) async fn answer(&mut self) -> Result<ServerMessage, ClientError> {
        let answer = self.next().await?;
        if let ServerMessage::Refused { reason } = answer {
            return Err(ClientError::Refused(reason));
        }
        Ok(answer)
    }

    /// Waits for the next message. A wait that is given up loses nothing.
    pub(crate) async fn next(&mut self) -> Result<ServerMessage, ClientError> {
        loop {
            if let Some(body) = self.frames.poll()? {
                return Ok(decode_server(Encoding::Binary, body)?);
            }
            let count = self.stream.read(&mut self.buffer).await?;
            if count == 0 {
                return Err(ClientError::Closed);
            }
            self.frames.handle_bytes(&self.buffer[..count]);
        }
    }
}

/// A connection that the server has welcomed.
#[derive(Debug)]
pub(crate) struct Connection {
    talk: Talk,
    pub(crate) welcome: Welcome,
    pub(crate) view: View,
    /// The view with which who comes begins.
    beginning: View,
}

impl Connection {
    /// Connects, says `first` and waits for the welcome.
    pub(crate) async fn open(destination: Destination, first: &ClientMessage) -> Result<Self, ClientError> {
        let talk = Talk::connect(&destination).await?;
        Self::begin(talk, destination.enter().as_ref(), first).await
    }

    /// As [`Self::open`], over a connection that is there.
    pub(crate) async fn begin(
        mut talk: Talk,
        enter: Option<&ClientMessage>,
        first: &ClientMessage,
    ) -> Result<Self, ClientError> {
        if let Some(enter) = enter {
            talk.say(enter).await?;
        }
        talk.say(first).await?;
        let answer = talk.answer().await?;
        let name = answer.name();
        let ServerMessage::Welcome(welcome) = answer else { return Err(unexpected(name, "the welcome")) };
        let view = View::new(&welcome.rules, Arc::new(welcome.terrain.clone()));
        Ok(Self { talk, welcome, beginning: view.clone(), view })
    }

    /// Waits for what the server says next. Can be given up and called again: nothing is lost.
    pub(crate) async fn next(&mut self) -> Result<Event, ClientError> {
        let mut message = self.talk.next().await?;
        if let ServerMessage::Keyframe {} = message {
            // Nothing is to be told before the keyframe has come.
            self.view = self.beginning.clone();
            message = self.talk.next().await?;
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
            other @ (ServerMessage::Welcome(_)
            | ServerMessage::Keyframe {}
            | ServerMessage::Matches { .. }
            | ServerMessage::Created { .. }) => Err(unexpected(other.name(), "a delta")),
        }
    }

    /// Sends a message.
    pub(crate) async fn say(&mut self, message: &ClientMessage) -> Result<(), ClientError> {
        self.talk.say(message).await
    }

    /// Sends messages that are written already.
    pub(crate) async fn write(&mut self, bytes: &[u8]) -> Result<(), ClientError> {
        self.talk.write(bytes).await
    }

    fn take_in(&mut self, delta: Delta) -> Result<Event, ClientError> {
        self.view.apply(&delta)?;
        Ok(Event::Cycle(Box::new(delta)))
    }
}

pub(crate) fn unexpected(found: &'static str, expected: &'static str) -> ClientError {
    ClientError::Unexpected { found, expected }
}
