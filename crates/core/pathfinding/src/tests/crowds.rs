//! Groups for which there is no schedule, or whose orders are lost.

use glam::DVec2;
use maniple_tilemap::{Kind, TileMap, TileShape};

use super::release::{block, gap};
use super::trial::{Outcome, Trial};
use super::{drawn, generated};
use crate::{Delivery, Goals, Group, StepError, Tactic};

fn open(side: u32) -> TileMap {
    let shapes = vec![TileShape::Open; (side * side) as usize];
    TileMap::of_shapes(side, &shapes, Vec::new()).unwrap()
}

fn group(starts: Vec<DVec2>, goals: Vec<DVec2>) -> Group {
    Group { starts, goals, whose: Goals::Interchangeable }
}

/// Four groups that change the corners of a field: so many units in all.
pub(crate) fn corners(units: usize) -> (TileMap, Vec<Group>) {
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

/// A group in a maze of a side, with passages for a radius, that goes from one corner to the other.
pub(crate) fn maze((side, radius): (u32, f64), units: usize, seed: u64) -> (TileMap, Vec<Group>) {
    let map = generated(Kind::Maze, side, radius, seed);
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

/// Leads groups as they are led where there is a schedule, and in step.
fn check_both(name: &str, (map, groups): &(TileMap, Vec<Group>)) {
    let trial = Trial::of_groups(map, Tactic::Auto, groups.clone());
    check(name, &trial);
    check(&format!("{name}, in step"), &Trial { is_in_step: true, ..trial });
}

fn check(name: &str, sure: &Trial<'_>) {
    let units: usize = sure.groups.iter().map(|group| group.starts.len()).sum();
    for (latency, lost, delivery) in
        [(0, 0.0, Delivery::Sure), (2, 0.0, Delivery::Sure), (2, 0.01, Delivery::Lossy { repeats: 2 })]
    {
        let outcome = Trial { latency, lost, delivery, ..sure.clone() }.run(6000);
        let Outcome { arrived, collisions, orders, refused, cycles, error, .. } = &outcome;
        println!(
            "{name}, {units} units, {latency} cycles, {lost} lost: {arrived} arrived, {collisions} collisions, {orders} orders, \
             {cycles} cycles, {error:?}"
        );
        assert_eq!((*arrived, *collisions, *refused), (units, 0, 0), "{name} {units} {latency} {lost}");
    }
}

#[test]
fn four_groups_change_the_corners_of_a_field() {
    for units in [5, 20, 100] {
        check_both("corners", &corners(units));
    }
}

/// Closer than the middles of tiles, and beside them.
#[test]
fn dense_groups_spread_onto_the_board_and_close_up_again() {
    for (units, share) in [(16, 0.75), (36, 0.75), (64, 0.8)] {
        let (map, mut groups) = corners(units);
        for points in groups.iter_mut().flat_map(|group| [&mut group.starts, &mut group.goals]) {
            let middle = points.iter().sum::<DVec2>() / points.len() as f64;
            for point in points {
                *point = middle + (*point - middle) * share + DVec2::new(0.3, 0.1);
            }
        }
        check_both("dense", &(map, groups));
    }
}

#[test]
fn groups_go_through_mazes() {
    for (units, seed) in [(20, 1), (50, 2), (100, 3)] {
        check_both("maze", &maze((40, 0.7), units, seed));
    }
}

#[test]
fn two_groups_pass_a_gap_in_opposite_directions() {
    for width in [1, 2, 4] {
        let (map, groups) = counterflow(width);
        check("counterflow", &Trial::of_groups(&map, Tactic::Auto, groups));
    }
}

/// Nobody is told to go where it has not been seen that the way gets free, so lost orders cost time alone.
#[test]
fn a_line_that_loses_a_fifth_of_all_orders_makes_nobody_collide_in_step() {
    let (map, groups) = corners(20);
    for seed in 0..5 {
        let trial = Trial {
            latency: 2,
            lost: 0.2,
            delivery: Delivery::Lossy { repeats: 6 },
            is_in_step: true,
            seed,
            ..Trial::of_groups(&map, Tactic::Auto, groups.clone())
        };
        let Outcome { arrived, collisions, orders, cycles, .. } = trial.run(6000);
        println!("seed {seed}: {arrived} arrived, {collisions} collisions, {orders} orders, {cycles} cycles");
        assert_eq!((arrived, collisions), (20, 0), "seed {seed}");
    }
}

#[test]
fn larger_circles_go_on_a_coarser_board() {
    let (map, groups) = corners(20);
    for radius in [0.4, 0.45] {
        let trial =
            Trial { radius, is_in_step: true, ..Trial::of_groups(&map, Tactic::Auto, groups.clone()) };
        let Outcome { arrived, collisions, orders, cycles, error, .. } = trial.run(6000);
        println!(
            "radius {radius}: {arrived} arrived, {collisions} collisions, {orders} orders, {cycles} cycles, {error:?}"
        );
        assert_eq!((arrived, collisions), (20, 0), "radius {radius}");
    }
}

/// Orders that are given again before the departure are not missed.
#[test]
fn a_line_that_loses_a_tenth_of_all_orders_makes_nobody_collide_in_a_schedule() {
    let (map, groups) = counterflow(2);
    let delivery = Delivery::Lossy { repeats: 5 };
    let trial = Trial { latency: 2, lost: 0.1, delivery, ..Trial::of_groups(&map, Tactic::Auto, groups) };
    let Outcome { arrived, collisions, .. } = trial.run(3000);
    assert_eq!((arrived, collisions), (100, 0));
}

/// Two who have to change places in a corridor with one bay: there is no schedule, and a plan in step if the bay is on the board.
#[test]
fn two_change_places_in_a_corridor_with_a_bay() {
    let map = drawn(&["@@@@@@@@@", "@.......@", "@@@@.@@@@", "@@@@@@@@@"]);
    let at = |x: f64| vec![DVec2::new(x, 1.5)];
    let groups = vec![group(at(1.5), at(7.5)), group(at(7.5), at(1.5))];
    let trial = Trial::of_groups(&map, Tactic::Auto, groups);
    for latency in [0, 2] {
        let outcome = Trial { latency, ..trial.clone() }.run(1000);
        println!("bay: {} orders, {} cycles", outcome.orders, outcome.cycles);
        assert_eq!((outcome.arrived, outcome.collisions), (2, 0));
    }
    // The bay is in an odd column, as the ends are: a raster of every second tile has it. In an even one it has not.
    let larger = Trial { radius: 0.45, ..trial.clone() }.run(1000);
    assert_eq!((larger.arrived, larger.collisions, larger.error), (0, 0, Some(StepError::NoPlan)));
    assert!(larger.orders < 10 && larger.last_order < 100, "{} {}", larger.orders, larger.last_order);
}

#[test]
fn no_cycle_plans_more_than_its_budget_and_one_part() {
    // The largest part: 96 units and as many goals are assigned to each other.
    let part = 120_000;
    for ((map, groups), budget) in [
        (corners(20), 1_000),
        (corners(20), 20_000),
        (corners(100), 50_000),
        (counterflow(2), 1_000),
        (counterflow(2), 1 << 18),
    ] {
        let units: usize = groups.iter().map(|group| group.starts.len()).sum();
        let outcome = Trial { budget, ..Trial::of_groups(&map, Tactic::Auto, groups) }.run(6000);
        let most = outcome.looks.iter().copied().max().unwrap();
        let all: u64 = outcome.looks.iter().sum();
        println!("{units} units, budget {budget}: {most} at most, {all} in all, {} cycles", outcome.cycles);
        assert!(most < budget + part, "{most}");
        assert_eq!((outcome.arrived, outcome.collisions), (units, 0));
    }
}

#[test]
fn the_same_crowd_is_led_by_the_same_orders() {
    let (map, groups) = corners(20);
    let delivery = Delivery::Lossy { repeats: 1 };
    let trial = Trial {
        budget: 20_000,
        latency: 2,
        lost: 0.05,
        delivery,
        ..Trial::of_groups(&map, Tactic::Auto, groups)
    };
    assert_eq!(trial.run(6000), trial.run(6000));
}
