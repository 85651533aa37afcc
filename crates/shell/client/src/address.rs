//! Where a server is, and how it is spoken to.

use std::io;

use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::TcpStream;

use crate::error::ClientError;
use crate::tls::Tls;

/// Host and port of a server, and whether what is said to it is encrypted. A text alone is an address where nothing is.
#[derive(Clone, Debug)]
pub struct Address {
    place: String,
    tls: Option<Tls>,
}

/// Bytes to and from a server, encrypted or not.
pub(crate) trait Stream: AsyncRead + AsyncWrite + Unpin + Send + Sync + std::fmt::Debug {}

impl<T: AsyncRead + AsyncWrite + Unpin + Send + Sync + std::fmt::Debug> Stream for T {}

impl<T: Into<String>> From<T> for Address {
    fn from(place: T) -> Self {
        Self { place: place.into(), tls: None }
    }
}

impl Address {
    /// Returns the address of a server that is spoken to by TLS.
    #[must_use]
    pub fn encrypted(place: impl Into<String>, tls: Tls) -> Self {
        Self { place: place.into(), tls: Some(tls) }
    }

    /// Connects.
    pub(crate) async fn open(&self) -> Result<Box<dyn Stream>, ClientError> {
        let failed = |source: io::Error| ClientError::Connect { address: self.place.clone(), source };
        let stream = TcpStream::connect(&self.place).await.map_err(failed)?;
        stream.set_nodelay(true)?;
        match &self.tls {
            None => Ok(Box::new(stream)),
            Some(tls) => match tls.open(stream).await {
                Ok(stream) => Ok(Box::new(stream)),
                Err(source) => Err(ClientError::Handshake { address: self.place.clone(), source }),
            },
        }
    }
}
