//! Who may still be waited for in lock-step.

use std::time::Duration;

use maniple_view::Seat;
use serde::{Deserialize, Serialize};

/// The time banks of all seats.
///
/// A seat's bank runs down from the start of each cycle until the seat is done; each cycle adds the length that it
/// would have in real time, up to the full bank. Time is an argument: any duration since a fixed moment.
#[derive(Clone, Debug)]
pub(crate) struct Banks {
    full: Duration,
    refill: Duration,
    now: Duration,
    cycle_start: Duration,
    banks: Vec<Bank>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Bank {
    /// What is left of it, without the present cycle unless the seat is done.
    left: Duration,
    is_done: bool,
}

/// All banks at a moment.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct BanksSnapshot {
    now: Duration,
    cycle_start: Duration,
    banks: Vec<Bank>,
}

impl Banks {
    /// Returns full banks at the time zero.
    pub(crate) fn new(seats: usize, full: Duration, refill: Duration) -> Self {
        let bank = Bank { left: full, is_done: false };
        Self { full, refill, now: Duration::ZERO, cycle_start: Duration::ZERO, banks: vec![bank; seats] }
    }

    /// Returns the banks as they are now.
    pub(crate) fn snapshot(&self) -> BanksSnapshot {
        BanksSnapshot { now: self.now, cycle_start: self.cycle_start, banks: self.banks.clone() }
    }

    /// Goes on where a snapshot was taken; `None` where it is of another number of seats.
    pub(crate) fn restore(&mut self, snapshot: &BanksSnapshot) -> Option<()> {
        let BanksSnapshot { now, cycle_start, banks } = snapshot;
        if banks.len() != self.banks.len() {
            return None;
        }
        (self.now, self.cycle_start) = (*now, *cycle_start);
        self.banks.clone_from(banks);
        Some(())
    }

    /// Returns the last time that was taken.
    pub(crate) fn now(&self) -> Duration {
        self.now
    }

    /// Takes the present time; one that lies before the last is ignored.
    pub(crate) fn handle_time(&mut self, now: Duration) {
        self.now = self.now.max(now);
    }

    /// Takes the present time, and that none of what has passed since the last counts for anybody.
    pub(crate) fn handle_time_off(&mut self, now: Duration) {
        self.cycle_start = self.cycle_start.saturating_add(now.saturating_sub(self.now));
        self.handle_time(now);
    }

    /// Takes that a seat is done with the present cycle.
    pub(crate) fn handle_done(&mut self, seat: Seat) {
        let waited = self.waited();
        let bank = &mut self.banks[seat.index()];
        if !bank.is_done {
            bank.is_done = true;
            bank.left = bank.left.saturating_sub(waited);
        }
    }

    /// Begins to wait now: for the first time, or anew.
    pub(crate) fn restart(&mut self) {
        self.cycle_start = self.now;
    }

    /// Goes on to the next cycle.
    pub(crate) fn next_cycle(&mut self) {
        let waited = self.waited();
        for bank in &mut self.banks {
            if !bank.is_done {
                bank.left = bank.left.saturating_sub(waited);
            }
            bank.left = bank.left.saturating_add(self.refill).min(self.full);
            bank.is_done = false;
        }
        self.restart();
    }

    /// Returns whether a seat is not waited for: it is done, or its bank is empty.
    pub(crate) fn is_free(&self, seat: Seat) -> bool {
        self.banks[seat.index()].is_done || self.is_empty(seat)
    }

    /// Returns whether a seat is not done and its bank is empty.
    pub(crate) fn is_empty(&self, seat: Seat) -> bool {
        let bank = self.banks[seat.index()];
        !bank.is_done && self.waited() >= bank.left
    }

    /// Returns when the bank of a seat that is not done will be empty; `None` if it is done.
    pub(crate) fn empty_at(&self, seat: Seat) -> Option<Duration> {
        let bank = self.banks[seat.index()];
        (!bank.is_done).then(|| self.cycle_start.saturating_add(bank.left))
    }

    fn waited(&self) -> Duration {
        self.now.saturating_sub(self.cycle_start)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SEAT: Seat = Seat(0);

    #[test]
    fn a_bank_runs_down_until_the_seat_is_done() {
        let mut banks = banks();
        banks.handle_time(seconds(4));
        assert!(!banks.is_free(SEAT));
        assert_eq!(banks.empty_at(SEAT), Some(seconds(10)));
        banks.handle_done(SEAT);
        assert!(banks.is_free(SEAT) && !banks.is_empty(SEAT));
        banks.handle_time(seconds(50));
        banks.next_cycle();
        assert_eq!(banks.empty_at(SEAT), Some(seconds(50 + 10 - 4 + 1)));
        banks.handle_time(seconds(56));
        assert!(!banks.is_empty(SEAT));
        banks.handle_time(seconds(57));
        assert!(banks.is_empty(SEAT) && banks.is_free(SEAT));
    }

    #[test]
    fn an_empty_bank_gets_a_cycles_length_each_cycle_and_never_more_than_it_holds() {
        let mut banks = banks();
        banks.handle_time(seconds(30));
        banks.next_cycle();
        assert_eq!(banks.empty_at(SEAT), Some(seconds(31)));
        for _ in 0..20 {
            banks.handle_done(SEAT);
            banks.next_cycle();
        }
        assert_eq!(banks.empty_at(SEAT), Some(seconds(40)));
    }

    #[test]
    fn time_off_empties_no_bank() {
        let mut banks = banks();
        banks.handle_time(seconds(4));
        banks.handle_time_off(seconds(1000));
        banks.handle_time_off(seconds(900));
        assert_eq!(banks.empty_at(SEAT), Some(seconds(1006)));
        banks.handle_time(seconds(1005));
        assert!(!banks.is_free(SEAT));
        banks.handle_done(SEAT);
        banks.next_cycle();
        assert_eq!(banks.empty_at(SEAT), Some(seconds(1005 + 10 - (4 + 5) + 1)));
    }

    #[test]
    fn time_does_not_run_back() {
        let mut banks = banks();
        banks.handle_time(seconds(12));
        banks.handle_time(seconds(3));
        assert!(banks.is_empty(SEAT));
    }

    fn banks() -> Banks {
        Banks::new(1, seconds(10), seconds(1))
    }

    fn seconds(seconds: u64) -> Duration {
        Duration::from_secs(seconds)
    }
}
