//! Who is on the way already, and when another can depart.

use glam::DVec2;
use maniple_geometry::Scalar;

use super::conflict::{Span, forbid};
use super::trajectory::Trajectory;

/// How much longer at both ends a span is taken to be than it was computed, in cycles: 2^-26, about 1.5e-8. Spans of neighbouring
/// pieces meet in one moment, and rounding must not leave a slit between them. The gap between circles has room for it.
const SLIT: f64 = 1.0 / (1u64 << 26) as f64;

/// A circle that keeps to its plan.
#[derive(Clone, Debug)]
pub(crate) struct Planned {
    pub(crate) trajectory: Trajectory,
    /// In cycles since the beginning of the schedule.
    pub(crate) departure: f64,
    pub(crate) radius: f64,
}

/// How much nearer than they are two circles may come that are too near to each other from the start, in world units: 2^-44.
const NEARER: f64 = 1.0 / (1u64 << 44) as f64;

/// How near two circles may come that start in two points: as near as `reach`, or, where they start nearer to each other, as they
/// are. Circles that have collided stand a skin above touching, and have to get away from each other.
pub(crate) fn reach_from(start: DVec2, other: DVec2, reach: f64) -> f64 {
    let distance = start.distance(other);
    if distance < reach { distance - NEARER } else { reach }
}

/// All circles whose plans stand.
#[derive(Clone, Debug, Default)]
pub(crate) struct Traffic {
    planned: Vec<Planned>,
    /// Memory of one question.
    spans: Vec<Span>,
    /// How many pairs have been looked at.
    pub(crate) looks: u64,
}

impl Traffic {
    pub(crate) fn push(&mut self, planned: Planned) {
        self.planned.push(planned);
    }

    /// Returns the earliest moment, not before `from`, at which a circle can depart without ever coming nearer to any other than
    /// both radii, and the gap above it; `None` where there is none. `reach` is its radius and the gap.
    pub(crate) fn earliest(&mut self, trajectory: &Trajectory, reach: f64, from: f64) -> Option<f64> {
        self.spans.clear();
        for other in &self.planned {
            let first = self.spans.len();
            let reach = reach_from(trajectory.start(), other.trajectory.start(), reach + other.radius);
            self.looks += forbid(trajectory, &other.trajectory, reach, &mut self.spans);
            let mut kept = first;
            for index in first..self.spans.len() {
                let span = self.spans[index];
                let span =
                    Span { from: span.from + other.departure - SLIT, to: span.to + other.departure + SLIT };
                if span.to > from {
                    self.spans[kept] = span;
                    kept += 1;
                }
            }
            self.spans.truncate(kept);
        }
        self.spans.sort_unstable_by(|one, other| one.from.total_cmp(&other.from));
        let mut departure = from;
        for span in &self.spans {
            if span.from >= departure {
                break;
            }
            departure = departure.greater(span.to);
        }
        departure.is_finite().then_some(departure)
    }
}
