//! The way to a match.

use maniple_protocol::ClientMessage;
use maniple_view::{Digest, Seat};
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::TcpStream;

use crate::error::ClientError;
use crate::tls::Tls;

/// A server, and which of its matches.
#[derive(Clone, Debug)]
pub struct Destination {
    pub(crate) address: String,
    tls: Option<Tls>,
    pub(crate) enter: Option<(Digest, Option<Seat>)>,
}

impl Destination {
    /// Returns a match of a server by its number; without it, it is the one that the server plays by itself.
    #[must_use]
    pub fn of_match(address: impl Into<String>, id: Digest) -> Self {
        Self::from(address.into()).entering(id)
    }

    /// Returns the same server with a match of its lobby.
    #[must_use]
    pub fn entering(self, id: Digest) -> Self {
        Self { enter: Some((id, None)), ..self }
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

    /// Returns the same over an encrypted connection.
    #[must_use]
    pub fn encrypted(self, tls: Tls) -> Self {
        Self { tls: Some(tls), ..self }
    }

    /// Connects.
    pub(crate) async fn open(&self) -> Result<Box<dyn Stream>, ClientError> {
        let address = || self.address.clone();
        let connected = TcpStream::connect(&self.address).await;
        let stream = connected.map_err(|source| ClientError::Connect { address: address(), source })?;
        stream.set_nodelay(true)?;
        match &self.tls {
            None => Ok(Box::new(stream)),
            Some(tls) => match tls.open(stream).await {
                Ok(stream) => Ok(Box::new(stream)),
                Err(source) => Err(ClientError::Handshake { address: address(), source }),
            },
        }
    }

    /// Returns what is said before the hello or watch.
    pub(crate) fn enter(&self) -> Option<ClientMessage> {
        self.enter.map(|(match_id, seat)| ClientMessage::Enter { match_id, seat })
    }
}

impl From<&str> for Destination {
    fn from(address: &str) -> Self {
        address.to_owned().into()
    }
}

impl From<&String> for Destination {
    fn from(address: &String) -> Self {
        address.as_str().into()
    }
}

impl From<String> for Destination {
    fn from(address: String) -> Self {
        Self { address, tls: None, enter: None }
    }
}

/// What bytes come and go through: a TCP connection, also an encrypted one, or, in tests, a simulated one.
pub trait Stream: AsyncRead + AsyncWrite + Unpin + Send + Sync + std::fmt::Debug + 'static {}

impl<S: AsyncRead + AsyncWrite + Unpin + Send + Sync + std::fmt::Debug + 'static> Stream for S {}
