//! Plans walked in step by the kinematics.

use maniple_geometry::{Circle, Limits, ObjectId};
use maniple_kinematics::{EventKind, Layers, Leg, Placement, Stops, Wall, WallKind, World};
use maniple_tilemap::{Kind, TileMap};

use super::{instance, plan};
use crate::Ground;
use crate::in_step::{Algorithm, Board, Instance, Plan, RADIUS_IN_STEP_MAX, Refinement};
use crate::tests::{Dice, generated, scattered as blocked_at_random, slanted};

/// Cycles of a step.
const CYCLES: u32 = 5;

/// Walks a plan by circles of a radius, and returns how many collisions there were.
fn collisions(map: &TileMap, instance: &Instance<'_>, plan: &Plan, radius: f64) -> usize {
    let speed = 1.0 / f64::from(CYCLES);
    let side = f64::from(map.width().max(map.height()));
    let wall = |segment| Wall { segment, kind: WallKind::Segment, layers: Layers::GROUND };
    let walls: Vec<Wall> = map.segments().into_iter().map(wall).collect();
    let mut world = World::new(Limits::new(side, radius, speed).unwrap(), Stops::Both, &walls).unwrap();
    let point = |place| instance.board().point(place);
    for (agent, &start) in (0..).zip(instance.starts()) {
        world.insert(ObjectId(agent), Circle::new(point(start), radius), Layers::GROUND).unwrap();
    }
    let mut collisions = 0;
    for step in 1..=plan.steps() {
        for (agent, (from, &to)) in (0..).zip(plan.at(step - 1).iter().zip(plan.at(step))) {
            if *from != to {
                let leg = Leg { goal: point(to), speed };
                world.go(ObjectId(agent), &[leg], Placement::Replace, None).unwrap();
            }
        }
        for _ in 0..CYCLES {
            collisions += world.step().iter().filter(|event| event.kind != EventKind::Arrived).count();
        }
    }
    let is_there = |(agent, &goal): (u32, _)| world.circle(ObjectId(agent)).unwrap().center == point(goal);
    assert!(collisions > 0 || (0..).zip(instance.goals()).all(is_there));
    collisions
}

#[test]
fn plans_are_walked_without_a_collision_up_to_the_largest_radius() {
    let mut dice = Dice(51);
    let mut maps: Vec<TileMap> =
        Kind::ALL.into_iter().map(|kind| generated(kind, 24, RADIUS_IN_STEP_MAX, dice.roll())).collect();
    maps.extend([0.1, 0.2].map(|blocked| blocked_at_random(&mut dice, 20, blocked)));
    maps.push(slanted(&mut dice, 20));
    let mut steps = 0;
    for map in &maps {
        for radius in [0.2, 0.35, 0.3535, RADIUS_IN_STEP_MAX] {
            let board = Board::new(&Ground::new(map, radius).unwrap()).unwrap();
            let instance = instance(&board, board.len() / 5, dice.roll());
            let first = plan(Algorithm::Lacam, &instance, 1, 20_000);
            let mut refinement = Refinement::new(&instance, &first, 1);
            refinement.improve(200);
            for plan in [first, refinement.plan()] {
                assert_eq!(collisions(map, &instance, &plan, radius), 0, "radius {radius}");
                steps += plan.steps();
            }
        }
    }
    println!("{steps} steps");
}

/// What the limit is for: circles a little larger collide at corners.
#[test]
fn larger_circles_would_collide() {
    let mut dice = Dice(61);
    let map = blocked_at_random(&mut dice, 20, 0.2);
    let board = super::board_of(&map);
    let instance = instance(&board, board.len() / 3, 1);
    let plan = plan(Algorithm::Lacam, &instance, 1, 20_000);
    assert_eq!(collisions(&map, &instance, &plan, 0.3535), 0);
    assert!(collisions(&map, &instance, &plan, 0.36) > 100);
    assert!(collisions(&map, &instance, &plan, 0.3537) > 0);
}
