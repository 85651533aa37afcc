//! The way to a match.

use maniple_protocol::ClientMessage;
use maniple_view::{Digest, Seat};
use tokio::io::{AsyncRead, AsyncWrite};

/// A server, and which of its matches.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Destination {
    pub(crate) address: String,
    pub(crate) enter: Option<(Digest, Option<Seat>)>,
}

impl Destination {
    /// Returns a match of a server by its number; without it, it is the one that the server plays by itself.
    #[must_use]
    pub fn of_match(address: impl Into<String>, id: Digest) -> Self {
        Self { address: address.into(), enter: Some((id, None)) }
    }

    /// Returns the same with the open seat that is wanted.
    ///
    /// # Panics
    /// Without a match.
    #[must_use]
    pub fn at(self, seat: Seat) -> Self {
        let (id, _) = self.enter.expect("a seat is one of a match");
        Self { enter: Some((id, Some(seat))), ..self }
    }

    /// Returns what is said before the hello or watch.
    pub(crate) fn enter(&self) -> Option<ClientMessage> {
        self.enter.map(|(match_id, seat)| ClientMessage::Enter { match_id, seat })
    }
}

impl From<&str> for Destination {
    fn from(address: &str) -> Self {
        Self { address: address.to_owned(), enter: None }
    }
}

impl From<&String> for Destination {
    fn from(address: &String) -> Self {
        address.as_str().into()
    }
}

impl From<String> for Destination {
    fn from(address: String) -> Self {
        Self { address, enter: None }
    }
}

/// What bytes come and go through: a TCP connection, also an encrypted one, or, in tests, a simulated one.
pub trait Stream: AsyncRead + AsyncWrite + Unpin + Send + Sync + std::fmt::Debug + 'static {}

impl<S: AsyncRead + AsyncWrite + Unpin + Send + Sync + std::fmt::Debug + 'static> Stream for S {}
