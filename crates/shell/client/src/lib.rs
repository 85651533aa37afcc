//! The Rust client: a mirrored view over TCP.
//!
//! A [`Client`] connects, keeps a view of its own up to date with the deltas of the server, and compares the two after
//! each. [`Client::play`] runs a bot with it.

mod client;
mod error;

pub use client::{Client, Event, Login};
pub use error::ClientError;
