//! The broad phase alone, to be measured beside others: spheres in sectors, and which of them intersect.

use glam::DVec2;
use maniple_geometry::Circle;

use crate::bands::{Bands, nobody};
use crate::batch::Batch;
use crate::lanes::{Pairs, add_pairs_of_row, add_pairs_with_level};
use crate::sphere::{MotionSphere, outward_radius};

/// The sectors of a cycle without its objects: only the steps from motion spheres to pairs that may meet. The same code
/// as in [`crate::World::step`], which does not use this type. Keeps its memory from call to call.
#[derive(Clone, Debug)]
pub struct BroadPhase {
    batch: Batch<f64>,
    bands: Bands<f64>,
    pairs: Pairs,
}

/// What a broad phase did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NearPairs {
    /// Pairs of spheres that were tested.
    pub tested: usize,
    /// Pairs of spheres that intersect. A sphere is rounded outwards, by less than 2^-18 of its radius and of its
    /// distance from the first one, so that a pair that all but intersects may be among them.
    pub found: usize,
}

impl BroadPhase {
    /// Returns a broad phase without any memory yet.
    #[must_use]
    pub fn new() -> Self {
        Self { batch: Batch::new(), bands: Bands::new(), pairs: Pairs::default() }
    }

    /// Returns how many pairs of spheres had to be tested, and how many of them intersect; each pair counts once.
    ///
    /// The spheres need finite centres and positive radii, as the limits of a world have them. In one thread, except that
    /// spheres of several orders of magnitude are sorted into sectors by as many as rayon has.
    ///
    /// # Panics
    /// Where there are more spheres than a `u32` can count.
    pub fn near_pairs(&mut self, spheres: &[Circle]) -> NearPairs {
        self.gather(spheres);
        self.bands.fill(std::slice::from_mut(&mut self.batch), 1, |_| nobody());
        let (bands, pairs) = (&self.bands, &mut self.pairs);
        let mut near = NearPairs::default();
        for (number, band) in bands.all().iter().enumerate() {
            for row in band.rows() {
                pairs.clear();
                near.tested += add_pairs_of_row(bands, number, row, pairs);
                near.found += pairs.len();
            }
            for level in bands.levels_seen_from(number) {
                for (place, node) in (0u32..).zip(band.base..).take(band.tags.len()) {
                    pairs.clear();
                    near.tested += add_pairs_with_level(bands, level, (node, band.sphere(place)), pairs);
                    near.found += pairs.len();
                }
            }
        }
        near
    }

    /// Rounds the spheres outwards, as those of a cycle are.
    fn gather(&mut self, spheres: &[Circle]) {
        let anchor = spheres.first().map_or(DVec2::ZERO, |sphere| sphere.center);
        self.batch.slots.clear();
        self.batch.slots.extend(0..u32::try_from(spheres.len()).expect("fewer spheres than a u32 can count"));
        self.batch.clear_spheres();
        for sphere in spheres {
            let radius = outward_radius(sphere.radius);
            self.batch.add_sphere(MotionSphere::outward(sphere.center - anchor, radius));
        }
    }
}

impl Default for BroadPhase {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Spheres strewn over a square of 100, one in a hundred of them many times larger.
    fn strewn(count: u32, giant: f64) -> Vec<Circle> {
        let mut state = count;
        let mut unit = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state) / f64::from(u32::MAX)
        };
        (0..count)
            .map(|place| {
                let scale = if place % 100 == 0 { giant } else { 1.0 };
                Circle::new(DVec2::new(100.0 * unit(), 100.0 * unit()), scale * (0.2 + unit()))
            })
            .collect()
    }

    /// How many pairs come within a share of touching.
    fn all_pairs(spheres: &[Circle], share: f64) -> usize {
        let near = |a: &Circle, b: &Circle| {
            let reach = (a.radius + b.radius) * share;
            a.center.distance_squared(b.center) <= reach * reach
        };
        let later = |place: usize, a: &Circle| spheres[place + 1..].iter().filter(|b| near(a, b)).count();
        spheres.iter().enumerate().map(|(place, a)| later(place, a)).sum()
    }

    #[test]
    fn the_pairs_are_those_of_all_that_intersect_or_nearly_do() {
        let mut broad = BroadPhase::new();
        for (count, giant) in
            [(0, 1.0), (1, 1.0), (2, 1.0), (50, 8.0), (1000, 1.0), (3000, 1.0), (3000, 40.0)]
        {
            let spheres = strewn(count, giant);
            let near = broad.near_pairs(&spheres);
            let (least, most) = (all_pairs(&spheres, 1.0), all_pairs(&spheres, 1.0 + 1e-3));
            assert!((least..=most).contains(&near.found), "{count} x {giant}: {least} {near:?} {most}");
            assert!(near.tested >= near.found, "{count} x {giant}: {near:?}");
        }
    }

    #[test]
    fn few_pairs_are_tested_where_spheres_are_strewn() {
        let spheres = strewn(3000, 1.0);
        let near = BroadPhase::new().near_pairs(&spheres);
        assert!(near.tested * 20 < spheres.len() * spheres.len() / 2, "{near:?}");
    }

    #[test]
    fn a_call_leaves_nothing_to_the_next() {
        let (few, many) = (strewn(40, 8.0), strewn(900, 1.0));
        let mut broad = BroadPhase::new();
        let first = broad.near_pairs(&few);
        broad.near_pairs(&many);
        assert_eq!(broad.near_pairs(&few), first);
    }
}
