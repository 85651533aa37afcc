//! Where a circle goes straight ahead or rests, whenever it does.

use glam::DVec2;
use maniple_geometry::{Scalar, Segment};

/// A straight leg at constant speed, or a point to rest in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Stretch {
    /// Where the centre is at its beginning, in world units.
    pub(crate) point: DVec2,
    /// Where it is at its end, exactly.
    pub(crate) end: DVec2,
    /// World units a cycle; zero at rest.
    pub(crate) velocity: DVec2,
    /// How long a leg takes, in cycles; zero at rest, which takes any time.
    pub(crate) duration: f64,
    /// The smallest rectangle that holds it.
    pub(crate) bounds: Bounds,
}

/// A rectangle along the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    /// The corner with the smallest coordinates.
    low: DVec2,
    /// The corner with the largest.
    high: DVec2,
}

impl Stretch {
    pub(crate) fn rest(point: DVec2) -> Self {
        Self { point, end: point, velocity: DVec2::ZERO, duration: 0.0, bounds: Bounds::of(point, point) }
    }

    /// Returns a leg; its duration is positive.
    pub(crate) fn leg(from: DVec2, to: DVec2, duration: f64) -> Self {
        let velocity = (to - from) / duration;
        Self { point: from, end: to, velocity, duration, bounds: Bounds::of(from, to) }
    }

    pub(crate) fn is_moving(&self) -> bool {
        self.duration > 0.0
    }

    /// The square of its distance from a point.
    pub(crate) fn distance_squared(&self, point: DVec2) -> f64 {
        let line: Segment = Segment::new(self.point, self.end);
        line.nearest(point).distance_squared(point)
    }
}

impl Bounds {
    /// Returns the smallest that holds two points.
    pub(crate) fn of(one: DVec2, other: DVec2) -> Self {
        let low = DVec2::new(one.x.lesser(other.x), one.y.lesser(other.y));
        let high = DVec2::new(one.x.greater(other.x), one.y.greater(other.y));
        Self { low, high }
    }

    /// Returns the smallest that holds two others.
    pub(crate) fn join(self, other: Self) -> Self {
        Self { low: Self::of(self.low, other.low).low, high: Self::of(self.high, other.high).high }
    }

    /// Whether two are farther apart than `reach` along an axis.
    #[inline]
    pub(crate) fn is_far(&self, other: &Self, reach: f64) -> bool {
        self.low.x - other.high.x > reach
            || other.low.x - self.high.x > reach
            || self.low.y - other.high.y > reach
            || other.low.y - self.high.y > reach
    }
}
