//! rapier2d, with continuous collision on for every circle.

use glam::DVec2;
use rapier2d::pipeline::PhysicsWorld;
use rapier2d::prelude::{ColliderBuilder, RigidBodyBuilder, RigidBodyHandle, Vector};

use super::{CYCLE_SECONDS, Engine};
use crate::march::{RADIUS, Scene};

/// A world without gravity, and the body of each circle.
pub(super) struct Rapier {
    world: PhysicsWorld,
    bodies: Vec<RigidBodyHandle>,
}

impl Rapier {
    pub(super) fn new(scene: &Scene) -> Self {
        let mut world = PhysicsWorld { gravity: Vector::ZERO, ..PhysicsWorld::default() };
        world.integration_parameters.dt = CYCLE_SECONDS;
        for (start, end) in scene.walls() {
            let wall = ColliderBuilder::segment(vector(start), vector(end));
            world.insert(RigidBodyBuilder::fixed(), wall.restitution(0.0).friction(0.0));
        }
        let radius = vector(DVec2::splat(RADIUS)).x;
        let mut insert = |start: &DVec2| {
            let body = RigidBodyBuilder::dynamic().translation(vector(*start)).lock_rotations();
            let ball = ColliderBuilder::ball(radius).restitution(0.0).friction(0.0);
            world.insert(body.can_sleep(false).ccd_enabled(true), ball).0
        };
        let bodies = scene.starts.iter().map(&mut insert).collect();
        Self { world, bodies }
    }
}

impl Engine for Rapier {
    fn order(&mut self, velocities: &[DVec2]) {
        for (&body, velocity) in self.bodies.iter().zip(velocities) {
            self.world.bodies[body].set_linvel(vector(*velocity) / CYCLE_SECONDS, true);
        }
    }

    fn step(&mut self) {
        self.world.step();
    }

    fn read(&self, positions: &mut [DVec2]) {
        for (&body, position) in self.bodies.iter().zip(positions) {
            let center = self.world.bodies[body].translation();
            *position = DVec2::new(center.x.into(), center.y.into());
        }
    }
}

fn vector(point: DVec2) -> Vector {
    let point = point.as_vec2();
    Vector::new(point.x, point.y)
}
