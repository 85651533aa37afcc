//! Which departures would bring two circles too near to each other.

use glam::DVec2;
use maniple_geometry::Scalar;

use super::stretch::Stretch;
use super::trajectory::{Times, Trajectory};

/// Departures between two moments, in cycles; the ends do not belong to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Span {
    /// May be minus infinity.
    pub(crate) from: f64,
    /// May be infinity.
    pub(crate) to: f64,
}

impl Span {
    /// No departure.
    pub(crate) const NONE: Self = Self { from: f64::INFINITY, to: f64::NEG_INFINITY };

    /// Joins two spans that have departures in common; `None` for others.
    #[inline]
    pub(crate) fn joined(self, other: Self) -> Option<Self> {
        (self.from < other.to && other.from < self.to)
            .then(|| Self { from: self.from.lesser(other.from), to: self.to.greater(other.to) })
    }
}

/// How much later than on one stretch a circle must not be on another, if it is not to come too near: between two delays, in cycles,
/// counted from when the circles are at the beginning of their stretches. Neither depends on when they are there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Contact {
    from: f64,
    to: f64,
}

impl Contact {
    /// Returns the contact of two stretches; `None` where they never come nearer than `reach`.
    ///
    /// With the time `s` in which one has gone, and `t` in which the other has, the centres are `f(s, t) = x + u s - w t` apart, where
    /// `x` is the offset of the points at which the stretches begin, and `u`, `w` are the velocities. `|f| < reach` is an ellipse in
    /// the plane of `s` and `t`, or a strip where `u` and `w` are parallel: convex, and so is its part within the rectangle of the
    /// times that the stretches last. So the delays `t - s` that must not be are one span, from the smallest to the largest in that
    /// part. These lie on the border of the rectangle, or where the ellipse touches a line of equal delay. Of a circle at rest, which is
    /// in the first point all the time, `s` or `t` is zero.
    pub(crate) fn of(one: &Stretch, other: &Stretch, reach: f64) -> Option<Self> {
        let offset = one.point - other.point;
        match (one.is_moving(), other.is_moving()) {
            (false, false) => {
                (offset.length_squared() < reach * reach).then_some(Self { from: 0.0, to: 0.0 })
            }
            (false, true) => near((offset, -other.velocity), reach, other.duration)
                .map(|(first, last)| Self { from: first, to: last }),
            (true, false) => near((offset, one.velocity), reach, one.duration)
                .map(|(first, last)| Self { from: -last, to: -first }),
            (true, true) => delays(offset, (one, other), reach),
        }
    }

    /// Returns when the circle on the first stretch must not begin its trajectory, of which the times are counted, lest it comes too near
    /// to the one on the other.
    #[inline]
    pub(crate) fn span(self, one: Times, other: Times) -> Span {
        Span { from: other.first - one.last + self.from, to: other.last - one.first + self.to }
    }
}

/// Puts behind `spans` when a circle must not begin a trajectory, lest its centre comes nearer than `reach` to that of another, which
/// has a trajectory and a departure. Spans may overlap. Returns how many looks it took.
pub(crate) fn forbid(
    one: &Trajectory,
    (other, departure): (&Trajectory, f64),
    reach: f64,
    spans: &mut Vec<Span>,
) -> u64 {
    let mut looks = 1;
    if one.bounds().is_far(other.bounds(), reach) {
        return looks;
    }
    for a in one.pieces() {
        if a.stretch.bounds.is_far(other.bounds(), reach) {
            continue;
        }
        looks += other.pieces().len() as u64;
        for b in other.pieces() {
            if !a.stretch.bounds.is_far(&b.stretch.bounds, reach) {
                let contact = Contact::of(&a.stretch, &b.stretch, reach);
                spans.extend(contact.map(|contact| contact.span(a.times, b.times.later(departure))));
            }
        }
    }
    looks
}

/// The delays of [`Contact::of`] for two stretches that are legs.
fn delays(x: DVec2, (one, other): (&Stretch, &Stretch), reach: f64) -> Option<Contact> {
    let (u, w) = (one.velocity, other.velocity);
    let (s_end, t_end) = (one.duration, other.duration);
    let mut contact = Contact { from: f64::INFINITY, to: f64::NEG_INFINITY };
    let mut take = |delay: f64| {
        contact.from = contact.from.lesser(delay);
        contact.to = contact.to.greater(delay);
    };
    for s in [0.0, s_end] {
        if let Some((first, last)) = near((x + u * s, -w), reach, t_end) {
            take(first - s);
            take(last - s);
        }
    }
    for t in [0.0, t_end] {
        if let Some((first, last)) = near((x - w * t, u), reach, s_end) {
            take(t - first);
            take(t - last);
        }
    }
    // Where the distance of the line `x - w d + (u - w) s` from the origin is the reach, with `d` the delay.
    let along = u - w;
    let turn = w.perp_dot(along);
    if turn != 0.0 {
        for side in [-reach, reach] {
            let delay = (x.perp_dot(along) + side * along.length()) / turn;
            let s = -(x - w * delay).dot(along) / along.length_squared();
            let t = s + delay;
            if (0.0..=s_end).contains(&s) && (0.0..=t_end).contains(&t) {
                take(delay);
            }
        }
    }
    (contact.from < contact.to).then_some(contact)
}

/// When a point that starts at an offset with a velocity is nearer than `reach` to the origin, as two times of `0.0..=end`;
/// `None` where it never is.
///
/// The roots of `|x + v t|² = reach²`.
fn near((x, v): (DVec2, DVec2), reach: f64, end: f64) -> Option<(f64, f64)> {
    let (square, slope, rest) = (v.length_squared(), x.dot(v), x.length_squared() - reach * reach);
    let discriminant = slope * slope - square * rest;
    if discriminant <= 0.0 {
        return None;
    }
    let root = discriminant.sqrt();
    let first = ((-slope - root) / square).greater(0.0);
    let last = ((root - slope) / square).lesser(end);
    (first < last).then_some((first, last))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::release::trajectory::Piece;
    use crate::tests::Dice;

    /// How often it is looked, in cycles; so long nobody comes nearer than by 0.15.
    const LOOK: f64 = 0.05;

    /// The slow twin: how near two trajectories come if one departs so much later than the other, by looking often.
    fn nearest(one: &Trajectory, other: &Trajectory, delay: f64) -> f64 {
        let end = one.duration() + other.duration() + delay.abs() + 1.0;
        let at = |trajectory: &Trajectory, time: f64| {
            let is_meant = |piece: &&Piece| time <= piece.times.last + piece.stretch.duration;
            let Piece { stretch, times } = trajectory.pieces().iter().find(is_meant).unwrap();
            let gone = if stretch.is_moving() { time - times.first } else { 0.0 };
            stretch.point + stretch.velocity * gone
        };
        let mut least = f64::INFINITY;
        let mut time = -end;
        while time < end {
            least = least.lesser(at(one, time - delay).distance(at(other, time)));
            time += LOOK;
        }
        least
    }

    #[test]
    fn departures_are_forbidden_if_and_only_if_circles_would_come_too_near() {
        let (mut near_count, mut far_count) = (0, 0);
        for seed in 0..300 {
            let mut dice = Dice(seed);
            let mut trajectory = || {
                let mut point = || DVec2::new(dice.share(), dice.share()) * 6.0;
                let (from, legs) = (point(), [point(), point(), point()]);
                let count = (0..3).filter(|_| dice.share() < 0.7).count();
                Trajectory::new(from, &legs[..count], 0.5 + dice.share())
            };
            let (one, other) = (trajectory(), trajectory());
            let mut spans = Vec::new();
            forbid(&one, (&other, 0.0), 0.7, &mut spans);
            for delay in (-40..40).map(f64::from) {
                let is_forbidden = spans.iter().any(|span| span.from < delay && delay < span.to);
                let least = nearest(&one, &other, delay);
                assert!(is_forbidden || least > 0.7 - 1e-9, "seed {seed}, delay {delay}: {least}");
                // What is looked at is never nearer than it is, and at most a step farther.
                assert!(!is_forbidden || least < 0.7 + 0.3, "seed {seed}, delay {delay}: {least}");
                *(if is_forbidden { &mut near_count } else { &mut far_count }) += 1;
            }
        }
        assert!(near_count > 1000 && far_count > 1000, "{near_count} {far_count}");
    }
}
