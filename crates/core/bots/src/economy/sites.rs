//! Where there is room for a building.

use glam::DVec2;
use maniple_pathfinding::Ground;
use maniple_view::UnitType;

use super::town::ROOM;
use crate::seeing::{Block, Item, Scene, nearest_point};

/// Room that is left around a new building, in world units, so that units get through.
const STREET: f64 = 1.0;

/// Room that is left around patches and the ways to them, in world units, so that workers get there.
const YARD: f64 = 1.0;

/// Farthest place of a new building from the one at home, in tiles.
const REACH: i32 = 18;

/// Distance of the points at which it is looked whether there is room, as a part of the radius of a worker: discs on a lattice with this
/// distance cover it.
const STEP: f64 = 1.4;

/// What is known of the ground of a town.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sites<'a, 'b> {
    pub(crate) ground: &'b Ground,
    pub(crate) scene: &'b Scene<'a>,
    /// Ways that have to stay free, as their two ends.
    pub(crate) lanes: &'b [(DVec2, DVec2)],
    /// Where building has failed.
    pub(crate) spoiled: &'b [DVec2],
}

impl Sites<'_, '_> {
    /// Returns the centre nearest to home for a building that has room around it and leaves the ways free; `None` where there is none.
    pub(crate) fn nearest(&self, kind: &UnitType, home: DVec2) -> Option<DVec2> {
        let half = kind.shape.half() + DVec2::splat(kind.shape.rounding());
        let corners =
            (-REACH..=REACH).flat_map(|y| (-REACH..=REACH).map(move |x| (f64::from(x), f64::from(y))));
        let center = |(x, y)| (home + DVec2::new(x, y)).floor() + half;
        let mut centers: Vec<DVec2> = corners.map(center).collect();
        centers.sort_by(|one, other| {
            (one.distance_squared(home).total_cmp(&other.distance_squared(home)))
                .then(one.y.total_cmp(&other.y))
                .then(one.x.total_cmp(&other.x))
        });
        centers.into_iter().find(|&center| {
            !self.spoiled.contains(&center)
                && self.leaves_ways(center, half)
                && !self.is_occupied(center, half)
                && self.has_room(center, half)
        })
    }

    fn leaves_ways(&self, center: DVec2, half: DVec2) -> bool {
        let is_near = |point: DVec2| {
            let beyond = (point - center).abs() - half;
            beyond.x < YARD && beyond.y < YARD
        };
        let crosses = |&(from, to): &(DVec2, DVec2)| {
            let mut along = 0.0;
            while along < 1.0 {
                if is_near(from + (to - from) * along) {
                    return true;
                }
                along += 0.125;
            }
            is_near(to)
        };
        !self.scene.patches().any(|patch| is_near(patch.center)) && !self.lanes.iter().any(crosses)
    }

    /// Whether somebody rests where the building would be.
    fn is_occupied(&self, center: DVec2, half: DVec2) -> bool {
        let site = Block { center, half };
        let rests_there = |item: &Item<'_>| {
            nearest_point(&site, item.center).distance(item.center) < item.kind.shape.radius() + ROOM
        };
        self.scene.all().filter(|item| item.is_in_the_way()).any(rests_there)
    }

    /// Whether walls and buildings leave room for the building and the street around it.
    fn has_room(&self, center: DVec2, half: DVec2) -> bool {
        let (low, size) = (center - half - STREET, (half + STREET) * 2.0);
        let step = self.ground.radius() * STEP;
        let mut y = 0.0;
        while y <= size.y {
            let mut x = 0.0;
            while x <= size.x {
                if !self.ground.holds(low + DVec2::new(x, y)) {
                    return false;
                }
                x += step;
            }
            y += step;
        }
        true
    }
}
