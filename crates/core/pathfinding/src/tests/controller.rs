//! Controllers that lead circles of the kinematics.

use std::collections::VecDeque;

use glam::DVec2;
use maniple_geometry::{Circle, Limits, ObjectId};
use maniple_kinematics::{EventKind, Layers, Leg, Placement, Stops, Wall, WallKind, World};
use maniple_tilemap::TileMap;

use super::release::{block, gap, moment};
use super::{Dice, drawn};
use crate::{Controller, Ground, Order, Progress, Scene, Seen, Tactic};

const RADIUS: f64 = 0.35;

/// World units a cycle.
const SPEED: f64 = 0.2;

/// A group and the line over which it is led.
struct Trial<'a> {
    map: &'a TileMap,
    starts: Vec<DVec2>,
    goals: Vec<DVec2>,
    tactic: Tactic,
    /// Cycles from an order to its effect.
    latency: usize,
    /// The part of the orders that is lost.
    lost: f64,
    /// Who stands in the way, and until which cycle.
    stones: Vec<(Circle, u32)>,
}

/// What became of it.
#[derive(Debug, PartialEq)]
struct Outcome {
    arrived: usize,
    collisions: usize,
    orders: usize,
    /// When the last order was given.
    last_order: u32,
    /// When the last one arrived; the end of the trial where not all have.
    cycles: u32,
    progress: Vec<Progress>,
}

impl Trial<'_> {
    fn new(map: &TileMap, tactic: Tactic, starts: Vec<DVec2>, goals: Vec<DVec2>) -> Trial<'_> {
        Trial { map, starts, goals, tactic, latency: 0, lost: 0.0, stones: Vec::new() }
    }

    fn world(&self) -> World {
        let side = f64::from(self.map.width().max(self.map.height()));
        let wall = |segment| Wall { segment, kind: WallKind::Segment, layers: Layers::GROUND };
        let walls: Vec<Wall> = self.map.segments().into_iter().map(wall).collect();
        let mut world = World::new(Limits::new(side, 1.0, SPEED).unwrap(), Stops::Both, &walls).unwrap();
        for (id, start) in (0..).zip(&self.starts) {
            world.insert(ObjectId(id), Circle::new(*start, RADIUS), Layers::GROUND).unwrap();
        }
        for (id, stone) in (10_000..).zip(&self.stones) {
            world.insert(ObjectId(id), stone.0, Layers::GROUND).unwrap();
        }
        world
    }

    fn run(&self, cycles_max: u32) -> Outcome {
        let ground = Ground::new(self.map, RADIUS).unwrap();
        let mut world = self.world();
        let mut controller = Controller::new(self.tactic, self.goals.clone(), SPEED);
        let mut dice = Dice(7);
        let mut line: VecDeque<Vec<Order>> = std::iter::repeat_n(Vec::new(), self.latency).collect();
        let units = u32::try_from(self.starts.len()).unwrap();
        let mut outcome =
            Outcome { arrived: 0, collisions: 0, orders: 0, last_order: 0, cycles: 0, progress: Vec::new() };
        for cycle in 0..cycles_max {
            for (id, stone) in (10_000..).zip(&self.stones) {
                if stone.1 == cycle {
                    world.remove(ObjectId(id)).unwrap();
                }
            }
            let units: Vec<Seen> = (0..units)
                .map(|id| Seen {
                    position: world.circle(ObjectId(id)).unwrap().center,
                    is_moving: world.motion(ObjectId(id)).unwrap().is_moving(),
                })
                .collect();
            let others: Vec<Circle> =
                self.stones.iter().filter(|stone| stone.1 > cycle).map(|stone| stone.0).collect();
            let orders = controller.advance(&ground, &Scene { cycle, units: &units, others: &others });
            if !orders.is_empty() {
                outcome.orders += orders.len();
                outcome.last_order = cycle;
            }
            line.push_back(orders.into_iter().filter(|_| dice.share() >= self.lost).collect());
            for order in line.pop_front().unwrap() {
                obey(&mut world, &order);
            }
            let events = world.step();
            let collided = |kind| matches!(kind, EventKind::Object | EventKind::Segment | EventKind::Edge);
            outcome.collisions += events.iter().filter(|event| collided(event.kind)).count();
            outcome.progress = (0..self.starts.len()).map(|unit| controller.progress(unit)).collect();
            let is_at_goal = |id: u32| {
                let center = world.circle(ObjectId(id)).unwrap().center;
                self.goals.iter().any(|goal| goal.distance(center) < 1e-3)
            };
            outcome.arrived =
                (0..u32::try_from(self.starts.len()).unwrap()).filter(|&id| is_at_goal(id)).count();
            outcome.cycles = cycle;
            if outcome.progress.iter().all(|&progress| progress == Progress::Arrived) {
                break;
            }
        }
        outcome
    }
}

fn obey(world: &mut World, order: &Order) {
    let id = ObjectId(u32::try_from(order.unit).unwrap());
    if order.legs.is_empty() {
        world.halt(id, None).unwrap();
        return;
    }
    let legs: Vec<Leg> = order.legs.iter().map(|&goal| Leg { goal, speed: SPEED }).collect();
    let start = order.start.map(moment);
    // An order that comes too late is refused; that is as if it had been lost.
    let _ = world.go(id, &legs, Placement::Replace, start);
}

fn through_gap(map: &TileMap, tactic: Tactic) -> Trial<'_> {
    let middle = 0.5 * f64::from(map.width());
    let starts = block((10, 10), DVec2::new(middle, 9.0));
    Trial::new(map, tactic, starts, block((10, 10), DVec2::new(middle, 33.0)))
}

#[test]
fn a_schedule_brings_all_through_gaps_where_reactions_fail() {
    for width in [1, 2, 3] {
        let map = gap(width);
        for tactic in Tactic::ALL {
            let outcome = through_gap(&map, tactic).run(if tactic == Tactic::Auto { 2000 } else { 500 });
            println!(
                "gap {width} {}: {} arrived, {} collisions, {} orders, {} cycles",
                tactic.name(),
                outcome.arrived,
                outcome.collisions,
                outcome.orders,
                outcome.cycles
            );
            if tactic == Tactic::Auto {
                assert_eq!((outcome.arrived, outcome.collisions, outcome.orders), (100, 0, 100));
            } else {
                assert!(outcome.arrived < 60, "{}: {}", tactic.name(), outcome.arrived);
            }
        }
    }
}

#[test]
fn all_arrive_over_a_slow_line_that_loses_orders() {
    for width in [1, 2, 3] {
        let map = gap(width);
        for (latency, lost) in [(2, 0.01), (2, 0.03), (2, 0.05)] {
            let outcome = Trial { latency, lost, ..through_gap(&map, Tactic::Auto) }.run(6000);
            println!(
                "gap {width}, {latency} cycles, {lost} lost: {} arrived, {} collisions, {} orders, {} cycles",
                outcome.arrived, outcome.collisions, outcome.orders, outcome.cycles
            );
            assert_eq!(outcome.arrived, 100, "{width} {latency} {lost}");
            assert!(outcome.collisions <= 5, "{width} {latency} {lost}: {}", outcome.collisions);
        }
    }
}

#[test]
fn a_denied_gap_is_waited_for_without_shuffling() {
    let map = gap(1);
    let middle = 0.5 * f64::from(map.width());
    let stone = Circle::new(DVec2::new(middle, 21.5), 0.35);
    let free_at = Trial { stones: vec![(stone, 600)], ..through_gap(&map, Tactic::Auto) }.run(4000);
    println!("denied {} {} {} {}", free_at.arrived, free_at.collisions, free_at.orders, free_at.cycles);
    assert_eq!((free_at.arrived, free_at.collisions), (100, 0));
    let never = Trial { stones: vec![(stone, u32::MAX)], ..through_gap(&map, Tactic::Auto) }.run(1000);
    println!("never {} {} {} {}", never.arrived, never.collisions, never.orders, never.last_order);
    assert!(never.orders <= 200 && never.last_order < 50, "{} {}", never.orders, never.last_order);
}

#[test]
fn who_cannot_reach_a_goal_is_told_so_at_once() {
    let map = drawn(&[".....@.....", ".....@.....", ".....@....."]);
    let goal = DVec2::new(8.5, 1.5);
    for tactic in [Tactic::Alone, Tactic::Replan, Tactic::Auto] {
        let outcome = Trial::new(&map, tactic, vec![DVec2::new(1.5, 1.5)], vec![goal]).run(20);
        assert_eq!(outcome.progress, [Progress::Unreachable], "{}", tactic.name());
    }
}

#[test]
fn who_is_in_the_way_all_at_once_is_evaded() {
    let map = gap(5);
    let middle = 0.5 * f64::from(map.width());
    // Two of five tiles are closed from the start, and the schedule has to do with the others.
    let stones = [-1.5, -0.5].map(|x| (Circle::new(DVec2::new(middle + x, 21.5), 0.45), 5000)).to_vec();
    let outcome = Trial { stones, ..through_gap(&map, Tactic::Auto) }.run(4000);
    println!("evaded {} {} {} {}", outcome.arrived, outcome.collisions, outcome.orders, outcome.cycles);
    assert_eq!((outcome.arrived, outcome.collisions), (100, 0));
}

#[test]
fn the_same_trial_ends_the_same() {
    let map = gap(2);
    let run = || Trial { latency: 2, lost: 0.02, ..through_gap(&map, Tactic::Auto) }.run(6000);
    assert_eq!(run(), run());
}
