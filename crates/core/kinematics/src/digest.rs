//! The state hash.

use maniple_geometry::{Cycle, Motion, ObjectId, Planar, Scalar};
use twox_hash::XxHash3_64;

use crate::plan::{Leg, Placement, Plan, Planned, WAYPOINTS_MAX};
use crate::wall::Layers;

/// Returns the hash of a state: XXH3 with 64 bits over the hash before, the cycle, and the wrapping sum of one hash
/// an object, as three words.
#[must_use]
pub fn chained(before: u64, cycle: Cycle, sum: u64) -> u64 {
    let mut words = Words::<3>::new();
    words.put(before);
    words.put(u64::from(cycle.0));
    words.put(sum);
    words.hash()
}

/// The hash of all that decides what an object will do.
pub(crate) fn object_hash<S: Scalar>(id: ObjectId, shape: (S, Layers), plan: &Plan<'_, S>) -> u64 {
    if plan.queue.is_empty() {
        hash_in(&mut Words::<OBJECT_WORDS_MAX>::new(), id, shape, plan)
    } else {
        hash_in(
            &mut Words::<{ OBJECT_WORDS_MAX + WAYPOINTS_MAX * PLANNED_WORDS_MAX }>::new(),
            id,
            shape,
            plan,
        )
    }
}

/// Words of id and layers, radius, motion and present leg.
const OBJECT_WORDS_MAX: usize = 1 + 1 + 6 + 4;

/// Words of a waiting leg.
const PLANNED_WORDS_MAX: usize = 1 + 3 + 2;

/// Words to be hashed, each little-endian, without memory from the heap. Words and not bytes: what is written and read again
/// at once in other portions makes the processor wait.
struct Words<const MAX: usize> {
    bytes: [[u8; 8]; MAX],
    length: usize,
}

impl<const MAX: usize> Words<MAX> {
    fn new() -> Self {
        Self { bytes: [[0; 8]; MAX], length: 0 }
    }

    fn put(&mut self, word: u64) {
        self.bytes[self.length] = word.to_le_bytes();
        self.length += 1;
    }

    /// Widened, so that a number has the same bytes in every scalar that can hold it.
    fn put_number<S: Scalar>(&mut self, number: S) {
        self.put(number.to_f64().to_bits());
    }

    fn put_vector<S: Scalar>(&mut self, vector: S::Vector) {
        self.put_number(vector.x());
        self.put_number(vector.y());
    }

    fn put_leg<S: Scalar>(&mut self, leg: &Leg<S>) {
        self.put_vector::<S>(leg.goal);
        self.put_number(leg.speed);
    }

    fn hash(&self) -> u64 {
        XxHash3_64::oneshot(self.bytes[..self.length].as_flattened())
    }
}

/// Two halves of a word.
fn pair(high: u32, low: u32) -> u64 {
    u64::from(high) << 32 | u64::from(low)
}

fn hash_in<S: Scalar, const MAX: usize>(
    words: &mut Words<MAX>,
    id: ObjectId,
    (radius, layers): (S, Layers),
    plan: &Plan<'_, S>,
) -> u64 {
    let Motion { start, velocity, from } = plan.motion;
    words.put(pair(id.0, layers.0));
    words.put_number(radius);
    words.put_vector::<S>(start);
    words.put_vector::<S>(velocity);
    words.put(from.fraction.to_bits());
    words.put(pair(from.cycle.0, u32::from(plan.course.is_some())));
    if let Some(course) = &plan.course {
        words.put_leg(&course.leg);
        words.put(course.duration.to_bits());
    }
    for planned in plan.queue {
        put_planned(words, planned);
    }
    words.hash()
}

fn put_planned<S: Scalar, const MAX: usize>(words: &mut Words<MAX>, planned: &Planned<S>) {
    let placement = match planned.placement {
        Placement::Replace => 0,
        Placement::Queue => 1,
    };
    let is_there = u32::from(planned.leg.is_some()) | u32::from(planned.start.is_some()) << 1;
    words.put(pair(placement, is_there));
    if let Some(leg) = &planned.leg {
        words.put_leg(leg);
    }
    if let Some(start) = planned.start {
        words.put(u64::from(start.cycle.0));
        words.put(start.fraction.to_bits());
    }
}
