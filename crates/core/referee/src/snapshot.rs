//! All that decides what a match does and tells next, as plain data.

use maniple_game::{Loaded, WorldError, WorldSnapshot};
use maniple_geometry::Cycle;
use maniple_view::{Digest, MismatchError, Seat, TrackerSnapshot, Vantage};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::bank::BanksSnapshot;
use crate::pause::Agreement;
use crate::stand::StandsSnapshot;

/// All that decides what a match does and tells next, at the start of a cycle; see [`crate::Referee::snapshot`].
///
/// Who is connected, and commands that wait for the cycle, are not in it: players come back, and what they say comes from the
/// record or from themselves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Snapshot {
    /// What the match is made of.
    pub(crate) origin: Digest,
    pub(crate) world: WorldSnapshot,
    pub(crate) seats: Vec<SeatSnapshot>,
    pub(crate) banks: BanksSnapshot,
    pub(crate) agreement: Agreement,
    pub(crate) stands: StandsSnapshot,
    /// Who sees everything; `None` where that is not watched.
    pub(crate) overseer: Option<TrackerSnapshot>,
}

/// What is kept of a seat.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SeatSnapshot {
    /// Empty until a player has come.
    pub(crate) name: String,
    pub(crate) tracker: TrackerSnapshot,
}

impl Snapshot {
    /// Returns the cycle at whose start it was taken.
    #[must_use]
    pub fn cycle(&self) -> Cycle {
        self.world.cycle()
    }

    /// Checks that it is one of this match.
    ///
    /// # Errors
    /// [`ResumeError::Origin`].
    pub fn check_origin(&self, loaded: &Loaded) -> Result<(), ResumeError> {
        let (expected, found) = (loaded.origin(), self.origin);
        if expected == found { Ok(()) } else { Err(ResumeError::Origin { expected, found }) }
    }

    /// Returns the state hash at the start of that cycle.
    #[must_use]
    pub fn hash(&self) -> Digest {
        self.world.hash()
    }
}

/// A snapshot from which a match cannot go on.
#[derive(Debug, Error)]
pub enum ResumeError {
    /// A snapshot of another match.
    #[error(
        "the snapshot is of another match: it was made of {found}, this one is of {expected}; load the files of its replay"
    )]
    Origin {
        /// What this match is made of; see [`maniple_game::Loaded::origin`].
        expected: Digest,
        /// What the match of the snapshot was made of.
        found: Digest,
    },
    /// The world.
    #[error("the snapshot's world: {0}")]
    World(#[from] maniple_game::RestoreError),
    /// What a view is told.
    #[error("the snapshot's view of {vantage}: {problem}")]
    View {
        /// Whose view.
        vantage: Vantage,
        /// What is wrong with it.
        problem: maniple_view::RestoreError,
    },
    /// What spectators see.
    #[error("the snapshot's stands: {0}")]
    Stand(#[from] MismatchError),
    /// A stand of a seat that the match does not have, of everything without who sees it, or with something held back that
    /// does not lead to what is seen now.
    #[error("the snapshot's stands hold something of {0} that the match does not lead to")]
    Vantage(Vantage),
    /// The name of a player.
    #[error("the snapshot's seat {seat} has a name that cannot be one")]
    Name {
        /// The seat.
        seat: Seat,
    },
    /// Time banks, wishes for a pause or views of another number of seats.
    #[error("the snapshot is of another number of seats than the {seats} of the match")]
    Seats {
        /// How many the match has.
        seats: usize,
    },
}

impl From<WorldError> for ResumeError {
    fn from(error: WorldError) -> Self {
        Self::World(error.into())
    }
}
