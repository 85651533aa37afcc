//! Who sees what.

use std::collections::BTreeMap;

use glam::DVec2;
use maniple_geometry::ObjectId;
use maniple_view::{Seat, Shape, hull_distance};

/// Smallest edge of a bucket, in world units; it bounds how many there are.
const BUCKET_MIN: f64 = 1.0;

/// What each seat sees, and saw at the start of the last cycle.
#[derive(Clone, Debug)]
pub(crate) enum Sight {
    /// Everything.
    Perfect,
    /// What is in sight of the seat's team; the lists are by seat, in ascending order.
    Fog { now: Vec<Vec<ObjectId>>, before: Vec<Vec<ObjectId>> },
}

impl Sight {
    /// Returns the sight of so many seats that see nothing yet.
    pub(crate) fn fog(seats: usize) -> Self {
        Self::Fog { now: vec![Vec::new(); seats], before: vec![Vec::new(); seats] }
    }

    /// Takes a look; `teams` are those of the seats.
    pub(crate) fn look(&mut self, teams: &[u16], objects: &[Visible]) {
        match self {
            Self::Perfect => {}
            Self::Fog { now, before } => *before = std::mem::replace(now, seen_by_each(teams, objects)),
        }
    }

    /// Returns whether a seat sees an object that is alive.
    pub(crate) fn sees(&self, seat: Seat, object: ObjectId) -> bool {
        match self {
            Self::Perfect => true,
            Self::Fog { now, .. } => now[seat.index()].binary_search(&object).is_ok(),
        }
    }

    /// Returns whether a seat saw an object at the start of the last cycle that was alive then.
    pub(crate) fn saw(&self, seat: Seat, object: ObjectId) -> bool {
        match self {
            Self::Perfect => true,
            Self::Fog { before, .. } => before[seat.index()].binary_search(&object).is_ok(),
        }
    }
}

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
}

/// Returns for each seat what it sees, in the order of `objects`: the objects of its team, and those of others whose hull is
/// within sight of the hull of one of its team.
fn seen_by_each(teams: &[u16], objects: &[Visible]) -> Vec<Vec<ObjectId>> {
    let mut reach = BUCKET_MIN;
    for a in objects {
        // Both radii: an object is found by its centre, and at most as large as the largest.
        let own = a.sight + 2.0 * a.shape.radius();
        if own > reach {
            reach = own;
        }
    }
    let mut radius_max = 0.0;
    for a in objects {
        if a.shape.radius() > radius_max {
            radius_max = a.shape.radius();
        }
    }
    let bucket = reach + radius_max;
    let mut seen: BTreeMap<u16, Vec<ObjectId>> = BTreeMap::new();
    for &team in teams {
        seen.entry(team).or_insert_with(|| seen_by(team, objects, bucket));
    }
    teams.iter().map(|team| seen[team].clone()).collect()
}

fn seen_by(team: u16, objects: &[Visible], bucket: f64) -> Vec<ObjectId> {
    let mut eyes: BTreeMap<(i64, i64), Vec<&Visible>> = BTreeMap::new();
    for eye in objects.iter().filter(|eye| eye.team == Some(team)) {
        eyes.entry(bucket_of(eye.center, bucket)).or_default().push(eye);
    }
    let is_seen = |other: &&Visible| {
        other.team == Some(team) || {
            let (x, y) = bucket_of(other.center, bucket);
            (y - 1..=y + 1).any(|y| {
                (x - 1..=x + 1)
                    .any(|x| eyes.get(&(x, y)).is_some_and(|eyes| eyes.iter().any(|eye| sees(eye, other))))
            })
        }
    };
    objects.iter().filter(is_seen).map(|visible| visible.object).collect()
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
        Visible { object: ObjectId(number), team: Some(team), center: DVec2::new(x, 1.0), shape, sight }
    }
}
