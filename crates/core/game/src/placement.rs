//! Where everything stands when a match begins.

use std::collections::BTreeMap;

use glam::DVec2;
use maniple_geometry::{Cycle, Segment};
use maniple_tilemap::{Area, Regions, TileMap, place_far_apart, regions};
use maniple_view::{Seat, UnitTypeId, Zone};
use thiserror::Error;

use crate::keyed::{Purpose, keyed};
use crate::scenario::{Group, Objective, Scenario};

/// Least distance of a unit from walls and other units at the start, in world units: room to turn, and far above
/// any skin.
pub const START_GAP: f64 = 1.0 / 16.0;

/// The start of a match.
#[derive(Clone, Debug, PartialEq)]
pub struct Setup {
    /// The units, by seat and in the order of its groups; the place in this list is the number of the object.
    pub units: Vec<StartUnit>,
    /// The zone of each seat, in order of the seats.
    pub zones: Vec<Zone>,
}

/// A unit at the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StartUnit {
    /// Whose it is.
    pub seat: Seat,
    /// Its type.
    pub unit_type: UnitTypeId,
    /// Its centre, in world units.
    pub position: DVec2,
}

/// Why the units of a scenario do not fit on a map.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum PlaceError {
    /// The map gives no places for all seats, and its largest region has too few tiles to find them.
    #[error(
        "the map has no spawn and zone for each of {seats} seats, and too few open tiles to place them; \
         give each player a spawn and a zone, or take a map with at least {} open tiles in one region",
        2 * .seats
    )]
    TooSmall {
        /// How many seats there are.
        seats: usize,
    },
    /// The spawn of a seat is not on an open tile.
    #[error(
        "the spawn of seat {seat} at ({}, {}) is not on an open tile; move it to one",
        .position.x,
        .position.y
    )]
    SpawnBlocked {
        /// The seat.
        seat: Seat,
        /// Where its spawn is, in world units.
        position: DVec2,
    },
    /// The region of a seat's spawn has no room for all units of a group.
    #[error(
        "around the spawn of seat {seat} there is room for {placed} of the {units} units of a group; \
         lower the count or the radius, add another spawn of the player in open ground, or take a larger map"
    )]
    NoRoom {
        /// The seat.
        seat: Seat,
        /// How many units of the group found room.
        placed: usize,
        /// How many it has.
        units: u32,
    },
}

impl Setup {
    /// Returns where the units of a scenario stand on a map, and the zones.
    ///
    /// The groups of a seat start in turn at the spawns of the player with its number, and it has that player's first
    /// zone. Who has none gets one of twice as many points as there are seats, placed far apart in the largest region
    /// from the seed; of the points left for zones each seat in turn takes the one that is farthest from its spawn.
    ///
    /// # Errors
    /// See [`PlaceError`].
    pub(crate) fn new(scenario: &Scenario, map: &TileMap) -> Result<Self, PlaceError> {
        let seats: Vec<Seat> = (0..).map(Seat).take(scenario.seats.len()).collect();
        let (spawns, zones) = places(scenario, map, &seats)?;
        let mut room = Room::new(scenario, map);
        let mut units = Vec::new();
        for (&seat, spawns) in seats.iter().zip(&spawns) {
            let groups = &scenario.seats[seat.index()].groups;
            for (&Group { unit_type, count }, &spawn) in groups.iter().zip(spawns.iter().cycle()) {
                let radius = scenario.unit_types[usize::from(unit_type.0)].radius;
                let positions = room.take(seat, spawn, radius, count)?;
                units.extend(positions.into_iter().map(|position| StartUnit { seat, unit_type, position }));
            }
        }
        Ok(Self { units, zones })
    }
}

/// Returns the spawns, at least one, and the zone of each seat.
fn places(
    scenario: &Scenario,
    map: &TileMap,
    seats: &[Seat],
) -> Result<(Vec<Vec<DVec2>>, Vec<Zone>), PlaceError> {
    let spawns: Vec<Vec<DVec2>> = seats.iter().map(|&seat| map_spawns(map, seat)).collect();
    let areas: Vec<Option<Area>> = seats.iter().map(|&seat| map_zone(map, seat)).collect();
    let is_whole = !spawns.iter().any(Vec::is_empty) && areas.iter().all(Option::is_some);
    let placed = if is_whole {
        Vec::new()
    } else {
        let seed = keyed(scenario.seed, Cycle(0), Seat(0), 0, Purpose::Placement);
        place_far_apart(map, 2 * seats.len(), seed).ok_or(PlaceError::TooSmall { seats: seats.len() })?
    };
    let Objective::Race { zone_size } = scenario.objective;
    let mut for_zones = placed.get(seats.len()..).unwrap_or_default().to_vec();
    let mut all_spawns = Vec::new();
    let mut zones = Vec::new();
    for (&seat, (mut spawns, area)) in seats.iter().zip(spawns.into_iter().zip(areas)) {
        if spawns.is_empty() {
            spawns.push(placed[seat.index()]);
        }
        let area = area.unwrap_or_else(|| square(map, take_farthest(&mut for_zones, spawns[0]), zone_size));
        all_spawns.push(spawns);
        zones.push(Zone { seat, min: area.min, max: area.max });
    }
    Ok((all_spawns, zones))
}

fn map_spawns(map: &TileMap, seat: Seat) -> Vec<DVec2> {
    let player = u32::from(seat.0);
    map.spawns().iter().filter(|spawn| spawn.player == player).map(|spawn| spawn.position).collect()
}

fn map_zone(map: &TileMap, seat: Seat) -> Option<Area> {
    let player = Some(u32::from(seat.0));
    map.zones().iter().find(|zone| zone.player == player).map(|zone| zone.area)
}

/// Takes the point that is farthest from `from`, the first of several.
fn take_farthest(points: &mut Vec<DVec2>, from: DVec2) -> DVec2 {
    let mut farthest = 0;
    for (place, point) in points.iter().enumerate() {
        if point.distance_squared(from) > points[farthest].distance_squared(from) {
            farthest = place;
        }
    }
    points.remove(farthest)
}

/// Returns the square around a point, cut to the map.
fn square(map: &TileMap, center: DVec2, size: f64) -> Area {
    let half = size / 2.0;
    let low = |value: f64| if value - half < 0.0 { 0.0 } else { value - half };
    let high = |value: f64, end: f64| if value + half > end { end } else { value + half };
    let (width, height) = (f64::from(map.width()), f64::from(map.height()));
    Area {
        min: DVec2::new(low(center.x), low(center.y)),
        max: DVec2::new(high(center.x, width), high(center.y, height)),
    }
}

/// The room that is left on a map.
struct Room<'a> {
    map: &'a TileMap,
    regions: Regions,
    free_walls: &'a [Segment],
    /// Edge of the square buckets: no two circles touch across more than one of them.
    bucket: f64,
    taken: BTreeMap<(i32, i32), Vec<(DVec2, f64)>>,
}

impl<'a> Room<'a> {
    fn new(scenario: &Scenario, map: &'a TileMap) -> Self {
        let mut radius_max = 0.0;
        for unit_type in &scenario.unit_types {
            if unit_type.radius > radius_max {
                radius_max = unit_type.radius;
            }
        }
        Self {
            map,
            regions: regions(map),
            free_walls: map.free_walls(),
            bucket: 2.0 * radius_max + START_GAP,
            taken: BTreeMap::new(),
        }
    }

    /// Takes room around a spawn: on the points of a lattice as wide as the units, from the spawn outwards, ties by
    /// y, then x.
    fn take(&mut self, seat: Seat, spawn: DVec2, radius: f64, units: u32) -> Result<Vec<DVec2>, PlaceError> {
        let label = self.label(spawn).ok_or(PlaceError::SpawnBlocked { seat, position: spawn })?;
        let spacing = 2.0 * radius + START_GAP;
        let across = f64::from(self.map.width()) + f64::from(self.map.height());
        let mut points = Rings::new(across / spacing);
        let mut positions = Vec::new();
        while positions.len() < units as usize {
            let Some((x, y)) = points.next() else {
                return Err(PlaceError::NoRoom { seat, placed: positions.len(), units });
            };
            let point = spawn + DVec2::new(f64::from(x), f64::from(y)) * spacing;
            if self.label(point) == Some(label) && self.is_free(point, radius) {
                self.taken.entry(self.bucket_of(point)).or_default().push((point, radius));
                positions.push(point);
            }
        }
        Ok(positions)
    }

    /// Returns the region of the tile that a point is on; `None` where there is none.
    fn label(&self, point: DVec2) -> Option<u32> {
        let (x, y) = tile_of(point)?;
        if y < self.map.height() { self.regions.label(x, y) } else { None }
    }

    fn is_free(&self, point: DVec2, radius: f64) -> bool {
        self.is_open(point, radius + START_GAP)
            && self.free_walls.iter().all(|wall| !is_nearer(point, wall, radius + START_GAP))
            && self.near(point).all(|(other, other_radius)| {
                let gap = radius + other_radius + START_GAP;
                other.distance_squared(point) >= gap * gap
            })
    }

    /// Returns whether all tiles under the square around a point are open; no wall of a tile is nearer then.
    fn is_open(&self, point: DVec2, reach: f64) -> bool {
        let Some((left, top)) = tile_of(point - DVec2::splat(reach)) else { return false };
        let Some((right, bottom)) = tile_of(point + DVec2::splat(reach)) else { return false };
        (top..=bottom).all(|y| (left..=right).all(|x| self.map.is_passable(x, y)))
    }

    fn near(&self, point: DVec2) -> impl Iterator<Item = (DVec2, f64)> {
        let (x, y) = self.bucket_of(point);
        (y - 1..=y + 1)
            .flat_map(move |y| (x - 1..=x + 1).map(move |x| (x, y)))
            .filter_map(|bucket| self.taken.get(&bucket))
            .flatten()
            .copied()
    }

    #[expect(
        clippy::cast_possible_truncation,
        reason = "a map is at most 4096 wide, a bucket at least START_GAP"
    )]
    fn bucket_of(&self, point: DVec2) -> (i32, i32) {
        ((point.x / self.bucket).floor() as i32, (point.y / self.bucket).floor() as i32)
    }
}

/// Returns the tile that a point is on; `None` left of or above the map.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "not negative; saturates")]
fn tile_of(point: DVec2) -> Option<(u32, u32)> {
    (point.x >= 0.0 && point.y >= 0.0).then_some((point.x as u32, point.y as u32))
}

/// Returns whether a point is nearer to a segment than `reach`.
fn is_nearer(point: DVec2, segment: &Segment, reach: f64) -> bool {
    let direction = segment.direction();
    let offset = point - segment.start;
    let along = offset.dot(direction) / direction.dot(direction);
    let nearest = if along > 1.0 {
        segment.end
    } else if along > 0.0 {
        segment.start + direction * along
    } else {
        segment.start
    };
    point.distance_squared(nearest) < reach * reach
}

/// The points of the unit lattice by distance from the origin, ties by y, then x.
struct Rings {
    /// Points within `inner` have been given; those that wait are within `outer`, the nearest last.
    inner: i32,
    outer: i32,
    end: i32,
    waiting: Vec<(i32, i32)>,
}

impl Rings {
    /// Returns the points of a disc, a little more than `radius` wide.
    #[expect(clippy::cast_possible_truncation, reason = "saturates, and is limited")]
    fn new(radius: f64) -> Self {
        /// Beyond it the square of a distance would not fit into 32 bits.
        const RADIUS_MAX: i32 = 32_000;
        let end = (radius.floor() as i32).min(RADIUS_MAX) + 1;
        Self { inner: -1, outer: 0, end, waiting: vec![(0, 0)] }
    }

    /// Waits for the points of a ring a quarter wider than all before.
    fn widen(&mut self) {
        self.inner = self.outer;
        self.outer = (self.inner + self.inner / 4 + 4).min(self.end);
        let (inner, outer) = (self.inner * self.inner, self.outer * self.outer);
        let side = -self.outer..=self.outer;
        self.waiting = side
            .clone()
            .flat_map(|y| side.clone().map(move |x| (x, y)))
            .filter(|&(x, y)| (inner + 1..=outer).contains(&(x * x + y * y)))
            .collect();
        self.waiting.sort_by_key(|&(x, y)| std::cmp::Reverse((x * x + y * y, y, x)));
    }
}

impl Iterator for Rings {
    type Item = (i32, i32);

    fn next(&mut self) -> Option<(i32, i32)> {
        while self.waiting.is_empty() && self.outer < self.end {
            self.widen();
        }
        self.waiting.pop()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::tests::files;
    use crate::{Loaded, Overrides, load};

    #[test]
    fn the_lattice_is_walked_outwards_and_each_point_once() {
        let points: Vec<(i32, i32)> = Rings::new(12.0).collect();
        let keys: Vec<(i32, i32, i32)> = points.iter().map(|&(x, y)| (x * x + y * y, y, x)).collect();
        assert!(keys.is_sorted());
        let mut sorted = points.clone();
        sorted.sort_unstable();
        sorted.dedup();
        assert_eq!(sorted.len(), points.len());
        let side = -13..=13;
        let disc =
            side.clone().flat_map(|y| side.clone().map(move |x| x * x + y * y)).filter(|&d| d <= 169).count();
        assert_eq!(points.len(), disc);
        assert_eq!(points[..5], [(0, 0), (0, -1), (-1, 0), (1, 0), (0, 1)]);
    }

    #[test]
    fn units_stand_clear_of_walls_and_of_each_other() {
        let rows = "..........\n..........\n....@.....\n..........\n..........\n..........\n";
        let loaded =
            loaded(rows, "groups = [{ unit = 'a', count = 16 }, { unit = 'b', count = 2 }]").unwrap();
        assert_eq!(loaded.setup.units.len(), 36);
        let types = &loaded.scenario.unit_types;
        let radius = |unit: &StartUnit| types[usize::from(unit.unit_type.0)].radius;
        for (place, unit) in loaded.setup.units.iter().enumerate() {
            for wall in loaded.map.segments() {
                assert!(!is_nearer(unit.position, &wall, radius(unit) + START_GAP), "{unit:?} {wall:?}");
            }
            for other in &loaded.setup.units[..place] {
                let gap = radius(unit) + radius(other) + START_GAP;
                assert!(unit.position.distance(other.position) >= gap, "{unit:?} {other:?}");
            }
        }
    }

    #[test]
    fn placed_zones_are_far_from_the_spawn_and_within_the_map() {
        let rows = "........................\n".repeat(24);
        let loaded = loaded(&rows, "groups = [{ unit = 'a', count = 1 }]").unwrap();
        for zone in &loaded.setup.zones {
            let spawn = loaded.setup.units.iter().find(|unit| unit.seat == zone.seat).unwrap().position;
            let center = (zone.min + zone.max) / 2.0;
            assert!(spawn.distance(center) > 12.0, "{spawn} {zone:?}");
            assert!(zone.min.x >= 0.0 && zone.max.x <= 24.0 && zone.min.x < zone.max.x);
            assert!(zone.min.y >= 0.0 && zone.max.y <= 24.0 && zone.min.y < zone.max.y);
        }
    }

    #[test]
    fn what_does_not_fit_is_an_error_that_says_how_much_would() {
        let error = loaded("....\n....\n....\n....\n", "groups = [{ unit = 'a', count = 40 }]").unwrap_err();
        assert!(error.contains("there is room for") && error.contains("of the 40 units"), "{error}");
        assert!(error.contains("lower the count"), "{error}");
        let error = loaded(".@\n", "groups = [{ unit = 'a', count = 1 }]").unwrap_err();
        assert!(error.contains("too few open tiles") && error.contains("at least 4 open tiles"), "{error}");
        let error = PlaceError::SpawnBlocked { seat: Seat(1), position: DVec2::new(2.5, 0.5) }.to_string();
        assert!(error.contains("seat 1 at (2.5, 0.5)") && error.contains("move it"), "{error}");
    }

    #[test]
    fn a_zone_at_the_border_is_cut() {
        let files = files("", &"....\n".repeat(4), "groups = [{ unit = 'a', count = 1 }]");
        let map = load(&files, "s/tiny.toml", &Overrides::default()).unwrap().map;
        let area = square(&map, DVec2::new(0.5, 3.5), 4.0);
        assert_eq!((area.min, area.max), (DVec2::new(0.0, 1.5), DVec2::new(2.5, 4.0)));
    }

    /// Loads a match of two equal seats on a map of these rows.
    fn loaded(rows: &str, groups: &str) -> Result<Loaded, String> {
        let seats = format!("{groups}\n[[seat]]\n{groups}");
        load(&files("", rows, &seats), "s/tiny.toml", &Overrides::default())
            .map_err(|error| error.to_string())
    }
}
