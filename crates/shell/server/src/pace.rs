//! When the cycles of a real-time match are due.

use std::time::Duration;

/// Periods by which a cycle may be late before the clock gives up catching up. A short stall is made good by cycles in
/// quick succession; after a long one such a burst would be a stall of its own.
pub const LATE_PERIODS_MAX: u32 = 5;

/// The least time between two warnings about lateness.
const WARNING_INTERVAL: Duration = Duration::from_secs(1);

/// Absolute deadlines, one a period, so that lateness does not add up. Time is an argument: any duration since a
/// fixed moment.
#[derive(Clone, Debug)]
pub(crate) struct Pace {
    period: Duration,
    due: Duration,
    /// When the last cycle was played.
    played: Option<Duration>,
    /// Periods that were given up and not warned of yet.
    slipped: u64,
    warned_at: Option<Duration>,
}

impl Pace {
    /// Returns deadlines of which the first is one period after `now`.
    pub(crate) fn new(period: Duration, now: Duration) -> Self {
        Self { period, due: now.saturating_add(period), played: None, slipped: 0, warned_at: None }
    }

    /// Returns by how much the time from the last cycle to one that is played now differs from a period; `None`: it is the first.
    pub(crate) fn jitter(&self, now: Duration) -> Option<Duration> {
        self.played.map(|played| now.saturating_sub(played).abs_diff(self.period))
    }

    /// Takes that the cycle that is due is played now. Returns how many periods were given up since the last warning,
    /// if it is time for another.
    pub(crate) fn handle_step(&mut self, now: Duration) -> Option<u64> {
        self.played = Some(now);
        let late = now.saturating_sub(self.due);
        if late <= self.period.saturating_mul(LATE_PERIODS_MAX) {
            self.due = self.due.saturating_add(self.period);
            return None;
        }
        let periods = late.as_nanos() / self.period.as_nanos().max(1);
        self.slipped = self.slipped.saturating_add(u64::try_from(periods).unwrap_or(u64::MAX));
        self.due = now.saturating_add(self.period);
        let is_time = self.warned_at.is_none_or(|at| now.saturating_sub(at) >= WARNING_INTERVAL);
        if !is_time {
            return None;
        }
        self.warned_at = Some(now);
        Some(std::mem::take(&mut self.slipped))
    }

    /// Returns when the next cycle is due.
    pub(crate) fn due(&self) -> Duration {
        self.due
    }

    /// Returns how much of the present period has passed, `0.0..=1.0`.
    pub(crate) fn fraction(&self, now: Duration) -> f64 {
        let left = self.due.saturating_sub(now).as_secs_f64() / self.period.as_secs_f64();
        (1.0 - left).clamp(0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lateness_of_one_cycle_does_not_move_the_next() {
        let mut pace = Pace::new(millis(100), millis(50));
        for (now, due) in [(150, 250), (260, 350), (500, 450), (500, 550), (550, 650)] {
            assert_eq!(pace.handle_step(millis(now)), None);
            assert_eq!(pace.due(), millis(due));
        }
    }

    #[test]
    fn jitter_is_the_difference_from_a_period() {
        let mut pace = Pace::new(millis(100), millis(50));
        assert_eq!(pace.jitter(millis(150)), None);
        for (played, next, jitter) in [(150, 250, 0), (252, 349, 3), (349, 470, 21)] {
            pace.handle_step(millis(played));
            assert_eq!(pace.jitter(millis(next)), Some(millis(jitter)));
        }
    }

    #[test]
    fn after_a_long_stall_the_clock_starts_anew() {
        let mut pace = Pace::new(millis(100), millis(0));
        assert_eq!(pace.handle_step(millis(600)), None, "five periods late");
        assert_eq!(pace.due(), millis(200));
        assert_eq!(pace.handle_step(millis(800)), Some(6));
        assert_eq!(pace.due(), millis(900));
    }

    #[test]
    fn there_is_one_warning_a_second_and_it_counts_all() {
        let mut pace = Pace::new(millis(10), millis(0));
        assert_eq!(pace.handle_step(millis(110)), Some(10));
        assert_eq!(pace.handle_step(millis(220)), None);
        assert_eq!(pace.handle_step(millis(330)), None);
        assert_eq!(pace.handle_step(millis(1340)), Some(10 + 10 + 100));
    }

    #[test]
    fn the_fraction_grows_from_0_to_1() {
        let pace = Pace::new(millis(1000), millis(1000));
        for (now, fraction) in [(900, 0.0), (1000, 0.0), (1250, 0.25), (2000, 1.0), (9000, 1.0)] {
            assert_eq!(pace.fraction(millis(now)), fraction, "{now}");
        }
    }

    fn millis(millis: u64) -> Duration {
        Duration::from_millis(millis)
    }
}
