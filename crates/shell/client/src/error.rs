//! What can go wrong between a client and its server.

use std::io;

use maniple_protocol::{DecodeError, EncodeError, FrameError, PackedError, Refused};
use maniple_view::MismatchError;
use thiserror::Error;

/// Why a client cannot go on.
#[derive(Debug, Error)]
pub enum ClientError {
    /// The server cannot be reached.
    #[error("no server answers at {address}; start `maniple serve` there, or name its address")]
    Connect {
        /// The address.
        address: String,
        /// What the system says.
        source: io::Error,
    },
    /// The server does not encrypt, or is not the one that was asked for.
    #[error(
        "no TLS with {address}; does the server have it, and is its certificate for this name, from who is trusted?"
    )]
    Handshake {
        /// The address.
        address: String,
        /// What is wrong.
        source: io::Error,
    },
    /// The connection broke.
    #[error("the connection broke: {0}")]
    Broken(#[from] io::Error),
    /// The server closed the connection without a word; connect again with the same token.
    #[error("the server closed the connection without a word; connect again with the same token")]
    Closed,
    /// The server refused the client.
    #[error("the server refused: {0}")]
    Refused(Refused),
    /// The server's bytes are no frames.
    #[error("from the server: {0}")]
    Frame(#[from] FrameError),
    /// The server's frame is no message.
    #[error("from the server, {0}")]
    Decode(#[from] DecodeError),
    /// A message that does not fit into a frame.
    #[error(transparent)]
    Encode(#[from] EncodeError),
    /// The mirrored view is not the server's; connect again for a keyframe.
    #[error("{0}; connect again for a keyframe")]
    Mismatch(#[from] MismatchError),
    /// A packed delta that cannot be read; connect again for a keyframe.
    #[error("{0}; connect again for a keyframe")]
    Packed(#[from] PackedError),
    /// A message that cannot come at this place.
    #[error("the server sent {found} where {expected} was expected")]
    Unexpected {
        /// The message.
        found: &'static str,
        /// What should have come.
        expected: &'static str,
    },
}
