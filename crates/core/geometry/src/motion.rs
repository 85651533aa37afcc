//! The law by which an object moves.

use crate::scalar::{Planar, Scalar};
use crate::time::{Cycle, Moment};

/// A straight motion at constant speed: the position is `start + velocity * (t - from)`, evaluated from its
/// start each time and never accumulated. An object at rest has the velocity zero.
#[doc(alias = "sweep")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion<S: Scalar = f64> {
    /// The centre at `from`, in world units.
    pub start: S::Vector,
    /// World units a cycle.
    pub velocity: S::Vector,
    /// When the object was at `start`.
    pub from: Moment,
}

impl<S: Scalar> Motion<S> {
    /// Returns the motion of an object that rests at `point` since a moment.
    pub fn at_rest(point: S::Vector, from: Moment) -> Self {
        Self { start: point, velocity: S::Vector::zero(), from }
    }

    /// Returns whether the object moves.
    #[must_use]
    pub fn is_moving(&self) -> bool {
        self.velocity != S::Vector::zero()
    }

    /// Returns the centre at the start of `cycle`: `p + v * ((k - k0) - f0)`, in this order.
    #[must_use]
    pub fn position(&self, cycle: Cycle) -> S::Vector {
        self.start + self.velocity * S::from_f64(self.from.until(cycle))
    }
}
