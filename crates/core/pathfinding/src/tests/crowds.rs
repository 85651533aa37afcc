//! Groups for which there is no schedule, or whose orders are lost.

use glam::DVec2;
use maniple_tilemap::{Kind, TileMap, TileShape};

use super::generated;
use super::release::{block, gap};
use super::trial::{Outcome, Trial};
use crate::{Goals, Group, Tactic};

fn open(side: u32) -> TileMap {
    let shapes = vec![TileShape::Open; (side * side) as usize];
    TileMap::of_shapes(side, &shapes, Vec::new()).unwrap()
}

fn group(starts: Vec<DVec2>, goals: Vec<DVec2>) -> Group {
    Group { starts, goals, whose: Goals::Interchangeable }
}

/// Four groups that change the corners of a field: so many units in all.
fn corners(units: usize) -> (TileMap, Vec<Group>) {
    let side = (1..).find(|side| side * side * 4 >= units).unwrap();
    let size = 4 * side + 30;
    let near = 5.0 + 0.5 * side as f64;
    let far = size as f64 - near;
    let ends = [(near, near), (far, far), (far, near), (near, far)].map(DVec2::from);
    let block = |corner: usize, count: usize| {
        let mut points = block((side, side), ends[corner]);
        points.truncate(count);
        points
    };
    let of_corner = |corner: usize| {
        let count = (units + corner) / 4;
        group(block(corner, count), block(corner ^ 1, count))
    };
    (open(u32::try_from(size).unwrap()), (0..4).map(of_corner).collect())
}

/// Half of the units above a gap and half below it.
fn counterflow(width: usize) -> (TileMap, Vec<Group>) {
    let map = gap(width);
    let middle = 0.5 * f64::from(map.width());
    let above = |x: f64| block((5, 10), DVec2::new(middle + x, 8.0));
    let below = |x: f64| block((5, 10), DVec2::new(middle + x, 34.0));
    (map, vec![group(above(-5.0), below(-5.0)), group(below(5.0), above(5.0))])
}

/// A group in a maze that goes from one corner to the other.
fn maze(units: usize, seed: u64) -> (TileMap, Vec<Group>) {
    let map = generated(Kind::Maze, 40, 0.7, seed);
    let ground = crate::Ground::new(&map, 0.35).unwrap();
    let regions = maniple_tilemap::regions(&map);
    let tiles = (0..map.height()).flat_map(|y| (0..map.width()).map(move |x| (x, y)));
    let tiles = tiles.filter(|&(x, y)| regions.largest() == regions.label(x, y));
    let mut points: Vec<DVec2> = tiles
        .map(|(x, y)| DVec2::new(f64::from(x), f64::from(y)) + 0.5)
        .filter(|&at| ground.holds(at))
        .collect();
    points.sort_by(|a, b| (a.x + a.y).total_cmp(&(b.x + b.y)).then(a.x.total_cmp(&b.x)));
    let goals = points.split_off(points.len() - units);
    points.truncate(units);
    (map, vec![group(points, goals)])
}

fn check(name: &str, (map, groups): &(TileMap, Vec<Group>)) {
    let units: usize = groups.iter().map(|group| group.starts.len()).sum();
    let sure = Trial::of_groups(map, Tactic::Auto, groups.clone());
    for (latency, lost, repeats) in [(0, 0.0, 0), (2, 0.01, 2)] {
        let outcome = Trial { latency, lost, repeats, ..sure.clone() }.run(6000);
        let Outcome { arrived, collisions, orders, cycles, error, .. } = &outcome;
        println!(
            "{name}, {units} units, {latency} cycles, {lost} lost: {arrived} arrived, {collisions} collisions, {orders} orders, \
             {cycles} cycles, {error:?}"
        );
        assert_eq!((*arrived, *collisions), (units, 0), "{name} {units} {latency} {lost}");
    }
}

#[test]
fn four_groups_change_the_corners_of_a_field() {
    for units in [5, 20, 100] {
        check("corners", &corners(units));
    }
}

#[test]
fn groups_go_through_mazes() {
    for (units, seed) in [(20, 1), (50, 2), (100, 3)] {
        check("maze", &maze(units, seed));
    }
}

#[test]
fn two_groups_pass_a_gap_in_opposite_directions() {
    for width in [1, 2, 4] {
        check("counterflow", &counterflow(width));
    }
}
