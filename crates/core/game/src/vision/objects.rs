//! Which objects a team sees.

use std::collections::BTreeMap;

use glam::DVec2;
use maniple_geometry::ObjectId;
use maniple_view::{Shape, hull_distance};

/// Smallest edge of a bucket, in world units; it bounds how many there are.
const BUCKET_MIN: f64 = 1.0;

/// An object as vision needs it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Visible {
    /// The object.
    pub(crate) object: ObjectId,
    /// The team of its owner; `None`: it is nobody's, and nobody sees by it.
    pub(crate) team: Option<u16>,
    /// Its centre, in world units.
    pub(crate) center: DVec2,
    /// What it covers.
    pub(crate) shape: Shape,
    /// How far it sees from its hull, in world units.
    pub(crate) sight: f64,
    /// Whether it looks down on walls.
    pub(crate) is_in_air: bool,
}

/// Returns the edge of buckets in which what a team sees is in the bucket of who sees it, or in one around it.
pub(super) fn bucket(objects: &[Visible]) -> f64 {
    let (mut reach, mut radius_max) = (BUCKET_MIN, 0.0);
    for object in objects {
        // Both radii: an object is found by its centre, and at most as large as the largest.
        let own = object.sight + 2.0 * object.shape.radius();
        if own > reach {
            reach = own;
        }
        if object.shape.radius() > radius_max {
            radius_max = object.shape.radius();
        }
    }
    reach + radius_max
}

/// The objects of a team, by bucket.
pub(super) struct Eyes<'a> {
    bucket: f64,
    eyes: BTreeMap<(i64, i64), Vec<&'a Visible>>,
}

impl<'a> Eyes<'a> {
    /// Returns the objects of a team in buckets with such an edge; see [`bucket`].
    pub(super) fn of(team: u16, objects: &'a [Visible], bucket: f64) -> Self {
        let mut eyes: BTreeMap<(i64, i64), Vec<&Visible>> = BTreeMap::new();
        for eye in objects.iter().filter(|eye| eye.team == Some(team)) {
            eyes.entry(bucket_of(eye.center, bucket)).or_default().push(eye);
        }
        Self { bucket, eyes }
    }

    /// Returns whether the hull of an object is within sight of the hull of one of these.
    pub(super) fn see(&self, other: &Visible) -> bool {
        let (x, y) = bucket_of(other.center, self.bucket);
        (y - 1..=y + 1).any(|y| {
            (x - 1..=x + 1)
                .any(|x| self.eyes.get(&(x, y)).is_some_and(|eyes| eyes.iter().any(|eye| sees(eye, other))))
        })
    }
}

/// Compares squares: two circles are within sight where `|p - q| <= ra + rb + sight`.
fn sees(eye: &Visible, other: &Visible) -> bool {
    let offset = other.center - eye.center;
    match (eye.shape, other.shape) {
        (Shape::Circle { radius: own }, Shape::Circle { radius }) => {
            let reach = own + radius + eye.sight;
            offset.length_squared() <= reach * reach
        }
        (eye_shape, shape) => hull_distance(offset, &eye_shape, &shape) <= eye.sight,
    }
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
            let seen: Vec<u32> = seen_by_each(&[0, 1], &objects)[0].iter().map(|object| object.0).collect();
            assert_eq!(seen, expected, "{x}");
        };
        check(4.5, &[0, 1]);
        check(4.500_001, &[0]);
        check(2.6, &[0, 1]);
    }

    #[test]
    fn seeing_is_not_mutual() {
        let objects = [object(0, 0, 1.0, 0.5, 5.0), object(1, 1, 5.0, 0.5, 0.5)];
        let seen = seen_by_each(&[0, 1], &objects);
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
                team: Some(u16::try_from(index % 3).unwrap()),
                center: DVec2::new(60.0 * number(index, 1), 60.0 * number(index * 7, 2)),
                shape: Shape::Circle { radius: 0.1 + number(index, 3) },
                sight: 0.1 + 4.0 * number(index, 4),
                is_in_air: false,
            })
            .collect();
        for (team, seen) in (0u16..).zip(seen_by_each(&[0, 1, 2], &objects)) {
            let slow: Vec<ObjectId> = objects
                .iter()
                .filter(|other| {
                    other.team == Some(team)
                        || objects.iter().any(|eye| eye.team == Some(team) && sees(eye, other))
                })
                .map(|other| other.object)
                .collect();
            assert_eq!(seen, slow);
            assert!(seen.len() > 100 && seen.len() < 300, "{}", seen.len());
        }
    }

    fn object(number: u32, team: u16, x: f64, radius: f64, sight: f64) -> Visible {
        let shape = Shape::Circle { radius };
        let center = DVec2::new(x, 1.0);
        Visible { object: ObjectId(number), team: Some(team), center, shape, sight, is_in_air: false }
    }

    fn seen_by_each(teams: &[u16], objects: &[Visible]) -> Vec<Vec<ObjectId>> {
        let seen_by = |&team: &u16| {
            let eyes = Eyes::of(team, objects, bucket(objects));
            objects.iter().filter(|object| eyes.see(object)).map(|object| object.object).collect()
        };
        teams.iter().map(seen_by).collect()
    }
}
