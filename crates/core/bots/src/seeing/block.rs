//! What stands on the ground.

use glam::DVec2;

/// Something that stands on the ground and does not move: a rectangle around it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Block {
    /// World units.
    pub(crate) center: DVec2,
    /// Half of its width and height, in world units.
    pub(crate) half: DVec2,
}

/// Returns the point of a block that is nearest to a point.
pub(crate) fn nearest_point(block: &Block, point: DVec2) -> DVec2 {
    let within = |value: f64, low: f64, high: f64| {
        if value < low {
            low
        } else if value > high {
            high
        } else {
            value
        }
    };
    let (low, high) = (block.center - block.half, block.center + block.half);
    DVec2::new(within(point.x, low.x, high.x), within(point.y, low.y, high.y))
}
