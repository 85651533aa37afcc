//! Places for many around a point.

use glam::DVec2;
use maniple_pathfinding::{Ground, Planner, length};

use super::roads::Roads;

/// Directions all around, as sides of right triangles of the length 1.
pub(crate) const AROUND: [(f64, f64); 12] = [
    (1.0, 0.0),
    (0.8, 0.6),
    (0.6, 0.8),
    (0.0, 1.0),
    (-0.6, 0.8),
    (-0.8, 0.6),
    (-1.0, 0.0),
    (-0.8, -0.6),
    (-0.6, -0.8),
    (0.0, -1.0),
    (0.6, -0.8),
    (0.8, -0.6),
];

/// Distance of places beyond touching, as a part of a unit's diameter.
const SLOT_GAP: f64 = 0.25;

/// How many times as many places of the lattice are looked at as are wanted, at least; the others are blocked or cut off.
const LOOKED_AT: usize = 4;

/// How many rings around a point are searched for one that has room.
const RINGS_MAX: i32 = 24;

/// How much longer than straight the way from the point to a place may be: others lie behind a wall.
const WINDING_MAX: f64 = 1.5;

/// Returns up to so many places around a point that can be reached from `from`, nearest first, as far
/// apart as circles of the ground's radius need; none where nothing around the point has room.
pub(crate) fn slots_around(
    roads: &Roads,
    ground: &Ground,
    (from, point): (DVec2, DVec2),
    count: usize,
) -> Vec<DVec2> {
    let spacing = 2.0 * ground.radius() * (1.0 + SLOT_GAP);
    let Some(anchor) = reachable(roads, ground, (from, point), spacing) else { return Vec::new() };
    let mut rings = 1;
    while (2 * rings + 1) * (2 * rings + 1) < i32::try_from(count * LOOKED_AT).unwrap_or(i32::MAX) {
        rings += 1;
    }
    let mut offsets: Vec<DVec2> = (0..=rings).flat_map(ring_of).collect();
    offsets.sort_by(|one, other| one.length_squared().total_cmp(&other.length_squared()));
    let mut planner = Planner::new(ground);
    let mut is_near = |slot: DVec2| {
        let straight = slot.distance(anchor);
        let is_at_hand = |legs: &[DVec2]| length(anchor, legs) <= straight * WINDING_MAX + spacing;
        ground.is_clear(anchor, slot) || planner.path(anchor, slot).is_ok_and(is_at_hand)
    };
    let slots = offsets.into_iter().map(|offset| anchor + offset * spacing);
    slots.filter(|&slot| ground.holds(slot) && !roads.is_covered(slot) && is_near(slot)).take(count).collect()
}

/// Returns the point nearest to `point` on a lattice around it that has room and can be reached from `from`.
fn reachable(roads: &Roads, ground: &Ground, (from, point): (DVec2, DVec2), spacing: f64) -> Option<DVec2> {
    let mut planner = Planner::new(ground);
    (0..=RINGS_MAX)
        .flat_map(ring_of)
        .map(|offset| point + offset * spacing)
        .find(|&place| ground.holds(place) && !roads.is_covered(place) && planner.connects(from, place))
}

/// Returns the points of a lattice of ones on the square so far around the origin, by (y, x).
fn ring_of(ring: i32) -> impl Iterator<Item = DVec2> {
    let is_on = move |&(x, y): &(i32, i32)| x.abs() == ring || y.abs() == ring;
    let square = (-ring..=ring).flat_map(move |y| (-ring..=ring).map(move |x| (x, y)));
    square.filter(is_on).map(|(x, y)| DVec2::new(f64::from(x), f64::from(y)))
}
