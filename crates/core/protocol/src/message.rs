//! What client and server say to each other.

use maniple_geometry::Cycle;
use maniple_view::{ClockMode, Delta, Digest, MatchResult, Rules, Seat, Sequenced, Terrain, Vantage};
use serde::{Deserialize, Serialize};

use crate::packed::PackedDelta;
use crate::refused::Refused;

/// The version of the protocol. It rises with every change of a message, a field or their order, so that two
/// programs with the same number understand each other, and others part at the handshake.
pub const PROTOCOL: u32 = 3;

/// What a client says.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum ClientMessage {
    /// The first message of a player, and only the first.
    Hello(Hello),
    /// Commands; they are applied in the next cycle that starts, and each is answered in a delta.
    Commands {
        /// The cycle of the last delta that the client had taken in when it decided.
        seen_cycle: Cycle,
        /// The commands, in the order in which they are to be applied.
        list: Vec<Sequenced>,
    },
    /// Lock-step: the client has said all that it wants to say in `cycle`.
    Done {
        /// The cycle of the last delta; another one has no effect.
        cycle: Cycle,
    },
    /// Asks for a pong, to measure the way there and back and to set a clock.
    Ping {
        /// A number that comes back.
        id: u32,
    },
    /// Wants the clock to stand still, or to go on.
    Pause {
        /// Whether it shall stand still: it does at the end of the cycle in which all seats that are in and have a
        /// player want it to, until one of them says otherwise.
        on: bool,
    },
    /// The first message of a spectator, and only the first; after it a spectator says nothing but `ping`.
    Watch(Watch),
    /// Asks the lobby which matches there are; before the hello or watch, and only there.
    List {
        /// The client's [`PROTOCOL`].
        protocol: u32,
    },
    /// Asks the lobby for a new match; before the hello or watch, and only there.
    Create(Create),
    /// Chooses the match that the hello or watch after it is for; before it, and only there. Without it that is the match which the
    /// server plays by itself, if it does.
    Enter {
        /// The number of the match; `match` in JSON.
        #[serde(rename = "match")]
        match_id: Digest,
        /// The open seat that a hello without a token takes; `None`: the first that is free.
        seat: Option<Seat>,
    },
}

/// Who connects. The layout of this message stays the same in every version of the protocol.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hello {
    /// The client's [`PROTOCOL`].
    pub protocol: u32,
    /// Name and version of the program, at most [`crate::NAME_MAX`] bytes; for the server's log.
    pub client: String,
    /// The player's name, 1 to [`crate::NAME_MAX`] bytes; everybody sees it.
    pub player: String,
    /// The seat's token, [`crate::TOKEN_DIGITS`] hex digits; empty where the match has open seats.
    #[serde(default)]
    pub token: String,
}

/// Who wants to watch, and what. The layout of this message stays the same in every version of the protocol, too.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Watch {
    /// The client's [`PROTOCOL`].
    pub protocol: u32,
    /// Name and version of the program, at most [`crate::NAME_MAX`] bytes; for the server's log.
    pub client: String,
    /// What it wants to watch.
    pub view: Vantage,
}

/// A match that somebody wants. The server chooses the seed, and tells it nobody.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Create {
    /// The client's [`PROTOCOL`].
    pub protocol: u32,
    /// The name of the scenario, one of those in [`ServerMessage::Matches`]; at most [`crate::NAME_MAX`] bytes.
    pub scenario: String,
    /// How time passes.
    pub clock: ClockMode,
    /// Whether anybody may take the seats; else each needs a token, which the answer holds.
    pub open: bool,
}

/// What the server says.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum ServerMessage {
    /// The answer to a hello that gets a seat and to a watch that is permitted; a keyframe follows.
    Welcome(Welcome),
    /// The last message of a connection that the server closes before the match has ended.
    Refused {
        /// Why.
        reason: Refused,
    },
    /// The change of the client's view over one cycle.
    Delta(Delta),
    /// The answer to a ping.
    Pong {
        /// The ping's number.
        id: u32,
        /// The cycle that runs; to a spectator that of its view.
        cycle: Cycle,
        /// How much of the cycle's wall-clock time has passed, `0.0..=1.0`; 0 in lock-step and in a pause.
        fraction: f64,
    },
    /// The match has ended; the last message of the connection.
    Ended {
        /// How.
        result: MatchResult,
    },
    /// As [`ServerMessage::Delta`], in few bytes; on binary connections, and only there.
    Packed(PackedDelta),
    /// Who wants a pause, and whether there is one. To all when that changes, to who asks even if it does not, and
    /// behind the keyframe of who comes when it is not none.
    Paused {
        /// The seats that want it, in their order; once there is one, those that had asked for it.
        seats: Vec<Seat>,
        /// Whether the clock stands still.
        on: bool,
    },
    /// The answer to `list`.
    Matches {
        /// The scenarios of which anybody may create a match, by name; none where nobody may.
        scenarios: Vec<String>,
        /// The matches that are played or wait for their players, in the order of their numbers.
        list: Vec<Listed>,
    },
    /// The answer to `create`.
    Created {
        /// The number of the match; `match` in JSON.
        #[serde(rename = "match")]
        match_id: Digest,
        /// By seat the token that opens it; none where all are open.
        tokens: Vec<String>,
    },
    /// The client is too far behind for deltas: it drops its view, and starts anew with one that is empty but for the terrain of
    /// the welcome. The delta that follows is a keyframe.
    Keyframe {},
    /// The client broke a rule, and what it said was dropped; the connection goes on.
    Warned {
        /// Which rule.
        reason: Refused,
        /// How often it may still do so; the time after that is the last, and closes the connection.
        left: u32,
    },
}

impl ServerMessage {
    /// Returns what it is, for a message about one that came at the wrong place.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Welcome(_) => "a welcome",
            Self::Refused { .. } => "a refusal",
            Self::Delta(_) | Self::Packed(_) => "a delta",
            Self::Pong { .. } => "a pong",
            Self::Ended { .. } => "the end",
            Self::Paused { .. } => "a pause",
            Self::Matches { .. } => "a list of matches",
            Self::Created { .. } => "a new match",
            Self::Keyframe {} => "the announcement of a keyframe",
            Self::Warned { .. } => "a warning",
        }
    }
}

/// A match in the lobby, as everybody may know of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Listed {
    /// The number of the match; `match` in JSON.
    #[serde(rename = "match")]
    pub match_id: Digest,
    /// The scenario's name.
    pub scenario: String,
    /// How time passes.
    pub clock: ClockMode,
    /// Cycles a second.
    pub rate: f64,
    /// Whether all seats have been joined.
    pub has_begun: bool,
    /// By seat.
    pub seats: Vec<ListedSeat>,
    /// What spectators may watch; `None`: nothing.
    pub spectators: Option<ListedSpectators>,
}

/// A seat of a match in the lobby.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ListedSeat {
    /// Whether it needs no token.
    pub open: bool,
    /// Whether a player sits there.
    pub taken: bool,
}

/// What spectators of a match in the lobby may watch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ListedSpectators {
    /// Whether that is everything, too, and not seats alone.
    pub everything: bool,
    /// Cycles by which they are behind.
    pub delay: u32,
}

/// All that a client needs to know before the first delta.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Welcome {
    /// The number of the match; `match` in JSON.
    #[serde(rename = "match")]
    pub match_id: Digest,
    /// The seat whose view it is: the client's own, or, of a spectator, the one that is watched; `None`: everything is.
    pub seat: Option<Seat>,
    /// By how many cycles a spectator is behind the match; `None`: the client is the player at the seat.
    pub delay: Option<u32>,
    /// How many seats the match has.
    pub seats: u16,
    /// The cycle of the keyframe that follows; to a spectator it comes when the match is old enough.
    pub cycle: Cycle,
    /// Cycles a second; in lock-step the rate at which a viewer would show the match.
    pub rate: f64,
    /// How time passes.
    pub clock: ClockMode,
    /// Every constant of the match.
    pub rules: Rules,
    /// The terrain that the seat knows at `cycle`.
    pub terrain: Terrain,
}
