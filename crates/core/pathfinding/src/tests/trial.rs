//! Groups led over a line by a controller, in the kinematics.

use std::collections::VecDeque;

use glam::DVec2;
use maniple_geometry::{Circle, Limits, ObjectId};
use maniple_kinematics::{EventKind, Layers, Leg, Placement, Stops, Wall, WallKind, World};
use maniple_tilemap::TileMap;

use super::Dice;
use super::release::moment;
use crate::{Controller, Delivery, Goals, Ground, Group, Order, Progress, Scene, Seen, StepError, Tactic};

/// World units a cycle.
pub(crate) const SPEED: f64 = 0.2;

/// The first number of those who stand in the way.
const STONES: u32 = 10_000;

/// Groups and the line over which they are led.
#[derive(Clone, Debug)]
pub(crate) struct Trial<'a> {
    pub(crate) map: &'a TileMap,
    pub(crate) radius: f64,
    pub(crate) groups: Vec<Group>,
    /// Where the one group is led before its goals.
    pub(crate) stages: Vec<Vec<DVec2>>,
    pub(crate) tactic: Tactic,
    /// Cycles from an order to its effect.
    pub(crate) latency: usize,
    /// The part of the orders that is lost.
    pub(crate) lost: f64,
    /// What the controller is told of it.
    pub(crate) delivery: Delivery,
    /// Looks a cycle.
    pub(crate) budget: u64,
    /// Whether no schedule is to be found, so that groups go in step.
    pub(crate) is_in_step: bool,
    /// Decides which orders are lost.
    pub(crate) seed: u64,
    /// Who stands in the way, from which cycle on and until which.
    pub(crate) stones: Vec<(Circle, std::ops::Range<u32>)>,
}

/// What became of it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Outcome {
    pub(crate) arrived: usize,
    pub(crate) collisions: usize,
    pub(crate) orders: usize,
    /// Of these, those that got lost.
    pub(crate) lost: usize,
    /// Orders that came later than the start that they named.
    pub(crate) refused: usize,
    /// When the last order was given.
    pub(crate) last_order: u32,
    /// When the last one arrived; the end of the trial where not all have.
    pub(crate) cycles: u32,
    pub(crate) progress: Vec<Progress>,
    pub(crate) error: Option<StepError>,
    /// The looks of each cycle.
    pub(crate) looks: Vec<u64>,
    /// How many were at the goals of each stage when it ended.
    pub(crate) formed: Vec<usize>,
}

impl Trial<'_> {
    /// One group whose goals are interchangeable, of circles of radius 0.35, over a line without delay or loss.
    pub(crate) fn new(map: &TileMap, tactic: Tactic, starts: Vec<DVec2>, goals: Vec<DVec2>) -> Trial<'_> {
        Trial::of_groups(map, tactic, vec![Group { starts, goals, whose: Goals::Interchangeable }])
    }

    pub(crate) fn of_groups(map: &TileMap, tactic: Tactic, groups: Vec<Group>) -> Trial<'_> {
        let (radius, latency, lost, delivery, seed, stones) = (0.35, 0, 0.0, Delivery::Sure, 7, Vec::new());
        let (budget, is_in_step) = (1 << 20, false);
        let stages = Vec::new();
        Trial {
            map,
            radius,
            groups,
            stages,
            tactic,
            latency,
            lost,
            delivery,
            budget,
            is_in_step,
            seed,
            stones,
        }
    }

    fn starts(&self) -> impl Iterator<Item = DVec2> {
        self.groups.iter().flat_map(|group| group.starts.iter().copied())
    }

    fn world(&self) -> World {
        let side = f64::from(self.map.width().max(self.map.height()));
        let wall = |segment| Wall { segment, kind: WallKind::Segment, layers: Layers::GROUND };
        let walls: Vec<Wall> = self.map.segments().into_iter().map(wall).collect();
        let mut world = World::new(Limits::new(side, 1.0, SPEED).unwrap(), Stops::Both, &walls).unwrap();
        for (id, start) in (0..).zip(self.starts()) {
            world.insert(ObjectId(id), Circle::new(start, self.radius), Layers::GROUND).unwrap();
        }
        world
    }

    pub(crate) fn run(&self, cycles_max: u32) -> Outcome {
        self.run_with(cycles_max, |_, _| {})
    }

    /// Runs; before each cycle something else may be done to the world.
    pub(crate) fn run_with(&self, cycles_max: u32, mut meddle: impl FnMut(u32, &mut World)) -> Outcome {
        let ground = Ground::new(self.map, self.radius).unwrap();
        let mut world = self.world();
        let mut controller = self.controller();
        let mut dice = Dice(self.seed);
        let mut line: VecDeque<Vec<Order>> = std::iter::repeat_n(Vec::new(), self.latency).collect();
        let units = u32::try_from(self.starts().count()).unwrap();
        let mut outcome = Outcome {
            arrived: 0,
            collisions: 0,
            orders: 0,
            refused: 0,
            lost: 0,
            last_order: 0,
            cycles: 0,
            progress: Vec::new(),
            error: None,
            looks: Vec::new(),
            formed: Vec::new(),
        };
        for cycle in 0..cycles_max {
            self.set_stones(cycle, &mut world);
            meddle(cycle, &mut world);
            let seen: Vec<Seen> = (0..units).map(|id| look(&world, id)).collect();
            let others: Vec<Circle> =
                self.stones.iter().filter(|stone| stone.1.contains(&cycle)).map(|stone| stone.0).collect();
            let orders = controller.advance(&ground, &Scene { cycle, units: &seen, others: &others });
            outcome.looks.push(controller.looks());
            if let Some(goals) = self.stages.get(outcome.formed.len())
                && controller.stages_left() < self.stages.len() - outcome.formed.len()
            {
                let is_taken = |goal: &&DVec2| seen.iter().any(|seen| seen.position.distance(**goal) < 1e-3);
                outcome.formed.push(goals.iter().filter(is_taken).count());
            }
            if !orders.is_empty() {
                outcome.orders += orders.len();
                outcome.last_order = cycle;
            }
            let given = orders.len();
            let kept: Vec<Order> = orders.into_iter().filter(|_| dice.share() >= self.lost).collect();
            outcome.lost += given - kept.len();
            line.push_back(kept);
            for order in line.pop_front().unwrap() {
                outcome.refused += usize::from(!obey(&mut world, &order));
            }
            let events = world.step();
            let collided = |kind| matches!(kind, EventKind::Object | EventKind::Segment | EventKind::Edge);
            outcome.collisions += events.iter().filter(|event| collided(event.kind)).count();
            outcome.progress = (0..units as usize).map(|unit| controller.progress(unit)).collect();
            outcome.cycles = cycle;
            let have_arrived = outcome.progress.iter().all(|&progress| progress == Progress::Arrived);
            if have_arrived && controller.stages_left() == 0 {
                break;
            }
        }
        outcome.arrived = self.arrived(&world);
        outcome.error = controller.step_error();
        outcome
    }

    fn controller(&self) -> Controller {
        let controller = if self.stages.is_empty() {
            Controller::of_groups(self.tactic, &self.groups, SPEED)
        } else {
            let goals = self.groups.iter().map(|group| group.goals.clone());
            Controller::by_stages(self.tactic, self.stages.iter().cloned().chain(goals).collect(), SPEED)
        };
        let controller = controller.with_delivery(self.delivery).with_budget(self.budget);
        if self.is_in_step { controller.in_step() } else { controller }
    }

    fn set_stones(&self, cycle: u32, world: &mut World) {
        for (id, (stone, cycles)) in (STONES..).zip(&self.stones) {
            if cycles.start == cycle {
                world.insert(ObjectId(id), *stone, Layers::GROUND).unwrap();
            }
            if cycles.end == cycle {
                world.remove(ObjectId(id)).unwrap();
            }
        }
    }

    /// How many rest at goals of their own groups, no two at the same.
    fn arrived(&self, world: &World) -> usize {
        let mut first = 0;
        let mut arrived = 0;
        for group in &self.groups {
            let units = first..first + u32::try_from(group.starts.len()).unwrap();
            first = units.end;
            for (index, goal) in group.goals.iter().enumerate() {
                let is_there = |id: u32| {
                    let whose = group.whose == Goals::Interchangeable || (id - units.start) as usize == index;
                    whose && world.circle(ObjectId(id)).unwrap().center.distance(*goal) < 1e-3
                };
                arrived += usize::from(units.clone().any(is_there));
            }
        }
        arrived
    }
}

fn look(world: &World, id: u32) -> Seen {
    Seen {
        position: world.circle(ObjectId(id)).unwrap().center,
        is_moving: world.motion(ObjectId(id)).unwrap().is_moving(),
    }
}

/// Carries an order out; returns whether it could be.
fn obey(world: &mut World, order: &Order) -> bool {
    let id = ObjectId(u32::try_from(order.unit).unwrap());
    if order.legs.is_empty() {
        world.halt(id, None).unwrap();
        return true;
    }
    let legs: Vec<Leg> = order.legs.iter().map(|&goal| Leg { goal, speed: SPEED }).collect();
    let start = order.start.map(moment);
    // An order that comes too late is refused; that is as if it had been lost.
    world.go(id, &legs, Placement::Replace, start).is_ok()
}
