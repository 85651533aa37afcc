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

use crate::runner::Runner;
use crate::solve::{Component, Setting, first_contact};

/// How often an object can be pulled back before it is at its start: the steps are 4, 8, 16… roundoffs of the cycle,
/// and 2^53 of them are the whole of it.
const RETREATS_MAX: u32 = 64;

impl<S: Scalar> Component<S> {
    /// Pulls objects back until none overlaps another or a wall.
    ///
    /// Each round looks at the state that the round before has left and pulls back all that fail at once, so that the
    /// result does not depend on any order.
    pub(crate) fn certify(&mut self, setting: &Setting<'_, S>, neighbours: &[Vec<u32>]) {
        let mut suspects: Vec<u32> = (0u32..).zip(&self.edges).map(|(edge, _)| edge).collect();
        let mut near_walls = self.walls.clone();
        loop {
            let mut failed: Vec<u32> = Vec::new();
            for &edge in &suspects {
                self.judge(edge, setting, &mut failed);
            }
            failed
                .extend(near_walls.iter().filter(|&&near| self.is_in_wall(near, setting)).map(|near| near.0));
            if failed.is_empty() {
                return;
            }
            failed.sort_unstable();
            failed.dedup();
            for &runner in &failed {
                self.runners[runner as usize].retreat();
                assert!(self.runners[runner as usize].retreats <= RETREATS_MAX, "retreats reach the start");
            }
            suspects =
                failed.iter().flat_map(|&runner| neighbours[runner as usize].iter().copied()).collect();
            suspects.sort_unstable();
            suspects.dedup();
            near_walls =
                self.walls.iter().filter(|near| failed.binary_search(&near.0).is_ok()).copied().collect();
        }
    }

    /// Adds who of a pair has to be pulled back, if it fails.
    fn judge(&self, edge: u32, setting: &Setting<'_, S>, failed: &mut Vec<u32>) {
        let (a, b) = self.edges[edge as usize];
        let (first, second) = (&self.runners[a as usize], &self.runners[b as usize]);
        let (p, q) = (first.final_position(setting.cycle), second.final_position(setting.cycle));
        if circles_overlap::<S>(p, first.radius, q, second.radius) {
            let advances = |runner: &Runner<S>, way: S::Vector| {
                runner.can_retreat() && runner.stage_at(runner.end).motion.velocity.dot(way) > S::ZERO
            };
            let (one, other) = (advances(first, q - p), advances(second, p - q));
            if one || other {
                failed.extend(one.then_some(a));
                failed.extend(other.then_some(b));
            } else {
                failed.extend(first.can_retreat().then_some(a));
                failed.extend(second.can_retreat().then_some(b));
            }
            assert!(first.can_retreat() || second.can_retreat(), "the state before the cycle was valid");
            return;
        }
        if first.retreats + second.retreats > 0 && passes_through(first, second, setting.skin) {
            // Who was pulled back rests in the other's way; the other must not have passed.
            let later = if first.end > second.end { a } else { b };
            failed.push(later);
        }
    }

    fn is_in_wall(&self, (runner, wall): (u32, u32), setting: &Setting<'_, S>) -> bool {
        let this = &self.runners[runner as usize];
        let segment = &setting.walls[wall as usize].segment;
        circle_overlaps_segment(this.final_position(setting.cycle), this.radius, segment)
    }
}

/// Whether one of two passes through the other after that was pulled back to its final place, deeper than rounding
/// explains: nearer than touching by more than half a skin.
fn passes_through<S: Scalar>(first: &Runner<S>, second: &Runner<S>, skin: S) -> bool {
    let from = first.end.lesser(second.end);
    if from >= S::ONE {
        return false;
    }
    let shrunk =
        |runner: &Runner<S>| Runner { radius: runner.radius - skin * S::from_f64(0.25), ..runner.clone() };
    first_contact(&shrunk(first), &shrunk(second), from, S::ZERO).is_some()
}
