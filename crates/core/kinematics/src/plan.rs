//! What an object does and is going to do.

use maniple_geometry::{Cycle, Moment, Motion, Planar, Scalar};
use serde::{Deserialize, Serialize};

use crate::state::{NEVER, NO_QUEUE};

/// Largest number of legs that wait behind the present one.
pub const WAYPOINTS_MAX: usize = 64;

/// One straight way: to a goal, at a speed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(
    deny_unknown_fields,
    bound(
        serialize = "S: Serialize, S::Vector: Serialize",
        deserialize = "S: Deserialize<'de>, S::Vector: Deserialize<'de>"
    )
)]
pub struct Leg<S: Scalar = f64> {
    /// World units.
    pub goal: S::Vector,
    /// World units a cycle; positive.
    pub speed: S,
}

/// Where new legs go.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
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

impl<S: Scalar> Course<S> {
    /// Returns the course of a motion along a leg, from the start of that motion.
    pub(crate) fn along(leg: Leg<S>, start: S::Vector) -> Self {
        Self { leg, duration: ((leg.goal - start).length() / leg.speed).to_f64() }
    }
}

/// What an object does and is going to do.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plan<'a, S: Scalar> {
    pub(crate) motion: Motion<S>,
    pub(crate) course: Option<Course<S>>,
    pub(crate) queue: &'a [Planned<S>],
}

impl<S: Scalar> Plan<'_, S> {
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

    /// Returns the first cycle in which the track may be more than one straight piece: where the leg ends, a
    /// replacement starts, or what waits begins. Never too late; [`NEVER`] where nothing will happen.
    pub(crate) fn wakes(&self, now: Cycle) -> u32 {
        let arrival = self.course.map(|course| self.arrives(course.duration));
        let mut first = arrival.unwrap_or(NEVER);
        let begins = |planned: &Planned<S>| planned.start.map_or(now.0, |start| start.cycle.0);
        let replacement = self.queue.iter().find(|planned| planned.placement == Placement::Replace);
        let next = if self.course.is_none() { self.queue.first() } else { None };
        for planned in replacement.into_iter().chain(next) {
            first = first.min(begins(planned));
        }
        first
    }

    /// The cycle before the one in which the leg ends, since the sum is rounded.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a duration beyond the last cycle is meant to saturate"
    )]
    fn arrives(&self, duration: f64) -> u32 {
        let cycles = (self.motion.from.fraction + duration).floor() as u32;
        self.motion.from.cycle.0.saturating_add(cycles.saturating_sub(1))
    }
}

/// The waiting legs of the objects that have any.
#[derive(Clone, Debug)]
pub(crate) struct Queues<S: Scalar> {
    queues: Vec<Vec<Planned<S>>>,
    /// Empty queues, kept for their memory.
    free: Vec<u32>,
}

impl<S: Scalar> Queues<S> {
    pub(crate) fn new() -> Self {
        Self { queues: Vec::new(), free: Vec::new() }
    }

    /// Returns the legs that wait in a queue, or none.
    pub(crate) fn waiting(&self, queue: u32) -> &[Planned<S>] {
        if queue == NO_QUEUE { &[] } else { &self.queues[queue as usize] }
    }

    /// Forgets all waiting legs but the first `kept` and appends others; returns the queue to go on with.
    pub(crate) fn extend(&mut self, queue: u32, kept: usize, new: impl Iterator<Item = Planned<S>>) -> u32 {
        let queue = if queue == NO_QUEUE { self.claim() } else { queue };
        let waiting = &mut self.queues[queue as usize];
        waiting.truncate(kept);
        waiting.extend(new);
        self.released_if_empty(queue)
    }

    /// Takes the first `count` legs out; returns the queue to go on with.
    pub(crate) fn consume(&mut self, queue: u32, count: usize) -> u32 {
        if queue == NO_QUEUE {
            return NO_QUEUE;
        }
        self.queues[queue as usize].drain(..count);
        self.released_if_empty(queue)
    }

    /// Forgets a queue.
    pub(crate) fn release(&mut self, queue: u32) {
        if queue != NO_QUEUE {
            self.queues[queue as usize].clear();
            self.free.push(queue);
        }
    }

    fn claim(&mut self) -> u32 {
        self.free.pop().unwrap_or_else(|| {
            self.queues.push(Vec::new());
            u32::try_from(self.queues.len() - 1).expect("as many queues as objects")
        })
    }

    fn released_if_empty(&mut self, queue: u32) -> u32 {
        if self.queues[queue as usize].is_empty() {
            self.free.push(queue);
            return NO_QUEUE;
        }
        queue
    }
}
