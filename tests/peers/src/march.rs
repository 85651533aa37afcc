//! The scene: circles that march through a square on random headings, and turn where they are blocked.

use std::f64::consts::{PI, TAU};

use glam::DVec2;

/// Radius of every circle, in world units.
pub(crate) const RADIUS: f64 = 0.4;

/// Distance of the centres of two circles that touch, in world units.
pub(crate) const CONTACT: f64 = 2.0 * RADIUS;

/// Smallest speed of a circle, in world units a cycle.
pub(crate) const SPEED_MIN: f64 = 0.1;

/// Largest speed of a circle, in world units a cycle.
pub(crate) const SPEED_MAX: f64 = 1.0;

/// Largest share of the area that circles may cover: random placing gets slow above it and cannot go beyond 0.547.
pub(crate) const DENSITY_MAX: f64 = 0.4;

/// Smallest gap between two circles, and between a circle and a wall, at the start, in world units: more than single
/// precision loses in a world of 10,000 units, so that every engine starts without an overlap.
const START_GAP: f64 = 0.001;

/// A circle that made less than this share of its way takes a new heading.
const BLOCKED_BELOW: f64 = 0.9;

/// Where everybody starts, and how fast; a function of its size, density and seed.
#[derive(Clone, Debug)]
pub(crate) struct Scene {
    /// Edge of the square, from the origin, in world units.
    pub(crate) side: f64,
    /// The centres at the start.
    pub(crate) starts: Vec<DVec2>,
    speeds: Vec<f64>,
    seed: u64,
}

/// The march of one engine: what everybody wants. Equal for two engines as long as the same circles are blocked.
#[derive(Clone, Debug)]
pub(crate) struct March<'a> {
    scene: &'a Scene,
    /// How many headings each circle has drawn.
    draws: Vec<u64>,
    velocities: Vec<DVec2>,
}

impl Scene {
    /// Returns a scene whose circles cover the share `density` of the square, in `0.0..=DENSITY_MAX`.
    ///
    /// Places one circle after the other at a uniformly random point that is free (random sequential addition).
    pub(crate) fn random(objects: u32, density: f64, seed: u64) -> Self {
        let side = (f64::from(objects) * PI * RADIUS * RADIUS / density).sqrt();
        let speeds = (0..u64::from(objects)).map(|object| {
            let draw = unit(&[seed, Purpose::Speed as u64, object]);
            SPEED_MIN + (SPEED_MAX - SPEED_MIN) * draw
        });
        let mut placing = Placing::new(side);
        let mut attempts = 0u64..;
        while placing.taken.len() < objects as usize {
            let attempt = attempts.next().expect("there are always more attempts");
            let draws = [Purpose::StartX, Purpose::StartY].map(|axis| unit(&[seed, axis as u64, attempt]));
            placing.try_place(DVec2::from(draws));
        }
        Self { side, starts: placing.taken, speeds: speeds.collect(), seed }
    }

    /// Returns a scene with given starts, each circle at full speed.
    #[cfg(test)]
    pub(crate) fn of(side: f64, starts: Vec<DVec2>) -> Self {
        let speeds = vec![SPEED_MAX; starts.len()];
        Self { side, starts, speeds, seed: 0 }
    }

    /// Returns the ends of the four walls.
    pub(crate) fn walls(&self) -> [(DVec2, DVec2); 4] {
        let corner = |x, y| DVec2::new(x, y) * self.side;
        let corners = [corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)];
        std::array::from_fn(|place| (corners[place], corners[(place + 1) % 4]))
    }

    fn velocity(&self, object: usize, draw: u64) -> DVec2 {
        let heading = TAU * unit(&[self.seed, Purpose::Heading as u64, object as u64, draw]);
        self.speeds[object] * DVec2::from_angle(heading)
    }
}

impl<'a> March<'a> {
    /// Returns the march at its start: everybody has drawn one heading.
    pub(crate) fn new(scene: &'a Scene) -> Self {
        let velocities = (0..scene.starts.len()).map(|object| scene.velocity(object, 0)).collect();
        Self { scene, draws: vec![1; scene.starts.len()], velocities }
    }

    /// Gives a new heading to everybody who was blocked on the way from `before` to `after`.
    pub(crate) fn turn(&mut self, before: &[DVec2], after: &[DVec2]) {
        for (object, (from, to)) in before.iter().zip(after).enumerate() {
            if from.distance(*to) < BLOCKED_BELOW * self.scene.speeds[object] {
                self.velocities[object] = self.scene.velocity(object, self.draws[object]);
                self.draws[object] += 1;
            }
        }
    }

    /// Returns the velocity that each circle wants, in world units a cycle.
    pub(crate) fn velocities(&self) -> &[DVec2] {
        &self.velocities
    }
}

/// What a draw is for, so that two draws are never the same.
#[derive(Clone, Copy, Debug)]
enum Purpose {
    StartX,
    StartY,
    Speed,
    Heading,
}

/// Circles that have a place, in buckets as wide as two circles that touch.
struct Placing {
    side: f64,
    columns: usize,
    buckets: Vec<Vec<DVec2>>,
    taken: Vec<DVec2>,
}

impl Placing {
    fn new(side: f64) -> Self {
        let columns = bucket(side) + 1;
        Self { side, columns, buckets: vec![Vec::new(); columns * columns], taken: Vec::new() }
    }

    /// Takes the place at a share of the room between the walls, if it is free.
    fn try_place(&mut self, share: DVec2) {
        let margin = RADIUS + START_GAP;
        let center = share * (self.side - 2.0 * margin) + margin;
        let (column, row) = (bucket(center.x), bucket(center.y));
        let last = self.columns - 1;
        for y in row.saturating_sub(1)..=(row + 1).min(last) {
            for x in column.saturating_sub(1)..=(column + 1).min(last) {
                let near = &self.buckets[y * self.columns + x];
                if near.iter().any(|other| other.distance(center) < CONTACT + START_GAP) {
                    return;
                }
            }
        }
        self.buckets[row * self.columns + column].push(center);
        self.taken.push(center);
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "coordinates are small and positive"
)]
fn bucket(coordinate: f64) -> usize {
    (coordinate / (CONTACT + START_GAP)) as usize
}

/// Returns a number in `0.0..1.0` that depends on all `parts` (the mixing function of SplitMix64: Steele, Lea,
/// Flood, *Fast Splittable Pseudorandom Number Generators*, 2014, §5).
fn unit(parts: &[u64]) -> f64 {
    let mut mixed = 0u64;
    for part in parts {
        mixed = mixed.wrapping_add(*part).wrapping_add(0x9e37_79b9_7f4a_7c15);
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^= mixed >> 31;
    }
    // The upper 53 bits, as many as a double holds.
    (mixed >> 11) as f64 / (1u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scene_starts_without_an_overlap_and_within_its_walls() {
        let scene = Scene::random(500, 0.25, 7);
        for (place, start) in scene.starts.iter().enumerate() {
            assert!(start.min_element() > RADIUS && start.max_element() < scene.side - RADIUS);
            assert!(scene.starts[..place].iter().all(|other| other.distance(*start) > CONTACT));
        }
        let covered = 500.0 * PI * RADIUS * RADIUS / (scene.side * scene.side);
        assert!((covered - 0.25).abs() < 1e-12);
    }

    #[test]
    fn a_seed_decides_the_scene() {
        let starts = |seed| Scene::random(50, 0.05, seed).starts;
        assert_eq!(starts(1), starts(1));
        assert_ne!(starts(1), starts(2));
    }

    #[test]
    fn only_a_blocked_circle_turns() {
        let scene = Scene::of(10.0, vec![DVec2::splat(3.0), DVec2::splat(7.0)]);
        let mut march = March::new(&scene);
        let wanted = march.velocities().to_vec();
        let after = [scene.starts[0] + wanted[0], scene.starts[1] + 0.8 * wanted[1]];
        march.turn(&scene.starts, &after);
        assert_eq!(march.velocities()[0], wanted[0]);
        assert_ne!(march.velocities()[1], wanted[1]);
    }
}
