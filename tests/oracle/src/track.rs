//! The way of an object through the cycle, and which ways come near to each other at all.

use crate::exact::{Exact, Vector, exact};
use crate::scene::{Object, Obstacle, Scene};

/// The way of an object through the cycle: straight on until it comes to rest.
#[derive(Clone, Debug)]
pub(crate) struct Track {
    pub(crate) radius: Exact,
    pub(crate) start: Vector,
    pub(crate) velocity: Vector,
    /// When it comes to rest or leaves the cycle: 0 to 1.
    pub(crate) end: Exact,
    /// Where it is from then on.
    pub(crate) rest: Vector,
    pub(crate) is_stopped: bool,
    /// As [`crate::Outcome::leverage`].
    pub(crate) leverage: f64,
}

impl Track {
    /// Returns the way of an object in whose way nothing is.
    pub(crate) fn free(object: &Object) -> Self {
        let (start, velocity) = (Vector::new(object.center), Vector::new(object.velocity));
        let (end, rest) = match object.goal {
            Some(goal) => (exact(goal.time), Vector::new(goal.point)),
            None => (Exact::ONE, start.plus(&velocity)),
        };
        Self { radius: exact(object.radius), start, velocity, end, rest, is_stopped: false, leverage: 0.0 }
    }

    /// Returns where the centre is at a time.
    pub(crate) fn at(&self, time: &Exact) -> Vector {
        if *time >= self.end { self.rest.clone() } else { self.start.plus(&self.velocity.times(time)) }
    }

    /// Returns how far the place of somebody who was stopped is off if all distances and places are off by 1. In the middle of
    /// a cycle every solver has to round a place, even at a time that is exact.
    pub(crate) fn error(&self) -> f64 {
        if self.is_stopped && !self.end.is_zero() { 1.0 + self.leverage } else { self.leverage }
    }

    /// Returns whether the object moves from a time on.
    pub(crate) fn is_moving(&self, time: &Exact) -> bool {
        *time < self.end && !self.velocity.is_zero()
    }

    /// Returns the velocity from a time on.
    pub(crate) fn velocity_at(&self, time: &Exact) -> Vector {
        if *time >= self.end { Vector::new([0.0; 2]) } else { self.velocity.clone() }
    }
}

/// Returns the windows from a time to the end of the cycle in each of which both objects go straight or rest.
pub(crate) fn windows(from: &Exact, a: &Track, b: &Track) -> Vec<(Exact, Exact)> {
    let mut times = vec![from.clone(), Exact::ONE];
    times.extend([&a.end, &b.end].into_iter().filter(|end| *from < **end && **end < Exact::ONE).cloned());
    times.sort();
    times.windows(2).filter(|pair| pair[0] < pair[1]).map(|pair| (pair[0].clone(), pair[1].clone())).collect()
}

/// Returns the pairs that can meet: those whose boxes around the whole way and the radius are not further apart than
/// a margin, each once and with the smaller number first.
///
/// The boxes are in doubles. The margin, four skins and 2^-30 of the largest coordinate, is millions of times their
/// error, so no pair is left out that comes within two skins.
pub(crate) fn near(scene: &Scene, tracks: &[Track]) -> Vec<(usize, Obstacle)> {
    let boxed = |track: &Track, radius: f64| {
        let (a, b, c) = (
            track.start.to_f64(),
            track.rest.to_f64(),
            track.start.plus(&track.velocity.times(&track.end)).to_f64(),
        );
        let [x, y] = [0, 1].map(|axis| {
            (a[axis].min(b[axis]).min(c[axis]) - radius, a[axis].max(b[axis]).max(c[axis]) + radius)
        });
        [x, y]
    };
    let circles: Vec<[(f64, f64); 2]> =
        tracks.iter().zip(&scene.objects).map(|(track, object)| boxed(track, object.radius)).collect();
    let walls: Vec<[(f64, f64); 2]> = scene
        .walls
        .iter()
        .map(|wall| {
            [0, 1].map(|axis| (wall.start[axis].min(wall.end[axis]), wall.start[axis].max(wall.end[axis])))
        })
        .collect();
    let largest =
        circles.iter().flatten().fold(0.0, |most: f64, span| most.max(span.0.abs()).max(span.1.abs()));
    let margin = 4.0 * scene.skin + largest / f64::from(1 << 30);
    let meet = |a: &[(f64, f64); 2], b: &[(f64, f64); 2]| {
        (0..2).all(|axis| a[axis].0 <= b[axis].1 + margin && b[axis].0 <= a[axis].1 + margin)
    };
    let mut pairs = Vec::new();
    for (a, circle) in circles.iter().enumerate() {
        let others = (a + 1..circles.len()).filter(|&b| meet(circle, &circles[b])).map(Obstacle::Object);
        let ahead = (0..walls.len()).filter(|&wall| meet(circle, &walls[wall])).map(Obstacle::Wall);
        pairs.extend(others.chain(ahead).map(|other| (a, other)));
    }
    pairs
}
