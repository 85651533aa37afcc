//! One cycle, collision by collision.

use std::collections::BTreeMap;

use crate::exact::{Exact, Vector, exact, least_square, nearest, root, rounded, shortened, square_between};
use crate::scene::{Obstacle, Scene, Stops};
use crate::track::{Track, near, windows};

/// Collisions that are no further apart than this part of a cycle, 2^-150, are at the same time: far above the error of
/// a time, 2^-200, and far below the distance of any two times that are not meant to be the same.
const SIMULTANEOUS: f64 = 1.0 / (1u128 << 75) as f64 / (1u128 << 75) as f64;

/// What becomes of a scene in one cycle.
#[derive(Clone, Debug)]
pub struct Solution {
    /// For each object.
    pub outcomes: Vec<Outcome>,
    /// By how much all distances of the cycle and all places of stops may be off, in world units, before anything is
    /// decided otherwise: who collides with whom, or in which order. Infinite where rounding has no say, since the numbers
    /// given decide it.
    ///
    /// A solver that is off by more may part lawfully.
    pub margin: f64,
}

/// What becomes of an object in one cycle.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Why it rests at the end, or not.
    pub ending: Ending,
    /// When it came to rest, as a fraction of the cycle; 1 where it goes on.
    pub time: Exact,
    /// Where its centre is at the end of the cycle, in world units.
    pub point: Vector,
    /// How far its place is off along its way if all distances are off by 1, to the first order: a graze turns a small error of the
    /// distance into a large one of the time, and so does the stop of whoever it collides with. Zero where it did not
    /// collide.
    pub leverage: f64,
}

/// Why an object rests at the end of a cycle, or not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// It goes on, or rested all along.
    Continues,
    /// It reached its goal.
    Arrived,
    /// It collided; where it did so with several at the same time, this is the first of them.
    Stopped(Obstacle),
}

/// A pair that may meet, and when it collides next.
struct Contact {
    object: usize,
    other: Obstacle,
    hit: Option<Hit>,
}

/// A collision ahead.
#[derive(Clone)]
struct Hit {
    time: Exact,
    /// How far the time is off, in cycles, if all distances are off by 1.
    slack: f64,
}

/// Returns what becomes of a scene in one cycle.
///
/// Takes the earliest collisions, stops who is in them, and asks anew for all pairs of whoever was stopped, until there
/// are none left.
///
/// # Panics
/// Where a number of the scene is not finite.
#[must_use]
pub fn solve(scene: &Scene) -> Solution {
    let tracks: Vec<Track> = scene.objects.iter().map(Track::free).collect();
    let pairs = near(scene, &tracks);
    let contacts = pairs.into_iter().map(|(object, other)| Contact { object, other, hit: None }).collect();
    let mut cycle = Cycle { scene, tracks, contacts, stopped: BTreeMap::new(), margin: f64::INFINITY };
    let start = Hit { time: Exact::ZERO, slack: 0.0 };
    for place in 0..cycle.contacts.len() {
        cycle.predict(place, &start);
    }
    // Each round stops somebody, or drops collisions with whoever arrives at that very time.
    while let Some(time) = cycle.first() {
        cycle.stop_all(&time);
    }
    let ending = |object: usize| match (cycle.stopped.get(&object), scene.objects[object].goal) {
        (Some(&obstacle), _) => Ending::Stopped(obstacle),
        (None, Some(_)) => Ending::Arrived,
        (None, None) => Ending::Continues,
    };
    let outcomes = (0..).zip(&cycle.tracks).map(|(object, track)| Outcome {
        ending: ending(object),
        time: track.end.clone(),
        point: track.rest.clone(),
        leverage: track.leverage,
    });
    Solution { outcomes: outcomes.collect(), margin: cycle.margin }
}

/// A cycle that is being solved.
struct Cycle<'a> {
    scene: &'a Scene,
    tracks: Vec<Track>,
    contacts: Vec<Contact>,
    stopped: BTreeMap<usize, Obstacle>,
    margin: f64,
}

impl Cycle<'_> {
    fn first(&self) -> Option<Exact> {
        self.contacts.iter().filter_map(|contact| contact.hit.as_ref()).map(|hit| &hit.time).min().cloned()
    }

    /// Stops who collides at a time.
    fn stop_all(&mut self, time: &Exact) {
        let until = time + exact(SIMULTANEOUS);
        let is_now = |contact: &Contact| contact.hit.as_ref().is_some_and(|hit| hit.time <= until);
        let mut causes: BTreeMap<usize, (Obstacle, Hit)> = BTreeMap::new();
        let mut asked: Vec<usize> = Vec::new();
        for (place, contact) in self.contacts.iter().enumerate().filter(|(_, contact)| is_now(contact)) {
            asked.push(place);
            for (object, other) in self.concerned(contact, time) {
                let slack = contact.hit.as_ref().map_or(0.0, |hit| hit.slack);
                let cause = causes.entry(object).or_insert((other, Hit { time: time.clone(), slack }));
                cause.0 = cause.0.min(other);
                cause.1.slack = cause.1.slack.max(slack);
            }
        }
        for (&object, (other, hit)) in &causes {
            self.note_order(object, *other, hit);
            let track = &mut self.tracks[object];
            track.rest = track.at(time);
            track.end = time.clone();
            let [x, y] = track.velocity.to_f64();
            track.is_stopped = true;
            track.leverage = x.hypot(y) * hit.slack;
            self.stopped.insert(object, *other);
        }
        let involves = |contact: &Contact, object: &usize| {
            contact.object == *object || contact.other == Obstacle::Object(*object)
        };
        for place in 0..self.contacts.len() {
            let contact = &self.contacts[place];
            let slack =
                causes.iter().filter(|(object, _)| involves(contact, object)).map(|(_, cause)| cause.1.slack);
            let slack = slack.reduce(f64::max);
            if slack.is_some() || asked.contains(&place) {
                self.predict(place, &Hit { time: time.clone(), slack: slack.unwrap_or(0.0) });
            }
        }
    }

    /// Returns who of a pair is stopped by a collision, and by what.
    fn concerned(&self, contact: &Contact, time: &Exact) -> Vec<(usize, Obstacle)> {
        let moves = |object: usize| self.tracks[object].is_moving(time);
        let Obstacle::Object(second) = contact.other else {
            return if moves(contact.object) { vec![(contact.object, contact.other)] } else { Vec::new() };
        };
        let advances = |one: usize, other: usize| {
            let offset = self.tracks[other].at(time).minus(&self.tracks[one].at(time));
            self.tracks[one].velocity.dot(&offset) > Exact::ZERO
        };
        let is_concerned = |one: usize, other: usize| {
            moves(one)
                && match self.scene.stops {
                    Stops::Both => true,
                    Stops::Approaching => advances(one, other),
                }
        };
        let pairs = [(contact.object, second), (second, contact.object)];
        let concerned = pairs.into_iter().filter(|&(one, other)| is_concerned(one, other));
        concerned.map(|(one, other)| (one, Obstacle::Object(other))).collect()
    }

    /// Notes how near the stop of an object is to being another: another collision of it might have come first, or its
    /// arrival.
    fn note_order(&mut self, object: usize, cause: Obstacle, stop: &Hit) {
        let mut note = |time: &Exact, slack: f64| {
            let slack = slack + stop.slack;
            if slack > 0.0 {
                self.margin = self.margin.min(rounded(&(time - &stop.time)) / slack);
            }
        };
        for contact in &self.contacts {
            let Some(hit) = &contact.hit else { continue };
            let is_cause = (contact.object, contact.other) == (object, cause)
                || (cause, contact.other) == (Obstacle::Object(contact.object), Obstacle::Object(object));
            if !is_cause && (contact.object == object || contact.other == Obstacle::Object(object)) {
                note(&hit.time, hit.slack);
            }
        }
        if self.scene.objects[object].goal.is_some() {
            note(&self.tracks[object].end, 0.0);
        }
    }

    /// Finds the next collision of a pair from a time on.
    fn predict(&mut self, place: usize, since: &Hit) {
        let Contact { object, other, .. } = self.contacts[place];
        let skin = exact(self.scene.skin);
        let (hit, margin) = match other {
            Obstacle::Object(other) => {
                let (a, b) = (&self.tracks[object], &self.tracks[other]);
                let halted = |one, by| self.stopped.get(&one) == Some(&Obstacle::Object(by));
                // Who was stopped by the other is off along its way, but not in the distance from that other.
                let have_met = halted(object, other) || halted(other, object);
                let error = if have_met { 1.0 } else { a.error() + b.error() };
                meet((a, b), &skin, since, error)
            }
            Obstacle::Wall(wall) => {
                let wall = &self.scene.walls[wall];
                run_into(&self.tracks[object], &[wall.start, wall.end].map(Vector::new), &skin, since)
            }
        };
        self.contacts[place].hit = hit;
        self.margin = self.margin.min(margin);
    }
}

/// Returns when two circles collide next, and the margin of that decision: `error` is how far their distance is off if all
/// others are off by 1.
///
/// In a window in which both go straight, with the offset `d`, relative velocity `w` and sum of the radii `R`, they collide if
/// they approach, `d · w < 0`, and the least distance is below `R`.
fn meet((a, b): (&Track, &Track), skin: &Exact, since: &Hit, error: f64) -> (Option<Hit>, f64) {
    let reach = &a.radius + &b.radius;
    let square = &reach * &reach;
    let mut margin = f64::INFINITY;
    for (from, to) in windows(&since.time, a, b) {
        let (d, w) = (b.at(&from).minus(&a.at(&from)), b.velocity_at(&from).minus(&a.velocity_at(&from)));
        if w.is_zero() {
            continue;
        }
        let last = b.at(&to).minus(&a.at(&to)).square();
        let least = least_square(&d, &w, &(&to - &from), last);
        if error > 0.0 {
            margin = margin.min(gap(&least, &reach).abs() / error);
        }
        if d.dot(&w) >= Exact::ZERO || least >= square {
            continue;
        }
        let at_once = &reach + skin + skin;
        margin = margin.min(gap(&d.square(), &at_once).abs() / (1.0 + error));
        if d.square() <= &at_once * &at_once {
            let slack = if from == since.time { since.slack } else { 0.0 };
            return (Some(Hit { time: from, slack }), margin);
        }
        let hit = match entry(&d, &w, &(&reach + skin)) {
            Some((time, closing)) => Hit { time: (from + time).min(to), slack: (1.0 + error) / closing },
            None => Hit { time: to, slack: f64::INFINITY },
        };
        return (Some(hit), margin);
    }
    (None, margin)
}

/// Returns when a circle collides next with a wall, given by its ends, and the margin of that decision.
///
/// It does if the distance falls at the start and is below the radius at some time; the distance is a convex function of
/// time. At the end it is that of the goal, as in [`least_square`].
fn run_into(track: &Track, wall: &[Vector; 2], skin: &Exact, since: &Hit) -> (Option<Hit>, f64) {
    let from = &since.time;
    if !track.is_moving(from) {
        return (None, f64::INFINITY);
    }
    let (point, velocity, radius) = (track.at(from), &track.velocity, &track.radius);
    let line_end = track.start.plus(&velocity.times(&track.end));
    let in_goal = nearest(&track.rest, wall).minus(&track.rest).square();
    let falls_to_the_end = nearest(&line_end, wall).minus(&line_end).dot(velocity) > Exact::ZERO;
    let least = if falls_to_the_end {
        in_goal
    } else {
        square_between(&[point.clone(), line_end], wall).min(in_goal)
    };
    let foot = nearest(&point, wall).minus(&point);
    if foot.dot(velocity) <= Exact::ZERO || least >= radius * radius {
        return (None, f64::INFINITY);
    }
    let at_once = radius + skin + skin;
    let margin = gap(&foot.square(), &at_once).abs();
    if foot.square() <= &at_once * &at_once {
        return (Some(since.clone()), margin);
    }
    let reach = radius + skin;
    let ends = wall.iter().filter_map(|end| entry(&end.minus(&point), &velocity.times(&exact(-1.0)), &reach));
    let first = ends.chain(entry_of_side(&point, velocity, wall, &reach)).min_by(|a, b| a.0.cmp(&b.0));
    let hit = match first {
        Some((time, closing)) => Hit { time: (from + time).min(track.end.clone()), slack: 1.0 / closing },
        None => Hit { time: track.end.clone(), slack: f64::INFINITY },
    };
    (Some(hit), margin)
}

/// Returns after which time two points at the offset `d`, further apart than `reach` and with the relative velocity
/// `w`, are as near as that, and how fast they then approach; `None` where they never are.
///
/// The smaller root of `w² t² + 2 (d · w) t + d² - reach² = 0`.
fn entry(d: &Vector, w: &Vector, reach: &Exact) -> Option<(Exact, f64)> {
    let (closing, square) = (d.dot(w), w.square());
    let discriminant = &closing * &closing - &square * (d.square() - reach * reach);
    if closing >= Exact::ZERO || discriminant < Exact::ZERO {
        return None;
    }
    let root = root(&discriminant);
    let speed = rounded(&root) / rounded(reach);
    Some((shortened(&((-closing - root) / square)), speed))
}

/// As [`entry`] for the flat sides of a wall: `|e × (q + v t)| = reach |e|` with the wall `e` and the offset `q` from its
/// start, where the foot of the point lies on the wall.
fn entry_of_side(
    point: &Vector,
    v: &Vector,
    [start, end]: &[Vector; 2],
    reach: &Exact,
) -> Option<(Exact, f64)> {
    let (e, q) = (end.minus(start), point.minus(start));
    let (side, turn, length) = (e.cross(&q), e.cross(v), root(&e.square()));
    let (side, closing) = if side < Exact::ZERO { (-side, turn) } else { (side, -turn) };
    if closing <= Exact::ZERO {
        return None;
    }
    let speed = rounded(&closing) / rounded(&length);
    let time = shortened(&((side - reach * length) / closing));
    let foot = e.dot(&q.plus(&v.times(&time)));
    let is_beside = Exact::ZERO <= foot && foot <= e.square();
    (time >= Exact::ZERO && is_beside).then_some((time, speed))
}

/// By how much the distance with this square is above `reach`, in world units; only the last step is rounded.
pub(crate) fn gap(square: &Exact, reach: &Exact) -> f64 {
    rounded(&(square - reach * reach)) / (rounded(square).sqrt() + rounded(reach))
}
