//! Obstacles that come and go, beside grounds that are built anew.

use std::collections::BTreeMap;

use glam::DVec2;
use maniple_geometry::{Circle, Limits, ObjectId, Segment};
use maniple_kinematics::{Layers, Stops, Wall, WallKind, World};
use maniple_tilemap::{Area, TileMap, TileShape};

use super::walk::{SPEED, is_walked};
use super::{Dice, drawn, scattered};
use crate::{Ground, Obstacle, Obstacles, Planner, length};

/// Width and height of the maps, in tiles.
const SIDE: u32 = 20;

/// Obstacles that come or go on one map.
const CHANGES: usize = 25;

/// The largest radius of who walks and of what stands there.
const RADIUS_MAX: f64 = 1.5;

/// How many are there at once at most: keys are below.
const KEYS: u64 = 8;

/// A rectangle of up to three by three tiles.
fn tiles(dice: &mut Dice) -> Area {
    let mut number = |below: u64| f64::from(u32::try_from(dice.roll() % below).unwrap());
    let min = DVec2::new(number(u64::from(SIDE) - 3), number(u64::from(SIDE) - 3));
    Area { min, max: min + DVec2::new(1.0 + number(3), 1.0 + number(3)) }
}

/// A circle or a rectangle anywhere.
fn anything(dice: &mut Dice, map: &TileMap) -> Obstacle {
    let (place, size) = (dice.point(map) * 0.8 + 1.0, DVec2::new(dice.share(), dice.share()) * 2.0 + 0.1);
    if dice.roll().is_multiple_of(2) {
        Obstacle::Circle(Circle::new(place, 0.5 * size.x))
    } else {
        Obstacle::Rectangle(Area { min: place, max: place + size })
    }
}

/// Puts an obstacle there, or takes one away; `standing` is what is there.
fn change(
    dice: &mut Dice,
    obstacle: Obstacle,
    (obstacles, standing): (&mut Obstacles<'_>, &mut BTreeMap<usize, Obstacle>),
) {
    let key = usize::try_from(dice.roll() % KEYS).unwrap();
    if dice.roll().is_multiple_of(3) {
        assert_eq!(obstacles.remove(key), standing.remove(&key));
    } else {
        assert_eq!(obstacles.insert(key, obstacle), Ok(standing.insert(key, obstacle)));
    }
}

/// The map with the tiles of all rectangles blocked.
fn rebuilt(map: &TileMap, standing: &BTreeMap<usize, Obstacle>) -> TileMap {
    let covers = |obstacle: &Obstacle, middle: DVec2| match obstacle {
        Obstacle::Circle(_) => false,
        Obstacle::Rectangle(area) => area.contains(middle),
    };
    let places =
        (0..SIDE * SIDE).map(|tile| DVec2::new(f64::from(tile % SIDE), f64::from(tile / SIDE)) + 0.5);
    let shapes: Vec<TileShape> = places
        .zip(map.tiles())
        .map(|(middle, tile)| {
            let is_covered = standing.values().any(|obstacle| covers(obstacle, middle));
            if is_covered { TileShape::Blocked } else { tile.shape }
        })
        .collect();
    TileMap::of_shapes(SIDE, &shapes, Vec::new()).unwrap()
}

/// Rectangles of whole tiles are what blocked tiles are: the same legs are clear, and the same ends connected.
#[test]
fn rectangles_are_to_legs_what_blocked_tiles_are() {
    let mut dice = Dice(41);
    let (mut clear, mut paths) = (0, 0);
    let (mut around, mut anew) = (0.0, 0.0);
    for radius in [0.2, 0.35, 0.8] {
        let map = scattered(&mut dice, SIDE, 0.08);
        let ground = Ground::new(&map, radius).unwrap();
        let mut obstacles = Obstacles::new(&ground);
        let mut standing = BTreeMap::new();
        for _ in 0..CHANGES {
            let rectangle = Obstacle::Rectangle(tiles(&mut dice));
            change(&mut dice, rectangle, (&mut obstacles, &mut standing));
            let map = rebuilt(&map, &standing);
            let twin = Ground::new(&map, radius).unwrap();
            let mut planner = Planner::new(&twin);
            for _ in 0..200 {
                let (from, to) = (dice.point(&map), dice.point(&map));
                assert_eq!(obstacles.holds(from), twin.holds(from), "{from} {radius} {standing:?}");
                let is_clear = twin.is_clear(from, to);
                assert_eq!(obstacles.is_clear(from, to), is_clear, "{from} {to} {radius} {standing:?}");
                clear += usize::from(is_clear);
            }
            for _ in 0..5 {
                let (from, to) = (dice.place(&map, &twin), dice.place(&map, &twin));
                let path = obstacles.path(from, to).unwrap();
                assert_eq!(
                    path.is_some(),
                    planner.path(from, to).is_ok(),
                    "{from} {to} {radius} {standing:?}"
                );
                if let Some(legs) = path {
                    around += length(from, &legs);
                    anew += length(from, planner.path(from, to).unwrap());
                    paths += 1;
                }
            }
        }
    }
    println!("{clear} clear legs; {paths} paths, {:.4} of the length on a ground built anew", around / anew);
    assert!(clear > 1000 && paths > 200, "{clear} legs, {paths} paths");
}

/// The walls of the map and the sides of rectangles, and the circles.
fn world(map: &TileMap, standing: &BTreeMap<usize, Obstacle>) -> World {
    let mut segments = map.segments();
    let mut circles = Vec::new();
    for obstacle in standing.values() {
        match *obstacle {
            Obstacle::Circle(circle) => circles.push(circle),
            Obstacle::Rectangle(Area { min, max }) => {
                let corners = [min, DVec2::new(max.x, min.y), max, DVec2::new(min.x, max.y)];
                segments
                    .extend([0, 1, 2, 3].map(|side| Segment::new(corners[side], corners[(side + 1) % 4])));
            }
        }
    }
    let wall = |segment| Wall { segment, kind: WallKind::Segment, layers: Layers::GROUND };
    let walls: Vec<Wall> = segments.into_iter().map(wall).collect();
    let limits = Limits::new(f64::from(SIDE), RADIUS_MAX, SPEED).unwrap();
    let mut world = World::new(limits, Stops::Both, &walls).unwrap();
    for (id, circle) in (100..).zip(circles) {
        // Those that overlap something have no place in a world.
        let _ = world.insert(ObjectId(id), circle, Layers::GROUND);
    }
    world
}

/// Circles and rectangles anywhere: every path is walked, and every point of it keeps radius and margin from all.
#[test]
fn paths_among_what_comes_and_goes_are_walked_without_a_collision() {
    let mut dice = Dice(42);
    let (mut walked, mut closed) = (0, 0);
    for radius in [0.2, 0.35, 0.45, 0.8] {
        let map = scattered(&mut dice, SIDE, 0.05);
        let ground = Ground::new(&map, radius).unwrap();
        let mut obstacles = Obstacles::new(&ground);
        let mut standing = BTreeMap::new();
        for _ in 0..CHANGES {
            let obstacle = anything(&mut dice, &map);
            change(&mut dice, obstacle, (&mut obstacles, &mut standing));
            let mut world = world(&map, &standing);
            for _ in 0..12 {
                let (from, to) = (dice.point(&map), dice.point(&map));
                if !obstacles.holds(from) || !obstacles.holds(to) {
                    continue;
                }
                let Some(legs) = obstacles.path(from, to).unwrap() else {
                    closed += 1;
                    continue;
                };
                let starts = std::iter::once(&from).chain(&legs);
                assert!(starts.zip(&legs).all(|(start, end)| obstacles.is_clear(*start, *end)));
                assert!(is_walked(&mut world, radius, from, &legs), "{from} to {to}, {radius}, {standing:?}");
                walked += 1;
            }
        }
        for key in 0..usize::try_from(KEYS).unwrap() {
            obstacles.remove(key);
        }
        for _ in 0..200 {
            let (from, to) = (dice.point(&map), dice.point(&map));
            assert_eq!(obstacles.is_clear(from, to), ground.is_clear(from, to), "all are gone");
        }
    }
    println!("{walked} paths, and {closed} closed");
    assert!(walked > 300, "only {walked} paths");
}

/// A building may rise beside a unit, or touch it.
#[test]
fn a_start_that_is_too_near_to_an_obstacle_is_left_straight_away_from_it() {
    let map = drawn(&["........"; 8]);
    let ground = Ground::new(&map, 0.25).unwrap();
    let mut obstacles = Obstacles::new(&ground);
    obstacles
        .insert(7, Obstacle::Rectangle(Area { min: DVec2::new(3.0, 3.0), max: DVec2::new(5.0, 5.0) }))
        .unwrap();
    let from = DVec2::new(2.75, 4.0);
    let legs = obstacles.path(from, DVec2::new(6.5, 4.0)).unwrap().unwrap();
    assert!(legs.len() > 2 && legs[0].x <= from.x, "{legs:?}");
    assert_eq!(obstacles.path(DVec2::new(4.0, 4.0), DVec2::new(6.5, 4.0)), Ok(None), "from within");
    assert_eq!(obstacles.path(from, DVec2::new(4.0, 4.0)), Ok(None), "into it");
}
