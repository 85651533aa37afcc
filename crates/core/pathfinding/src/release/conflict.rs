//! Which departures would bring two circles too near to each other.

use glam::DVec2;
use maniple_geometry::Scalar;

use super::trajectory::{Piece, Trajectory};

/// Departures between two moments, in cycles; the ends do not belong to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Span {
    /// May be minus infinity.
    pub(crate) from: f64,
    /// May be infinity.
    pub(crate) to: f64,
}

impl Span {
    /// Joins two spans that have departures in common; `None` for others.
    fn joined(self, other: Self) -> Option<Self> {
        (self.from < other.to && other.from < self.to)
            .then(|| Self { from: self.from.lesser(other.from), to: self.to.greater(other.to) })
    }
}

/// Puts behind `spans` when one circle must not depart, counted from the departure of another, lest their centres come
/// nearer than `reach` to each other. Spans may overlap. Returns how many looks it took.
pub(crate) fn forbid(one: &Trajectory, other: &Trajectory, reach: f64, spans: &mut Vec<Span>) -> u64 {
    let mut looks = 1;
    if one.whole().is_far(other.whole(), reach) {
        return looks;
    }
    let first = spans.len();
    for (run, pieces) in one.runs() {
        if run.is_far(other.whole(), reach) {
            continue;
        }
        for (other_run, other_pieces) in other.runs() {
            looks += 1;
            if run.is_far(other_run, reach) {
                continue;
            }
            for a in pieces {
                if a.bounds().is_far(other_run, reach) {
                    continue;
                }
                looks += other_pieces.len() as u64;
                for b in other_pieces {
                    if !a.bounds().is_far(b.bounds(), reach) {
                        add(forbidden(a, b, reach), first, spans);
                    }
                }
            }
        }
    }
    looks
}

/// Puts a span behind others, of which those from `first` on are of the same two circles. Neighbouring pieces forbid nearly the same
/// departures, so that it often is the last one that grows.
fn add(span: Option<Span>, first: usize, spans: &mut Vec<Span>) {
    let Some(span) = span else { return };
    if let Some(last) = spans[first..].last_mut()
        && let Some(joined) = last.joined(span)
    {
        *last = joined;
    } else {
        spans.push(span);
    }
}

/// Returns when `a` must not begin its trajectory, counted from the beginning of that of `b`; `None` where the two never
/// come nearer than `reach`.
///
/// With the time `s` in which `a` has gone, and `t` in which `b` has, the centres are `f(s, t) = x + u s - w t` apart, where
/// `x` is the offset of the points at which the pieces begin, and `u`, `w` are the velocities. `|f| < reach` is an ellipse in
/// the plane of `s` and `t`, or a strip where `u` and `w` are parallel: convex, and so is its part within the rectangle of the
/// times that the pieces last. So the delay `t - s` of the departures that must not be is one span, from the smallest to the
/// largest delay in that part. These lie on the border of the rectangle, or where the ellipse touches a line of equal delay.
fn forbidden(a: &Piece, b: &Piece, reach: f64) -> Option<Span> {
    let offset = a.point - b.point;
    let between = b.since - a.since;
    match (a.is_moving(), b.is_moving()) {
        (false, false) => (offset.length_squared() < reach * reach)
            .then_some(Span { from: b.since - a.until, to: b.until - a.since }),
        (false, true) => near((offset, -b.velocity), reach, b.duration())
            .map(|(first, last)| Span { from: b.since + first - a.until, to: b.since + last - a.since }),
        (true, false) => near((offset, a.velocity), reach, a.duration())
            .map(|(first, last)| Span { from: b.since - (a.since + last), to: b.until - (a.since + first) }),
        (true, true) => {
            let span = delays(offset, (a, b), reach)?;
            Some(Span { from: between + span.from, to: between + span.to })
        }
    }
}

/// The delays `t - s` of [`forbidden`] for two pieces that move.
fn delays(x: DVec2, (a, b): (&Piece, &Piece), reach: f64) -> Option<Span> {
    let (u, w) = (a.velocity, b.velocity);
    let (s_end, t_end) = (a.duration(), b.duration());
    let mut span = Span { from: f64::INFINITY, to: f64::NEG_INFINITY };
    let mut take = |delay: f64| {
        span.from = span.from.lesser(delay);
        span.to = span.to.greater(delay);
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
    (span.from < span.to).then_some(span)
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
    use crate::tests::Dice;

    /// How often it is looked, in cycles; so long nobody comes nearer than by 0.15.
    const LOOK: f64 = 0.05;

    /// The slow twin: how near two trajectories come if one departs so much later than the other, by looking often.
    fn nearest(one: &Trajectory, other: &Trajectory, delay: f64) -> f64 {
        let end = one.duration() + other.duration() + delay.abs() + 1.0;
        let at = |trajectory: &Trajectory, time: f64| {
            let piece = trajectory.pieces().iter().find(|piece| time <= piece.until).unwrap();
            if piece.is_moving() { piece.point + piece.velocity * (time - piece.since) } else { piece.point }
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
            forbid(&one, &other, 0.7, &mut spans);
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
