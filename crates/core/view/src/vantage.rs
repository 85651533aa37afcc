//! What a view is of.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::identity::Seat;

/// What a view is of: all that there is, or what a seat sees.
///
/// A player has the view of a seat; a spectator either, as far as the scenario permits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Vantage {
    /// All objects, all terrain, and of the objects of all seats what else only their owner knows; of no seat the stock.
    Everything,
    /// Exactly what a seat sees.
    Seat(Seat),
}

impl Vantage {
    /// Returns the seat whose view it is; `None`: it is nobody's.
    #[must_use]
    pub fn seat(self) -> Option<Seat> {
        match self {
            Self::Everything => None,
            Self::Seat(seat) => Some(seat),
        }
    }

    /// Returns whether what only the owner knows of an object is in the view; `None`: the object is nobody's.
    pub(crate) fn owns(self, owner: Option<Seat>) -> bool {
        match self {
            Self::Everything => owner.is_some(),
            Self::Seat(seat) => owner == Some(seat),
        }
    }
}

impl From<Seat> for Vantage {
    fn from(seat: Seat) -> Self {
        Self::Seat(seat)
    }
}

impl fmt::Display for Vantage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Everything => f.write_str("everything"),
            Self::Seat(seat) => write!(f, "seat {seat}"),
        }
    }
}
