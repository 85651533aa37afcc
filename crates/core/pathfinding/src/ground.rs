//! A map as circles of one radius see it.

use glam::DVec2;
use maniple_geometry::Segment;
use maniple_geometry::{Limits, predicate};
use maniple_tilemap::{SIZE_MAX, TileMap};

use crate::corners::Corners;
use crate::error::GroundError;
use crate::lattice::Lattice;
use crate::walls::Walls;

/// How much farther from walls than touching a path keeps, in world units: 2^-12, about 2.4e-4.
///
/// Kinematics decides exactly, and a leg is rounded: a velocity and the places on the way to it, by less than 1e-11 on
/// the largest map. The rest is for clients that round what they send. A gap has to be wider than the circle by twice
/// as much.
#[doc(alias = "clearance")]
pub const MARGIN: f64 = 1.0 / (1u32 << 12) as f64;

/// Largest radius that paths are planned for, in world units: each tile lists the walls within it, and the lists grow with its
/// square.
pub const RADIUS_MAX: f64 = 4.0;

/// How often a start that is nearer to walls than the margin is moved away from them; two walls need a few.
const PUSHES_MAX: u32 = 16;

/// A map as circles of one radius see it: where they have room, and which straight ways are clear. Never changes.
#[derive(Clone, Debug)]
pub struct Ground {
    width: u32,
    height: u32,
    radius: f64,
    pub(crate) reach: f64,
    pub(crate) walls: Walls,
    pub(crate) lattice: Lattice,
    pub(crate) corners: Corners,
}

impl Ground {
    /// Returns the ground for a radius in world units, with [`MARGIN`].
    ///
    /// # Errors
    /// A radius that kinematics would not take, or above [`RADIUS_MAX`].
    pub fn new(map: &TileMap, radius: f64) -> Result<Self, GroundError> {
        Self::with_margin(map, radius, MARGIN)
    }

    /// Returns the ground for a radius and another margin, both in world units.
    ///
    /// # Errors
    /// A radius that kinematics would not take, or above [`RADIUS_MAX`], or a margin that is not within `0.0..=1.0`. Below 1e-10 paths may collide.
    pub fn with_margin(map: &TileMap, radius: f64, margin: f64) -> Result<Self, GroundError> {
        let limits =
            Limits::new(f64::from(SIZE_MAX), RADIUS_MAX, 1.0).expect("the limits are within the limits");
        limits.check_radius(radius).map_err(GroundError::Radius)?;
        if !(0.0..=1.0).contains(&margin) {
            return Err(GroundError::Margin(margin));
        }
        let reach = radius + margin;
        let walls = Walls::new(map, map.segments(), reach);
        let lattice = Lattice::new(map, &walls, reach);
        let (width, height) = (map.width(), map.height());
        let corners = Corners::new(&walls, height, room(radius, reach));
        Ok(Self { width, height, radius, reach, walls, lattice, corners })
    }

    /// Returns the radius of the circles, in world units.
    #[must_use]
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Returns the width and height of the map, in tiles.
    #[must_use]
    pub fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    /// Returns whether the middle of a circle can be in a point, the margin included.
    #[must_use]
    pub fn holds(&self, point: DVec2) -> bool {
        self.is_within(point) && self.walls.holds(point)
    }

    /// Returns whether a circle can go straight from one point to another, the margin included.
    #[must_use]
    pub fn is_clear(&self, from: DVec2, to: DVec2) -> bool {
        self.holds(from) && self.is_within(to) && self.walls.is_clear(from, to)
    }

    /// How far from walls points are placed: a little more than needed, so that rounding does not take it back.
    pub(crate) fn room(&self) -> f64 {
        room(self.radius, self.reach)
    }

    /// Returns whether a point is on the map. What is no number is not.
    pub(crate) fn is_within(&self, point: DVec2) -> bool {
        self.walls.is_within(point)
    }

    /// Returns the point with all its margin that a circle goes to first from a start that touches walls or nearly does;
    /// the start itself where it has the margin. `None` where the circle overlaps something or is wedged in.
    ///
    /// Each wall in turn that is too near pushes the point straight away from itself. On the way from the start to that point
    /// the distance of each wall near the start must grow: the distance from a convex thing along a line is convex, so it is
    /// enough that it grows at the beginning.
    pub(crate) fn departure(&self, start: DVec2) -> Option<DVec2> {
        if self.walls.holds(start) {
            return Some(start);
        }
        let overlaps = |wall: &Segment| predicate::circle_overlaps_segment(start, self.radius, wall);
        if self.walls.near(start).any(overlaps) {
            return None;
        }
        let room = self.room();
        let mut point = start;
        for _ in 0..PUSHES_MAX {
            let Some(wall) = self.walls.blocker(point, point) else { break };
            let nearest = wall.nearest(point);
            let away = point - nearest;
            point = nearest + away * (room / away.length());
        }
        let leaves = |wall: &Segment| {
            let away = start - wall.nearest(start);
            away.length() >= self.reach || away.dot(point - start) > 0.0
        };
        (self.walls.holds(point) && self.walls.near(start).all(leaves)).then_some(point)
    }
}

/// How far from walls points are placed.
fn room(radius: f64, reach: f64) -> f64 {
    reach + (reach - radius) / 16.0
}
