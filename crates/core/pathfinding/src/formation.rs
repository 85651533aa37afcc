//! Formations: where each of many stands around one point.

use glam::DVec2;
use maniple_geometry::Scalar;
use thiserror::Error;

use crate::error::PlanError;
use crate::ground::{Ground, MARGIN};
use crate::planner::Planner;
use crate::release::last_narrow_place;

/// How far slots are apart, in diameters: so much that everybody can leave between the others' edges.
const APART: f64 = 1.25;

/// How far around a slot another is looked for where it has no room, in half the distance of slots.
const RINGS_MAX: i32 = 24;

/// Distance of the points of a path at which it is tried to form up, in world units.
const STEP: f64 = 0.5;

/// A shape in which units stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Formation {
    /// Side by side, the anchor in the middle.
    Line,
    /// One behind the other, the first at the anchor.
    Column,
    /// Two arms that trail behind the first at the anchor; of an even number the last one stands between their ends.
    Wedge,
    /// Ranks as wide as deep or one wider, the middle of the first at the anchor; the last may be shorter.
    Box,
}

/// Why units cannot form up.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum FormationError {
    /// The anchor is no place for a circle.
    #[error("the anchor ({}, {}) is blocked or off the map; choose a point with room", point.x, point.y)]
    Anchor {
        /// The anchor.
        point: DVec2,
    },
    /// Around a slot no other is free.
    #[error("slot {slot} of {count} finds no room near the anchor; choose another anchor, or lead fewer")]
    NoRoom {
        /// The slot.
        slot: usize,
        /// How many there are.
        count: usize,
    },
    /// There is no way to go.
    #[error(transparent)]
    Path(#[from] PlanError),
}

impl Formation {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Line, Self::Column, Self::Wedge, Self::Box];

    /// Returns how far neighbouring slots are apart, in world units, for circles of a radius.
    #[must_use]
    pub fn distance(radius: f64) -> f64 {
        2.0 * APART * radius + 2.0 * MARGIN
    }

    /// Returns the slots of so many circles, in world units: those in front first. The anchor is the middle of the front; `facing` is a
    /// unit vector. The shape is its own image in the line through the anchor along `facing`.
    ///
    /// # Panics
    /// With a `facing` that is no unit vector.
    #[must_use]
    pub fn slots(self, anchor: DVec2, facing: DVec2, count: usize, radius: f64) -> Vec<DVec2> {
        assert!((facing.length_squared() - 1.0).abs() < 1e-6, "facing is a unit vector");
        let distance = Self::distance(radius);
        let across = facing.perp();
        let point =
            |(aside, behind): (f64, f64)| anchor + across * (aside * distance) - facing * (behind * distance);
        self.places(count).into_iter().map(point).collect()
    }

    /// The slots, in distances: how far aside, and how far behind.
    fn places(self, count: usize) -> Vec<(f64, f64)> {
        match self {
            Self::Line => rank(count, 0.0).collect(),
            Self::Column => (0..count).map(|behind| (0.0, behind as f64)).collect(),
            Self::Wedge => {
                let arms = count.saturating_sub(1) / 2;
                let mut places: Vec<(f64, f64)> = (0..count.min(1)).map(|_| (0.0, 0.0)).collect();
                places.extend(
                    (1..=arms).flat_map(|arm| [(-(arm as f64), arm as f64), (arm as f64, arm as f64)]),
                );
                let is_even = count > 1 && count.is_multiple_of(2);
                places.extend(is_even.then_some((0.0, arms.max(1) as f64)));
                places
            }
            Self::Box => {
                let root = count.isqrt();
                let width = if root * root < count { root + 1 } else { root };
                let ranks = count.div_ceil(width.max(1));
                (0..ranks).flat_map(|behind| rank(width.min(count - behind * width), behind as f64)).collect()
            }
        }
    }

    /// Returns the slots on a ground. A slot without room, or from which the anchor cannot be reached, is moved to the nearest point of a
    /// lattice of half the distance that has both and is free.
    ///
    /// # Errors
    /// An anchor without room, or a slot without any near it.
    ///
    /// # Panics
    /// As [`Self::slots`].
    pub fn slots_on(
        self,
        ground: &Ground,
        anchor: DVec2,
        facing: DVec2,
        count: usize,
    ) -> Result<Vec<DVec2>, FormationError> {
        if !ground.holds(anchor) {
            return Err(FormationError::Anchor { point: anchor });
        }
        let mut planner = Planner::new(ground);
        let mut slots = self.slots(anchor, facing, count, ground.radius());
        let mut is_good = |slot: DVec2| ground.holds(slot) && planner.connects(anchor, slot);
        let moved: Vec<usize> = (0..count).filter(|&slot| !is_good(slots[slot])).collect();
        let mut is_settled = vec![true; count];
        for &slot in &moved {
            is_settled[slot] = false;
        }
        let step = 0.5 * Self::distance(ground.radius());
        let apart = 2.0 * ground.radius() + 2.0 * MARGIN;
        let around = around();
        for slot in moved {
            let from = slots[slot];
            let point =
                |&(x, y): &(i32, i32)| from + (facing.perp() * f64::from(x) + facing * f64::from(y)) * step;
            let is_free = |point: &DVec2| {
                let settled = slots.iter().zip(&is_settled).filter(|(_, is_settled)| **is_settled);
                settled.into_iter().all(|(other, _)| other.distance_squared(*point) >= apart * apart)
            };
            let found = around.iter().map(point).find(|point| is_free(point) && is_good(*point));
            slots[slot] = found.ok_or(FormationError::NoRoom { slot, count })?;
            is_settled[slot] = true;
        }
        Ok(slots)
    }

    /// Returns the goals of so many circles that go from one point to another, stage by stage: behind the last narrow place on the way,
    /// as soon as all slots have room there, and at the end. In each they face where the way leads.
    ///
    /// # Errors
    /// As [`Self::slots_on`], or no path.
    pub fn march(
        self,
        ground: &Ground,
        from: DVec2,
        to: DVec2,
        count: usize,
    ) -> Result<Vec<Vec<DVec2>>, FormationError> {
        let mut planner = Planner::new(ground);
        let legs = planner.path(from, to)?.to_vec();
        let mut stages = Vec::new();
        if let Some(narrow) = last_narrow_place(ground, from, &legs) {
            stages.extend(self.first_room(ground, (from, &legs), narrow, count));
        }
        let before = legs.len().checked_sub(2).map_or(from, |index| legs[index]);
        let facing = (to - before).normalize_or(DVec2::X);
        stages.push(self.slots_on(ground, to, facing, count)?);
        Ok(stages)
    }

    /// The slots at the first point of a path behind a place at which all have room and nobody stands before that place.
    fn first_room(
        self,
        ground: &Ground,
        (from, legs): (DVec2, &[DVec2]),
        narrow: DVec2,
        count: usize,
    ) -> Option<Vec<DVec2>> {
        let distance = Self::distance(ground.radius());
        let mut planner = Planner::new(ground);
        let mut at = from;
        let mut is_behind = false;
        for &goal in legs {
            let length = at.distance(goal);
            let facing = (goal - at) / length.greater(f64::MIN_POSITIVE);
            let mut along = 0.0;
            while along < length {
                let anchor = at + facing * along;
                along += STEP;
                is_behind |= anchor.distance(narrow) < STEP;
                if !is_behind {
                    continue;
                }
                let slots = self.slots(anchor, facing, count, ground.radius());
                let mut has_room = |&slot: &DVec2| {
                    (slot - narrow).dot(facing) >= distance
                        && ground.holds(slot)
                        && planner.connects(anchor, slot)
                };
                if slots.iter().all(&mut has_room) {
                    return Some(slots);
                }
            }
            at = goal;
        }
        None
    }
}

/// So many side by side.
fn rank(count: usize, behind: f64) -> impl Iterator<Item = (f64, f64)> {
    (0..count).map(move |place| (place as f64 - 0.5 * (count as f64 - 1.0), behind))
}

/// The points of a lattice around one, the nearest first.
fn around() -> Vec<(i32, i32)> {
    let side = -RINGS_MAX..=RINGS_MAX;
    let mut points: Vec<(i32, i32)> = side.clone().flat_map(|y| side.clone().map(move |x| (x, y))).collect();
    points.sort_by_key(|&(x, y)| (x * x + y * y, y, x));
    points
}
