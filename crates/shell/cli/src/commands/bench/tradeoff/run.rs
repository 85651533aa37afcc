//! A scene that is played under a setting.

use std::time::{Duration, Instant};

use glam::DVec2;
use maniple_geometry::{Circle, ObjectId, Planar, Scalar};
use maniple_kinematics::{Event, EventKind, Layers, Leg, Placement, Wall, World};
use maniple_oracle::{Actual, Goal, Object, Obstacle, Solution, Stops, Verdict, judge, solve};

use crate::commands::bench::tradeoff::arena::{Arena, RADIUS};
use crate::commands::bench::tradeoff::setting::{Positions, Precision, Setting};

/// Going through something less deep than this, in world units, is no tunnelling: a hundredth of the radius is not to be seen.
const TUNNEL_DEPTH: f64 = RADIUS / 100.0;

/// The least time to a goal that the oracle is told, as a fraction of a cycle: the border refuses smaller ones.
const TIME_MIN: f64 = maniple_geometry::limits::TINY;

/// A run, whatever its scalar.
pub(super) trait Run {
    /// Gives orders to whoever rests.
    fn order(&mut self);

    /// Simulates a cycle and returns the time that it took, without the orders.
    fn step(&mut self) -> Duration;

    /// Gives orders, simulates a cycle and returns what the oracle says to it.
    fn judge(&mut self) -> Judged;

    /// Returns where everybody is, by id.
    fn centers(&self) -> Vec<DVec2>;

    /// Returns what was sent so far.
    fn sent(&self) -> Sent;

    /// Returns how far above touching a colliding circle stops, in world units.
    fn skin(&self) -> f64;
}

/// Returns the run of a scene under a setting, at its start.
pub(super) fn start<'a>(arena: &'a Arena, setting: &'a Setting) -> Box<dyn Run + 'a> {
    match setting.precision {
        Precision::F64 => Box::new(Playing::<f64>::new(arena, setting)),
        Precision::F32 => Box::new(Playing::<f32>::new(arena, setting)),
    }
}

/// Points that were sent: where motions start, and where objects stop.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sent {
    pub(super) points: u64,
    pub(super) bytes: u64,
}

impl Sent {
    /// Returns what was sent after `earlier`.
    pub(super) fn since(self, earlier: Self) -> Self {
        Self { points: self.points - earlier.points, bytes: self.bytes - earlier.bytes }
    }

    fn add(&mut self, point: DVec2, positions: Positions) {
        self.points += 1;
        self.bytes += positions.bytes(point.x) + positions.bytes(point.y);
    }
}

/// What the oracle says to cycles; counts and sums over all of them.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Judged {
    pub(super) cycles: u32,
    pub(super) objects: u64,
    /// Stops that should have been.
    pub(super) stops: u64,
    pub(super) missed: u64,
    /// Stops that should not have been.
    pub(super) spurious: u64,
    /// Objects that went through something.
    pub(super) tunnelled: u64,
    /// Objects that overlap something at the end.
    pub(super) overlapping: u64,
    pub(super) deepest: f64,
    pub(super) deviation_sum: f64,
    pub(super) deviation_max: f64,
}

impl Judged {
    fn of(verdict: &Verdict, stops: usize, objects: u32) -> Self {
        Self {
            cycles: 1,
            objects: u64::from(objects),
            stops: stops as u64,
            missed: verdict.missed.len() as u64,
            spurious: verdict.spurious.len() as u64,
            tunnelled: concerned(&verdict.tunnelled),
            overlapping: concerned(&verdict.overlapping),
            deepest: verdict.deepest.max(0.0),
            deviation_sum: verdict.deviation_mean * f64::from(objects),
            deviation_max: verdict.deviation_max,
        }
    }

    pub(super) fn add(&mut self, other: &Self) {
        self.cycles += other.cycles;
        self.objects += other.objects;
        self.stops += other.stops;
        self.missed += other.missed;
        self.spurious += other.spurious;
        self.tunnelled += other.tunnelled;
        self.overlapping += other.overlapping;
        self.deepest = self.deepest.max(other.deepest);
        self.deviation_sum += other.deviation_sum;
        self.deviation_max = self.deviation_max.max(other.deviation_max);
    }
}

/// Returns how many objects are in any of the pairs.
fn concerned(pairs: &[(usize, Obstacle)]) -> u64 {
    let mut objects: Vec<usize> = Vec::new();
    for &(object, other) in pairs {
        objects.push(object);
        if let Obstacle::Object(other) = other {
            objects.push(other);
        }
    }
    objects.sort_unstable();
    objects.dedup();
    objects.len() as u64
}

/// A run in one scalar.
struct Playing<'a, S: Scalar> {
    arena: &'a Arena,
    setting: &'a Setting,
    world: World<S>,
    walls: Vec<Wall<S>>,
    /// By id: how many orders each has had.
    draws: Vec<u64>,
    /// By id: what each was ordered last.
    legs: Vec<Option<Leg<S>>>,
    /// Who has no order.
    idle: Vec<ObjectId>,
    sent: Sent,
}

impl<'a, S: Scalar> Playing<'a, S> {
    fn new(arena: &'a Arena, setting: &'a Setting) -> Self {
        let rounded =
            |wall: &Wall| Wall { segment: wall.segment.rounded(), kind: wall.kind, layers: wall.layers };
        let walls: Vec<Wall<S>> = arena.walls.iter().map(rounded).collect();
        let limits = arena.limits(f64::from(setting.stretch));
        let mut world =
            World::new(limits, setting.of_world(), &walls).expect("another world has these walls");
        world.reserve(arena.starts.len());
        for (id, &start) in (0..).map(ObjectId).zip(&arena.starts) {
            let circle = Circle::new(S::Vector::from_dvec2(start), S::from_f64(RADIUS));
            world.insert(id, circle, Layers::GROUND).expect("the start is free");
        }
        let objects = arena.starts.len();
        let idle = (0..arena.objects()).map(ObjectId).collect();
        Self {
            arena,
            setting,
            world,
            walls,
            draws: vec![0; objects],
            legs: vec![None; objects],
            idle,
            sent: Sent::default(),
        }
    }

    fn ids(&self) -> impl Iterator<Item = ObjectId> + use<S> {
        (0..self.arena.objects()).map(ObjectId)
    }

    fn center(&self, id: ObjectId) -> DVec2 {
        self.world.circle(id).expect("nobody is taken out").center.to_dvec2()
    }

    /// Takes note of what happened.
    fn note(&mut self, events: &[Event]) {
        for event in events.iter().filter(|event| event.rests) {
            self.idle.push(event.object);
            self.sent.add(self.center(event.object), self.setting.positions);
        }
    }

    /// The state at the start of the cycle.
    ///
    /// The skin is that of the exact setting, so that a larger one is judged too.
    fn asked(&self) -> maniple_oracle::Scene {
        let wall = |wall: &Wall<S>| maniple_oracle::Wall {
            start: wall.segment.start.to_dvec2().to_array(),
            end: wall.segment.end.to_dvec2().to_array(),
        };
        maniple_oracle::Scene {
            objects: self.ids().map(|id| self.object(id)).collect(),
            walls: self.walls.iter().map(wall).collect(),
            skin: self.world.limits().skin(),
            stops: Stops::Both,
        }
    }

    fn object(&self, id: ObjectId) -> Object {
        let motion = self.world.motion(id).expect("nobody is taken out");
        let center = self.center(id);
        let resting = Object { center: center.to_array(), velocity: [0.0; 2], radius: RADIUS, goal: None };
        let Some(leg) = self.legs[id.0 as usize] else { return resting };
        let goal = leg.goal.to_dvec2();
        if goal == center {
            return Object { goal: Some(Goal { point: goal.to_array(), time: 0.0 }), ..resting };
        }
        // When it arrives is given; what becomes of it is asked.
        let way = (leg.goal - motion.start).length() / leg.speed;
        let left = way.to_f64() - motion.from.until(self.world.cycle());
        let goal = (left <= 1.0).then(|| Goal { point: goal.to_array(), time: left.max(TIME_MIN) });
        Object { velocity: motion.velocity.to_dvec2().to_array(), goal, ..resting }
    }

    /// What the world made of the objects, as a client sees it.
    fn actual(&self, events: &[Event]) -> Vec<Actual> {
        let actual = |id: ObjectId| {
            let rest = events.iter().rfind(|event| event.object == id && event.rests);
            let is_stopped = rest.is_some_and(|event| event.kind != EventKind::Arrived);
            let point = self.center(id).to_array().map(|coordinate| self.setting.positions.seen(coordinate));
            Actual { point, until: rest.map_or(1.0, |event| event.time), is_stopped }
        };
        self.ids().map(actual).collect()
    }
}

impl<S: Scalar> Run for Playing<'_, S> {
    fn order(&mut self) {
        for id in std::mem::take(&mut self.idle) {
            let center = self.center(id);
            let order = self.arena.order(id, &mut self.draws[id.0 as usize], center);
            let speed = S::from_f64(order.speed * f64::from(self.setting.stretch));
            let leg = Leg { goal: S::Vector::from_dvec2(order.goal), speed };
            self.world.go(id, &[leg], Placement::Replace, None).expect("the goal is within the limits");
            self.legs[id.0 as usize] = Some(leg);
            self.sent.add(center, self.setting.positions);
        }
    }

    fn step(&mut self) -> Duration {
        let begun = Instant::now();
        let events = self.world.step();
        let took = begun.elapsed();
        let events = events.to_vec();
        self.note(&events);
        took
    }

    fn judge(&mut self) -> Judged {
        self.order();
        let asked = self.asked();
        let solution: Solution = solve(&asked);
        let events = self.world.step().to_vec();
        self.note(&events);
        let verdict = judge(&asked, &solution, &self.actual(&events), TUNNEL_DEPTH);
        let is_stop = |ending| matches!(ending, maniple_oracle::Ending::Stopped(_));
        let stops = solution.outcomes.iter().filter(|outcome| is_stop(outcome.ending)).count();
        Judged::of(&verdict, stops, self.arena.objects())
    }

    fn centers(&self) -> Vec<DVec2> {
        self.ids().map(|id| self.center(id)).collect()
    }

    fn sent(&self) -> Sent {
        self.sent
    }

    fn skin(&self) -> f64 {
        self.world.skin().to_f64()
    }
}
