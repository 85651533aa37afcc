//! A way with its times.

use glam::DVec2;
use maniple_geometry::{Scalar, Segment};

/// So many pieces one after the other are passed over at once where they are far away.
const RUN: usize = 8;

/// A straight part of a trajectory at constant speed, or at rest: at the time `t` the centre is at
/// `point + velocity * (t - since)`.
///
/// A rest has ends at infinity where it has no beginning or no end; its `point` holds whatever the time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Piece {
    /// The centre at `since`, in world units.
    pub(crate) point: DVec2,
    /// The centre at `until`, exactly.
    end: DVec2,
    /// World units a cycle; zero at rest.
    pub(crate) velocity: DVec2,
    /// When it begins, in cycles.
    pub(crate) since: f64,
    /// When it ends, in cycles.
    pub(crate) until: f64,
    bounds: Bounds,
}

/// A rectangle along the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    /// The corner with the smallest coordinates.
    low: DVec2,
    /// The corner with the largest.
    high: DVec2,
}

impl Bounds {
    /// Returns the smallest that holds two points.
    fn new(one: DVec2, other: DVec2) -> Self {
        let low = DVec2::new(one.x.lesser(other.x), one.y.lesser(other.y));
        let high = DVec2::new(one.x.greater(other.x), one.y.greater(other.y));
        Self { low, high }
    }

    /// Returns the smallest that holds those of some pieces, of which there is one at least.
    fn of(pieces: &[Piece]) -> Self {
        let join = |one: Self, other: Self| Self {
            low: Self::new(one.low, other.low).low,
            high: Self::new(one.high, other.high).high,
        };
        pieces.iter().map(|piece| piece.bounds).fold(pieces[0].bounds, join)
    }

    /// Whether two are farther apart than `reach` along an axis.
    #[inline]
    pub(crate) fn is_far(&self, other: &Self, reach: f64) -> bool {
        self.low.x - other.high.x > reach
            || other.low.x - self.high.x > reach
            || self.low.y - other.high.y > reach
            || other.low.y - self.high.y > reach
    }
}

impl Piece {
    fn rest(point: DVec2, since: f64, until: f64) -> Self {
        Self { point, end: point, velocity: DVec2::ZERO, since, until, bounds: Bounds::new(point, point) }
    }

    fn leg(from: DVec2, to: DVec2, since: f64, until: f64) -> Self {
        let velocity = (to - from) / (until - since);
        Self { point: from, end: to, velocity, since, until, bounds: Bounds::new(from, to) }
    }

    pub(crate) fn is_moving(&self) -> bool {
        self.velocity != DVec2::ZERO
    }

    /// The centre at the end, exactly.
    pub(crate) fn end(&self) -> DVec2 {
        self.end
    }

    /// How long it lasts, in cycles.
    pub(crate) fn duration(&self) -> f64 {
        self.until - self.since
    }

    /// The square of the distance of its line from a point.
    fn distance_squared(&self, point: DVec2) -> f64 {
        if !self.is_moving() {
            return self.point.distance_squared(point);
        }
        let line: Segment = Segment::new(self.point, self.end);
        line.nearest(point).distance_squared(point)
    }

    /// The smallest rectangle that holds it.
    pub(crate) fn bounds(&self) -> &Bounds {
        &self.bounds
    }
}

/// Where a circle is at any time: it rests in its first point until it departs, goes along legs at full speed, and rests in the
/// last point from its arrival on. Times are cycles since the departure.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Trajectory {
    /// The rest, the legs, the other rest; for a circle that stays, one rest without ends.
    pieces: Vec<Piece>,
    /// For each [`RUN`] pieces one after the other their bounds.
    runs: Vec<Bounds>,
    whole: Bounds,
}

impl Trajectory {
    /// Returns the trajectory along legs at a speed in world units a cycle. Legs without length are left out.
    pub(crate) fn new(from: DVec2, legs: &[DVec2], speed: f64) -> Self {
        let mut pieces = vec![Piece::rest(from, f64::NEG_INFINITY, 0.0)];
        let (mut at, mut time) = (from, 0.0);
        for &goal in legs {
            let duration = at.distance(goal) / speed;
            if duration > 0.0 {
                pieces.push(Piece::leg(at, goal, time, time + duration));
                (at, time) = (goal, time + duration);
            }
        }
        if pieces.len() == 1 {
            return Self::still(from);
        }
        pieces.push(Piece::rest(at, time, f64::INFINITY));
        Self::of(pieces)
    }

    /// Returns the trajectory of a circle that stays where it is.
    pub(crate) fn still(point: DVec2) -> Self {
        Self::of(vec![Piece::rest(point, f64::NEG_INFINITY, f64::INFINITY)])
    }

    fn of(pieces: Vec<Piece>) -> Self {
        let runs = pieces.chunks(RUN).map(Bounds::of).collect();
        Self { whole: Bounds::of(&pieces), runs, pieces }
    }

    pub(crate) fn pieces(&self) -> &[Piece] {
        &self.pieces
    }

    /// The pieces in runs one after the other, each with a rectangle that holds it.
    pub(crate) fn runs(&self) -> impl Iterator<Item = (&Bounds, &[Piece])> {
        self.runs.iter().zip(self.pieces.chunks(RUN))
    }

    /// A rectangle that holds all pieces.
    pub(crate) fn whole(&self) -> &Bounds {
        &self.whole
    }

    /// The pieces in which it moves.
    pub(crate) fn legs(&self) -> &[Piece] {
        let last = self.pieces.len() - 1;
        &self.pieces[1.min(last)..last]
    }

    pub(crate) fn start(&self) -> DVec2 {
        self.pieces[0].point
    }

    pub(crate) fn goal(&self) -> DVec2 {
        self.pieces[self.pieces.len() - 1].point
    }

    /// How long it takes from departure to arrival, in cycles.
    pub(crate) fn duration(&self) -> f64 {
        self.legs().last().map_or(0.0, |leg| leg.until)
    }

    /// Whether its legs come nearer than `reach` to a point.
    pub(crate) fn leads_over(&self, point: DVec2, reach: f64) -> bool {
        let place = Bounds::new(point, point);
        !self.whole.is_far(&place, reach)
            && self
                .legs()
                .iter()
                .any(|leg| !leg.bounds.is_far(&place, reach) && leg.distance_squared(point) < reach * reach)
    }
}
