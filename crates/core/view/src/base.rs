//! From what a view evaluates where an object is.

use glam::DVec2;
use maniple_geometry::{Cycle, Moment};
use serde::{Deserialize, Serialize};

/// Where an object was at a moment, and its velocity since: all that a view needs to know where it is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Base {
    /// The centre at `cycle` and `fraction`, in world units.
    pub point: DVec2,
    /// The cycle of the moment.
    pub cycle: Cycle,
    /// The fraction of that cycle, `0.0..=1.0`.
    pub fraction: f64,
    /// World units a cycle; zero for an object at rest.
    pub velocity: DVec2,
}

impl Base {
    /// Returns the base of an object that rests at `point`.
    #[must_use]
    pub fn at_rest(point: DVec2, moment: Moment) -> Self {
        Self { point, cycle: moment.cycle, fraction: moment.fraction, velocity: DVec2::ZERO }
    }

    /// Returns the base with the same line, but evaluated at the start of `cycle`: it does not tell since when
    /// the object moves.
    #[must_use]
    pub fn refreshed(&self, cycle: Cycle) -> Self {
        Self { point: self.position(cycle), cycle, fraction: 0.0, velocity: self.velocity }
    }

    /// Returns whether the object moves.
    #[must_use]
    pub fn is_moving(&self) -> bool {
        self.velocity != DVec2::ZERO
    }

    /// Returns the centre at the start of `cycle`: `p + v * ((k - k0) - f0)`.
    ///
    /// This order, without fused multiply-add, is part of the protocol: every client gets the same bits. An
    /// object at rest is at its point, whatever the cycle.
    #[must_use]
    pub fn position(&self, cycle: Cycle) -> DVec2 {
        let elapsed = Moment { cycle: self.cycle, fraction: self.fraction }.until(cycle);
        self.point + self.velocity * elapsed
    }
}
