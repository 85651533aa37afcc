//! What happens between two stored states, decided in rational arithmetic and apart from the core: the check of K2.
//!
//! The way of an object through a cycle follows from what the world tells of it: where it was, how fast it went, the
//! time of its stop or turn, and where it is at the end. Nothing is asked about why it stopped.

use glam::DVec2;
use maniple_geometry::{Motion, Segment};
use maniple_kinematics::{Event, EventKind};

use crate::rational::{Exact, Rational, cross, number, square_distance};

/// Share of coordinates, radii and speeds by which the rounded sieve may err; it errs by less than a quarter of this.
const SIEVE: f64 = 64.0 * f64::EPSILON;

/// A straight part of the way of an object through a cycle: `point + velocity * (t - since)` from `since` to `until`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stretch {
    pub(super) point: DVec2,
    pub(super) velocity: DVec2,
    pub(super) since: f64,
    pub(super) until: f64,
    /// Where it is at `until` if that is a goal, and so not what the line says, up to rounding.
    pub(super) goal: Option<DVec2>,
}

impl Stretch {
    fn at_rest(point: DVec2, since: f64) -> Self {
        Self { point, velocity: DVec2::ZERO, since, until: 1.0, goal: None }
    }

    /// The rounded place at a time.
    pub(super) fn place(&self, time: f64) -> DVec2 {
        self.point + self.velocity * (time - self.since)
    }

    /// The place on the line at a time.
    fn line(&self, time: f64) -> Exact {
        let elapsed = number(time) - number(self.since);
        Exact::of(self.point).plus(&Exact::of(self.velocity), &elapsed)
    }

    /// The place at a time: the goal, if there is one, at the end.
    fn exact(&self, time: f64) -> Exact {
        match self.goal {
            Some(goal) if time >= self.until => Exact::of(goal),
            Some(_) | None => self.line(time),
        }
    }
}

/// The way of an object through a cycle.
#[derive(Clone, Debug)]
pub(super) struct Way {
    pub(super) radius: f64,
    pub(super) stretches: Vec<Stretch>,
    /// Where it is at the end of the cycle, as stored.
    pub(super) last: DVec2,
    /// Two corners of a box around the way, the radius included.
    low: DVec2,
    high: DVec2,
}

/// An object at a stored state.
#[derive(Clone, Copy, Debug)]
pub(super) struct Standing {
    pub(super) center: DVec2,
    pub(super) motion: Motion,
}

/// How near two things came in a cycle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Finding {
    /// By how much they were nearer than touching at some time, in world units; not above zero if they were not.
    pub(super) depth: f64,
    /// Whether they approached and came nearer than touching by any amount at all, without being stopped.
    pub(super) is_missed: bool,
}

impl Finding {
    pub(super) const NONE: Self = Self { depth: f64::NEG_INFINITY, is_missed: false };

    fn merge(&mut self, other: Self) {
        self.depth = self.depth.max(other.depth);
        self.is_missed |= other.is_missed;
    }
}

impl Way {
    /// The way of an object from one stored state to the next, with its events on it.
    ///
    /// # Panics
    /// If it turned more than once: then what the world tells is not enough.
    pub(super) fn new((before, after): (&Standing, &Standing), radius: f64, events: &[&Event]) -> Self {
        let stretches = stretches(before, after, events);
        let points = stretches.iter().flat_map(|stretch| [stretch.point, stretch.place(stretch.until)]);
        let (mut low, mut high) = (after.center, after.center);
        for point in points {
            low = low.min(point);
            high = high.max(point);
        }
        let reach = DVec2::splat(radius) + SIEVE * (high.abs().max(low.abs()) + radius);
        Self { radius, stretches, last: after.center, low: low - reach, high: high + reach }
    }

    /// The stretch on which it is just before a time.
    pub(super) fn before(&self, time: f64) -> &Stretch {
        self.stretches.iter().find(|stretch| time <= stretch.until).expect("the way covers the cycle")
    }

    fn is_clear_of(&self, low: DVec2, high: DVec2) -> bool {
        self.low.cmpgt(high).any() || self.high.cmplt(low).any()
    }
}

fn stretches(before: &Standing, after: &Standing, events: &[&Event]) -> Vec<Stretch> {
    let Motion { velocity, .. } = before.motion;
    if velocity == DVec2::ZERO {
        assert_eq!(before.center, after.center, "it set out in mid-cycle");
        return vec![Stretch::at_rest(before.center, 0.0)];
    }
    let line = Stretch { point: before.center, velocity, since: 0.0, until: 1.0, goal: None };
    let stop = events.iter().rev().find(|event| event.rests);
    let turn = events.iter().find(|event| !event.rests);
    let (first, second) = match (stop, turn) {
        (None, Some(turn)) => {
            assert!(
                events.len() == 1 && after.motion.from.fraction == turn.time,
                "it turned twice: {events:?}"
            );
            let Motion { start, velocity, .. } = after.motion;
            let next = Stretch { point: start, velocity, since: turn.time, until: 1.0, goal: None };
            (Stretch { until: turn.time, goal: Some(start), ..line }, next)
        }
        (Some(stop), None) => {
            let goal = (stop.kind == EventKind::Arrived).then_some(after.center);
            (Stretch { until: stop.time, goal, ..line }, Stretch::at_rest(after.center, stop.time))
        }
        (None, None) if after.motion.from == before.motion.from => return vec![line],
        (None, None) => {
            // It was pulled back: it rests where it is from about when it was there.
            let way = after.center - before.center;
            let until = (way.dot(velocity) / velocity.dot(velocity)).clamp(0.0, 1.0);
            (Stretch { until, ..line }, Stretch::at_rest(after.center, until))
        }
        (Some(_), Some(_)) => panic!("it turned and stopped: {events:?}"),
    };
    vec![first, second]
}

/// How near two circles came in a cycle.
///
/// In a cycle with retreats it is only looked for what was missed where neither of the two was stopped: a stop that was
/// pulled back is a little earlier than the one from which the core went on.
pub(super) fn pair(a: &Way, b: &Way, has_retreats: bool) -> Finding {
    let mut finding = Finding::NONE;
    if a.is_clear_of(b.low, b.high) {
        return finding;
    }
    for one in &a.stretches {
        for other in &b.stretches {
            let (from, to) = (one.since.max(other.since), one.until.min(other.until));
            if from <= to && may_meet((one, other), a.radius + b.radius, (from, to)) {
                let reach = number(a.radius) + number(b.radius);
                let found = meeting((one, other), &reach, (from, to));
                let is_cut = |stretch: &Stretch| stretch.until < 1.0 && stretch.goal.is_none();
                let is_whole = from == 0.0 && !is_cut(one) && !is_cut(other);
                let is_missed = found.is_missed && (is_whole || !has_retreats);
                finding.merge(Finding { is_missed, ..found });
            }
        }
    }
    finding
}

/// By how much two circles overlap at the end of the cycle, as stored; not above zero if they do not.
pub(super) fn stored_depth(a: &Way, b: &Way) -> f64 {
    let (d, reach) = (b.last - a.last, a.radius + b.radius);
    if d.dot(d) > reach * reach * (1.0 + SIEVE) {
        return f64::NEG_INFINITY;
    }
    let d = Exact::of(b.last).minus(&Exact::of(a.last));
    depth(&(number(a.radius) + number(b.radius)), &d.dot(&d))
}

/// Whether two circles that go straight approach at a time and then come nearer than touching until another one, or ever if
/// there is none: `d · w < 0`, `w² R² > (d × w)²`, and either the nearest point is passed by then, or they overlap then.
pub(super) fn enters(pair: (&Stretch, &Stretch), reach: &Rational, (from, to): (f64, Option<f64>)) -> bool {
    let (a, b) = pair;
    let d = b.line(from).minus(&a.line(from));
    let w = Exact::of(b.velocity).minus(&Exact::of(a.velocity));
    let (along, square) = (d.dot(&w), w.dot(&w));
    let across = d.cross(&w);
    let reach = reach * reach;
    if along >= Rational::ZERO || &square * &reach <= &across * &across {
        return false;
    }
    let Some(to) = to else { return true };
    let after = b.exact(to).minus(&a.exact(to));
    along + square * (number(to) - number(from)) >= Rational::ZERO || after.dot(&after) < reach
}

/// Whether two circles may come nearer than touching, in rounded numbers: errs on the side of saying so.
fn may_meet((a, b): (&Stretch, &Stretch), reach: f64, (from, to): (f64, f64)) -> bool {
    let (p, q, w) = (a.place(from), b.place(from), b.velocity - a.velocity);
    let d = q - p;
    let nearest = (-d.dot(w) / w.dot(w)).clamp(0.0, to - from);
    let least = if w == DVec2::ZERO { d } else { d + w * nearest };
    let size = |v: DVec2| v.x.abs() + v.y.abs();
    let error = SIEVE * (size(p) + size(q) + size(a.velocity) + size(b.velocity) + reach);
    least.dot(least).sqrt() <= reach + error
}

fn meeting((a, b): (&Stretch, &Stretch), reach: &Rational, (from, to): (f64, f64)) -> Finding {
    let d = b.line(from).minus(&a.line(from));
    let w = Exact::of(b.velocity).minus(&Exact::of(a.velocity));
    let after = b.exact(to).minus(&a.exact(to));
    let (along, square) = (d.dot(&w), w.dot(&w));
    let passes = along < Rational::ZERO && &along + &square * (number(to) - number(from)) > Rational::ZERO;
    let (first, last) = (d.dot(&d), after.dot(&after));
    let ends = if first < last { first.clone() } else { last };
    let least = if passes { first - &along * &along / square } else { ends.clone() };
    let least = if least < ends { least } else { ends };
    let is_missed = from < to && enters((a, b), reach, (from, Some(to)));
    Finding { depth: depth(reach, &least), is_missed }
}

/// How near a circle came to a wall in a cycle.
pub(super) fn wall(way: &Way, segment: &Segment) -> Finding {
    let mut finding = Finding::NONE;
    if way.is_clear_of(segment.start.min(segment.end), segment.start.max(segment.end)) {
        return finding;
    }
    for stretch in &way.stretches {
        finding.merge(wall_meeting(stretch, way.radius, segment));
    }
    let last = square_distance(&Exact::of(way.last), &Exact::of(segment.start), &Exact::of(segment.end));
    finding.merge(Finding { depth: depth(&number(way.radius), &last), is_missed: false });
    finding
}

/// By how much a circle overlaps a wall at the end of the cycle, as stored; not above zero if it does not.
pub(super) fn stored_wall_depth(way: &Way, segment: &Segment) -> f64 {
    if way.is_clear_of(segment.start.min(segment.end), segment.start.max(segment.end)) {
        return f64::NEG_INFINITY;
    }
    let (a, b) = (Exact::of(segment.start), Exact::of(segment.end));
    depth(&number(way.radius), &square_distance(&Exact::of(way.last), &a, &b))
}

/// Whether a circle that goes straight comes nearer to a segment than touching before its stretch ends.
pub(super) fn enters_wall(stretch: &Stretch, radius: f64, segment: &Segment) -> bool {
    if stretch.velocity == DVec2::ZERO || stretch.since >= stretch.until {
        return false;
    }
    let (a, b) = (Exact::of(segment.start), Exact::of(segment.end));
    let (before, after) = (stretch.line(stretch.since), stretch.exact(stretch.until));
    let reach = number(radius);
    let enters_end = |end: DVec2| {
        let end = Stretch::at_rest(end, stretch.since);
        enters((stretch, &end), &reach, (stretch.since, Some(stretch.until)))
    };
    cross(&before, &after, &a, &b)
        || square_distance(&after, &a, &b) < &reach * &reach
        || enters_end(segment.start)
        || enters_end(segment.end)
}

fn wall_meeting(stretch: &Stretch, radius: f64, segment: &Segment) -> Finding {
    let (from, to) = (stretch.place(stretch.since), stretch.place(stretch.until));
    let reach = DVec2::splat(radius + SIEVE * (radius + from.abs().max_element() + to.abs().max_element()));
    let (low, high) = (from.min(to) - reach, from.max(to) + reach);
    let is_clear =
        low.cmpgt(segment.start.max(segment.end)).any() || high.cmplt(segment.start.min(segment.end)).any();
    if is_clear {
        return Finding::NONE;
    }
    let (a, b) = (Exact::of(segment.start), Exact::of(segment.end));
    let (before, after) = (stretch.line(stretch.since), stretch.exact(stretch.until));
    let distances = [
        square_distance(&before, &a, &b),
        square_distance(&after, &a, &b),
        square_distance(&a, &before, &after),
        square_distance(&b, &before, &after),
    ];
    let least = distances.into_iter().min_by(Ord::cmp).expect("four distances");
    let least = if cross(&before, &after, &a, &b) { Rational::ZERO } else { least };
    Finding { depth: depth(&number(radius), &least), is_missed: enters_wall(stretch, radius, segment) }
}

/// How much nearer than `reach` a distance is, given its square: `(R² - m²) / (R + m)`, whose numerator is exact.
fn depth(reach: &Rational, square: &Rational) -> f64 {
    let over = (reach * reach - square).to_f64().value();
    over / (reach.to_f64().value() + square.to_f64().value().sqrt())
}
