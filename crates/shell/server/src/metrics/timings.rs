//! How long something took.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use serde::Serialize;

/// The upper bounds of the buckets, in seconds: a cycle at 8 a second has 125 ms, and one that is 10 ms late is late.
pub const TIMING_BOUNDS: [f64; 22] = [
    0.000_1,
    0.000_2,
    0.000_5,
    0.001,
    0.001_5,
    0.002,
    0.003,
    0.004,
    0.005,
    0.006,
    0.008,
    0.01,
    0.015,
    0.02,
    0.03,
    0.05,
    0.1,
    0.2,
    0.5,
    1.0,
    5.0,
    f64::INFINITY,
];

/// A histogram of durations.
#[derive(Debug, Default)]
pub struct Timings {
    /// By bucket, those of smaller ones not included.
    counts: [AtomicU64; TIMING_BOUNDS.len()],
    /// 2^64 nanoseconds are 584 years.
    sum_nanoseconds: AtomicU64,
    max_nanoseconds: AtomicU64,
}

/// How durations are spread, in milliseconds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// Half of all take no longer; an upper bound, one of [`TIMING_BOUNDS`] or the longest.
    pub p50: f64,
    /// 99 % of all take no longer; likewise.
    pub p99: f64,
    /// The longest took so long.
    pub max: f64,
}

/// A histogram at a moment.
pub(super) struct Reading {
    pub(super) sum_seconds: f64,
    pub(super) count: u64,
    /// The upper bound of each bucket in seconds, and how many are in it and in none before.
    pub(super) buckets: Vec<(f64, u64)>,
}

impl Timings {
    /// Counts a duration.
    pub fn record(&self, duration: Duration) {
        let seconds = duration.as_secs_f64();
        let bucket = TIMING_BOUNDS.iter().position(|&bound| seconds <= bound);
        let bucket = bucket.expect("the last bound is above everything");
        self.counts[bucket].fetch_add(1, Ordering::Relaxed);
        let nanoseconds = u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX);
        self.sum_nanoseconds.fetch_add(nanoseconds, Ordering::Relaxed);
        self.max_nanoseconds.fetch_max(nanoseconds, Ordering::Relaxed);
    }

    /// Returns how many durations were counted.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.read().count
    }

    /// Returns how they are spread; zeros if there were none.
    #[must_use]
    pub fn spread(&self) -> Spread {
        let Reading { count, buckets, .. } = self.read();
        let max = Duration::from_nanos(self.max_nanoseconds.load(Ordering::Relaxed)).as_secs_f64();
        let quantile = |share: f64| {
            let mut seen = 0;
            let bound = buckets.iter().find(|(_, in_bucket)| {
                seen += in_bucket;
                seen as f64 >= share * count as f64
            });
            bound.map_or(max, |&(bound, _)| bound.min(max)) * 1e3
        };
        Spread { p50: quantile(0.5), p99: quantile(0.99), max: max * 1e3 }
    }

    pub(super) fn read(&self) -> Reading {
        let counts = self.counts.iter().map(|count| count.load(Ordering::Relaxed));
        let buckets: Vec<(f64, u64)> = TIMING_BOUNDS.into_iter().zip(counts).collect();
        let sum = Duration::from_nanos(self.sum_nanoseconds.load(Ordering::Relaxed));
        Reading {
            sum_seconds: sum.as_secs_f64(),
            count: buckets.iter().map(|(_, count)| count).sum(),
            buckets,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_duration_is_counted_in_the_first_bucket_that_holds_it() {
        let timings = Timings::default();
        for (micros, bucket) in [(0, 0), (100, 0), (101, 1), (1_000_000, 19), (5_000_001, 21), (u64::MAX, 21)]
        {
            let before = timings.read().buckets[bucket].1;
            timings.record(Duration::from_micros(micros));
            assert_eq!(timings.read().buckets[bucket].1, before + 1, "{micros}");
        }
        assert_eq!(timings.count(), 6);
    }

    #[test]
    fn a_spread_is_of_bounds_but_for_the_longest() {
        let timings = Timings::default();
        assert_eq!(timings.spread(), Spread { p50: 0.0, p99: 0.0, max: 0.0 });
        for micros in (0..99).map(|_| 900).chain([8_300]) {
            timings.record(Duration::from_micros(micros));
        }
        assert_eq!(timings.spread(), Spread { p50: 1.0, p99: 1.0, max: 8.3 });
        timings.record(Duration::from_micros(8_200));
        assert_eq!(
            timings.spread(),
            Spread { p50: 1.0, p99: 8.3, max: 8.3 },
            "no bound is beyond the longest"
        );
    }
}
