//! Somebody who watches a match.

use maniple_protocol::{ClientMessage, PROTOCOL, Watch, Welcome};
use maniple_view::{Digest, Rules, Vantage, View};

use crate::connection::{Connection, Event, Talk, unexpected};
use crate::destination::{Destination, Stream};
use crate::error::ClientError;

/// A spectator of a match, with a mirrored view. It has nothing to say, and is behind the match by the delay that the
/// scenario asks for.
#[doc(alias = "observer")]
#[derive(Debug)]
pub struct Spectator {
    connection: Connection,
    delay: u32,
}

impl Spectator {
    /// Connects and watches a view; `client` is name and version of the program, for the server's log. The first
    /// [`Event::Cycle`] is the keyframe: it comes when the match is older than the delay.
    ///
    /// # Errors
    /// A server that cannot be reached, or refuses, for one because the scenario does not permit it.
    pub async fn watch(to: impl Into<Destination>, client: &str, view: Vantage) -> Result<Self, ClientError> {
        Self::seated(Connection::open(to.into(), &watch(client, view)).await?)
    }

    /// As [`Self::watch`], over a connection that is there, a match or the one that the server plays by itself.
    ///
    /// # Errors
    /// As [`Self::watch`].
    pub async fn over(
        stream: impl Stream,
        of: Option<Digest>,
        client: &str,
        view: Vantage,
    ) -> Result<Self, ClientError> {
        let enter = of.map(|match_id| ClientMessage::Enter { match_id, seat: None });
        Self::seated(Connection::begin(Talk::over(stream), enter.as_ref(), &watch(client, view)).await?)
    }

    fn seated(connection: Connection) -> Result<Self, ClientError> {
        let delay = connection.welcome.delay;
        let delay = delay.ok_or_else(|| unexpected("the welcome of a player", "that of a spectator"))?;
        Ok(Self { connection, delay })
    }

    /// Waits for what the server says next. Can be given up and called again: nothing is lost.
    ///
    /// # Errors
    /// A connection that is closed or broken, or a delta after which the two views differ.
    pub async fn next(&mut self) -> Result<Event, ClientError> {
        self.connection.next().await
    }

    /// Asks for a pong.
    ///
    /// # Errors
    /// None that [`Self::next`] does not tell better, but for a broken system.
    pub async fn ping(&mut self, id: u32) -> Result<(), ClientError> {
        self.connection.say(&ClientMessage::Ping { id }).await
    }

    /// Returns the view, at the start of the cycle of the last delta.
    #[must_use]
    pub fn view(&self) -> &View {
        &self.connection.view
    }

    /// Returns by how many cycles it is behind.
    #[must_use]
    pub fn delay(&self) -> u32 {
        self.delay
    }

    /// Returns the rules; the names of the players are those that had come when this spectator did.
    #[must_use]
    pub fn rules(&self) -> &Rules {
        &self.connection.welcome.rules
    }

    /// Returns all that the server said at the beginning.
    #[must_use]
    pub fn welcome(&self) -> &Welcome {
        &self.connection.welcome
    }
}

fn watch(client: &str, view: Vantage) -> ClientMessage {
    ClientMessage::Watch(Watch { protocol: PROTOCOL, client: client.to_owned(), view })
}
