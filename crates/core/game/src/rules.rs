//! What a match is about; one file a rule.

mod race;

use maniple_geometry::Cycle;
use maniple_view::{EndReason, Seat};

pub(crate) use race::Race;

/// What a seat has achieved so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Units that reached the seat's zone.
    pub arrived: u32,
    /// Sum of the cycles in which they did.
    pub arrival_sum: u64,
    /// Units at the start.
    pub units: u32,
    /// Whether the seat has resigned or was forfeited.
    pub is_out: bool,
}

/// How a match ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ending {
    /// Who won; `None` is a draw.
    pub winner: Option<Seat>,
    /// Why it ended.
    pub reason: EndReason,
    /// The cycles that were played.
    pub cycles: Cycle,
}
