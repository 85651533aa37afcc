//! When the clock stands still because all want it to, or whoever runs the match does.

use maniple_view::Seat;
use serde::{Deserialize, Serialize};

/// How often a seat may ask for a pause in a match. Everybody is told of each change, so without a limit whoever asked
/// and withdrew on and on could fill the queues of all others; 3 times, and 3 withdrawals, of 64 seats are fewer messages
/// than may wait for one connection of the server.
pub const PAUSES_MAX: u32 = 3;

/// Who wants a pause, and whether there is one.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Paused {
    /// The seats that want it, in their order; once there is one, those that had asked for it.
    pub seats: Vec<Seat>,
    /// Whether the clock stands still.
    pub on: bool,
}

/// The agreement on a pause. Who counts is an argument: the seats that are in and where a player is.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Agreement {
    /// Who wants a pause, by seat.
    wishes: Vec<bool>,
    /// How often each has asked.
    asked: Vec<u32>,
    /// Whether all agreed, and none has ended it since.
    is_on: bool,
    /// Whether whoever runs the match wants it, whatever the seats do.
    is_halted: bool,
    /// What everybody was told last.
    told: Paused,
}

impl Agreement {
    /// Returns that nobody wants a pause.
    pub(crate) fn new(seats: usize) -> Self {
        Self {
            wishes: vec![false; seats],
            asked: vec![0; seats],
            is_on: false,
            is_halted: false,
            told: Paused { seats: Vec::new(), on: false },
        }
    }

    /// Takes that a seat wants a pause. Has no effect if it does already, there is one, or it has asked too often.
    pub(crate) fn handle_wish(&mut self, seat: Seat) {
        let index = seat.index();
        if self.is_on || self.wishes[index] || self.asked[index] >= PAUSES_MAX {
            return;
        }
        self.asked[index] += 1;
        self.wishes[index] = true;
    }

    /// Takes that a seat wants no pause: ends it for all, or else withdraws the seat's own wish.
    pub(crate) fn handle_no_wish(&mut self, seat: Seat) {
        if self.is_on {
            self.end();
        } else {
            self.wishes[seat.index()] = false;
        }
    }

    /// Looks whether all who count agree now. Outside of a pause the wish of who does not count is forgotten; a pause
    /// ends when nobody is left who counts, for nobody could end it any more.
    pub(crate) fn review(&mut self, counts: impl Fn(Seat) -> bool) {
        let counting = (0..).map(Seat).zip(&mut self.wishes).map(|(seat, wish)| (counts(seat), wish));
        let (mut some, mut all) = (false, true);
        for (counts, wish) in counting {
            if counts {
                some = true;
                all &= *wish;
            } else if !self.is_on {
                *wish = false;
            }
        }
        if self.is_on && !some {
            self.end();
        } else if some && all {
            self.is_on = true;
        }
    }

    /// Takes whether whoever runs the match wants a pause.
    pub(crate) fn handle_halt(&mut self, is_halted: bool) {
        self.is_halted = is_halted;
    }

    /// Returns whether it is one of so many seats.
    pub(crate) fn is_of(&self, seats: usize) -> bool {
        self.wishes.len() == seats && self.asked.len() == seats
    }

    pub(crate) fn is_on(&self) -> bool {
        self.is_on || self.is_halted
    }

    /// Returns how it stands.
    pub(crate) fn state(&self) -> Paused {
        let seats = (0..).map(Seat).zip(&self.wishes).filter(|(_, wish)| **wish).map(|(seat, _)| seat);
        Paused { seats: seats.collect(), on: self.is_on() }
    }

    /// Returns how it stands, if that has changed since the last call.
    pub(crate) fn take_change(&mut self) -> Option<Paused> {
        let state = self.state();
        (state != self.told).then(|| {
            self.told.clone_from(&state);
            state
        })
    }

    fn end(&mut self) {
        self.is_on = false;
        self.wishes.fill(false);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const A: Seat = Seat(0);
    const B: Seat = Seat(1);

    #[test]
    fn a_pause_begins_when_all_who_count_want_it_and_ends_when_one_does_not() {
        let mut agreement = Agreement::new(3);
        let counts = |seat: Seat| seat != Seat(2);
        let mut check = |act: &dyn Fn(&mut Agreement), seats: &[Seat], on: bool| {
            act(&mut agreement);
            agreement.review(counts);
            assert_eq!(agreement.state(), Paused { seats: seats.to_vec(), on });
        };
        check(&|agreement| agreement.handle_wish(A), &[A], false);
        check(&|agreement| agreement.handle_no_wish(A), &[], false);
        check(&|agreement| agreement.handle_no_wish(A), &[], false);
        check(&|agreement| agreement.handle_wish(Seat(2)), &[], false);
        check(&|agreement| agreement.handle_wish(B), &[B], false);
        check(&|agreement| agreement.handle_wish(A), &[A, B], true);
        check(&|agreement| agreement.handle_wish(A), &[A, B], true);
        check(&|agreement| agreement.handle_no_wish(B), &[], false);
    }

    #[test]
    fn whoever_leaves_does_not_end_a_pause_unless_nobody_is_left() {
        let mut agreement = Agreement::new(2);
        agreement.handle_wish(A);
        agreement.review(|_| true);
        assert!(!agreement.is_on());
        agreement.review(|seat| seat == A);
        assert!(agreement.is_on(), "all who are there want it");
        agreement.review(|_| true);
        assert!(agreement.is_on(), "who comes back finds it");
        agreement.review(|seat| seat == B);
        assert_eq!(agreement.state(), Paused { seats: vec![A], on: true });
        agreement.review(|_| false);
        assert_eq!(agreement.state(), Paused { seats: vec![], on: false });
    }

    #[test]
    fn no_seat_ends_what_whoever_runs_the_match_wants() {
        let mut agreement = Agreement::new(2);
        agreement.handle_halt(true);
        for seat in [A, B] {
            agreement.handle_no_wish(seat);
        }
        agreement.review(|_| false);
        assert_eq!(agreement.state(), Paused { seats: vec![], on: true });
        // A wish that was there before is there after it.
        agreement.handle_wish(A);
        agreement.review(|_| true);
        agreement.handle_halt(false);
        assert_eq!(agreement.state(), Paused { seats: vec![A], on: false });
    }

    #[test]
    fn a_change_is_told_once_and_there_is_an_end_to_asking() {
        let mut agreement = Agreement::new(2);
        assert_eq!(agreement.take_change(), None);
        let mut told = 0;
        for _ in 0..3 * PAUSES_MAX {
            agreement.handle_wish(A);
            told += u32::from(agreement.take_change().is_some());
            assert_eq!(agreement.take_change(), None);
            agreement.handle_no_wish(A);
            told += u32::from(agreement.take_change().is_some());
        }
        assert_eq!(told, 2 * PAUSES_MAX);
        agreement.handle_wish(B);
        assert_eq!(agreement.take_change(), Some(Paused { seats: vec![B], on: false }));
    }
}
