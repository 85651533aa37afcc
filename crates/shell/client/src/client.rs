//! A seat in a match.

use maniple_protocol::{ClientMessage, Encoding, Hello, PROTOCOL, Welcome, encode_client, encode_commands};
use maniple_view::{ClockMode, Command, Delta, Digest, MatchResult, Rules, Seat, Sequenced, Terrain, View};

use crate::connection::{Connection, Event, Talk, unexpected};
use crate::destination::{Destination, Stream};
use crate::error::ClientError;

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

impl Login {
    fn hello(self) -> ClientMessage {
        let Self { client, player, token } = self;
        ClientMessage::Hello(Hello { protocol: PROTOCOL, client, player, token })
    }
}

/// A seat in a match.
#[derive(Debug)]
pub struct Client {
    connection: Connection,
    seat: Seat,
    next_seq: u32,
}

impl Client {
    /// Connects and takes a seat. The first [`Event::Cycle`] is the keyframe.
    ///
    /// Waits as long as the server does not answer, as it does not between two matches.
    ///
    /// # Errors
    /// A server that cannot be reached, or refuses.
    pub async fn connect(to: impl Into<Destination>, login: Login) -> Result<Self, ClientError> {
        Self::seated(Connection::open(to.into(), &login.hello()).await?)
    }

    /// As [`Self::connect`], over a connection that is there, to a match or to the one that the server plays by itself.
    ///
    /// # Errors
    /// As [`Self::connect`].
    pub async fn over(stream: impl Stream, of: Option<Digest>, login: Login) -> Result<Self, ClientError> {
        let enter = of.map(|match_id| ClientMessage::Enter { match_id, seat: None });
        Self::seated(Connection::begin(Talk::over(stream), enter.as_ref(), &login.hello()).await?)
    }

    fn seated(connection: Connection) -> Result<Self, ClientError> {
        let seat = connection.welcome.seat;
        let seat = seat.ok_or_else(|| unexpected("the welcome of a spectator", "that of a player"))?;
        Ok(Self { connection, seat, next_seq: 0 })
    }

    /// Waits for what the server says next. Can be given up and called again: nothing is lost.
    ///
    /// # Errors
    /// A connection that is closed or broken, or a delta after which the two views differ.
    pub async fn next(&mut self) -> Result<Event, ClientError> {
        self.connection.next().await
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
        self.connection.write(&bytes).await?;
        Ok(first)
    }

    /// Says that all is said about the present view: lock-step waits for it. In real time it has no effect.
    ///
    /// # Errors
    /// None that [`Self::next`] does not tell better, but for a broken system.
    pub async fn done(&mut self) -> Result<(), ClientError> {
        let bytes = self.encode_done()?;
        self.connection.write(&bytes).await
    }

    /// Asks for a pong.
    ///
    /// # Errors
    /// As [`Self::done`].
    pub async fn ping(&mut self, id: u32) -> Result<(), ClientError> {
        self.connection.say(&ClientMessage::Ping { id }).await
    }

    /// Asks for a pause: there is one once all seats that are in and have a player have asked for it.
    ///
    /// # Errors
    /// As [`Self::done`].
    pub async fn pause(&mut self) -> Result<(), ClientError> {
        self.connection.say(&ClientMessage::Pause { on: true }).await
    }

    /// Ends a pause, or withdraws the wish for one.
    ///
    /// # Errors
    /// As [`Self::done`].
    pub async fn go_on(&mut self) -> Result<(), ClientError> {
        self.connection.say(&ClientMessage::Pause { on: false }).await
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
                    let commands = decide(&self.connection.view, &delta);
                    let mut bytes = self.encode(commands)?;
                    if self.connection.welcome.clock == ClockMode::Lockstep {
                        bytes.extend(self.encode_done()?);
                    }
                    self.connection.write(&bytes).await?;
                }
                Event::Pong { .. } | Event::Paused { .. } | Event::Warned { .. } => {}
                Event::Ended(result) => return Ok(result),
            }
        }
    }

    /// Returns what the player knows of the objects, at the start of the cycle of the last delta.
    #[must_use]
    pub fn view(&self) -> &View {
        &self.connection.view
    }

    /// Returns the rules; the names of the players are those that had come when this client did.
    #[must_use]
    pub fn rules(&self) -> &Rules {
        &self.connection.welcome.rules
    }

    /// Returns the terrain as far as the player knows it.
    #[must_use]
    pub fn terrain(&self) -> &Terrain {
        self.connection.view.terrain()
    }

    /// Returns the seat.
    #[must_use]
    pub fn seat(&self) -> Seat {
        self.seat
    }

    /// Returns all that the server said at the beginning.
    #[must_use]
    pub fn welcome(&self) -> &Welcome {
        &self.connection.welcome
    }

    fn encode(&mut self, commands: Vec<Command>) -> Result<Vec<u8>, ClientError> {
        let mut sequenced = Vec::with_capacity(commands.len());
        for command in commands {
            sequenced.push(Sequenced { seq: self.next_seq, command });
            self.next_seq = self.next_seq.wrapping_add(1);
        }
        Ok(encode_commands(Encoding::Binary, self.connection.view.cycle(), &sequenced)?)
    }

    fn encode_done(&self) -> Result<Vec<u8>, ClientError> {
        let done = ClientMessage::Done { cycle: self.connection.view.cycle() };
        Ok(encode_client(Encoding::Binary, &done)?)
    }
}
