//! The straight piece of a wall.

use glam::DVec2;

use crate::scalar::{Planar, Scalar};

/// A straight line from `start` to `end`, in world units; the blocked side is to the right of that direction
/// (y points down, so right of +x is +y).
#[doc(alias = "wall")]
#[doc(alias = "boundary")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment<S: Scalar = f64> {
    /// Where the segment begins.
    pub start: S::Vector,
    /// Where the segment ends.
    pub end: S::Vector,
}

impl<S: Scalar> Segment<S> {
    /// Returns the segment between two points.
    pub fn new(start: S::Vector, end: S::Vector) -> Self {
        Self { start, end }
    }

    /// Returns the vector from start to end.
    #[must_use]
    pub fn direction(&self) -> S::Vector {
        self.end - self.start
    }

    /// Returns the point of the segment that is nearest to another, rounded.
    #[must_use]
    pub fn nearest(&self, point: S::Vector) -> S::Vector {
        let (e, q) = (self.direction(), point - self.start);
        let (foot, square) = (e.dot(q), e.dot(e));
        if foot <= S::ZERO {
            self.start
        } else if foot >= square {
            self.end
        } else {
            self.start + e * (foot / square)
        }
    }

    /// Returns the length in world units.
    #[must_use]
    pub fn length(&self) -> S {
        self.direction().length()
    }
}

impl Segment {
    /// Returns the segment with its end points rounded to another scalar.
    #[must_use]
    pub fn rounded<S: Scalar>(&self) -> Segment<S> {
        Segment::new(S::Vector::from_dvec2(self.start), S::Vector::from_dvec2(self.end))
    }
}

impl From<(DVec2, DVec2)> for Segment {
    fn from((start, end): (DVec2, DVec2)) -> Self {
        Self::new(start, end)
    }
}
