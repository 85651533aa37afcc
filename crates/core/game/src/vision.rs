//! Who sees what.

use std::collections::BTreeMap;

use glam::DVec2;
use maniple_geometry::ObjectId;
use maniple_view::Seat;

/// Smallest edge of a bucket, in world units; it bounds how many there are.
const BUCKET_MIN: f64 = 1.0;

/// An object as vision needs it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Visible {
    /// The object.
    pub(crate) object: ObjectId,
    /// Whose it is.
    pub(crate) owner: Seat,
    /// Its centre, in world units.
    pub(crate) center: DVec2,
    /// Its radius, in world units.
    pub(crate) radius: f64,
    /// How far it sees from its hull, in world units.
    pub(crate) sight: f64,
}

/// Returns for each seat what it sees, in the order of `objects`: its own objects, and those of others whose hull is
/// within sight of the hull of one of its own.
pub(crate) fn seen_by_each(seats: usize, objects: &[Visible]) -> Vec<Vec<ObjectId>> {
    let mut reach = BUCKET_MIN;
    for a in objects {
        // Both radii: an object is found by its centre, and at most as large as the largest.
        let own = a.sight + 2.0 * a.radius;
        if own > reach {
            reach = own;
        }
    }
    let mut radius_max = 0.0;
    for a in objects {
        if a.radius > radius_max {
            radius_max = a.radius;
        }
    }
    let bucket = reach + radius_max;
    (0..).map(Seat).take(seats).map(|seat| seen_by(seat, objects, bucket)).collect()
}

fn seen_by(seat: Seat, objects: &[Visible], bucket: f64) -> Vec<ObjectId> {
    let mut eyes: BTreeMap<(i64, i64), Vec<&Visible>> = BTreeMap::new();
    for eye in objects.iter().filter(|eye| eye.owner == seat) {
        eyes.entry(bucket_of(eye.center, bucket)).or_default().push(eye);
    }
    let is_seen = |other: &&Visible| {
        other.owner == seat || {
            let (x, y) = bucket_of(other.center, bucket);
            (y - 1..=y + 1).any(|y| {
                (x - 1..=x + 1)
                    .any(|x| eyes.get(&(x, y)).is_some_and(|eyes| eyes.iter().any(|eye| sees(eye, other))))
            })
        }
    };
    objects.iter().filter(is_seen).map(|visible| visible.object).collect()
}

/// Compares squares: hulls are within sight where `|p - q| <= ra + rb + sight`.
fn sees(eye: &Visible, other: &Visible) -> bool {
    let reach = eye.radius + other.radius + eye.sight;
    eye.center.distance_squared(other.center) <= reach * reach
}

#[expect(clippy::cast_possible_truncation, reason = "a coordinate is at most 2^30, a bucket at least 1")]
fn bucket_of(point: DVec2, bucket: f64) -> (i64, i64) {
    ((point.x / bucket).floor() as i64, (point.y / bucket).floor() as i64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sight_is_from_hull_to_hull_and_its_end_belongs_to_it() {
        let check = |x: f64, expected: &[u32]| {
            let objects = [object(0, 0, 1.0, 1.0, 2.0), object(1, 1, x, 0.5, 0.25)];
            let seen: Vec<u32> = seen_by_each(2, &objects)[0].iter().map(|object| object.0).collect();
            assert_eq!(seen, expected, "{x}");
        };
        check(4.5, &[0, 1]);
        check(4.500_001, &[0]);
        check(2.6, &[0, 1]);
    }

    #[test]
    fn seeing_is_not_mutual() {
        let objects = [object(0, 0, 1.0, 0.5, 5.0), object(1, 1, 5.0, 0.5, 0.5)];
        let seen = seen_by_each(2, &objects);
        assert_eq!(seen[0], [ObjectId(0), ObjectId(1)]);
        assert_eq!(seen[1], [ObjectId(1)]);
    }

    #[test]
    fn buckets_find_what_every_pair_finds() {
        let number = |index: u32, salt: u32| {
            let mixed = (index + 1).wrapping_mul(2_654_435_761).wrapping_add(salt.wrapping_mul(40_503));
            f64::from(mixed >> 8) / f64::from(1 << 24)
        };
        let objects: Vec<Visible> = (0..300)
            .map(|index| Visible {
                object: ObjectId(index),
                owner: Seat(u16::try_from(index % 3).unwrap()),
                center: DVec2::new(60.0 * number(index, 1), 60.0 * number(index * 7, 2)),
                radius: 0.1 + number(index, 3),
                sight: 0.1 + 4.0 * number(index, 4),
            })
            .collect();
        for (seat, seen) in (0..).map(Seat).zip(seen_by_each(3, &objects)) {
            let slow: Vec<ObjectId> = objects
                .iter()
                .filter(|other| {
                    other.owner == seat || objects.iter().any(|eye| eye.owner == seat && sees(eye, other))
                })
                .map(|other| other.object)
                .collect();
            assert_eq!(seen, slow);
            assert!(seen.len() > 100 && seen.len() < 300, "{}", seen.len());
        }
    }

    fn object(number: u32, seat: u16, x: f64, radius: f64, sight: f64) -> Visible {
        Visible { object: ObjectId(number), owner: Seat(seat), center: DVec2::new(x, 1.0), radius, sight }
    }
}
