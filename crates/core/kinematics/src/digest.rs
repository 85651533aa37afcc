//! The state hash.

use maniple_geometry::{Cycle, Motion, ObjectId, Planar, Scalar};
use twox_hash::XxHash3_64;

use crate::plan::{Leg, Placement, Plan, Planned, WAYPOINTS_MAX};
use crate::wall::Layers;

/// Returns the hash of a state: XXH3 with 64 bits over the hash before, the cycle, and the wrapping sum of one hash
/// an object, each little-endian.
#[must_use]
pub fn chained(before: u64, cycle: Cycle, sum: u64) -> u64 {
    let mut bytes = Bytes::<20>::new();
    bytes.put(before.to_le_bytes());
    bytes.put(cycle.0.to_le_bytes());
    bytes.put(sum.to_le_bytes());
    bytes.hash()
}

/// The hash of all that decides what an object will do.
pub(crate) fn object_hash<S: Scalar>(id: ObjectId, shape: (S, Layers), plan: &Plan<'_, S>) -> u64 {
    if plan.queue.is_empty() {
        hash_in(&mut Bytes::<OBJECT_BYTES_MAX>::new(), id, shape, plan)
    } else {
        hash_in(
            &mut Bytes::<{ OBJECT_BYTES_MAX + WAYPOINTS_MAX * PLANNED_BYTES_MAX }>::new(),
            id,
            shape,
            plan,
        )
    }
}

/// Bytes of id, radius, layers, motion and present leg.
const OBJECT_BYTES_MAX: usize = 4 + 8 + 4 + 44 + 33;

/// Bytes of a waiting leg.
const PLANNED_BYTES_MAX: usize = 1 + 25 + 13;

/// Bytes to be hashed, without memory from the heap.
struct Bytes<const MAX: usize> {
    bytes: [u8; MAX],
    length: usize,
}

impl<const MAX: usize> Bytes<MAX> {
    fn new() -> Self {
        Self { bytes: [0; MAX], length: 0 }
    }

    fn put<const N: usize>(&mut self, more: [u8; N]) {
        self.bytes[self.length..self.length + N].copy_from_slice(&more);
        self.length += N;
    }

    fn hash(&self) -> u64 {
        XxHash3_64::oneshot(&self.bytes[..self.length])
    }
}

fn hash_in<S: Scalar, const MAX: usize>(
    bytes: &mut Bytes<MAX>,
    id: ObjectId,
    (radius, layers): (S, Layers),
    plan: &Plan<'_, S>,
) -> u64 {
    bytes.put(id.0.to_le_bytes());
    put(bytes, radius);
    bytes.put(layers.0.to_le_bytes());
    put_motion(bytes, &plan.motion);
    match &plan.course {
        None => bytes.put([0]),
        Some(course) => {
            bytes.put([1]);
            put_leg(bytes, &course.leg);
            bytes.put(course.duration.to_le_bytes());
        }
    }
    for planned in plan.queue {
        put_planned(bytes, planned);
    }
    bytes.hash()
}

fn put_planned<S: Scalar, const MAX: usize>(bytes: &mut Bytes<MAX>, planned: &Planned<S>) {
    bytes.put(match planned.placement {
        Placement::Replace => [0],
        Placement::Queue => [1],
    });
    match &planned.leg {
        None => bytes.put([0]),
        Some(leg) => {
            bytes.put([1]);
            put_leg(bytes, leg);
        }
    }
    match planned.start {
        None => bytes.put([0]),
        Some(start) => {
            bytes.put([1]);
            bytes.put(start.cycle.0.to_le_bytes());
            bytes.put(start.fraction.to_le_bytes());
        }
    }
}

fn put_motion<S: Scalar, const MAX: usize>(bytes: &mut Bytes<MAX>, motion: &Motion<S>) {
    put_vector::<S, MAX>(bytes, motion.start);
    put_vector::<S, MAX>(bytes, motion.velocity);
    bytes.put(motion.from.cycle.0.to_le_bytes());
    bytes.put(motion.from.fraction.to_le_bytes());
}

fn put_leg<S: Scalar, const MAX: usize>(bytes: &mut Bytes<MAX>, leg: &Leg<S>) {
    put_vector::<S, MAX>(bytes, leg.goal);
    put(bytes, leg.speed);
}

fn put_vector<S: Scalar, const MAX: usize>(bytes: &mut Bytes<MAX>, vector: S::Vector) {
    put(bytes, vector.x());
    put(bytes, vector.y());
}

/// Widened, so that a number has the same bytes in every scalar that can hold it.
fn put<S: Scalar, const MAX: usize>(bytes: &mut Bytes<MAX>, number: S) {
    bytes.put(number.to_f64().to_le_bytes());
}
