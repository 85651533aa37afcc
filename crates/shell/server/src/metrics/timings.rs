//! How long something took.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

/// The upper bounds of the buckets, in seconds: a cycle at 8 a second has 125 ms, and one that is 10 ms late is late.
pub const TIMING_BOUNDS: [f64; 12] =
    [0.000_5, 0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, f64::INFINITY];

/// A histogram of durations.
#[derive(Debug, Default)]
pub struct Timings {
    /// By bucket, those of smaller ones not included.
    counts: [AtomicU64; TIMING_BOUNDS.len()],
    /// 2^64 nanoseconds are 584 years.
    sum_nanoseconds: AtomicU64,
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
    }

    /// Returns how many durations were counted.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.read().count
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
        for (micros, bucket) in [(0, 0), (500, 0), (501, 1), (1_000_000, 10), (1_000_001, 11), (u64::MAX, 11)]
        {
            let before = timings.read().buckets[bucket].1;
            timings.record(Duration::from_micros(micros));
            assert_eq!(timings.read().buckets[bucket].1, before + 1, "{micros}");
        }
        assert_eq!(timings.count(), 6);
    }
}
