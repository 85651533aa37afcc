//! Where everything stands when a match begins.

use std::collections::BTreeMap;

use glam::DVec2;
use maniple_geometry::{Cycle, Segment};
use maniple_tilemap::{Area, Regions, Resource, TileMap, place_far_apart, regions};
use maniple_view::{Seat, UnitTypeId, Zone};
use thiserror::Error;

use crate::keyed::{Purpose, keyed};
use crate::room::{Rings, is_nearer, is_open, tile_of};
use crate::scenario::{Group, HarvestRule, Objective, Scenario};

/// Least distance of a unit from walls and other units at the start, in world units: room to turn, and far above
/// any skin.
pub const START_GAP: f64 = 1.0 / 16.0;

/// The start of a match.
#[derive(Clone, Debug, PartialEq)]
pub struct Setup {
    /// The units, by seat and in the order of its groups, then those of nobody: resources in the order of the map, and neutral units.
    /// The place in this list is the number of the object.
    pub units: Vec<StartUnit>,
    /// The zone of each seat, in order of the seats; none where the match is no race.
    pub zones: Vec<Zone>,
}

/// A unit at the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StartUnit {
    /// Whose it is; `None`: nobody's.
    pub seat: Option<Seat>,
    /// Its type.
    pub unit_type: UnitTypeId,
    /// Its centre, in world units.
    pub position: DVec2,
    /// Resources in it; 0 for all but patches.
    pub amount: u32,
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
    /// A resource of the map lies where no patch can be.
    #[error(
        "the resource at ({}, {}) has no room for a patch of radius {radius}: a wall or another patch is too near; \
         move it, or give the patch a smaller radius",
        .position.x,
        .position.y
    )]
    PatchBlocked {
        /// Where it is, in world units.
        position: DVec2,
        /// The radius of a patch, in world units.
        radius: f64,
    },
    /// The map has no room for all neutral units.
    #[error(
        "there is room for {placed} of the {units} neutral units of a group; lower the count, or take a larger map"
    )]
    NoRoomForNeutral {
        /// How many of the group found room.
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
        let patches = patches(scenario, map, &mut room)?;
        let mut units = Vec::new();
        for (&seat, spawns) in seats.iter().zip(&spawns) {
            let groups = &scenario.seats[seat.index()].groups;
            for (&Group { unit_type, count }, &spawn) in groups.iter().zip(spawns.iter().cycle()) {
                let radius = scenario.unit_types[usize::from(unit_type.0)].shape.radius();
                let label = room.label(spawn).ok_or(PlaceError::SpawnBlocked { seat, position: spawn })?;
                let positions = room.take(label, spawn, radius, count);
                if positions.len() < count as usize {
                    return Err(PlaceError::NoRoom { seat, placed: positions.len(), units: count });
                }
                let unit = |position| StartUnit { seat: Some(seat), unit_type, position, amount: 0 };
                units.extend(positions.into_iter().map(unit));
            }
        }
        units.extend(patches);
        units.extend(neutral(scenario, &mut room)?);
        Ok(Self { units, zones })
    }
}

/// Returns the patches, which are where the map has resources.
fn patches(scenario: &Scenario, map: &TileMap, room: &mut Room<'_>) -> Result<Vec<StartUnit>, PlaceError> {
    let Some(HarvestRule { patch }) = scenario.harvest else { return Ok(Vec::new()) };
    let radius = scenario.unit_types[usize::from(patch.0)].shape.radius();
    let place = |resource: &Resource| {
        let position = resource.position;
        if !room.is_free(position, radius) {
            return Err(PlaceError::PatchBlocked { position, radius });
        }
        room.occupy(position, radius);
        Ok(StartUnit { seat: None, unit_type: patch, position, amount: resource.amount })
    };
    map.resources().iter().map(place).collect()
}

/// Returns the neutral units, each near a tile that is chosen from the seed.
fn neutral(scenario: &Scenario, room: &mut Room<'_>) -> Result<Vec<StartUnit>, PlaceError> {
    let mut units = Vec::new();
    let Some(neutral) = &scenario.neutral else { return Ok(units) };
    let mut index = 0;
    for &Group { unit_type, count } in &neutral.groups {
        let radius = scenario.unit_types[usize::from(unit_type.0)].shape.radius();
        for placed in 0..count as usize {
            index += 1;
            let position = (room.open_tile(scenario.seed, index))
                .and_then(|(label, center)| room.take(label, center, radius, 1).first().copied())
                .ok_or(PlaceError::NoRoomForNeutral { placed, units: count })?;
            units.push(StartUnit { seat: None, unit_type, position, amount: 0 });
        }
    }
    Ok(units)
}

/// Returns the spawns, at least one, and the zone of each seat.
fn places(
    scenario: &Scenario,
    map: &TileMap,
    seats: &[Seat],
) -> Result<(Vec<Vec<DVec2>>, Vec<Zone>), PlaceError> {
    let spawns: Vec<Vec<DVec2>> = seats.iter().map(|&seat| map_spawns(map, seat)).collect();
    let areas: Vec<Option<Area>> = seats.iter().map(|&seat| map_zone(map, seat)).collect();
    let needs_zones = matches!(scenario.objective, Objective::Race { .. });
    let is_whole = !spawns.iter().any(Vec::is_empty) && (!needs_zones || areas.iter().all(Option::is_some));
    let placed = if is_whole {
        Vec::new()
    } else {
        let seed = keyed(scenario.seed, Cycle(0), Some(Seat(0)), 0, Purpose::Placement);
        place_far_apart(map, 2 * seats.len(), seed).ok_or(PlaceError::TooSmall { seats: seats.len() })?
    };
    let mut for_zones = placed.get(seats.len()..).unwrap_or_default().to_vec();
    let mut all_spawns = Vec::new();
    let mut zones = Vec::new();
    for (&seat, (mut spawns, area)) in seats.iter().zip(spawns.into_iter().zip(areas)) {
        if spawns.is_empty() {
            spawns.push(placed[seat.index()]);
        }
        if let Objective::Race { zone_size } = scenario.objective {
            let chosen = || square(map, take_farthest(&mut for_zones, spawns[0]), zone_size);
            let Area { min, max } = area.unwrap_or_else(chosen);
            zones.push(Zone { seat, min, max });
        }
        all_spawns.push(spawns);
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
            if unit_type.shape.radius() > radius_max {
                radius_max = unit_type.shape.radius();
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

    /// Takes room for as many units as fit around a point of a region, at most `units`: on the points of a lattice as wide
    /// as the units, from the point outwards, ties by y, then x.
    fn take(&mut self, label: u32, around: DVec2, radius: f64, units: u32) -> Vec<DVec2> {
        let spacing = 2.0 * radius + START_GAP;
        let across = f64::from(self.map.width()) + f64::from(self.map.height());
        let mut points = Rings::new(across / spacing);
        let mut positions = Vec::new();
        while positions.len() < units as usize {
            let Some((x, y)) = points.next() else { break };
            let point = around + DVec2::new(f64::from(x), f64::from(y)) * spacing;
            if self.label(point) == Some(label) && self.is_free(point, radius) {
                self.occupy(point, radius);
                positions.push(point);
            }
        }
        positions
    }

    fn occupy(&mut self, point: DVec2, radius: f64) {
        self.taken.entry(self.bucket_of(point)).or_default().push((point, radius));
    }

    /// Returns the region and the centre of the `index`th tile of those that are chosen from the seed; `None` where the map has
    /// no open tile.
    fn open_tile(&self, seed: u64, index: u32) -> Option<(u32, DVec2)> {
        let tiles = self.map.tiles().len() as u64;
        let chosen = keyed(seed, Cycle(0), None, index, Purpose::Placement) % tiles;
        let center = |tile: u64| {
            let width = u64::from(self.map.width());
            DVec2::new((tile % width) as f64 + 0.5, (tile / width) as f64 + 0.5)
        };
        let mut tiles = (chosen..tiles).chain(0..chosen).map(center);
        tiles.find_map(|center| self.label(center).map(|label| (label, center)))
    }

    /// Returns the region of the tile that a point is on; `None` where there is none.
    fn label(&self, point: DVec2) -> Option<u32> {
        let (x, y) = tile_of(point)?;
        if y < self.map.height() { self.regions.label(x, y) } else { None }
    }

    fn is_free(&self, point: DVec2, radius: f64) -> bool {
        is_open(self.map, point, DVec2::splat(radius + START_GAP))
            && self.free_walls.iter().all(|wall| !is_nearer(point, wall, radius + START_GAP))
            && self.near(point).all(|(other, other_radius)| {
                let gap = radius + other_radius + START_GAP;
                other.distance_squared(point) >= gap * gap
            })
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::tests::files;
    use crate::{Loaded, Overrides, load};

    #[test]
    fn units_stand_clear_of_walls_and_of_each_other() {
        let rows = "..........\n..........\n....@.....\n..........\n..........\n..........\n";
        let loaded =
            loaded(rows, "groups = [{ unit = 'a', count = 16 }, { unit = 'b', count = 2 }]").unwrap();
        assert_eq!(loaded.setup.units.len(), 36);
        let types = &loaded.scenario.unit_types;
        let radius = |unit: &StartUnit| types[usize::from(unit.unit_type.0)].shape.radius();
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
            let spawn = loaded.setup.units.iter().find(|unit| unit.seat == Some(zone.seat)).unwrap().position;
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
