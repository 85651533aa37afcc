//! How far behind a client is, and what is done about it.

use maniple_geometry::Cycle;

/// Deltas that wait for a connection: two seconds at 8 cycles a second. Who lets more of them wait is better served with one that
/// tells it all.
pub const DELTAS_UNTAKEN_MAX: usize = 16;

/// Bytes of deltas that wait for a connection, for the few whose deltas are large: 16 of them may be a megabyte then.
pub const BYTES_UNTAKEN_MAX: usize = 256 * 1024;

/// Cycles that a client may be behind what it was sent, by its own word. As [`DELTAS_UNTAKEN_MAX`]: where such deltas wait, here or there,
/// makes no difference to who reads them.
pub const CYCLES_UNSEEN_MAX: u32 = 16;

/// Cycles in which nothing can be sent before the connection is closed: a minute at 8 cycles a second.
pub const CYCLES_WITHHELD_MAX: u32 = 512;

/// What a connection has not taken yet.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Untaken {
    /// How many deltas.
    pub deltas: usize,
    /// How many bytes they have.
    pub bytes: usize,
}

/// What is to be done with the deltas of a client.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turn {
    /// It gets what it was not told yet.
    Now,
    /// It lags: it gets nothing until it has caught up with what was sent.
    Later,
    /// It has lagged for too long.
    Never,
}

/// How far behind a client is: known by what it says that it has seen, and by what its connection does not take, and not
/// guessed.
#[derive(Clone, Copy, Debug, Default)]
pub struct Lag {
    /// The cycle of the last delta that was sent; `None` before the first.
    sent: Option<Cycle>,
    word: Word,
    is_behind: bool,
}

/// What a client has said of its view.
#[derive(Clone, Copy, Debug, Default)]
enum Word {
    #[default]
    Nothing,
    /// It has given commands, and may have no more to give: what they said counts until this cycle.
    Late(Cycle),
    /// It says of each delta that it has seen it, and this is the last.
    Seen(Cycle),
}

impl Lag {
    /// Takes that all up to this cycle was sent.
    pub fn handle_sent(&mut self, cycle: Cycle) {
        self.sent = Some(cycle);
    }

    /// Takes that the client says to be done with a delta.
    pub fn handle_done(&mut self, cycle: Cycle) {
        let seen = match self.word {
            Word::Seen(seen) => seen.max(cycle),
            Word::Nothing | Word::Late(_) => cycle,
        };
        self.word = Word::Seen(seen);
    }

    /// Takes that commands came in cycle `now`, decided on a view of cycle `seen`.
    pub fn handle_commands(&mut self, now: Cycle, seen: Cycle) {
        self.word = match self.word {
            Word::Seen(_) => return self.handle_done(seen),
            Word::Nothing | Word::Late(_) if self.is_unseen(seen) => {
                Word::Late(Cycle(now.0.saturating_add(CYCLES_UNSEEN_MAX)))
            }
            Word::Nothing | Word::Late(_) => Word::Nothing,
        };
    }

    /// Returns what is to be done with what the client was not told up to cycle `now`.
    pub fn poll(&mut self, now: Cycle, untaken: Untaken) -> Turn {
        self.is_behind = if self.is_behind {
            untaken.deltas > 0 || !self.has_seen_all(now)
        } else {
            untaken.deltas >= DELTAS_UNTAKEN_MAX
                || untaken.bytes >= BYTES_UNTAKEN_MAX
                || self.says_to_be_behind(now)
        };
        let withheld = now.0.saturating_sub(self.sent.map_or(0, |sent| sent.0));
        match self.is_behind {
            false => Turn::Now,
            true if withheld > CYCLES_WITHHELD_MAX => Turn::Never,
            true => Turn::Later,
        }
    }

    /// Returns the cycle of the last delta that was sent; `None` before the first.
    #[must_use]
    pub fn sent(&self) -> Option<Cycle> {
        self.sent
    }

    /// Returns whether the client lagged when it was last polled.
    #[must_use]
    pub fn is_behind(&self) -> bool {
        self.is_behind
    }

    fn says_to_be_behind(&self, now: Cycle) -> bool {
        match self.word {
            Word::Nothing => false,
            Word::Late(until) => now < until,
            Word::Seen(seen) => self.is_unseen(seen),
        }
    }

    fn has_seen_all(&self, now: Cycle) -> bool {
        match self.word {
            Word::Nothing => true,
            Word::Late(until) => now >= until,
            Word::Seen(seen) => self.sent.is_none_or(|sent| seen >= sent),
        }
    }

    fn is_unseen(&self, seen: Cycle) -> bool {
        self.sent.is_some_and(|sent| sent.0.saturating_sub(seen.0) > CYCLES_UNSEEN_MAX)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TAKEN: Untaken = Untaken { deltas: 0, bytes: 0 };

    #[test]
    fn a_connection_that_takes_all_is_never_behind_however_silent_the_client() {
        let mut lag = Lag::default();
        for cycle in (0..2000).map(Cycle) {
            assert_eq!(lag.poll(cycle, Untaken { deltas: DELTAS_UNTAKEN_MAX - 1, bytes: 1000 }), Turn::Now);
            lag.handle_sent(cycle);
        }
    }

    #[test]
    fn a_connection_that_takes_nothing_waits_and_is_closed_in_the_end() {
        for full in [
            Untaken { deltas: DELTAS_UNTAKEN_MAX, bytes: 0 },
            Untaken { deltas: 1, bytes: BYTES_UNTAKEN_MAX },
        ] {
            let mut lag = Lag::default();
            lag.handle_sent(Cycle(7));
            for cycle in 8..=7 + CYCLES_WITHHELD_MAX {
                assert_eq!(lag.poll(Cycle(cycle), full), Turn::Later, "cycle {cycle}");
                // It has to take all of it, not some.
                assert_eq!(lag.poll(Cycle(cycle), Untaken { deltas: 1, bytes: 1 }), Turn::Later);
            }
            let mut alive = lag;
            assert_eq!(lag.poll(Cycle(8 + CYCLES_WITHHELD_MAX), full), Turn::Never);
            assert_eq!(alive.poll(Cycle(8 + CYCLES_WITHHELD_MAX), TAKEN), Turn::Now);
        }
    }

    #[test]
    fn who_says_of_each_delta_that_it_has_seen_it_is_taken_at_its_word() {
        let mut lag = Lag::default();
        lag.handle_done(Cycle(0));
        for cycle in (0..=17).map(Cycle) {
            assert_eq!(lag.poll(cycle, TAKEN), Turn::Now);
            lag.handle_sent(cycle);
        }
        for seen in 0..17 {
            lag.handle_done(Cycle(seen));
            assert_eq!(lag.poll(Cycle(18), TAKEN), Turn::Later, "seen {seen}");
        }
        // Commands of the same client say as much; an older word takes nothing back.
        lag.handle_commands(Cycle(18), Cycle(17));
        lag.handle_done(Cycle(3));
        assert_eq!(lag.poll(Cycle(18), TAKEN), Turn::Now);
    }

    #[test]
    fn late_commands_count_for_a_while_because_there_may_be_no_more_of_them() {
        let mut lag = Lag::default();
        lag.handle_sent(Cycle(100));
        lag.handle_commands(Cycle(100), Cycle(84));
        assert_eq!(lag.poll(Cycle(101), TAKEN), Turn::Now);
        lag.handle_commands(Cycle(101), Cycle(83));
        for cycle in 101..117 {
            assert_eq!(lag.poll(Cycle(cycle), TAKEN), Turn::Later, "cycle {cycle}");
        }
        let mut silent = lag;
        assert_eq!(silent.poll(Cycle(117), TAKEN), Turn::Now);
        lag.handle_commands(Cycle(110), Cycle(99));
        assert_eq!(lag.poll(Cycle(110), TAKEN), Turn::Now);
    }
}
