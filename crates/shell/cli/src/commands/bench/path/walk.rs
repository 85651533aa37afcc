//! Plans walked by the kinematics.

use anyhow::Context;
use glam::DVec2;
use maniple_geometry::{Circle, Cycle, Limits, Moment, ObjectId};
use maniple_kinematics::{
    EventKind, Layers, Leg, OrderError, Placement, Stops, WAYPOINTS_MAX, Wall, WallKind, World,
};
use maniple_pathfinding::Seen;
use maniple_tilemap::TileMap;

use crate::commands::bench::path::SPEED;
use crate::failure::Failure;

/// A world with the walls of a map, and what happened in it.
pub(super) struct Walk {
    world: World,
    radius: f64,
    /// How often somebody was stopped by an object or a wall.
    pub(super) collisions: u64,
    gate: Option<Gate>,
}

/// A line across which units go downwards.
struct Gate {
    height: f64,
    /// Those who have not passed.
    waiting: Vec<u32>,
    /// When the others did, in cycles since the beginning, nearly.
    passed: Vec<f64>,
}

impl Walk {
    pub(super) fn new(map: &TileMap, radius: f64) -> Result<Self, Failure> {
        let side = f64::from(map.width().max(map.height()));
        let limits = Limits::new(side, radius, SPEED)
            .map_err(|(name, problem)| Failure::usage(format!("--radius {radius}: the {name} {problem}")))?;
        let wall = |segment| Wall { segment, kind: WallKind::Segment, layers: Layers::GROUND };
        let walls: Vec<Wall> = map.segments().into_iter().map(wall).collect();
        let world =
            World::new(limits, Stops::Both, &walls).context("the walls").map_err(Failure::BadInput)?;
        Ok(Self { world, radius, collisions: 0, gate: None })
    }

    /// Notes from now on when the first so many units pass a height downwards.
    pub(super) fn watch(&mut self, height: f64, units: usize) {
        let waiting = (0..).take(units).collect();
        self.gate = Some(Gate { height, waiting, passed: Vec::new() });
    }

    /// Returns how many units a cycle have passed what is watched, from the first to the last; `None` where not all have, or nothing is watched.
    pub(super) fn throughput(&self) -> Option<f64> {
        let Gate { waiting, passed, .. } = self.gate.as_ref()?;
        let (first, last) = (passed.first()?, passed.last()?);
        (waiting.is_empty() && last > first).then(|| (passed.len() - 1) as f64 / (last - first))
    }

    /// Puts a unit into the world.
    pub(super) fn insert(&mut self, unit: u32, at: DVec2) -> Result<(), Failure> {
        let circle = Circle::new(at, self.radius);
        self.world.insert(ObjectId(unit), circle, Layers::GROUND).map_err(Failure::bad_input)
    }

    pub(super) fn remove(&mut self, unit: u32) -> Result<(), Failure> {
        self.world.remove(ObjectId(unit)).map_err(Failure::failed)
    }

    /// Lets a unit go straight to a point, from now on.
    pub(super) fn go(&mut self, unit: u32, goal: DVec2) -> Result<(), Failure> {
        let leg = Leg { goal, speed: SPEED };
        self.world.go(ObjectId(unit), &[leg], Placement::Replace, None).map_err(Failure::failed)
    }

    /// Lets a unit go along legs until it rests, and all others, too.
    pub(super) fn go_along(&mut self, unit: u32, legs: &[DVec2]) -> Result<(), Failure> {
        for part in legs.chunks(WAYPOINTS_MAX) {
            let orders: Vec<Leg> = part.iter().map(|&goal| Leg { goal, speed: SPEED }).collect();
            self.world.go(ObjectId(unit), &orders, Placement::Replace, None).map_err(Failure::failed)?;
            while !self.world.is_at_rest() {
                self.step();
            }
        }
        Ok(())
    }

    /// Lets a unit go along legs, from a moment on in cycles since the beginning, or from now on. An order that comes too late is lost.
    pub(super) fn depart(&mut self, unit: u32, legs: &[DVec2], start: Option<f64>) -> Result<(), Failure> {
        let legs: Vec<Leg> = legs.iter().map(|&goal| Leg { goal, speed: SPEED }).collect();
        let moment = start.map(moment);
        match self.world.go(ObjectId(unit), &legs, Placement::Replace, moment) {
            Ok(()) | Err(OrderError::StartInPast { .. }) => Ok(()),
            Err(error) => Err(Failure::failed(error)),
        }
    }

    /// Lets a unit stop.
    pub(super) fn halt(&mut self, unit: u32) -> Result<(), Failure> {
        self.world.halt(ObjectId(unit), None).map_err(Failure::failed)
    }

    /// Goes on until all rest, and returns when the last of them came to rest, in cycles since the beginning.
    pub(super) fn rest(&mut self) -> f64 {
        let mut last = 0.0;
        while !self.world.is_at_rest() {
            last = self.step().unwrap_or(last);
        }
        last
    }

    pub(super) fn is_at_rest(&self) -> bool {
        self.world.is_at_rest()
    }

    /// Returns where a unit is; `None` where there is none of this number.
    pub(super) fn position(&self, unit: u32) -> Option<DVec2> {
        self.world.circle(ObjectId(unit)).map(|circle| circle.center)
    }

    /// Returns a unit as a controller sees it.
    pub(super) fn seen(&self, unit: u32) -> Option<Seen> {
        let is_moving = self.world.motion(ObjectId(unit))?.is_moving();
        Some(Seen { position: self.position(unit)?, is_moving })
    }

    /// Goes on by a cycle; returns when in it something happened last, in cycles since the beginning.
    pub(super) fn step(&mut self) -> Option<f64> {
        let is_collision = |kind: EventKind| match kind {
            EventKind::Arrived | EventKind::Ordered => false,
            EventKind::Object | EventKind::Segment | EventKind::Edge => true,
        };
        let events = self.world.step();
        self.collisions += events.iter().filter(|event| is_collision(event.kind)).count() as u64;
        let last = events.last().map(|event| f64::from(event.cycle.0) + event.time);
        self.watch_gate();
        last
    }

    fn watch_gate(&mut self) {
        let Some(gate) = &mut self.gate else { return };
        let now = f64::from(self.world.cycle().0);
        let Gate { height, waiting, passed } = gate;
        let begun = passed.len();
        waiting.retain(|&unit| {
            let beyond = self.world.circle(ObjectId(unit)).map_or(0.0, |circle| circle.center.y - *height);
            if beyond > 0.0 {
                passed.push(now - beyond / SPEED);
            }
            beyond <= 0.0
        });
        passed[begun..].sort_by(f64::total_cmp);
    }

    pub(super) fn is_at(&self, unit: u32, point: DVec2) -> bool {
        self.world.circle(ObjectId(unit)).is_some_and(|circle| circle.center == point)
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a schedule begins at 0 and is shorter than 2^32 cycles"
)]
fn moment(start: f64) -> Moment {
    Moment { cycle: Cycle(start as u32), fraction: start - start.floor() }
}
