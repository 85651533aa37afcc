//! What an object does and is going to do.

use std::collections::VecDeque;

use maniple_geometry::{Moment, Motion, Scalar};

/// Largest number of legs that wait behind the present one.
pub const WAYPOINTS_MAX: usize = 64;

/// One straight way: to a goal, at a speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leg<S: Scalar = f64> {
    /// World units.
    pub goal: S::Vector,
    /// World units a cycle; positive.
    pub speed: S,
}

/// Where new legs go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Placement {
    /// In the place of what runs and waits, from the start on.
    Replace,
    /// Behind what runs and waits.
    Queue,
}

/// A leg that waits, or, without a leg, an order to stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Planned<S: Scalar> {
    pub(crate) leg: Option<Leg<S>>,
    pub(crate) placement: Placement,
    /// Not before this moment; always there for [`Placement::Replace`].
    pub(crate) start: Option<Moment>,
}

/// The leg that an object is on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Course<S: Scalar> {
    pub(crate) leg: Leg<S>,
    /// Cycles from the start of the motion to the arrival.
    pub(crate) duration: f64,
}

/// What an object does and is going to do.
#[derive(Clone, Debug)]
pub(crate) struct Plan<S: Scalar> {
    pub(crate) motion: Motion<S>,
    pub(crate) course: Option<Course<S>>,
    pub(crate) queue: VecDeque<Planned<S>>,
}

impl<S: Scalar> Plan<S> {
    pub(crate) fn at_rest(point: S::Vector, from: Moment) -> Self {
        Self { motion: Motion::at_rest(point, from), course: None, queue: VecDeque::new() }
    }

    /// Returns how many of the waiting legs a replacement at `start` leaves: what runs goes on until then, so only
    /// what would begin at that moment or later is forgotten.
    pub(crate) fn kept_by(&self, start: Moment, now: Moment) -> usize {
        if start <= now {
            return 0;
        }
        let is_later =
            |planned: &Planned<S>| planned.placement == Placement::Replace && planned.start >= Some(start);
        self.queue.iter().position(is_later).unwrap_or(self.queue.len())
    }

    /// Forgets all waiting legs but the first `kept` and appends others.
    pub(crate) fn extend(&mut self, kept: usize, new: impl Iterator<Item = Planned<S>>) {
        self.queue.truncate(kept);
        self.queue.extend(new);
    }

    /// Returns whether the object neither moves nor is going to.
    pub(crate) fn is_idle(&self) -> bool {
        self.course.is_none() && self.queue.is_empty()
    }
}
