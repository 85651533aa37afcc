//! The Rust client: a mirrored view over TCP.
//!
//! A [`Client`] connects, keeps a view of its own up to date with the deltas of the server, and compares the two after
//! each. [`Client::play`] runs a bot with it. A [`Spectator`] does the same without a seat, and without a say.
//! A [`Lobby`] asks a server which matches it has, and for new ones.

mod client;
mod connection;
mod destination;
mod error;
mod lobby;
mod spectator;

pub use client::{Client, Login};
pub use connection::Event;
pub use destination::{Destination, Stream};
pub use error::ClientError;
pub use lobby::{Created, Lobby, Matches};
pub use spectator::Spectator;
