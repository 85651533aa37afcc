//! All pairs: the same stops as the kinematics core, found without any structure.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

use glam::DVec2;

use super::Engine;
use crate::march::{CONTACT, RADIUS, Scene};

/// How far above touching a circle stops, in world units: far above the rounding errors, far below anything visible.
const SKIN: f64 = 1e-9;

/// Circles in a square; both partners of a collision stop for the rest of the cycle.
pub(super) struct Brute {
    side: f64,
    /// The centres at the start of the cycle.
    centers: Vec<DVec2>,
    velocities: Vec<DVec2>,
    /// World units a cycle.
    speeds: Vec<f64>,
    /// When each circle was stopped in the cycle; 1 where it was not.
    ends: Vec<f64>,
    queue: BinaryHeap<Reverse<Hit>>,
    /// Room for the circles that are near one; empty between calls.
    near: Vec<usize>,
}

/// A collision to come, valid as long as none of its partners has been stopped since it was predicted.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Hit {
    time: f64,
    circle: usize,
    /// `None`: a wall.
    other: Option<usize>,
    /// How many of the partners were stopped when it was predicted: at most one of two.
    stopped: usize,
}

impl Eq for Hit {}

impl PartialOrd for Hit {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Hit {
    fn cmp(&self, other: &Self) -> Ordering {
        self.time.total_cmp(&other.time).then((self.circle, self.other).cmp(&(other.circle, other.other)))
    }
}

impl Brute {
    pub(super) fn new(scene: &Scene) -> Self {
        let count = scene.starts.len();
        Self {
            side: scene.side,
            centers: scene.starts.clone(),
            velocities: vec![DVec2::ZERO; count],
            speeds: vec![0.0; count],
            ends: vec![1.0; count],
            queue: BinaryHeap::new(),
            near: Vec::new(),
        }
    }

    fn predict_all(&mut self) {
        for circle in 0..self.centers.len() {
            let hit = Hit { time: self.wall_time(circle), circle, other: None, stopped: 0 };
            if hit.time <= 1.0 {
                self.queue.push(Reverse(hit));
            }
            self.predict_with_those_from(circle + 1, circle, 0.0);
        }
    }

    /// Predicts the collisions of a circle from a time on with all others from the index `first` on.
    fn predict_with_those_from(&mut self, first: usize, circle: usize, time: f64) {
        let (center, room) = (self.centers[circle], CONTACT + SKIN + self.speeds[circle]);
        let mut near = std::mem::take(&mut self.near);
        let others = self.centers[first..].iter().zip(&self.speeds[first..]);
        let is_near = |other: DVec2, speed: f64| {
            let reach = room + speed;
            center.distance_squared(other) <= reach * reach
        };
        near.extend(
            (first..).zip(others).filter_map(|(at, (other, speed))| is_near(*other, *speed).then_some(at)),
        );
        for other in near.drain(..).filter(|&other| other != circle) {
            self.predict(circle, other, time);
        }
        self.near = near;
    }

    /// Queues the first collision of two circles from a time on, if there is one in the cycle.
    fn predict(&mut self, a: usize, b: usize, from: f64) {
        let offset = self.position(b, from) - self.position(a, from);
        let velocity = self.velocity(b) - self.velocity(a);
        if let Some(time) = entry(offset, velocity).map(|time| from + time).filter(|&time| time <= 1.0) {
            let stopped = self.stopped(a) + self.stopped(b);
            self.queue.push(Reverse(Hit { time, circle: a, other: Some(b), stopped }));
        }
    }

    /// When a circle comes within the skin of a wall that it moves towards; more than 1 where it does not.
    fn wall_time(&self, circle: usize) -> f64 {
        let room = RADIUS + SKIN;
        let time = |center: f64, velocity: f64| {
            let gap = match velocity.total_cmp(&0.0) {
                Ordering::Less => center - room,
                Ordering::Equal => f64::INFINITY,
                Ordering::Greater => self.side - room - center,
            };
            gap.max(0.0) / velocity.abs()
        };
        let (center, velocity) = (self.centers[circle], self.velocities[circle]);
        time(center.x, velocity.x).min(time(center.y, velocity.y))
    }

    /// Takes all collisions of the earliest time that are still valid, stops their partners, and predicts theirs anew.
    fn stop_earliest(&mut self, time: f64) {
        let mut partners = Vec::new();
        while let Some(Reverse(hit)) = self.queue.peek().copied().filter(|Reverse(hit)| hit.time == time) {
            self.queue.pop();
            let now = self.stopped(hit.circle) + hit.other.map_or(0, |other| self.stopped(other));
            if hit.stopped == now {
                partners.extend([Some(hit.circle), hit.other].into_iter().flatten());
            }
        }
        partners.retain(|&circle| self.stopped(circle) == 0);
        partners.sort_unstable();
        partners.dedup();
        for &circle in &partners {
            self.ends[circle] = time;
        }
        for &circle in &partners {
            self.predict_with_those_from(0, circle, time);
        }
    }

    fn position(&self, circle: usize, time: f64) -> DVec2 {
        self.centers[circle] + self.velocities[circle] * time.min(self.ends[circle])
    }

    /// The velocity that a circle still has.
    fn velocity(&self, circle: usize) -> DVec2 {
        if self.stopped(circle) == 0 { self.velocities[circle] } else { DVec2::ZERO }
    }

    /// 1 where the circle has been stopped in this cycle, 0 where it has not.
    fn stopped(&self, circle: usize) -> usize {
        usize::from(self.ends[circle] < 1.0)
    }
}

impl Engine for Brute {
    fn order(&mut self, velocities: &[DVec2]) {
        self.velocities.copy_from_slice(velocities);
    }

    fn step(&mut self) {
        self.ends.fill(1.0);
        for (speed, velocity) in self.speeds.iter_mut().zip(&self.velocities) {
            *speed = velocity.length();
        }
        self.predict_all();
        // Each round drops a hit for good or stops a circle, at most once each, so there is an end.
        while let Some(time) = self.queue.peek().map(|Reverse(hit)| hit.time) {
            self.stop_earliest(time);
        }
        for circle in 0..self.centers.len() {
            self.centers[circle] = self.position(circle, 1.0);
        }
    }

    fn read(&self, positions: &mut [DVec2]) {
        positions.copy_from_slice(&self.centers);
    }
}

/// Returns when two circles come within the skin of each other, if they are going to overlap.
///
/// Solves `|d + w t| = s` for the smaller `t`, with the offset `d`, the relative velocity `w` and the contact distance
/// with the skin `s`, as `t = c / (sqrt(w² s² - (d × w)²) - d·w)` with `c = d² - s²`; 0 where they are as near already.
fn entry(d: DVec2, w: DVec2) -> Option<f64> {
    let approach = d.dot(w);
    let cross = d.perp_dot(w);
    let (speed, passing) = (w.length_squared(), cross * cross);
    if approach >= 0.0 || passing >= speed * CONTACT * CONTACT {
        return None;
    }
    let reach = CONTACT + SKIN;
    let c = d.length_squared() - reach * reach;
    Some(c.max(0.0) / ((speed * reach * reach - passing).sqrt() - approach))
}
