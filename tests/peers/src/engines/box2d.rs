//! Box2D, version 3, with continuous collision on.

use boxdd::{
    BodyBuilder, BodyId, BodyType, Circle, Error, Foundation, MotionLocks, Segment, ShapeDef,
    SurfaceMaterial, Vec2, WorkerCount, World, WorldBuilder,
};
use glam::DVec2;

use super::{CYCLE_SECONDS, Engine};
use crate::march::{RADIUS, Scene};

/// Solver sub-steps of a step: what Box2D's documents recommend.
const SUB_STEPS: i32 = 4;

/// Between whom collision is continuous.
#[derive(Clone, Copy, Debug)]
pub(super) enum Continuous {
    /// Circles and walls: the default of the engine.
    AgainstWalls,
    /// Circles and everything: every circle is a bullet.
    AgainstAll,
}

/// A world without gravity, and the body of each circle.
pub(super) struct Box2d {
    /// Access to a body borrows the world mutably, even to read.
    world: std::cell::RefCell<World>,
    bodies: Vec<BodyId>,
}

impl Box2d {
    pub(super) fn new(scene: &Scene, continuous: Continuous) -> Self {
        Self::try_new(scene, continuous).expect("Box2D takes the scene")
    }

    fn try_new(scene: &Scene, continuous: Continuous) -> Result<Self, Error> {
        let foundation = Foundation::initialize_default()?;
        let definition = WorldBuilder::from(foundation.world_def())
            .gravity(Vec2::new(0.0, 0.0))
            .enable_sleep(false)
            .enable_continuous(true)
            .worker_count(WorkerCount::new(1)?);
        let mut world = foundation.create_world(definition.build()?)?;
        let smooth = SurfaceMaterial::new().with_friction(0.0)?.with_restitution(0.0)?;
        let shape = ShapeDef::builder().material(smooth).density(1.0);
        let shape = shape.enable_contact_events(false).enable_sensor_events(false).build()?;

        let frame = world.create_body(BodyBuilder::from(foundation.body_def()).build()?)?;
        for (start, end) in scene.walls() {
            let wall = Segment::new(start.as_vec2().to_array(), end.as_vec2().to_array())?;
            world.body(frame)?.create_segment(&shape, &wall)?;
        }
        let circle = Circle::new([0.0, 0.0], DVec2::splat(RADIUS).as_vec2().x)?;
        let mut bodies = Vec::with_capacity(scene.starts.len());
        for start in &scene.starts {
            let body = BodyBuilder::from(foundation.body_def())
                .body_type(BodyType::Dynamic)
                .position(start.as_vec2().to_array())
                .motion_locks(MotionLocks::new(false, false, true))
                .enable_sleep(false)
                .bullet(matches!(continuous, Continuous::AgainstAll));
            let body = world.create_body(body.build()?)?;
            world.body(body)?.create_circle(&shape, &circle)?;
            bodies.push(body);
        }
        Ok(Self { world: world.into(), bodies })
    }

    fn try_order(&mut self, velocities: &[DVec2]) -> Result<(), Error> {
        let world = self.world.get_mut();
        for (&body, velocity) in self.bodies.iter().zip(velocities) {
            world.body(body)?.set_linear_velocity((velocity.as_vec2() / CYCLE_SECONDS).to_array())?;
        }
        Ok(())
    }

    fn try_read(&self, positions: &mut [DVec2]) -> Result<(), Error> {
        let mut world = self.world.borrow_mut();
        for (&body, position) in self.bodies.iter().zip(positions) {
            let center = world.body(body)?.position()?;
            *position = DVec2::new(center.x.into(), center.y.into());
        }
        Ok(())
    }
}

impl Engine for Box2d {
    fn order(&mut self, velocities: &[DVec2]) {
        self.try_order(velocities).expect("Box2D takes the velocities");
    }

    fn step(&mut self) {
        let completed = self.world.get_mut().step(CYCLE_SECONDS, SUB_STEPS);
        completed.and_then(|completed| completed.into_result().map(drop)).expect("Box2D makes the step");
    }

    fn read(&self, positions: &mut [DVec2]) {
        self.try_read(positions).expect("Box2D knows its bodies");
    }
}
