//! The square buckets of the broad phase.

use maniple_geometry::{Planar, Scalar};

use crate::sphere::MotionSphere;

/// The most sectors along one side of the world: with three grids, 24 bytes a bucket, under 5 MB in all.
const SECTORS_A_SIDE_MAX: usize = 256;

/// A grid of square buckets that holds numbers by place. What lies outside counts as in the outermost buckets, so that
/// nothing is ever missed.
#[doc(alias = "grid cell")]
#[derive(Clone, Debug)]
pub(crate) struct Sectors<S: Scalar> {
    origin: S::Vector,
    /// Sectors a world unit.
    inverse_edge: S,
    columns: usize,
    rows: usize,
    buckets: Vec<Vec<u32>>,
}

/// A rectangle of sectors: columns and rows, both ends included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Range {
    columns: (usize, usize),
    rows: (usize, usize),
}

impl<S: Scalar> Sectors<S> {
    /// Returns empty sectors over a box, with edges of at least `edge` world units.
    pub(crate) fn new(low: S::Vector, high: S::Vector, edge: S) -> Self {
        let extent = high - low;
        let longest = extent.x().greater(extent.y());
        let edge = edge.greater(longest / S::from_f64(256.0));
        let count = |length: S| (index((length / edge).floor()) + 1).min(SECTORS_A_SIDE_MAX);
        let (columns, rows) = (count(extent.x()), count(extent.y()));
        Self {
            origin: low,
            inverse_edge: S::ONE / edge,
            columns,
            rows,
            buckets: vec![Vec::new(); columns * rows],
        }
    }

    /// Puts a number into all buckets that a circle's bounding box meets.
    pub(crate) fn insert(&mut self, number: u32, center: S::Vector, radius: S) {
        let reach = S::Vector::new(radius, radius);
        self.insert_box(number, center - reach, center + reach);
    }

    /// Puts a number into all buckets that a box meets.
    pub(crate) fn insert_box(&mut self, number: u32, low: S::Vector, high: S::Vector) {
        let range = self.range(low, high);
        for bucket in self.indices(range) {
            self.buckets[bucket].push(number);
        }
    }

    /// Takes a number out of all buckets that a circle's bounding box meets.
    pub(crate) fn remove(&mut self, number: u32, center: S::Vector, radius: S) {
        let reach = S::Vector::new(radius, radius);
        let range = self.range(center - reach, center + reach);
        for bucket in self.indices(range) {
            self.buckets[bucket].retain(|&held| held != number);
        }
    }

    /// Returns the numbers in all buckets that a sphere's bounding box meets, sorted, each once.
    pub(crate) fn near(&self, sphere: &MotionSphere<S>) -> Vec<u32> {
        let reach = S::Vector::new(sphere.radius, sphere.radius);
        let range = self.range(sphere.center - reach, sphere.center + reach);
        let mut found = Vec::new();
        for bucket in self.indices(range) {
            found.extend_from_slice(&self.buckets[bucket]);
        }
        found.sort_unstable();
        found.dedup();
        found
    }

    fn range(&self, low: S::Vector, high: S::Vector) -> Range {
        let (low, high) = (low - self.origin, high - self.origin);
        let place = |length: S, count: usize| index((length * self.inverse_edge).floor()).min(count - 1);
        Range {
            columns: (place(low.x(), self.columns), place(high.x(), self.columns)),
            rows: (place(low.y(), self.rows), place(high.y(), self.rows)),
        }
    }

    fn indices(&self, range: Range) -> impl Iterator<Item = usize> + use<S> {
        let width = self.columns;
        (range.rows.0..=range.rows.1)
            .flat_map(move |row| (range.columns.0..=range.columns.1).map(move |column| row * width + column))
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "what lies outside is meant to saturate: the cast takes negative numbers to 0"
)]
fn index<S: Scalar>(place: S) -> usize {
    place.to_f64() as usize
}
