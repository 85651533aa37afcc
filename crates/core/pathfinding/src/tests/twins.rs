//! Fast answers beside slow obvious ones.

use glam::DVec2;
use maniple_geometry::Segment;
use maniple_tilemap::TileMap;

use super::{Dice, scattered, slanted};
use crate::walls::is_apart;
use crate::{Ground, MARGIN};

/// Legs for each map.
const LEGS: usize = 3000;

#[test]
fn a_leg_is_clear_where_it_keeps_its_distance_from_every_wall() {
    let mut dice = Dice(11);
    let mut clear = 0;
    for round in 0..24 {
        let map = if round % 2 == 0 { scattered(&mut dice, 20, 0.1) } else { slanted(&mut dice, 20) };
        for radius in [0.2, 0.45, 0.8, 1.4] {
            let ground = Ground::new(&map, radius).unwrap();
            let walls = map.segments();
            for _ in 0..LEGS {
                let (from, away) = (dice.point(&map), dice.point(&map) - dice.point(&map));
                // Long and short ones, and some along an axis.
                let away = away * [1.0, 0.2][usize::from(dice.roll().is_multiple_of(2))];
                let away = if dice.roll().is_multiple_of(8) { DVec2::new(away.x, 0.0) } else { away };
                let leg = Segment::new(from, from + away);
                if !ground.holds(from) || !ground.is_within(leg.end) {
                    continue;
                }
                let expected = walls.iter().all(|wall| is_apart(&leg, wall, radius + MARGIN));
                assert_eq!(ground.is_clear(from, leg.end), expected, "round {round}, {radius}, {leg:?}");
                clear += usize::from(expected);
            }
        }
    }
    assert!(clear > 10_000, "only {clear} legs are clear");
}

#[test]
fn a_leg_is_clear_up_to_where_the_wall_ahead_is() {
    let mut dice = Dice(14);
    let (mut clear, mut blocked) = (0, 0);
    for round in 0..24 {
        let map = if round % 2 == 0 { scattered(&mut dice, 20, 0.1) } else { slanted(&mut dice, 20) };
        for radius in [0.2, 0.45, 1.4] {
            let ground = Ground::new(&map, radius).unwrap();
            for _ in 0..LEGS {
                let (from, to) = (dice.point(&map), dice.point(&map));
                let unit = (to - from).normalize_or_zero();
                if !ground.holds(from) || unit == DVec2::ZERO {
                    continue;
                }
                let wall = ground.walls.way_ahead(from, unit, 8.0);
                let length = 8.0 * dice.share();
                let is_clear = ground.is_clear(from, from + unit * length);
                let is_sure = (length - wall).abs() > 1e-6;
                assert!(
                    !is_sure || is_clear == (length < wall),
                    "round {round}, {radius}, {from}, {to}, {length}"
                );
                *(if is_clear { &mut clear } else { &mut blocked }) += 1;
            }
        }
    }
    assert!(clear > 10_000 && blocked > 10_000, "{clear} {blocked}");
}

#[test]
fn a_point_holds_a_circle_where_it_is_open_and_far_from_every_wall() {
    let mut dice = Dice(12);
    for round in 0..12 {
        let map = if round % 2 == 0 { scattered(&mut dice, 20, 0.3) } else { slanted(&mut dice, 20) };
        let ground = Ground::new(&map, 0.35).unwrap();
        for _ in 0..LEGS {
            let point = dice.point(&map);
            let is_far =
                map.segments().iter().all(|wall| is_apart(&Segment::new(point, point), wall, ground.reach));
            // A point that is far from walls is open where the middle of its tile is, or its tile is a half-blocked one.
            let (x, y) = map.tile_at(point);
            if map.is_passable(x, y) {
                assert_eq!(ground.holds(point), is_far, "round {round}, {point}");
            } else {
                assert!(!ground.holds(point) || is_far, "round {round}, {point}");
            }
        }
    }
}

/// What the lattice promises: whoever goes from free node to free node touches nothing.
#[test]
fn every_step_of_the_lattice_is_clear() {
    let mut dice = Dice(13);
    for round in 0..40 {
        let map = if round % 2 == 0 { scattered(&mut dice, 16, 0.2) } else { slanted(&mut dice, 16) };
        for radius in [0.05, 0.2, 0.3, 0.35, 0.45, 0.499, 0.6, 0.8, 0.99, 1.4] {
            check_steps(&map, &Ground::new(&map, radius).unwrap());
        }
    }
}

fn check_steps(map: &TileMap, ground: &Ground) {
    let (lattice, walls) = (&ground.lattice, map.segments());
    for node in (0..).take(lattice.nodes()) {
        let from = lattice.place(node);
        if !lattice.is_free(from.0, from.1) {
            continue;
        }
        for (dx, dy) in [(1, 0), (0, 1), (1, 1), (1, -1)] {
            let to = (from.0 + dx, from.1 + dy);
            if lattice.is_diagonal_free(from, to) {
                let end = lattice.point(lattice.node(to.0.cast_unsigned(), to.1.cast_unsigned()));
                let step = Segment::new(lattice.point(node), end);
                let is_clear = walls.iter().all(|wall| is_apart(&step, wall, ground.reach));
                assert!(is_clear, "{step:?} with {}", ground.radius());
            }
        }
    }
}
