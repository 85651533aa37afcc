//! When the lanes of narrow places are passed.
//!
//! Where neighbouring lanes are nearer to each other than circles, and circles stand in each other's gaps, whoever comes a little late takes
//! the gap of two. So it can be asked that each lane is passed on beats: by one at most at each, as often in all lanes, and in every second
//! lane between two beats of its neighbours.

use std::collections::BTreeMap;

use super::ends::Start;

/// How a circle passes the narrow place of its group.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Passage {
    /// By which lane, counted from the left.
    pub(crate) lane: usize,
    /// How far it is from the start to the end of the narrow place, in world units.
    pub(crate) distance: f64,
    /// How far circles of a lane are behind each other, in world units.
    pub(crate) spacing: f64,
    /// Whether they keep to beats so far from each other.
    pub(crate) timing: Timing,
}

/// When a lane is passed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Timing {
    /// Whenever there is room.
    Anytime,
    /// On beats.
    OnBeats,
}

/// Moments of which one is as far from the next as from the one before, in cycles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Beats {
    /// One of them.
    one: f64,
    period: f64,
}

impl Beats {
    /// Returns those of which one is known, and how far from each other they are, in cycles.
    pub(crate) fn new(one: f64, period: f64) -> Self {
        Self { one, period }
    }

    /// Returns the first that is not before a moment.
    pub(crate) fn not_before(self, moment: f64) -> f64 {
        if !moment.is_finite() {
            return moment;
        }
        let beat = self.one + ((moment - self.one) / self.period).ceil() * self.period;
        // Rounding may have lost a little.
        if beat < moment { beat + self.period } else { beat }
    }
}

/// Who has passed the narrow places.
#[derive(Clone, Debug)]
pub(crate) struct Passed {
    speed: f64,
    /// When beats begin in the first lane of each group, and every second one from there.
    first: BTreeMap<usize, f64>,
    /// When a lane of a group was passed last.
    last: BTreeMap<(usize, usize), f64>,
}

impl Passed {
    pub(crate) fn new(speed: f64) -> Self {
        Self { speed, first: BTreeMap::new(), last: BTreeMap::new() }
    }

    /// Returns when a circle passes the narrow place that departs at a moment.
    pub(crate) fn moment(&self, passage: Passage, departure: f64) -> f64 {
        departure + passage.distance / self.speed
    }

    /// Returns when a circle may depart; `None` where it may at any time.
    pub(crate) fn departures(&self, start: &Start) -> Option<Beats> {
        let passage = start.passage.filter(|passage| passage.timing == Timing::OnBeats)?;
        let first = self.first.get(&start.group)? + self.phase(passage);
        Some(Beats::new(first - passage.distance / self.speed, passage.spacing / self.speed))
    }

    /// Returns whether a lane is left empty for long before a circle passes that departs at a moment.
    pub(crate) fn is_late(&self, start: &Start, departure: f64) -> bool {
        let last =
            start.passage.and_then(|passage| Some((passage, self.last.get(&(start.group, passage.lane))?)));
        last.is_some_and(|(passage, last)| {
            self.moment(passage, departure) - last > 1.5 * passage.spacing / self.speed
        })
    }

    /// Notes that a circle departs at a moment.
    pub(crate) fn take(&mut self, start: &Start, departure: f64) {
        let Some(passage) = start.passage else { return };
        let (moment, phase) = (self.moment(passage, departure), self.phase(passage));
        self.first.entry(start.group).or_insert(moment - phase);
        self.last.insert((start.group, passage.lane), moment);
    }

    /// How much later than those of the first lane the beats of a lane begin, in cycles.
    fn phase(&self, passage: Passage) -> f64 {
        if passage.lane.is_multiple_of(2) { 0.0 } else { 0.5 * passage.spacing / self.speed }
    }
}

#[cfg(test)]
mod tests {
    use maniple_geometry::Scalar;

    use super::*;
    use crate::tests::Dice;

    #[test]
    fn the_next_slot_is_the_first_that_is_not_before() {
        let mut dice = Dice(7);
        for _ in 0..10_000 {
            let beats = Beats { one: 200.0 * dice.share() - 100.0, period: 1.0 + 4.0 * dice.share() };
            let moment = 500.0 * dice.share();
            let found = beats.not_before(moment);
            // The slow twin: beat by beat.
            let mut beat = beats.one - 100.0 * beats.period;
            while beat < moment - 1e-9 {
                beat += beats.period;
            }
            let rounded = (found - beat).abs().lesser((found - beat - beats.period).abs());
            assert!(found >= moment && rounded < 1e-9, "{beats:?} {moment}: {found} instead of {beat}");
        }
        let beats = Beats { one: 0.0, period: 2.0 };
        assert_eq!(beats.not_before(f64::INFINITY), f64::INFINITY);
    }

    #[test]
    fn neighbours_pass_half_a_slot_after_each_other() {
        let start = |lane: usize, distance: f64| {
            let passage = Passage { lane, distance, spacing: 0.8, timing: Timing::OnBeats };
            Start { passage: Some(passage), ..Start::still(glam::DVec2::ZERO) }
        };
        let mut passed = Passed::new(0.2);
        let (first, second, third) = (start(1, 3.0), start(2, 4.0), start(1, 7.0));
        assert_eq!(passed.departures(&first), None);
        passed.take(&first, 10.0);
        let moments = |start: &Start| {
            let departure = passed.departures(start).unwrap().not_before(10.0);
            (start.passage.unwrap().distance / 0.2 + departure - 25.0) / 4.0
        };
        assert!((moments(&second).fract() - 0.5).abs() < 1e-9, "{}", moments(&second));
        assert!((moments(&third).fract() + 1e-9).fract() < 1e-6, "{}", moments(&third));
        assert!(!passed.is_late(&third, 10.0 - 20.0 + 4.0));
        assert!(passed.is_late(&third, 10.0));
    }
}
