//! Who is on the way already, and when another can depart.

use glam::DVec2;
use maniple_geometry::Scalar;

use super::beats::Beats;
use super::conflict::{Contact, Span, forbid};
use super::streets::{Streets, Use};
use super::trajectory::{Piece, Trajectory};

/// How much longer at both ends a span is taken to be than it was computed, in cycles: 2^-26, about 1.5e-8. Spans of neighbouring
/// pieces meet in one moment, and rounding must not leave a slit between them. The gap between circles has room for it.
const SLIT: f64 = 1.0 / (1u64 << 26) as f64;

/// A circle that keeps to its plan.
#[derive(Clone, Debug)]
pub(crate) struct Planned {
    pub(crate) trajectory: Trajectory,
    /// In cycles since the beginning of the schedule.
    pub(crate) departure: f64,
    pub(crate) radius: f64,
}

/// How much nearer than they are two circles may come that are too near to each other from the start, in world units: 2^-44.
const NEARER: f64 = 1.0 / (1u64 << 44) as f64;

/// How near two circles may come that start in two points: as near as `reach`, or, where they start nearer to each other, as they
/// are. Circles that have collided stand a skin above touching, and have to get away from each other.
pub(crate) fn reach_from(start: DVec2, other: DVec2, reach: f64) -> f64 {
    let distance = start.distance(other);
    if distance < reach { distance - NEARER } else { reach }
}

/// All circles whose plans stand.
#[derive(Clone, Debug)]
pub(crate) struct Traffic {
    /// The radius of those who ask, and how near to their middles the edges of others may come, in world units.
    radius: f64,
    gap: f64,
    planned: Vec<Planned>,
    /// Where those go who have that radius.
    streets: Streets,
    /// Memory of one question: for each of those planned the last span in which it forbids a departure, if streets say so, and all
    /// other spans.
    last: Vec<Option<Span>>,
    spans: Vec<Span>,
    /// How much it has looked up to now.
    pub(crate) looks: u64,
}

impl Traffic {
    /// Returns nobody, as circles of a radius see it that keep a margin from others; both in world units.
    pub(crate) fn new(radius: f64, margin: f64) -> Self {
        let gap = radius + margin;
        let streets = Streets::new(gap + radius);
        Self { radius, gap, planned: Vec::new(), streets, last: Vec::new(), spans: Vec::new(), looks: 0 }
    }

    /// Takes in a circle and returns its place.
    pub(crate) fn push(&mut self, planned: Planned) -> usize {
        let place = self.planned.len();
        if planned.radius == self.radius {
            self.streets.take_in(place, &planned.trajectory, planned.departure);
        }
        self.planned.push(planned);
        place
    }

    /// Returns the circle of a place.
    pub(crate) fn planned(&self, place: usize) -> &Planned {
        &self.planned[place]
    }

    /// Returns the same without the circle of a place; those behind it move up.
    pub(crate) fn without(&self, place: usize) -> Self {
        let Self { radius, gap, looks, .. } = *self;
        let mut traffic = Self { gap, looks, streets: Streets::new(gap + radius), ..Self::new(radius, 0.0) };
        for (other, planned) in self.planned.iter().enumerate() {
            if other != place {
                traffic.push(planned.clone());
            }
        }
        traffic
    }

    /// Returns the earliest moment, not before 0, at which a circle can depart without ever coming nearer to any other than both radii
    /// and the margin; `None` where there is none. Where there are beats, it is one of them.
    pub(crate) fn earliest(&mut self, trajectory: &Trajectory, beats: Option<Beats>) -> Option<f64> {
        self.spans.clear();
        self.last.clear();
        for other in &self.planned {
            let usual = self.gap + other.radius;
            let reach = reach_from(trajectory.start(), other.trajectory.start(), usual);
            let is_usual = other.radius == self.radius && reach == usual;
            self.last.push(is_usual.then_some(Span::NONE));
            if !is_usual {
                // Of another radius, or too near to it from the start.
                let other = (&other.trajectory, other.departure);
                self.looks += forbid(trajectory, other, reach, &mut self.spans);
            }
        }
        let mut own = Vec::new();
        for piece in trajectory.pieces() {
            let Self { streets, last, spans, .. } = self;
            match streets
                .meet_on_street(&piece.stretch, |other, contact| note(piece, other, contact, last, spans))
            {
                Some(looks) => self.looks += looks,
                None => own.push(piece),
            }
        }
        self.spans.extend(self.last.iter().flatten());
        self.spans.iter_mut().for_each(|span| *span = span.widened());
        let first = beats.map_or(0.0, |beats| beats.not_before(0.0));
        let departure = first_in_none(first, beats, &mut self.spans)?;
        // It is this one or a later one: what forbids earlier ones alone need not be looked for.
        self.spans.retain(|span| span.to > departure);
        let known = self.spans.len();
        self.last.iter_mut().flatten().for_each(|span| *span = Span::NONE);
        for piece in own {
            let Self { streets, last, spans, .. } = self;
            let after = departure + piece.times.first - SLIT;
            self.looks += streets
                .meet(&piece.stretch, after, |other, contact| note(piece, other, contact, last, spans));
        }
        self.spans.extend(self.last.iter().flatten());
        self.spans[known..].iter_mut().for_each(|span| *span = span.widened());
        first_in_none(departure, beats, &mut self.spans)
    }
}

/// Notes that another circle forbids departures to the one whose piece comes near to it: neighbouring pieces forbid nearly the same ones,
/// so that often the last span of that circle grows.
#[inline]
fn note(piece: &Piece, other: &Use, contact: Contact, last: &mut [Option<Span>], spans: &mut Vec<Span>) {
    let Some(last) = &mut last[other.circle] else { return };
    let span = contact.span(piece.times, other.times);
    if let Some(joined) = last.joined(span) {
        *last = joined;
    } else {
        spans.push(std::mem::replace(last, span));
    }
}

/// The first moment from one on that is in no span; sorts the spans. Where there are beats, both moments are beats. `None` where there is
/// none.
fn first_in_none(from: f64, beats: Option<Beats>, spans: &mut [Span]) -> Option<f64> {
    let not_before = |moment: f64| beats.map_or(moment, |beats| beats.not_before(moment));
    spans.sort_unstable_by(|one, other| one.from.total_cmp(&other.from));
    let mut departure = from;
    for span in spans {
        if span.from >= departure {
            break;
        }
        departure = departure.greater(not_before(span.to));
    }
    departure.is_finite().then_some(departure)
}

impl Span {
    /// The same, longer by a [`SLIT`] at both ends.
    fn widened(self) -> Self {
        Self { from: self.from - SLIT, to: self.to + SLIT }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::Dice;

    const RADIUS: f64 = 0.35;
    const MARGIN: f64 = 0.001;

    /// The slow twin: pair by pair, and piece by piece.
    fn earliest_by_pairs(traffic: &Traffic, trajectory: &Trajectory, beats: Option<Beats>) -> Option<f64> {
        let mut spans = Vec::new();
        for other in &traffic.planned {
            let usual = traffic.gap + other.radius;
            let reach = reach_from(trajectory.start(), other.trajectory.start(), usual);
            forbid(trajectory, (&other.trajectory, other.departure), reach, &mut spans);
        }
        spans.iter_mut().for_each(|span| *span = span.widened());
        let first = beats.map_or(0.0, |beats| beats.not_before(0.0));
        first_in_none(first, beats, &mut spans)
    }

    #[test]
    fn the_earliest_departure_is_that_of_all_pairs() {
        let (mut later, mut never) = (0, 0);
        for seed in 0..400 {
            let mut dice = Dice(seed);
            let point = |dice: &mut Dice| DVec2::new(dice.share(), dice.share()) * 12.0;
            // All go by some of these points, one after the other, so that they share legs.
            let trunk: Vec<DVec2> = (0..6).map(|_| point(&mut dice)).collect();
            let trajectory = |dice: &mut Dice| {
                let part = |share: f64| (0..=6).filter(|&index| f64::from(index) < 6.0 * share).count();
                let (first, last) = (part(0.5 * dice.share()), part(0.5 + 0.5 * dice.share()));
                let legs = [&trunk[first.min(last)..last.min(6)], &[point(dice)]].concat();
                match dice.roll() % 8 {
                    0 => Trajectory::still(point(dice)),
                    1 => Trajectory::new(point(dice), &legs, 0.3),
                    _ => Trajectory::new(point(dice), &legs, 0.2),
                }
            };
            let mut traffic = Traffic::new(RADIUS, MARGIN);
            for circle in 0..20 {
                let asked = trajectory(&mut dice);
                let is_on_beats = dice.roll().is_multiple_of(2);
                let beats = is_on_beats.then(|| Beats::new(9.0 * dice.share(), 0.1 + 7.0 * dice.share()));
                let found = traffic.earliest(&asked, beats);
                let expected = earliest_by_pairs(&traffic, &asked, beats);
                assert_eq!(found, expected, "seed {seed}, circle {circle}");
                later += usize::from(found.is_some_and(|departure| departure > 0.0));
                never += usize::from(found.is_none());
                let radius = if dice.share() < 0.9 { RADIUS } else { 0.6 };
                let (trajectory, departure) = (trajectory(&mut dice), found.unwrap_or(40.0 * dice.share()));
                traffic.push(Planned { trajectory, departure, radius });
            }
        }
        assert!(later > 1000 && never > 1000, "{later} {never}");
    }
}
