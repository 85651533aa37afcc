//! What stands still from the start.

use maniple_geometry::{Scalar, Segment};
use serde::{Deserialize, Serialize};

use crate::event::EventKind;

/// The layers that an object or a wall is in, one bit each. Only what shares a layer can collide.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Layers(pub u32);

impl Layers {
    /// The ground.
    pub const GROUND: Self = Self(1);
    /// The air.
    pub const AIR: Self = Self(2);

    /// Returns whether there is a layer in both.
    #[must_use]
    pub fn share(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }
}

/// What a wall is, as the reason of a stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum WallKind {
    /// A wall within the world.
    Segment,
    /// The edge of the world.
    Edge,
}

impl WallKind {
    /// The event of being stopped by it.
    pub(crate) fn event(self) -> EventKind {
        match self {
            Self::Segment => EventKind::Segment,
            Self::Edge => EventKind::Edge,
        }
    }
}

/// The number of a wall in its world.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct WallId(pub u32);

/// A segment that circles of its layers collide with, from both sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wall<S: Scalar = f64> {
    /// Where it is.
    pub segment: Segment<S>,
    /// What it is.
    pub kind: WallKind,
    /// Whom it stops.
    pub layers: Layers,
}
