//! An independent judge over the positions that an engine reports.

use glam::DVec2;

/// Share of the contact distance above which an overlap counts.
const OVERLAP_COUNTED: f64 = 0.01;

/// Share of the contact distance within which two circles must have passed each other to have tunnelled.
///
/// Half of it, because a circle that is stopped at the share `s` of its way is off the straight way in time by at most
/// `v s (1 - s)`, a quarter of its speed `v`: exact stops at the speeds of the scene are not taken for tunnelling.
const TUNNEL_WITHIN: f64 = 0.5;

/// What became of a number of cycles.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Verdict {
    /// Distance of the centres of two circles that touch.
    contact: f64,
    /// Circles times cycles.
    circle_cycles: u64,
    overlapping: u64,
    tunnelled: u64,
    deepest: f64,
}

impl Verdict {
    /// Returns the verdict over no cycle yet, for circles that touch at the distance `contact` of their centres.
    pub(crate) fn new(contact: f64) -> Self {
        Self { contact, circle_cycles: 0, overlapping: 0, tunnelled: 0, deepest: 0.0 }
    }

    /// Adds a cycle from the positions at its start and at its end.
    ///
    /// # Panics
    /// At a position that is not finite.
    pub(crate) fn add_cycle(&mut self, before: &[DVec2], after: &[DVec2]) {
        assert_eq!(before.len(), after.len(), "nobody comes or goes in a cycle");
        self.circle_cycles += after.len() as u64;
        let grid = Grid::new(before, after, self.contact);
        grid.for_each_near_pair(|a, b| self.add_pair(before[b] - before[a], after[b] - after[a]));
    }

    /// Returns how many pairs overlapped by more than 1 % of the contact distance, per 1,000 objects and cycle.
    pub(crate) fn overlapping(&self) -> f64 {
        self.per_thousand(self.overlapping)
    }

    /// Returns the deepest overlap at the end of a cycle, in world units; 0 where there was none.
    pub(crate) fn deepest(&self) -> f64 {
        self.deepest
    }

    /// Returns how many pairs were apart at both ends of a cycle but came nearer than half of the contact distance on
    /// the straight way between, per 1,000 objects and cycle.
    pub(crate) fn tunnelled(&self) -> f64 {
        self.per_thousand(self.tunnelled)
    }

    /// Adds a pair by the offset of its centres at both ends of the cycle.
    fn add_pair(&mut self, start: DVec2, end: DVec2) {
        let depth = self.contact - end.length();
        self.deepest = self.deepest.max(depth);
        self.overlapping += u64::from(depth > OVERLAP_COUNTED * self.contact);
        let is_apart = depth <= 0.0 && start.length() >= self.contact;
        let is_passed = nearest(start, end) < TUNNEL_WITHIN * self.contact;
        self.tunnelled += u64::from(is_apart && is_passed);
    }

    fn per_thousand(&self, count: u64) -> f64 {
        1000.0 * count as f64 / self.circle_cycles as f64
    }
}

/// Returns the smallest distance from the origin to the straight way from `start` to `end`.
fn nearest(start: DVec2, end: DVec2) -> f64 {
    let way = end - start;
    let squared = way.length_squared();
    let share = if squared > 0.0 { (-start.dot(way) / squared).clamp(0.0, 1.0) } else { 0.0 };
    (start + way * share).length()
}

/// The circles of a cycle by the middle of their way, in square cells.
///
/// Two circles whose centres come within the contact distance `c` during the cycle have the middles of their ways,
/// of lengths `u` and `w`, within `c + (u + w) / 2`. A cell is as wide as that can be, so only adjacent ones matter.
struct Grid {
    columns: usize,
    /// The cell of each circle.
    cells: Vec<usize>,
    /// Where each cell begins in `members`, and the end.
    begins: Vec<usize>,
    members: Vec<usize>,
}

impl Grid {
    fn new(before: &[DVec2], after: &[DVec2], contact: f64) -> Self {
        let middles: Vec<DVec2> = before.iter().zip(after).map(|(from, to)| from.midpoint(*to)).collect();
        assert!(middles.iter().all(|middle| middle.is_finite()), "an engine lost a circle");
        let longest = before.iter().zip(after).map(|(from, to)| from.distance(*to)).fold(0.0, f64::max);
        let low = middles.iter().fold(DVec2::INFINITY, |low, middle| low.min(*middle));
        let high = middles.iter().fold(DVec2::NEG_INFINITY, |high, middle| high.max(*middle));
        let extent = (high - low).max_element();
        // No more cells than circles, so that a circle that was thrown far away does not fill the memory.
        let edge = (contact + longest).max(extent / (middles.len() as f64).sqrt());
        let columns = whole(extent / edge) + 1;
        let cell = |middle: &DVec2| {
            let place = (*middle - low) / edge;
            whole(place.y) * columns + whole(place.x)
        };
        let cells: Vec<usize> = middles.iter().map(cell).collect();
        let mut begins = vec![0; columns * columns + 1];
        for cell in &cells {
            begins[cell + 1] += 1;
        }
        for cell in 0..columns * columns {
            begins[cell + 1] += begins[cell];
        }
        let mut next = begins.clone();
        let mut members = vec![0; cells.len()];
        for (circle, &cell) in cells.iter().enumerate() {
            members[next[cell]] = circle;
            next[cell] += 1;
        }
        Self { columns, cells, begins, members }
    }

    /// Calls `visit` once for every pair in the same or adjacent cells, the smaller index first.
    fn for_each_near_pair(&self, mut visit: impl FnMut(usize, usize)) {
        let last = self.columns - 1;
        for (circle, cell) in self.cells.iter().enumerate() {
            let (row, column) = (cell / self.columns, cell % self.columns);
            for y in row.saturating_sub(1)..=(row + 1).min(last) {
                let from = self.begins[y * self.columns + column.saturating_sub(1)];
                let to = self.begins[y * self.columns + (column + 1).min(last) + 1];
                for &other in self.members[from..to].iter().filter(|&&other| other > circle) {
                    visit(circle, other);
                }
            }
        }
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "cells are counted from the lowest"
)]
fn whole(number: f64) -> usize {
    number as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::march::{CONTACT, March, Scene};

    fn check(before: [(f64, f64); 2], after: [(f64, f64); 2], expected: (u64, u64, f64)) {
        let mut verdict = Verdict::new(0.8);
        verdict.add_cycle(&before.map(DVec2::from), &after.map(DVec2::from));
        assert_eq!(
            (verdict.overlapping, verdict.tunnelled),
            (expected.0, expected.1),
            "{before:?} {after:?}"
        );
        assert!((verdict.deepest - expected.2).abs() < 1e-12, "{} {}", verdict.deepest, expected.2);
    }

    #[test]
    fn a_planted_overlap_is_found() {
        check([(0.0, 0.0), (2.0, 0.0)], [(0.5, 0.0), (1.2, 0.0)], (1, 0, 0.1));
        check([(0.0, 0.0), (2.0, 0.0)], [(0.5, 0.0), (1.3, 0.0)], (0, 0, 0.0));
        // Below 1 % it shows in the depth alone.
        check([(0.0, 0.0), (2.0, 0.0)], [(0.5, 0.0), (1.295, 0.0)], (0, 0, 0.005));
    }

    #[test]
    fn a_planted_tunnelling_is_found() {
        check([(0.0, 0.0), (1.0, 0.0)], [(1.0, 0.0), (0.0, 0.0)], (0, 1, 0.0));
        check([(0.0, 0.0), (1.0, 0.3)], [(1.0, 0.0), (0.0, 0.3)], (0, 1, 0.0));
        // Farther than half of the contact distance, or side by side.
        check([(0.0, 0.0), (1.0, 0.5)], [(1.0, 0.0), (0.0, 0.5)], (0, 0, 0.0));
        check([(0.0, 0.0), (0.9, 0.0)], [(1.0, 0.0), (1.9, 0.0)], (0, 0, 0.0));
        // Whoever overlaps at an end has not passed.
        check([(0.0, 0.0), (1.0, 0.0)], [(0.8, 0.0), (0.2, 0.0)], (1, 0, 0.2));
    }

    #[test]
    fn the_grid_finds_what_all_pairs_find() {
        for (seed, thrown) in [(1, 1.0), (2, 1.0), (3, 20.0), (4, 1000.0)] {
            let scene = Scene::random(400, 0.3, seed);
            let march = March::new(&scene);
            let mut after: Vec<DVec2> = scene
                .starts
                .iter()
                .zip(march.velocities())
                .map(|(start, velocity)| start + velocity)
                .collect();
            after[17] += DVec2::splat(thrown);
            let mut by_grid = Verdict::new(CONTACT);
            by_grid.add_cycle(&scene.starts, &after);
            let mut by_pairs = Verdict::new(CONTACT);
            by_pairs.circle_cycles = 400;
            for a in 0..400 {
                for b in a + 1..400 {
                    by_pairs.add_pair(scene.starts[b] - scene.starts[a], after[b] - after[a]);
                }
            }
            assert_eq!(by_grid, by_pairs, "seed {seed}");
            assert!(by_grid.overlapping > 0 && by_grid.deepest > 0.0);
        }
    }
}
