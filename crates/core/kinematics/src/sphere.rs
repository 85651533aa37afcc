//! The circle that holds every point an object passes in its motion.

use maniple_geometry::{Planar, Scalar};

use crate::track::Stage;

/// A circle that holds every point that an object, with its radius, passes in a cycle, for all legs and pauses.
#[doc(alias = "bound")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MotionSphere<S: Scalar> {
    pub(crate) center: S::Vector,
    pub(crate) radius: S,
}

impl<S: Scalar> MotionSphere<S> {
    /// Returns the sphere around the bounding box of the track's corners, `margin` larger than needed: it takes in
    /// the skin, and the rounding of the sphere itself, which is far below it.
    pub(crate) fn around(stages: &[Stage<S>], radius: S, margin: S) -> Self {
        let corners =
            || stages.iter().flat_map(|stage| [stage.piece.point, stage.piece.position(stage.piece.until)]);
        let mut low = stages[0].piece.point;
        let mut high = low;
        for corner in corners() {
            low = S::Vector::new(low.x().lesser(corner.x()), low.y().lesser(corner.y()));
            high = S::Vector::new(high.x().greater(corner.x()), high.y().greater(corner.y()));
        }
        let center = low + (high - low) * S::from_f64(0.5);
        let mut square = S::ZERO;
        for corner in corners() {
            let offset = corner - center;
            square = square.greater(offset.dot(offset));
        }
        Self { center, radius: square.sqrt() + radius + margin }
    }

    /// Returns whether two spheres intersect: `|c - d|² <= (R + S)²`, which needs no root. The margins of both
    /// outweigh the rounding.
    pub(crate) fn intersects(&self, other: &Self) -> bool {
        let offset = other.center - self.center;
        let reach = self.radius + other.radius;
        offset.dot(offset) <= reach * reach
    }
}
