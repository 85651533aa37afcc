//! Paths walked by the kinematics.

use glam::DVec2;
use maniple_geometry::{Circle, Limits, ObjectId};
use maniple_kinematics::{EventKind, Layers, Leg, Placement, Stops, WAYPOINTS_MAX, Wall, WallKind, World};
use maniple_tilemap::{Kind, TileMap};

use super::{Dice, drawn, generated, scattered, slanted};
use crate::{Ground, MARGIN, PlanError, Planner};

/// World units a cycle.
pub(crate) const SPEED: f64 = 3.7;

/// Paths for each map and radius.
const QUERIES: usize = 60;

/// Who walks.
const WALKER: ObjectId = ObjectId(1);

/// Walls of a map with nobody there.
pub(crate) fn world(map: &TileMap, radius: f64) -> World {
    let side = f64::from(map.width().max(map.height()));
    let walls: Vec<Wall> = map
        .segments()
        .into_iter()
        .map(|segment| Wall { segment, kind: WallKind::Segment, layers: Layers::GROUND })
        .collect();
    World::new(Limits::new(side, radius, SPEED).unwrap(), Stops::Both, &walls).unwrap()
}

/// Walks a path and returns whether it was walked without a collision; the walker is gone afterwards.
pub(crate) fn is_walked(world: &mut World, radius: f64, from: DVec2, legs: &[DVec2]) -> bool {
    world.insert(WALKER, Circle::new(from, radius), Layers::GROUND).unwrap();
    let mut is_free = true;
    let mut at = from;
    for part in legs.chunks(WAYPOINTS_MAX) {
        let orders: Vec<Leg> = part.iter().map(|&goal| Leg { goal, speed: SPEED }).collect();
        world.go(WALKER, &orders, Placement::Replace, None).unwrap();
        while !world.is_at_rest() {
            is_free &= world.step().iter().all(|event| event.kind == EventKind::Arrived);
        }
        at = part[part.len() - 1];
        is_free &= world.circle(WALKER).unwrap().center == at;
    }
    assert!(!is_free || legs.is_empty() || legs[legs.len() - 1] == at);
    world.remove(WALKER).unwrap();
    is_free
}

/// Walks random paths and returns how many there were, and how many collided.
fn walk(map: &TileMap, ground: &Ground, dice: &mut Dice) -> (usize, usize) {
    let mut world = world(map, ground.radius());
    let mut planner = Planner::new(ground);
    let (mut walked, mut collided) = (0, 0);
    for _ in 0..QUERIES {
        let (from, to) = (dice.place(map, ground), dice.place(map, ground));
        match planner.path(from, to) {
            Ok(legs) => {
                walked += 1;
                collided += usize::from(!is_walked(&mut world, ground.radius(), from, legs));
            }
            Err(PlanError::Unreachable { .. } | PlanError::Enclosed { .. }) => {}
            Err(error @ (PlanError::Outside { .. } | PlanError::Blocked { .. })) => panic!("{error}"),
        }
    }
    (walked, collided)
}

#[test]
fn paths_on_generated_maps_are_walked_without_a_collision() {
    let mut dice = Dice(1);
    let mut walked = 0;
    for kind in Kind::ALL {
        for radius in [0.2, 0.35, 0.45, 0.8, 1.4] {
            let map = generated(kind, 48, radius, dice.roll());
            let ground = Ground::new(&map, radius).unwrap();
            let (paths, collided) = walk(&map, &ground, &mut dice);
            assert_eq!(collided, 0, "{kind:?} {radius}");
            walked += paths;
        }
    }
    assert!(walked > 28 * QUERIES, "only {walked} paths");
}

#[test]
fn paths_among_scattered_slanted_and_free_walls_are_walked_without_a_collision() {
    let mut dice = Dice(2);
    let mut walked = 0;
    for round in 0..20 {
        for radius in [0.2, 0.35, 0.45, 0.8] {
            let map = if round % 2 == 0 { scattered(&mut dice, 24, 0.2) } else { slanted(&mut dice, 24) };
            let ground = Ground::new(&map, radius).unwrap();
            let (paths, collided) = walk(&map, &ground, &mut dice);
            assert_eq!(collided, 0, "round {round}, radius {radius}");
            walked += paths;
        }
    }
    assert!(walked > 40 * QUERIES, "only {walked} paths");
}

/// The margin is what stands between rounding and a collision: without it, paths do collide.
#[test]
fn without_a_margin_paths_collide() {
    let mut dice = Dice(3);
    let collided: usize = (0..20)
        .map(|_| {
            let map = scattered(&mut dice, 24, 0.2);
            walk(&map, &Ground::with_margin(&map, 0.35, 0.0).unwrap(), &mut dice).1
        })
        .sum();
    assert!(collided > 0);
}

/// Circles that have collided stand a skin away from walls, and others exactly touch them.
#[test]
fn a_start_that_touches_walls_is_left_without_a_collision() {
    let map = drawn(&["......", "..@...", "......", "....@.", "......", "......"]);
    // In binary, so that touching is exact.
    let radius = 0.375;
    let ground = Ground::new(&map, radius).unwrap();
    let mut world = world(&map, radius);
    let skin: f64 = world.skin();
    let mut planner = Planner::new(&ground);
    let slope = radius / 2.0_f64.sqrt() + 1e-14;
    for gap in [0.0, 0.5 * skin, skin, 2.0 * skin, 0.5 * MARGIN, MARGIN] {
        let room = radius + gap;
        let corner = slope + gap;
        let starts = [
            DVec2::new(room, room),
            DVec2::new(6.0 - room, 3.25),
            DVec2::new(2.0 - room, 1.5),
            DVec2::new(2.5, 2.0 + room),
            DVec2::new(2.0 - corner, 1.0 - corner),
            DVec2::new(5.0 + room, 3.0),
        ];
        for from in starts {
            for to in [DVec2::new(5.5, 5.5), DVec2::new(0.5, 5.5), DVec2::new(3.5, 0.4), DVec2::new(5.5, 0.5)]
            {
                let legs = planner.path(from, to).unwrap_or_else(|error| panic!("{from} {gap}: {error}"));
                assert!(is_walked(&mut world, radius, from, legs), "{from} to {to}, {gap} above touching");
            }
        }
    }
}
