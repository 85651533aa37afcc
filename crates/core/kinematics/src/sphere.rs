//! The circle that holds every point an object passes in its motion.

use glam::DVec2;
use maniple_geometry::{Planar, Scalar};

use crate::track::Stage;

/// Room for rounding, as a share: 2^-20. The conversions to `f32` and the test of two spheres err by a few 2^-24.
const ROUNDING: f64 = 1.0 / (1u32 << 20) as f64;

/// A circle that holds every point that an object, with its radius, passes in a cycle, for all legs and pauses. In
/// single precision, relative to an anchor, and rounded outwards: spheres only sort out what surely cannot meet.
#[doc(alias = "bound")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MotionSphere {
    pub(crate) x: f32,
    pub(crate) y: f32,
    pub(crate) radius: f32,
}

impl MotionSphere {
    /// Returns a sphere that holds the one around `center`, relative to the anchor.
    #[inline]
    pub(crate) fn outward(center: DVec2, radius: f32) -> Self {
        let slack = narrowed((center.x.abs() + center.y.abs()) * ROUNDING);
        Self { x: narrowed(center.x), y: narrowed(center.y), radius: radius + slack }
    }

    /// Returns the sphere around the bounding box of a track's corners; `margin` takes in the skin.
    pub(crate) fn around<S: Scalar>(stages: &[Stage<S>], radius: S, margin: S, anchor: DVec2) -> Self {
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
        let reach = outward_radius((square.sqrt() + radius + margin).to_f64());
        Self::outward(center.to_dvec2() - anchor, reach)
    }
}

/// Returns the radius of the motion sphere of a whole cycle on one straight piece: half the way, the radius and
/// `margin`, which takes in the skin.
pub(crate) fn straight_reach<S: Scalar>(velocity: S::Vector, radius: S, margin: S) -> f32 {
    outward_radius((velocity.length() * S::from_f64(0.5) + radius + margin).to_f64())
}

pub(crate) fn outward_radius(radius: f64) -> f32 {
    narrowed(radius * (1.0 + 2.0 * ROUNDING))
}

#[expect(clippy::cast_possible_truncation, reason = "the rounding is what the room is for")]
pub(crate) fn narrowed(number: f64) -> f32 {
    number as f32
}
