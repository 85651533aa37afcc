//! Why the server closes a connection.

use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Why a connection is refused or closed.
///
/// Place, name and layout of `Protocol` stay the same in every version of the protocol.
#[derive(Clone, Debug, Error, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Refused {
    /// The client speaks another version.
    #[error("this server speaks protocol {supported}; use a client that does")]
    Protocol {
        /// The server's version.
        supported: u32,
    },
    /// Something of a match came before the hello or watch, or something of the lobby or a second one after it.
    #[error("`hello` or `watch` comes first and once; before it, only `list`, `create` and `enter`")]
    Handshake,
    /// The hello did not come in time.
    #[error("`hello` did not come within {seconds} seconds; send it at once")]
    Timeout {
        /// The time that it had, in seconds.
        seconds: u32,
    },
    /// A name in the hello is too long.
    #[error("the names `client` and `player` have at most {limit} bytes; shorten them")]
    NameTooLong {
        /// The largest number of bytes.
        limit: u32,
    },
    /// The token opens no seat, or one is needed.
    #[error("the token opens no seat; give the 32 hex digits of a seat of this match")]
    Token,
    /// All seats are taken.
    #[error("no seat is free; wait for the next match, or give the token of your seat")]
    Full,
    /// Another connection came with the same token.
    #[error("another connection with the same token took the seat over; use a token once at a time")]
    Replaced,
    /// Bytes that are no message.
    #[error("{place}: {problem}")]
    Malformed {
        /// Which message and where in it.
        place: String,
        /// What is wrong there.
        problem: String,
    },
    /// A message that is too long.
    #[error("a message has at most {limit} bytes here; send several shorter ones")]
    TooLarge {
        /// The largest number of bytes, without length or line end.
        limit: u32,
    },
    /// The client does not read what the server sends.
    #[error("the client reads more slowly than the match goes on; read faster, then connect again")]
    TooSlow,
    /// The server goes down.
    #[error("the server shuts down; connect again later with the same token")]
    Shutdown,
    /// The scenario lets nobody watch.
    #[error("the scenario of this match lets nobody watch")]
    NoSpectators,
    /// The scenario lets nobody watch everything.
    #[error("the scenario of this match permits to watch a seat, but not everything; name a seat")]
    SeatsOnly,
    /// A seat that the match does not have.
    #[error("the match has {seats} seats, counted from 0, and not this one; name one of them")]
    NoSuchSeat {
        /// How many seats there are.
        seats: u16,
    },
    /// There are as many spectators as there may be.
    #[error("{limit} spectators watch already, and no more may; wait until one has gone")]
    SpectatorsFull {
        /// The largest number.
        limit: u32,
    },
    /// A spectator said something that only a player may.
    #[error("a spectator says nothing but `ping`; to play, connect with `hello`")]
    Spectator,
    /// More has happened than the server holds back for spectators.
    #[error("more has happened in this match than is held back for spectators; watch its replay")]
    HeldTooMuch,
    /// The match was broken off by a mistake of the server or of its disk.
    #[error(
        "the match was broken off by a fault of the server, which its log tells; what was played is kept"
    )]
    Broken,
    /// There is no such match.
    #[error("the server has no such match, or has no more; ask it with `list`, and name one with `enter`")]
    NoMatch,
    /// A client may not create a match of this scenario.
    #[error("clients of this server create no match of this scenario; choose one of those that `list` names")]
    NoScenario,
    /// There are as many matches as there may be.
    #[error("there are {limit} matches, and no more may be; wait until one has ended")]
    MatchesFull {
        /// The largest number.
        limit: u32,
    },
    /// The address has as many matches or connections as one may have.
    #[error("this address has {limit} of these already, and no more may be; end one first")]
    AddressFull {
        /// The largest number.
        limit: u32,
    },
    /// The server takes no new matches.
    #[error("the server takes no new matches, because it will go down or cannot keep them; try later")]
    Draining,
    /// The players of a match did not come in time.
    #[error("the match has not begun within {seconds} seconds, and was given up; create another")]
    NotBegun {
        /// The time that it had, in seconds.
        seconds: u32,
    },
    /// Too much was asked of the lobby.
    #[error("a connection asks the lobby at most {limit} times; say `hello` or `watch`, or connect again")]
    AsksTooMuch {
        /// The largest number.
        limit: u32,
    },
    /// Whoever runs the server wants it so.
    #[error("whoever runs the server has closed this connection, or ended this match; ask them")]
    Operator,
    /// More commands than may wait for a cycle.
    #[error("at most {limit} commands of a seat may wait for a cycle; send fewer")]
    TooManyCommands {
        /// The largest number.
        limit: u32,
    },
}
