//! A straight part of an object's way through one cycle.

use crate::scalar::{Planar, Scalar};

/// A straight part of an object's way through one cycle, at constant speed or at rest: the position at the time
/// `t` is `point + velocity * (t - since)`. Times are fractions of the cycle, `0.0..=1.0`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece<S: Scalar = f64> {
    /// The centre at `since`, in world units.
    pub point: S::Vector,
    /// World units a cycle; zero at rest.
    pub velocity: S::Vector,
    /// When the piece begins.
    pub since: S,
    /// When the piece ends.
    pub until: S,
    /// The exact centre at `until`, where the piece ends in a goal.
    pub goal: Option<S::Vector>,
}

impl<S: Scalar> Piece<S> {
    /// Returns the piece of an object that rests at `point` from one time to another.
    pub fn at_rest(point: S::Vector, since: S, until: S) -> Self {
        Self { point, velocity: S::Vector::zero(), since, until, goal: None }
    }

    /// Returns whether the object moves.
    #[must_use]
    pub fn is_moving(&self) -> bool {
        self.velocity != S::Vector::zero()
    }

    /// Returns the centre at a time within the piece, rounded; exactly the goal at the end.
    #[inline]
    #[must_use]
    pub fn position(&self, time: S) -> S::Vector {
        match self.goal {
            Some(goal) if time >= self.until => goal,
            Some(_) | None if time <= self.since => self.point,
            Some(_) | None => (self.point + self.velocity * (time - self.since)).flushed(),
        }
    }

    /// Returns whether the piece has come to its end in a goal at a time, so that it is there and not on the line.
    pub(crate) fn ends_in_goal(&self, time: S) -> bool {
        self.goal.is_some() && time >= self.until
    }

    /// Returns the place at a time without rounding: on the line, or in the goal at the end.
    pub(crate) fn anchored(&self, time: S) -> Anchor {
        match self.goal {
            Some(goal) if time >= self.until => {
                Anchor { point: goal.to_dvec2(), since: time.to_f64(), ..self.on_line(time) }
            }
            Some(_) | None => self.on_line(time),
        }
    }

    /// Returns the place on the line at a time without rounding, which at the end may lie beside the goal by the
    /// rounding of the velocity.
    pub(crate) fn on_line(&self, time: S) -> Anchor {
        Anchor {
            point: self.point.to_dvec2(),
            velocity: self.velocity.to_dvec2(),
            since: self.since.to_f64(),
            time: time.to_f64(),
        }
    }
}

/// The place `point + velocity * (time - since)`, not rounded, and its velocity. All numbers in `f64`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Anchor {
    pub(crate) point: glam::DVec2,
    pub(crate) velocity: glam::DVec2,
    pub(crate) since: f64,
    pub(crate) time: f64,
}
