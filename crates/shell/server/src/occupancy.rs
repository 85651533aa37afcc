//! Who is at a match and how far it is, as its simulation tells it.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicI64, AtomicU32, AtomicU64, Ordering};
use std::time::Duration;

use maniple_geometry::Cycle;
use maniple_view::Seat;

use crate::metrics::{CycleTimings, Metrics};
use crate::operation::{MatchTimings, Phase};

/// Who is there, and how far the match is. It also keeps the count of players and spectators of the daemon.
#[derive(Debug)]
pub(crate) struct Occupancy {
    metrics: Arc<Metrics>,
    /// A bit a seat.
    taken: AtomicU64,
    spectators: AtomicU32,
    /// Messages that wait for connections to take them.
    waiting: AtomicI64,
    has_begun: AtomicBool,
    is_paused: AtomicBool,
    cycle: AtomicU32,
    cycles: CycleTimings,
}

impl Occupancy {
    /// Returns that nobody is there.
    pub(crate) fn new(metrics: Arc<Metrics>) -> Self {
        Self {
            metrics,
            taken: AtomicU64::new(0),
            spectators: AtomicU32::new(0),
            waiting: AtomicI64::new(0),
            has_begun: AtomicBool::new(false),
            is_paused: AtomicBool::new(false),
            cycle: AtomicU32::new(0),
            cycles: CycleTimings::default(),
        }
    }

    /// Returns what the daemon counts.
    pub(crate) fn metrics(&self) -> &Arc<Metrics> {
        &self.metrics
    }

    /// Notes whether somebody sits at a seat.
    pub(crate) fn note_seat(&self, seat: Seat, is_taken: bool) {
        let bit = 1u64 << (seat.index() % 64);
        let before = if is_taken {
            self.taken.fetch_or(bit, Ordering::Relaxed)
        } else {
            self.taken.fetch_and(!bit, Ordering::Relaxed)
        };
        let was_taken = before & bit != 0;
        self.metrics.players.change(i64::from(is_taken) - i64::from(was_taken));
    }

    /// Notes how many watch.
    pub(crate) fn note_spectators(&self, count: usize) {
        let count = u32::try_from(count).expect("there is a limit to spectators");
        let before = self.spectators.swap(count, Ordering::Relaxed);
        self.metrics.spectators.change(i64::from(count) - i64::from(before));
    }

    /// Notes how many messages wait for connections to take them.
    pub(crate) fn note_waiting(&self, count: usize) {
        let count = i64::try_from(count).expect("there is a limit to messages");
        let before = self.waiting.swap(count, Ordering::Relaxed);
        self.metrics.queue_depth.change(count - before);
    }

    /// Notes that all seats have been joined.
    pub(crate) fn note_begin(&self) {
        self.has_begun.store(true, Ordering::Relaxed);
    }

    /// Notes the cycle, and whether the clock stands still.
    pub(crate) fn note_clock(&self, cycle: Cycle, is_paused: bool) {
        self.cycle.store(cycle.0, Ordering::Relaxed);
        self.is_paused.store(is_paused, Ordering::Relaxed);
    }

    /// Notes by how much a cycle begins too late, and by how much its distance from the one before differs from the period.
    pub(crate) fn note_lateness(&self, lateness: Duration, jitter: Option<Duration>) {
        for cycles in [&self.cycles, &self.metrics.cycles] {
            cycles.lateness.record(lateness);
            if let Some(jitter) = jitter {
                cycles.jitter.record(jitter);
            }
        }
    }

    /// Notes how long a cycle has taken.
    pub(crate) fn note_duration(&self, duration: Duration) {
        for cycles in [&self.cycles, &self.metrics.cycles] {
            cycles.duration.record(duration);
        }
    }

    /// Returns how its cycles keep their time.
    pub(crate) fn timings(&self) -> MatchTimings {
        let CycleTimings { duration, lateness, jitter } = &self.cycles;
        MatchTimings { cycle: duration.spread(), lateness: lateness.spread(), jitter: jitter.spread() }
    }

    /// Returns whether somebody sits at a seat.
    pub(crate) fn is_taken(&self, seat: usize) -> bool {
        self.taken.load(Ordering::Relaxed) & (1 << (seat % 64)) != 0
    }

    /// Returns how many watch.
    pub(crate) fn spectators(&self) -> u32 {
        self.spectators.load(Ordering::Relaxed)
    }

    /// Returns whether all seats have been joined.
    pub(crate) fn has_begun(&self) -> bool {
        self.has_begun.load(Ordering::Relaxed)
    }

    /// Returns the cycle.
    pub(crate) fn cycle(&self) -> u32 {
        self.cycle.load(Ordering::Relaxed)
    }

    /// Returns where the match is.
    pub(crate) fn phase(&self) -> Phase {
        if self.is_paused.load(Ordering::Relaxed) {
            Phase::Paused
        } else if self.has_begun() {
            Phase::Running
        } else {
            Phase::Open
        }
    }
}

/// Whoever is still there is there no more.
impl Drop for Occupancy {
    fn drop(&mut self) {
        let players = self.taken.load(Ordering::Relaxed).count_ones();
        self.metrics.players.change(-i64::from(players));
        self.metrics.spectators.change(-i64::from(self.spectators()));
        self.metrics.queue_depth.change(-self.waiting.load(Ordering::Relaxed));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_is_there_is_counted_once_until_the_match_is_gone() {
        let metrics = Arc::new(Metrics::default());
        let occupancy = Occupancy::new(Arc::clone(&metrics));
        let count = || (metrics.players.value(), metrics.spectators.value());
        occupancy.note_waiting(9);
        occupancy.note_waiting(7);
        assert_eq!(metrics.queue_depth.value(), 7);
        for (seat, is_taken, players) in
            [(0, true, 1), (0, true, 1), (3, true, 2), (1, false, 2), (0, false, 1)]
        {
            occupancy.note_seat(Seat(seat), is_taken);
            assert_eq!(count(), (players, 0));
        }
        occupancy.note_spectators(5);
        occupancy.note_spectators(4);
        assert_eq!(count(), (1, 4));
        occupancy.note_lateness(Duration::from_millis(2), Some(Duration::from_millis(1)));
        occupancy.note_duration(Duration::from_millis(4));
        let MatchTimings { cycle, lateness, jitter } = occupancy.timings();
        assert_eq!((cycle.max, lateness.max, jitter.max), (4.0, 2.0, 1.0));
        drop(occupancy);
        let CycleTimings { duration, lateness, jitter } = &metrics.cycles;
        assert_eq!((duration.count(), lateness.count(), jitter.count()), (1, 1, 1));
        assert_eq!((count(), metrics.queue_depth.value()), ((0, 0), 0));
    }
}
