//! The state hash.

use maniple_geometry::{Cycle, Motion, ObjectId, Planar, Scalar};
use twox_hash::XxHash3_64;

use crate::plan::{Leg, Placement, Plan, Planned};
use crate::wall::Layers;

/// Returns the hash of a state: XXH3 with 64 bits over the hash before, the cycle, and the wrapping sum of one hash
/// an object, each little-endian.
#[must_use]
pub fn chained(before: u64, cycle: Cycle, sum: u64) -> u64 {
    let mut bytes = Vec::with_capacity(20);
    bytes.extend(before.to_le_bytes());
    bytes.extend(cycle.0.to_le_bytes());
    bytes.extend(sum.to_le_bytes());
    XxHash3_64::oneshot(&bytes)
}

/// The hash of all that decides what an object will do.
pub(crate) fn object_hash<S: Scalar>(id: ObjectId, (radius, layers): (S, Layers), plan: &Plan<'_, S>) -> u64 {
    let mut bytes = Vec::with_capacity(128);
    bytes.extend(id.0.to_le_bytes());
    put(&mut bytes, radius);
    bytes.extend(layers.0.to_le_bytes());
    put_motion(&mut bytes, &plan.motion);
    match &plan.course {
        None => bytes.push(0),
        Some(course) => {
            bytes.push(1);
            put_leg(&mut bytes, &course.leg);
            bytes.extend(course.duration.to_le_bytes());
        }
    }
    for planned in plan.queue {
        put_planned(&mut bytes, planned);
    }
    XxHash3_64::oneshot(&bytes)
}

fn put_planned<S: Scalar>(bytes: &mut Vec<u8>, planned: &Planned<S>) {
    bytes.push(match planned.placement {
        Placement::Replace => 0,
        Placement::Queue => 1,
    });
    match &planned.leg {
        None => bytes.push(0),
        Some(leg) => {
            bytes.push(1);
            put_leg(bytes, leg);
        }
    }
    match planned.start {
        None => bytes.push(0),
        Some(start) => {
            bytes.push(1);
            bytes.extend(start.cycle.0.to_le_bytes());
            bytes.extend(start.fraction.to_le_bytes());
        }
    }
}

fn put_motion<S: Scalar>(bytes: &mut Vec<u8>, motion: &Motion<S>) {
    put_vector::<S>(bytes, motion.start);
    put_vector::<S>(bytes, motion.velocity);
    bytes.extend(motion.from.cycle.0.to_le_bytes());
    bytes.extend(motion.from.fraction.to_le_bytes());
}

fn put_leg<S: Scalar>(bytes: &mut Vec<u8>, leg: &Leg<S>) {
    put_vector::<S>(bytes, leg.goal);
    put(bytes, leg.speed);
}

fn put_vector<S: Scalar>(bytes: &mut Vec<u8>, vector: S::Vector) {
    put(bytes, vector.x());
    put(bytes, vector.y());
}

/// Widened, so that a number has the same bytes in every scalar that can hold it.
fn put<S: Scalar>(bytes: &mut Vec<u8>, number: S) {
    bytes.extend(number.to_f64().to_le_bytes());
}
