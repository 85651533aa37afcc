//! Somebody who watches a match.

use maniple_protocol::{ClientMessage, PROTOCOL, Watch, Welcome};
use maniple_view::{Rules, Vantage, View};

use crate::address::Address;
use crate::connection::{Connection, Event, unexpected};
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
    pub async fn watch(
        address: impl Into<Address>,
        client: &str,
        view: Vantage,
    ) -> Result<Self, ClientError> {
        let watch = ClientMessage::Watch(Watch { protocol: PROTOCOL, client: client.to_owned(), view });
        let connection = Connection::open(&address.into(), &watch).await?;
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
