//! One connection to a match, and the view that it keeps.

use std::sync::Arc;

use maniple_protocol::{
    ClientMessage, Encoding, FRAME_FROM_SERVER_MAX, FrameDecoder, Hello, PROTOCOL, ServerMessage, Welcome,
    decode_server, encode_client, encode_commands,
};
use maniple_view::{ClockMode, Command, Delta, MatchResult, Rules, Seat, Sequenced, Terrain, View};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

use crate::error::ClientError;

/// Bytes that are read at once: a few of the usual deltas.
const READ_SIZE: usize = 16 * 1024;

/// Who connects.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Login {
    /// Name and version of the program, for the server's log.
    pub client: String,
    /// The player's name; everybody sees it.
    pub player: String,
    /// The seat's token; empty for a seat that is open to all.
    pub token: String,
}

/// What the server said.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// A cycle has passed: the delta has been applied to the view, and the views of both sides are the same.
    Cycle(Box<Delta>),
    /// The answer to a ping.
    Pong {
        /// The ping's number.
        id: u32,
        /// The cycle that ran.
        cycle: u32,
        /// How much of its wall-clock time had passed, `0.0..=1.0`; 0 in lock-step and in a pause.
        fraction: f64,
    },
    /// Who wants a pause, and whether there is one.
    Paused {
        /// The seats that want it, in their order; once there is one, those that had asked for it.
        seats: Vec<Seat>,
        /// Whether the clock stands still.
        on: bool,
    },
    /// The match has ended; nothing comes after.
    Ended(MatchResult),
}

/// A seat in a match.
#[derive(Debug)]
pub struct Client {
    stream: TcpStream,
    frames: FrameDecoder,
    buffer: Vec<u8>,
    welcome: Welcome,
    view: View,
    next_seq: u32,
}

impl Client {
    /// Connects and takes a seat. The first [`Event::Cycle`] is the keyframe.
    ///
    /// Waits as long as the server does not answer, as it does not between two matches.
    ///
    /// # Errors
    /// A server that cannot be reached, or refuses.
    pub async fn connect(address: &str, login: Login) -> Result<Self, ClientError> {
        let connected = TcpStream::connect(address).await;
        let mut stream =
            connected.map_err(|source| ClientError::Connect { address: address.to_owned(), source })?;
        stream.set_nodelay(true)?;
        let Login { client, player, token } = login;
        let hello = ClientMessage::Hello(Hello { protocol: PROTOCOL, client, player, token });
        let mut bytes = Encoding::Binary.preamble().to_vec();
        bytes.extend(encode_client(Encoding::Binary, &hello)?);
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
        };
        let view = View::new(&welcome.rules, Arc::new(welcome.terrain.clone()));
        Ok(Self { stream, frames, buffer, welcome, view, next_seq: 0 })
    }

    /// Waits for what the server says next. Can be given up and called again: nothing is lost.
    ///
    /// # Errors
    /// A connection that is closed or broken, or a delta after which the two views differ.
    pub async fn next(&mut self) -> Result<Event, ClientError> {
        match read(&mut self.stream, &mut self.frames, &mut self.buffer).await? {
            ServerMessage::Delta(delta) => self.take_in(delta),
            ServerMessage::Packed(packed) => {
                let delta = packed.unpack(&self.view, &self.welcome.rules)?;
                self.take_in(delta)
            }
            ServerMessage::Ended { result } => Ok(Event::Ended(result)),
            ServerMessage::Pong { id, cycle, fraction } => Ok(Event::Pong { id, cycle: cycle.0, fraction }),
            ServerMessage::Paused { seats, on } => Ok(Event::Paused { seats, on }),
            ServerMessage::Refused { reason } => Err(ClientError::Refused(reason)),
            ServerMessage::Welcome(_) => Err(unexpected("a second welcome", "a delta")),
        }
    }

    /// Sends commands that were decided on the present view, in as many messages as it takes. Returns the number that
    /// the result of the first will carry; the others count up from it.
    ///
    /// A connection that is closed is no error here: [`Self::next`] says why it is.
    ///
    /// # Errors
    /// A command that is too long for a message.
    pub async fn send(&mut self, commands: Vec<Command>) -> Result<u32, ClientError> {
        let first = self.next_seq;
        let bytes = self.encode(commands)?;
        write(&mut self.stream, &bytes).await?;
        Ok(first)
    }

    /// Says that all is said about the present view: lock-step waits for it. In real time it has no effect.
    ///
    /// # Errors
    /// None that [`Self::next`] does not tell better, but for a broken system.
    pub async fn done(&mut self) -> Result<(), ClientError> {
        let bytes = self.encode_done()?;
        write(&mut self.stream, &bytes).await
    }

    /// Asks for a pong.
    ///
    /// # Errors
    /// As [`Self::done`].
    pub async fn ping(&mut self, id: u32) -> Result<(), ClientError> {
        let bytes = encode_client(Encoding::Binary, &ClientMessage::Ping { id })?;
        write(&mut self.stream, &bytes).await
    }

    /// Asks for a pause: there is one once all seats that are in and have a player have asked for it.
    ///
    /// # Errors
    /// As [`Self::done`].
    pub async fn pause(&mut self) -> Result<(), ClientError> {
        self.say_pause(ClientMessage::Pause { on: true }).await
    }

    /// Ends a pause, or withdraws the wish for one.
    ///
    /// # Errors
    /// As [`Self::done`].
    pub async fn go_on(&mut self) -> Result<(), ClientError> {
        self.say_pause(ClientMessage::Pause { on: false }).await
    }

    /// Plays the match to its end: `decide` gets the view after each delta, and the delta, and returns the commands.
    ///
    /// # Errors
    /// As [`Self::next`] and [`Self::send`].
    pub async fn play(
        &mut self,
        mut decide: impl FnMut(&View, &Delta) -> Vec<Command>,
    ) -> Result<MatchResult, ClientError> {
        loop {
            match self.next().await? {
                Event::Cycle(delta) => {
                    let commands = decide(&self.view, &delta);
                    let mut bytes = self.encode(commands)?;
                    if self.welcome.clock == ClockMode::Lockstep {
                        bytes.extend(self.encode_done()?);
                    }
                    write(&mut self.stream, &bytes).await?;
                }
                Event::Pong { .. } | Event::Paused { .. } => {}
                Event::Ended(result) => return Ok(result),
            }
        }
    }

    /// Returns what the player knows of the objects, at the start of the cycle of the last delta.
    #[must_use]
    pub fn view(&self) -> &View {
        &self.view
    }

    /// Returns the rules; the names of the players are those that had come when this client did.
    #[must_use]
    pub fn rules(&self) -> &Rules {
        &self.welcome.rules
    }

    /// Returns the terrain as far as the player knows it.
    #[must_use]
    pub fn terrain(&self) -> &Terrain {
        self.view.terrain()
    }

    /// Returns the seat.
    #[must_use]
    pub fn seat(&self) -> Seat {
        self.welcome.seat
    }

    /// Returns all that the server said at the beginning.
    #[must_use]
    pub fn welcome(&self) -> &Welcome {
        &self.welcome
    }

    fn take_in(&mut self, delta: Delta) -> Result<Event, ClientError> {
        self.view.apply(&delta)?;
        Ok(Event::Cycle(Box::new(delta)))
    }

    fn encode(&mut self, commands: Vec<Command>) -> Result<Vec<u8>, ClientError> {
        let mut sequenced = Vec::with_capacity(commands.len());
        for command in commands {
            sequenced.push(Sequenced { seq: self.next_seq, command });
            self.next_seq = self.next_seq.wrapping_add(1);
        }
        Ok(encode_commands(Encoding::Binary, self.view.cycle(), &sequenced)?)
    }

    async fn say_pause(&mut self, message: ClientMessage) -> Result<(), ClientError> {
        let bytes = encode_client(Encoding::Binary, &message)?;
        write(&mut self.stream, &bytes).await
    }

    fn encode_done(&self) -> Result<Vec<u8>, ClientError> {
        let done = ClientMessage::Done { cycle: self.view.cycle() };
        Ok(encode_client(Encoding::Binary, &done)?)
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

fn unexpected(found: &'static str, expected: &'static str) -> ClientError {
    ClientError::Unexpected { found, expected }
}
