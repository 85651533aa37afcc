//! The engines, each behind the same three calls.

#[cfg(feature = "box2d")]
mod box2d;
mod brute;
mod maniple;
mod rapier;

use clap::ValueEnum;
use glam::DVec2;
use serde::Serialize;

use crate::march::Scene;

/// Simulated seconds that a cycle lasts in the engines that count in seconds: 0.1 s, so that the fastest circle goes
/// 10 world units a second, which is within what they are tuned for.
const CYCLE_SECONDS: f32 = 0.1;

/// Largest number of objects for the engine that compares all pairs: 50 million pairs a cycle.
const BRUTE_OBJECTS_MAX: u32 = 10_000;

/// An engine, with a scene in it.
pub(crate) trait Engine {
    /// Tells every circle the velocity that it wants in the next cycle, in world units a cycle.
    fn order(&mut self, velocities: &[DVec2]);

    /// Simulates one cycle.
    fn step(&mut self);

    /// Writes the centre of every circle.
    fn read(&self, positions: &mut [DVec2]);
}

/// Which engine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Kind {
    /// The kinematics core of this project.
    Maniple,
    /// rapier2d with continuous collision on.
    Rapier,
    /// Box2D with continuous collision on, which is for moving against static only.
    #[cfg(feature = "box2d")]
    Box2d,
    /// Box2D with every circle a bullet: continuous collision between moving circles, too. Not run unless named.
    #[cfg(feature = "box2d")]
    Box2dBullets,
    /// All pairs, exact stops.
    Brute,
}

impl Kind {
    /// The engines that run unless others are named.
    pub(crate) const DEFAULT: &[Self] = &[
        Self::Maniple,
        Self::Rapier,
        #[cfg(feature = "box2d")]
        Self::Box2d,
        Self::Brute,
    ];

    /// Returns the engine with the scene in it, everybody at rest.
    pub(crate) fn build(self, scene: &Scene) -> Box<dyn Engine> {
        match self {
            Self::Maniple => Box::new(maniple::Maniple::new(scene)),
            Self::Rapier => Box::new(rapier::Rapier::new(scene)),
            #[cfg(feature = "box2d")]
            Self::Box2d => Box::new(box2d::Box2d::new(scene, box2d::Continuous::AgainstWalls)),
            #[cfg(feature = "box2d")]
            Self::Box2dBullets => Box::new(box2d::Box2d::new(scene, box2d::Continuous::AgainstAll)),
            Self::Brute => Box::new(brute::Brute::new(scene)),
        }
    }

    /// Returns why the engine does not run at a number of objects; `None` where it does.
    pub(crate) fn obstacle(self, objects: u32) -> Option<String> {
        (self == Self::Brute && objects > BRUTE_OBJECTS_MAX)
            .then(|| format!("it compares all pairs, which is for at most {BRUTE_OBJECTS_MAX} objects"))
    }

    /// Returns the name as in the arguments and results.
    pub(crate) fn name(self) -> String {
        self.to_possible_value().expect("no engine is hidden").get_name().to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::march::{CONTACT, March, RADIUS, SPEED_MAX};

    /// Single precision in a world of 10 units, and the margins that engines keep.
    const TOLERANCE: f64 = 0.02;

    #[test]
    fn a_free_circle_makes_its_whole_way_in_every_engine() {
        let scene = Scene::of(20.0, vec![DVec2::new(3.0, 10.0), DVec2::new(15.0, 5.0)]);
        for &kind in Kind::value_variants() {
            let after = run(kind, &scene, &[DVec2::new(1.0, 0.5), DVec2::new(-0.3, 0.0)], 5);
            assert!(after[0].distance(DVec2::new(8.0, 12.5)) < 1e-4, "{kind:?} {after:?}");
            assert!(after[1].distance(DVec2::new(13.5, 5.0)) < 1e-4, "{kind:?} {after:?}");
        }
    }

    #[test]
    fn a_wall_stops_a_circle_in_every_engine() {
        let scene = Scene::of(10.0, vec![DVec2::new(8.0, 5.0)]);
        for &kind in Kind::value_variants() {
            let after = run(kind, &scene, &[DVec2::new(1.0, 0.0)], 5);
            assert!((after[0].x - (10.0 - RADIUS)).abs() < TOLERANCE, "{kind:?} {after:?}");
        }
    }

    #[test]
    fn circles_that_meet_stop_where_they_touch_in_the_exact_engines() {
        let scene = Scene::of(10.0, vec![DVec2::new(3.0, 5.0), DVec2::new(5.0, 5.0)]);
        for kind in [Kind::Maniple, Kind::Brute] {
            let after = run(kind, &scene, &[DVec2::new(1.0, 0.0), DVec2::new(-1.0, 0.0)], 3);
            assert!((after[0].distance(after[1]) - CONTACT).abs() < 1e-8, "{kind:?} {after:?}");
            assert!((after[0].x - 3.6).abs() < 1e-8, "{kind:?} {after:?}");
        }
    }

    /// The first cycle alone: later, circles rest at the skin of each other, and whether two collisions of the next
    /// cycle come at the same time or one rounding error apart differs with the skin.
    #[test]
    fn brute_and_maniple_stop_the_same_number_of_objects() {
        for seed in 1..=40 {
            let scene = Scene::random(150, 0.25, seed);
            let [ours, brute] = [Kind::Maniple, Kind::Brute].map(|kind| stopped(kind, &scene));
            assert_eq!(ours, brute, "seed {seed}");
            assert!(ours > 10, "seed {seed}: {ours}");
        }
    }

    fn run(kind: Kind, scene: &Scene, velocities: &[DVec2], cycles: u32) -> Vec<DVec2> {
        let mut engine = kind.build(scene);
        let mut positions = scene.starts.clone();
        for _ in 0..cycles {
            engine.order(velocities);
            engine.step();
            engine.read(&mut positions);
        }
        positions
    }

    /// How many objects do not make their whole way in the first cycle of a march.
    fn stopped(kind: Kind, scene: &Scene) -> usize {
        let march = March::new(scene);
        let after = run(kind, scene, march.velocities(), 1);
        let ways = scene.starts.iter().zip(&after).map(|(from, to)| from.distance(*to));
        let wanted = march.velocities().iter().map(|velocity| velocity.length());
        ways.zip(wanted).filter(|(way, wanted)| *way < wanted - 1e-6 * SPEED_MAX).count()
    }
}
