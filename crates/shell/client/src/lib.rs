//! The Rust client: a mirrored view over TCP.
//!
//! A [`Client`] connects, keeps a view of its own up to date with the deltas of the server, and compares the two after
//! each. [`Client::play`] runs a bot with it. A [`Spectator`] does the same without a seat, and without a say.

mod address;
mod client;
mod connection;
mod error;
mod spectator;
mod tls;

pub use address::Address;
pub use client::{Client, Login};
pub use connection::Event;
pub use error::ClientError;
pub use spectator::Spectator;
pub use tls::{Tls, TlsError};
