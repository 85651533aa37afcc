//! The proof, after each cycle, that the rounded positions overlap nowhere.
//!
//! The collisions were found on straight lines of real numbers; what is stored is rounded. Where two circles slide
//! along each other or march in step without a gap, rounding alone can make them overlap by the last bit. So every
//! pair that came near each other is checked with an exact predicate, and who fails is pulled back along its own
//! track by a few bits, twice as many each time. The pulled-back are checked again with their neighbours, round by
//! round. At worst all are back where they were at the start of the cycle, and that was certified one cycle ago: so
//! it ends, and it ends without an overlap. An object is pulled back at most `RETREATS_MAX` times.

use maniple_geometry::predicate::{circle_overlaps_segment, circles_overlap};
use maniple_geometry::{Planar, Scalar};

use crate::graph::Setting;
use crate::runner::{Runner, Track};
use crate::solve::{Solver, first_contact};
use crate::track::Stage;

/// How often an object can be pulled back before it is at its start: the steps are 4, 8, 16… roundoffs of the cycle,
/// and 2^53 of them are the whole of it.
const RETREATS_MAX: u32 = 64;

impl<S: Scalar> Solver<S> {
    /// Pulls objects back until none overlaps another or a wall.
    ///
    /// Each round looks at the state that the round before has left and pulls back all that fail at once, so that the
    /// result does not depend on any order.
    pub(crate) fn certify(&mut self, setting: &Setting<'_, S>) {
        self.failed.clear();
        for edge in 0..self.edges.len() {
            let (a, b) = self.edges[edge];
            let (first, second) = (&self.runners[a as usize], &self.runners[b as usize]);
            if circles_overlap::<S>(first.last, first.radius, second.last, second.radius) {
                self.judge((a, b), setting.rounding);
            }
        }
        setting.walls.fetch(self.beside.iter().map(|&index| self.runners[index as usize].last.to_dvec2()));
        for &index in &self.beside {
            let this = &self.runners[index as usize];
            if (this.ends_near || this.halt.is_some()) && overlaps_anything_at_rest(this, setting) {
                self.failed.push(index);
            }
        }
        while !self.failed.is_empty() {
            self.pull_back(setting);
        }
    }

    /// Pulls all who failed back, and finds out who fails then.
    fn pull_back(&mut self, setting: &Setting<'_, S>) {
        std::mem::swap(&mut self.failed, &mut self.pulled);
        self.failed.clear();
        let mut failed = std::mem::take(&mut self.pulled);
        let mut suspects = std::mem::take(&mut self.suspects);
        failed.sort_unstable();
        failed.dedup();
        suspects.clear();
        for &runner in &failed {
            let this = &mut self.runners[runner as usize];
            if !this.is_held && matches!(this.track, Track::Straight { .. }) {
                self.touched.push(runner);
            }
            this.retreat(&self.arena);
            assert!(this.retreats <= RETREATS_MAX, "retreats reach the start");
            suspects.extend_from_slice(self.links_of(runner));
        }
        suspects.sort_unstable();
        suspects.dedup();
        for &edge in &suspects {
            self.judge(self.edges[edge as usize], setting.rounding);
        }
        for &runner in &failed {
            if overlaps_anything_at_rest(&self.runners[runner as usize], setting) {
                self.failed.push(runner);
            }
        }
        self.suspects = suspects;
        self.pulled = failed;
    }

    /// Adds who of a pair has to be pulled back, if it fails.
    fn judge(&mut self, (a, b): (u32, u32), rounding: S) {
        let (first, second) = (&self.runners[a as usize], &self.runners[b as usize]);
        if circles_overlap::<S>(first.last, first.radius, second.last, second.radius) {
            let advances = |runner: &Runner<S>, way: S::Vector| {
                runner.can_retreat(&self.arena)
                    && runner.velocity_at(runner.end, &self.arena).dot(way) > S::ZERO
            };
            let (one, other) =
                (advances(first, second.last - first.last), advances(second, first.last - second.last));
            let (one, other) = if one || other {
                (one, other)
            } else {
                (first.can_retreat(&self.arena), second.can_retreat(&self.arena))
            };
            assert!(one || other, "the state before the cycle was valid");
            self.failed.extend(one.then_some(a));
            self.failed.extend(other.then_some(b));
            return;
        }
        if first.retreats + second.retreats > 0 && passes_through(first, second, rounding, &self.arena) {
            // Who was pulled back rests in the other's way; the other must not have passed.
            let later = if first.end > second.end { a } else { b };
            self.failed.push(later);
        }
    }
}

/// Whether a runner, at the end of the cycle, overlaps a wall or an object at rest.
fn overlaps_anything_at_rest<S: Scalar>(runner: &Runner<S>, setting: &Setting<'_, S>) -> bool {
    let (center, reach) = (runner.last.to_dvec2(), (runner.radius + setting.objects.margin).to_f64());
    if setting.walls.is_clear(center, reach) && setting.resting.is_clear(center, reach) {
        return false;
    }
    let layers = setting.objects.layers[runner.slot as usize];
    let mut overlaps = false;
    setting.walls.near(center, reach, |wall| {
        overlaps |=
            wall.layers.share(layers) && circle_overlaps_segment(runner.last, runner.radius, &wall.segment);
    });
    setting.resting.near(center, reach, |slot| {
        let state = &setting.objects.states[slot as usize];
        overlaps |= setting.objects.layers[slot as usize].share(layers)
            && circles_overlap::<S>(runner.last, runner.radius, state.start, state.radius);
    });
    overlaps
}

/// Whether one of two passes through the other after that was pulled back to its final place, deeper than rounding
/// explains: nearer than touching by more than half the skin that follows from the limits, which is far below any radius.
fn passes_through<S: Scalar>(first: &Runner<S>, second: &Runner<S>, rounding: S, arena: &[Stage<S>]) -> bool {
    let from = first.end.lesser(second.end);
    if from >= S::ONE {
        return false;
    }
    let shrunk =
        |runner: &Runner<S>| Runner { radius: runner.radius - rounding * S::from_f64(0.25), ..*runner };
    first_contact(&shrunk(first), &shrunk(second), (from, S::ZERO), arena).is_some()
}
