//! What has to be kept of a match so that it can be played again, to the same hashes.

use maniple_geometry::Cycle;
use maniple_view::{Digest, MatchResult, Seat, Sequenced};
use thiserror::Error;

/// Something that happened in a match, in the order in which it did.
#[doc(alias = "demo")]
#[derive(Clone, Debug, PartialEq)]
pub enum RecordedEvent {
    /// A player came to a seat for the first time.
    Joined {
        /// The cycle at whose start the match was.
        cycle: Cycle,
        /// The seat.
        seat: Seat,
        /// The player's name.
        name: String,
    },
    /// Commands were applied or refused; those that were refused are here too, so that results repeat.
    Commands {
        /// The cycle at whose start they were.
        cycle: Cycle,
        /// The seat that gave them.
        seat: Seat,
        /// The last cycle that the client had seen.
        seen_cycle: Cycle,
        /// The commands, in the order in which they came.
        commands: Vec<Sequenced>,
    },
    /// A seat lost by decision of the referee or of who runs it, before the commands of the cycle.
    Forfeited {
        /// The cycle.
        cycle: Cycle,
        /// The seat.
        seat: Seat,
    },
    /// The state at the start of a cycle; the first is that of cycle 0.
    Hash {
        /// The cycle.
        cycle: Cycle,
        /// The state hash.
        hash: Digest,
    },
    /// The match has ended.
    Ended {
        /// How.
        result: MatchResult,
    },
}

/// A record that does not lead to what it says.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ReplayError {
    /// The match comes out differently.
    #[error("at the start of cycle {cycle} the state hashes to {found}, the record says {expected}")]
    Hash {
        /// The first cycle that differs.
        cycle: Cycle,
        /// The hash that was recorded.
        expected: Digest,
        /// The hash now.
        found: Digest,
    },
    /// The match ends differently, or not where the record says.
    #[error("the match came to {found:?}, the record says {expected:?}")]
    Result {
        /// The result that was recorded; `None` where the record goes on.
        expected: Option<Box<MatchResult>>,
        /// The result now; `None` where the match goes on.
        found: Option<Box<MatchResult>>,
    },
    /// A record that cannot be at this place.
    #[error("at cycle {now} the record {problem}")]
    Order {
        /// The cycle at whose start the match is.
        now: Cycle,
        /// What is wrong with the record.
        problem: &'static str,
    },
    /// A seat that the match does not have.
    #[error("the record names seat {seat}, the match has {seats}")]
    Seat {
        /// The seat.
        seat: Seat,
        /// How many seats there are.
        seats: usize,
    },
}
