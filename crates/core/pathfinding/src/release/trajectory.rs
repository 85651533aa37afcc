//! A way with its times.

use glam::DVec2;

use super::stretch::{Bounds, Stretch};

/// A stretch with its times, in cycles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Piece {
    pub(crate) stretch: Stretch,
    pub(crate) times: Times,
}

/// When a circle is in the first point of a stretch: on a leg at one moment, at rest all the time from one to the other. A rest without
/// a beginning or an end has them at infinity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Times {
    pub(crate) first: f64,
    pub(crate) last: f64,
}

impl Times {
    /// Returns the same, so many cycles later.
    pub(crate) fn later(self, cycles: f64) -> Self {
        Self { first: self.first + cycles, last: self.last + cycles }
    }
}

impl Piece {
    fn rest(point: DVec2, first: f64, last: f64) -> Self {
        Self { stretch: Stretch::rest(point), times: Times { first, last } }
    }
}

/// Where a circle is at any time: it rests in its first point until it departs, goes along legs at full speed, and rests in the
/// last point from its arrival on. Times are cycles since the departure.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Trajectory {
    /// The rest, the legs, the other rest; for a circle that stays, one rest without ends.
    pieces: Vec<Piece>,
    bounds: Bounds,
}

impl Trajectory {
    /// Returns the trajectory along legs at a speed in world units a cycle. Legs without length are left out.
    pub(crate) fn new(from: DVec2, legs: &[DVec2], speed: f64) -> Self {
        let mut pieces = vec![Piece::rest(from, f64::NEG_INFINITY, 0.0)];
        let (mut at, mut time) = (from, 0.0);
        for &goal in legs {
            let duration = at.distance(goal) / speed;
            if duration > 0.0 {
                let times = Times { first: time, last: time };
                pieces.push(Piece { stretch: Stretch::leg(at, goal, duration), times });
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
        let bounds =
            pieces.iter().map(|piece| piece.stretch.bounds).fold(pieces[0].stretch.bounds, Bounds::join);
        Self { pieces, bounds }
    }

    pub(crate) fn pieces(&self) -> &[Piece] {
        &self.pieces
    }

    /// A rectangle that holds all pieces.
    pub(crate) fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    /// The pieces in which it moves.
    pub(crate) fn legs(&self) -> &[Piece] {
        let last = self.pieces.len() - 1;
        &self.pieces[1.min(last)..last]
    }

    pub(crate) fn start(&self) -> DVec2 {
        self.pieces[0].stretch.point
    }

    pub(crate) fn goal(&self) -> DVec2 {
        self.pieces[self.pieces.len() - 1].stretch.point
    }

    /// How long it takes from departure to arrival, in cycles.
    pub(crate) fn duration(&self) -> f64 {
        if self.pieces.len() == 1 { 0.0 } else { self.pieces[self.pieces.len() - 1].times.first }
    }

    /// Whether its legs come nearer than `reach` to a point.
    pub(crate) fn leads_over(&self, point: DVec2, reach: f64) -> bool {
        let place = Bounds::of(point, point);
        let is_over = |stretch: &Stretch| {
            !stretch.bounds.is_far(&place, reach) && stretch.distance_squared(point) < reach * reach
        };
        !self.bounds.is_far(&place, reach) && self.legs().iter().any(|leg| is_over(&leg.stretch))
    }
}
