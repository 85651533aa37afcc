//! Somebody who asks a server for its matches.

use maniple_protocol::{ClientMessage, Create, Listed, PROTOCOL, ServerMessage};
use maniple_view::{ClockMode, Digest};

use crate::connection::{Talk, unexpected};
use crate::destination::{Destination, Stream};
use crate::error::ClientError;

/// A connection to the lobby of a server.
#[derive(Debug)]
pub struct Lobby {
    talk: Talk,
}

/// What a server has.
#[derive(Clone, Debug, PartialEq)]
pub struct Matches {
    /// The scenarios of which anybody may create a match, by name.
    pub scenarios: Vec<String>,
    /// The matches that are played or wait for their players.
    pub list: Vec<Listed>,
}

/// A match that was created.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Created {
    /// Its number.
    pub match_id: Digest,
    /// By seat the token that opens it; none where all are open.
    pub tokens: Vec<String>,
}

impl Lobby {
    /// Connects to a server.
    ///
    /// # Errors
    /// A server that cannot be reached.
    pub async fn connect(address: &str) -> Result<Self, ClientError> {
        Ok(Self { talk: Talk::connect(&Destination::from(address)).await? })
    }

    /// As [`Self::connect`], over a connection that is there.
    #[must_use]
    pub fn over(stream: impl Stream) -> Self {
        Self { talk: Talk::over(stream) }
    }

    /// Asks which matches there are.
    ///
    /// # Errors
    /// A connection that is closed or broken, or a server that refuses.
    pub async fn list(&mut self) -> Result<Matches, ClientError> {
        self.talk.say(&ClientMessage::List { protocol: PROTOCOL }).await?;
        match self.talk.next().await? {
            ServerMessage::Matches { scenarios, list } => Ok(Matches { scenarios, list }),
            ServerMessage::Refused { reason } => Err(ClientError::Refused(reason)),
            other => Err(unexpected(other.name(), "the list of matches")),
        }
    }

    /// Asks for a match of a scenario, with seats that anybody may take or with a token for each.
    ///
    /// # Errors
    /// A connection that is closed or broken, or a server that refuses.
    pub async fn create(
        &mut self,
        scenario: &str,
        clock: ClockMode,
        open: bool,
    ) -> Result<Created, ClientError> {
        let create = Create { protocol: PROTOCOL, scenario: scenario.to_owned(), clock, open };
        self.talk.say(&ClientMessage::Create(create)).await?;
        match self.talk.next().await? {
            ServerMessage::Created { match_id, tokens } => Ok(Created { match_id, tokens }),
            ServerMessage::Refused { reason } => Err(ClientError::Refused(reason)),
            other => Err(unexpected(other.name(), "the new match")),
        }
    }
}
