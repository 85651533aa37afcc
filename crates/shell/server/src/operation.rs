//! What is seen of the daemon, and done to it, from outside of the protocol: health, metrics, administration, and the
//! service manager.

#[cfg(unix)]
pub mod administration;
#[cfg(test)]
mod double;
mod house;
pub mod http;
#[cfg(unix)]
pub mod systemd;

use std::net::IpAddr;
use std::pin::Pin;
use std::time::Duration;

use maniple_protocol::Refused;
use maniple_view::{ClockMode, Digest, Seat};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::metrics::Spread;
use crate::settings::Limits;

/// What can be operated: the daemon, as seen from here. Nothing in it waits for a match.
pub trait Operated: Send + Sync + 'static {
    /// Returns how it is.
    fn health(&self) -> Health;

    /// Returns the matches that are open or run, ordered by their number.
    fn matches(&self) -> Vec<MatchStatus>;

    /// Creates a match of one of the scenarios.
    ///
    /// # Errors
    /// No such scenario, or no room.
    fn create(&self, wanted: Wanted) -> Creating<'_>;

    /// Halts the clock of a match, or lets it go on.
    ///
    /// # Errors
    /// No such match.
    fn pause(&self, id: Digest, clock: Clock) -> Result<(), OperationError>;

    /// Breaks a match off; its players are told.
    ///
    /// # Errors
    /// No such match.
    fn end(&self, id: Digest) -> Result<(), OperationError>;

    /// Closes the connection at a seat; the player may come back.
    ///
    /// # Errors
    /// No such match or seat, or nobody sits there.
    fn kick(&self, id: Digest, seat: Seat) -> Result<(), OperationError>;

    /// Lets connections from an address in no more, and closes those that there are; or lets them in again. It is not kept
    /// when the daemon ends.
    ///
    /// # Errors
    /// More are banned than can be kept in mind.
    fn ban(&self, address: IpAddr, entry: Entry) -> Result<(), OperationError>;

    /// Lets matches that run come to their end, creates no new ones, and ends the daemon then.
    fn drain(&self);

    /// Puts other limits into force. Who is in stays in.
    fn change_limits(&self, limits: Limits);
}

/// The future of [`Operated::create`].
pub type Creating<'a> = Pin<Box<dyn Future<Output = Result<CreatedMatch, OperationError>> + Send + 'a>>;

/// A match that is wanted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Wanted {
    /// The name of its scenario.
    pub scenario: String,
    /// How time passes in it.
    pub clock: ClockMode,
    /// Who may take its seats.
    pub seats: Seats,
}

/// Who may take the seats of a match.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Seats {
    /// Whoever has the token of a seat.
    Tokens,
    /// Whoever comes.
    Open,
}

/// A match that was created.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct CreatedMatch {
    /// Its number.
    #[serde(rename = "match")]
    pub id: Digest,
    /// By seat the token that opens it; none where all are open.
    pub tokens: Vec<String>,
}

/// How a daemon is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Health {
    /// It takes new matches and players.
    Ready,
    /// It begins: journals are read.
    Starting,
    /// It takes no new matches; those that run go on.
    Draining,
    /// A match has waited for its turn for [`STUCK_AFTER`], or has one that lasts as long.
    Stuck,
}

/// Time after which a daemon is stuck: hundreds of cycles of the usual length, far more than the largest map takes.
pub const STUCK_AFTER: Duration = Duration::from_secs(30);

impl Health {
    /// Returns whether it does its work: if not, it is best started again.
    #[must_use]
    pub fn is_alive(self) -> bool {
        match self {
            Self::Ready | Self::Starting | Self::Draining => true,
            Self::Stuck => false,
        }
    }

    /// Returns whether it can be given new matches and players.
    #[must_use]
    pub fn is_ready(self) -> bool {
        match self {
            Self::Ready => true,
            Self::Starting | Self::Draining | Self::Stuck => false,
        }
    }
}

/// A match as operators see it: nothing that only players may know.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MatchStatus {
    /// Its number.
    #[serde(rename = "match")]
    pub id: Digest,
    /// The name of its scenario.
    pub scenario: String,
    /// How time passes in it.
    pub clock: ClockMode,
    /// Where it is.
    pub phase: Phase,
    /// The cycle.
    pub cycle: u32,
    /// Seats.
    pub seats: u16,
    /// Seats with a connection.
    pub players: u16,
    /// Connections that watch.
    pub spectators: u32,
    /// How its cycles keep their time since this daemon plays it, in milliseconds; zeros for what there was none of.
    pub timings_ms: MatchTimings,
}

/// How the cycles of a match keep their time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct MatchTimings {
    /// What a cycle takes.
    pub cycle: Spread,
    /// By how much it begins later than it is due, in real time.
    pub lateness: Spread,
    /// By how much two cycles are farther apart, or nearer, than the period, in real time.
    pub jitter: Spread,
}

/// Where a match is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Phase {
    /// Not all seats have been joined.
    Open,
    /// It is played.
    Running,
    /// The clock stands still.
    Paused,
}

/// What the clock of a match shall do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Clock {
    /// Stand still.
    Halt,
    /// Go on.
    GoOn,
}

/// Whether an address is let in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Entry {
    /// It is not.
    Denied,
    /// It is.
    Allowed,
}

/// Why something cannot be done.
#[derive(Clone, Debug, Error, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OperationError {
    /// A match cannot be created.
    #[error("{reason}")]
    NotCreated {
        /// Why not.
        reason: Refused,
    },
    /// There is no such match.
    #[error("there is no match {id}; `list` has those that there are")]
    NoSuchMatch {
        /// The number asked for.
        id: Digest,
    },
    /// The match has no such seat.
    #[error("the match has {seats} seats, counted from 0, and not this one; name one of them")]
    NoSuchSeat {
        /// How many it has.
        seats: u16,
    },
    /// Nobody sits there.
    #[error("nobody is at seat {seat}")]
    NobodyThere {
        /// The seat.
        seat: Seat,
    },
    /// Too many addresses are banned.
    #[error(
        "{limit} addresses are banned, and no more can be; allow one of them, or close the door before the daemon"
    )]
    TooManyBans {
        /// The largest number.
        limit: usize,
    },
}
