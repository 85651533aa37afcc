//! The kinematics core of this project, through its public interface.

use glam::DVec2;
use maniple_geometry::{Circle, Limits, ObjectId, Segment};
use maniple_kinematics::{Layers, Leg, Placement, Stops, Wall, WallKind, World};

use super::Engine;
use crate::march::{RADIUS, SPEED_MAX, Scene};

/// How far ahead of a circle its goal lies, in edges of the square: it never gets there.
const GOAL_AHEAD: f64 = 2.0;

/// Largest coordinate of a goal, in edges of the square.
const REACH: f64 = 1.0 + GOAL_AHEAD;

/// A world, with the ids of its objects counted from 0.
pub(super) struct Maniple {
    world: World,
    ahead: f64,
}

impl Maniple {
    pub(super) fn new(scene: &Scene) -> Self {
        // Twice the largest speed, because the length of a velocity is rounded.
        let limits = Limits::new(REACH * scene.side, RADIUS, 2.0 * SPEED_MAX).expect("the scene has a size");
        let walls = scene.walls().map(|(start, end)| Wall {
            segment: Segment::new(start, end),
            kind: WallKind::Edge,
            layers: Layers::GROUND,
        });
        let mut world = World::new(limits, Stops::Both, &walls).expect("the walls are within the limits");
        for (id, start) in (0..).zip(&scene.starts) {
            let circle = Circle::new(*start, RADIUS);
            world.insert(ObjectId(id), circle, Layers::GROUND).expect("the start is free");
        }
        Self { world, ahead: GOAL_AHEAD * scene.side }
    }
}

impl Engine for Maniple {
    /// Orders only those at rest: whoever moves does what is wanted, since who was blocked was stopped.
    fn order(&mut self, velocities: &[DVec2]) {
        for (id, velocity) in (0..).map(ObjectId).zip(velocities) {
            if self.world.motion(id).is_some_and(|motion| motion.is_moving()) {
                continue;
            }
            let center = self.world.circle(id).expect("nobody leaves").center;
            let speed = velocity.length();
            let leg = Leg { goal: center + *velocity * (self.ahead / speed), speed };
            self.world.go(id, &[leg], Placement::Replace, None).expect("the order is within the limits");
        }
    }

    fn step(&mut self) {
        self.world.step();
    }

    fn read(&self, positions: &mut [DVec2]) {
        for (id, position) in (0..).map(ObjectId).zip(positions) {
            *position = self.world.circle(id).expect("nobody leaves").center;
        }
    }
}
