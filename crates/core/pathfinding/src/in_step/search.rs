//! Searches for a plan, how they go on and how they end.

use crate::in_step::board::Place;
use crate::in_step::plan::Plan;

/// A search for a plan that goes on by as much as it is told to, so that it can be spread over cycles.
pub trait Search {
    /// Expands at most so many states more, and returns how the search ended; `None` where it goes on, and then it can be asked
    /// again. What a state is depends on the planner: see [`crate::in_step::Algorithm`].
    fn advance(&mut self, budget: u64) -> Option<Outcome>;

    /// Returns how many states have been expanded.
    fn expanded(&self) -> u64;
}

/// How a search for a plan ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// There is a plan.
    Solved(Plan),
    /// There is none: all there is was looked at.
    Unsolvable,
    /// The planner cannot go on, though there may be a plan.
    Stuck,
}

impl Outcome {
    /// Returns the plan; `None` where there is none.
    #[must_use]
    pub fn plan(&self) -> Option<&Plan> {
        match self {
            Self::Solved(plan) => Some(plan),
            Self::Unsolvable | Self::Stuck => None,
        }
    }
}

/// Returns a hash of where everybody is, for tables of configurations.
pub(crate) fn hash_of(places: &[Place]) -> u64 {
    let mixed = |hash: u64, place: &Place| {
        (hash ^ u64::from(place.0)).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29)
    };
    places.iter().fold(0, mixed)
}
