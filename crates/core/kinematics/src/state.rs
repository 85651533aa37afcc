//! What the world keeps of each object: what every cycle reads apart from what only a change reads.

use maniple_geometry::contact::Straight;
use maniple_geometry::{Cycle, Moment, Motion, ObjectId, Planar, Scalar};

use crate::plan::Leg;

/// As [`State::wakes`]: nothing will change on its own.
pub(crate) const NEVER: u32 = u32::MAX;

/// As [`Intent::queue`]: nothing waits.
pub(crate) const NO_QUEUE: u32 = u32::MAX;

/// A slot, and whether the track of its object turns in the cycle that is being solved; in one word, since there is one for
/// each active object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Tag(u32);

impl Tag {
    const TURNS: u32 = 1 << 31;

    pub(crate) fn new(slot: u32, turns: bool) -> Self {
        assert!(slot < Self::TURNS, "there are fewer than 2^31 objects");
        Self(if turns { slot | Self::TURNS } else { slot })
    }

    pub(crate) fn slot(self) -> u32 {
        self.0 & !Self::TURNS
    }

    pub(crate) fn turns(self) -> bool {
        self.0 & Self::TURNS != 0
    }
}

/// Where the world keeps an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Phase {
    /// The slot is free.
    Vacant,
    /// Taken out, but still in a list of the active; free at the next cycle.
    Leaving,
    /// At rest, in the lists of [`crate::resting::Resting`].
    Resting,
    /// As `Resting`, but from the next cycle on `Active`.
    Fresh,
    /// In the list of a batch: it moves, or did so in the last cycle.
    Active,
}

/// What every cycle reads of an object: one line of the cache in doubles.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct State<S: Scalar> {
    pub(crate) start: S::Vector,
    pub(crate) velocity: S::Vector,
    pub(crate) radius: S,
    /// With `cycle`, when the object was at `start`.
    pub(crate) fraction: f64,
    pub(crate) cycle: Cycle,
    /// The first cycle in which the track may be more than one straight piece; [`NEVER`] at rest without a plan.
    pub(crate) wakes: u32,
    /// Radius of the motion sphere of a whole cycle on one straight piece, rounded up.
    pub(crate) reach: f32,
    pub(crate) phase: Phase,
    /// For a motion that an order began in the present moment: whether the object rested before.
    pub(crate) rested_before: bool,
}

impl<S: Scalar> State<S> {
    /// Returns an object at rest.
    pub(crate) fn at_rest(point: S::Vector, from: Moment, radius: S) -> Self {
        Self {
            start: point,
            velocity: S::Vector::zero(),
            radius,
            fraction: from.fraction,
            cycle: from.cycle,
            wakes: NEVER,
            reach: 0.0,
            phase: Phase::Resting,
            rested_before: false,
        }
    }

    pub(crate) fn motion(&self) -> Motion<S> {
        let from = Moment { cycle: self.cycle, fraction: self.fraction };
        Motion { start: self.start, velocity: self.velocity, from }
    }

    pub(crate) fn set_motion(&mut self, motion: &Motion<S>) {
        self.start = motion.start;
        self.velocity = motion.velocity;
        self.cycle = motion.from.cycle;
        self.fraction = motion.from.fraction;
    }

    /// Returns whether the object would rest but for an order of this moment.
    pub(crate) fn rested_until(&self, now: Moment) -> bool {
        !self.is_moving() || (self.rested_before && self.motion().from == now)
    }

    pub(crate) fn is_moving(&self) -> bool {
        self.velocity != S::Vector::zero()
    }

    /// Returns whether the track of a cycle may turn, end or begin within it.
    pub(crate) fn turns_in(&self, cycle: Cycle) -> bool {
        self.wakes <= cycle.0
    }

    /// The object in a cycle in which it goes straight on or rests.
    #[inline]
    pub(crate) fn straight(&self, cycle: Cycle) -> Straight<S> {
        Straight { point: self.position(cycle), velocity: self.velocity, radius: self.radius }
    }

    /// Where the object is at the start of a cycle; flushed, like everything that is stored.
    #[inline]
    pub(crate) fn position(&self, cycle: Cycle) -> S::Vector {
        self.motion().position(cycle).flushed()
    }
}

/// What only a change of plan reads of an object.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Intent<S: Scalar> {
    pub(crate) id: ObjectId,
    /// Place in the table of queues, or [`NO_QUEUE`].
    pub(crate) queue: u32,
    /// The leg that the object is on; without meaning at rest.
    pub(crate) leg: Leg<S>,
    /// The summand of the object in the state hash.
    pub(crate) hash: u64,
}
