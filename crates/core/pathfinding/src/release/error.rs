//! Why there is no schedule.

use glam::DVec2;
use thiserror::Error;

use crate::error::PlanError;

/// Why there is no schedule.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum ReleaseError {
    /// A group has not as many goals as circles.
    #[error("group {group} has {circles} circles and {goals} goals; give each circle one goal")]
    Goals {
        /// The place of the group in the request.
        group: usize,
        /// Its circles.
        circles: usize,
        /// Its goals.
        goals: usize,
    },
    /// A circle has no path.
    #[error(transparent)]
    Path(#[from] PlanError),
    /// A circle would meet others whenever it departed.
    #[error(
        "circle {circle} of group {group} in ({}, {}) finds no departure without meeting others; give it another goal, or plan in \
         steps",
        from.x, from.y
    )]
    NoDeparture {
        /// The place of the group in the request.
        group: usize,
        /// The place of the circle in its group.
        circle: usize,
        /// Where it is.
        from: DVec2,
    },
}
