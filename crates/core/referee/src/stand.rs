//! What spectators see: views that stand some cycles back.

use std::collections::VecDeque;

use maniple_geometry::Cycle;
use maniple_view::{Delta, MismatchError, Vantage, View};
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Most entries of the deltas that are held back in a match, over all its views: 4 million of 60 bytes, seldom of up to
/// 150. Players decide how much happens, and shall not decide how much memory that takes. 400 units that all get an order
/// in every one of 240 cycles come to 300,000 in three views.
pub const HELD_ENTRIES_MAX: usize = 1 << 22;

/// Why a view cannot be watched.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum WatchError {
    /// The scenario lets nobody watch.
    #[error("the scenario lets nobody watch; it would need a table [spectators]")]
    NotPermitted,
    /// The scenario lets nobody watch everything.
    #[error("the scenario permits to watch seats only; watch one of them")]
    SeatsOnly,
    /// A seat that the match does not have.
    #[error("there is no such seat; watch one of 0 to {}", .seats.saturating_sub(1))]
    NoSuchSeat {
        /// How many seats there are.
        seats: u16,
    },
    /// More has happened than can be held back. The match goes on without spectators.
    #[error("more than {HELD_ENTRIES_MAX} changes would be held back; watch the replay of the match")]
    TooMuch,
}

/// A view that spectators watch: the deltas of a player, or of who sees everything, some cycles later.
///
/// Whatever is asked of it is from then: it says nothing of what is held back.
#[derive(Debug)]
pub struct Stand {
    vantage: Vantage,
    delay: usize,
    /// As it was `delay` cycles ago.
    view: View,
    has_begun: bool,
    held: VecDeque<Delta>,
    shown: Vec<Delta>,
}

impl Stand {
    fn new(vantage: Vantage, delay: u32, view: View) -> Self {
        let delay = usize::try_from(delay).unwrap_or(usize::MAX);
        Self { vantage, delay, view, has_begun: false, held: VecDeque::new(), shown: Vec::new() }
    }

    /// Takes what the players are told now, and shows what they were told `delay` cycles before. Returns the entries that
    /// are held more, and those that are held no more.
    fn push(&mut self, delta: Delta) -> (usize, usize) {
        self.shown.clear();
        let more = delta.entries();
        self.held.push_back(delta);
        let less = if self.held.len() > self.delay { self.show_next() } else { 0 };
        (more, less)
    }

    /// Shows all that is held.
    fn release(&mut self) {
        while !self.held.is_empty() {
            self.show_next();
        }
    }

    /// Shows the oldest delta that is held, and returns its entries.
    fn show_next(&mut self) -> usize {
        let Some(delta) = self.held.pop_front() else { return 0 };
        let applied = self.view.apply(&delta);
        assert_eq!(applied, Ok(()), "what is held back fits the view that stands back");
        self.has_begun = true;
        let entries = delta.entries();
        self.shown.push(delta);
        entries
    }

    /// Returns the deltas that spectators get after the last step, in their order: none as long as the match is younger than
    /// the delay, then one, and at the end of the match all that was held back.
    #[must_use]
    pub fn shown(&self) -> &[Delta] {
        &self.shown
    }

    /// Returns the delta that turns the view at the start into the one that spectators have now; `None` as long as the match is
    /// younger than the delay: the first delta that is shown will be one.
    #[must_use]
    pub fn keyframe(&self) -> Option<Delta> {
        self.has_begun.then(|| self.view.keyframe())
    }

    /// Returns the view that spectators have now; before the first delta it is empty.
    #[must_use]
    pub fn view(&self) -> &View {
        &self.view
    }

    /// Returns the cycle of that view; 0 too before the first delta.
    #[must_use]
    pub fn cycle(&self) -> Cycle {
        self.view.cycle()
    }

    /// Returns whether there is a view already.
    #[must_use]
    pub fn has_begun(&self) -> bool {
        self.has_begun
    }

    /// Returns by how many cycles it stands back.
    #[must_use]
    pub fn delay(&self) -> u32 {
        u32::try_from(self.delay).unwrap_or(u32::MAX)
    }
}

/// What a stand holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct StandSnapshot {
    pub(crate) vantage: Vantage,
    delay: u32,
    has_begun: bool,
    /// What turns the view at the start into the one that stands back.
    view: Delta,
    held: Vec<Delta>,
}

/// All stands of a match.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct StandsSnapshot {
    pub(crate) stands: Vec<StandSnapshot>,
    pub(crate) is_too_much: bool,
}

/// All stands of a match.
#[derive(Debug, Default)]
pub(crate) struct Stands {
    stands: Vec<Stand>,
    /// Entries that are held.
    held: usize,
    is_too_much: bool,
}

impl Stands {
    /// Returns what all stands hold; what they show has been told.
    pub(crate) fn snapshot(&self) -> StandsSnapshot {
        let stand = |stand: &Stand| StandSnapshot {
            vantage: stand.vantage,
            delay: stand.delay(),
            has_begun: stand.has_begun,
            view: stand.view.keyframe(),
            held: stand.held.iter().cloned().collect(),
        };
        StandsSnapshot { stands: self.stands.iter().map(stand).collect(), is_too_much: self.is_too_much }
    }

    /// Puts a stand of a snapshot in; `start` is the view at the start, `now` the one that is not held back.
    ///
    /// # Errors
    /// A view, or a delta that is held back, which does not fit what is before it; `Ok(false)`: all of them do not lead to what
    /// is seen now.
    pub(crate) fn put_back(
        &mut self,
        saved: &StandSnapshot,
        start: View,
        now: &View,
    ) -> Result<bool, MismatchError> {
        let StandSnapshot { vantage, delay, has_begun, view, held } = saved;
        let mut stand = Stand::new(*vantage, *delay, start);
        stand.view.apply(view)?;
        stand.has_begun = *has_begun;
        // What is held back is shown one day, and has to fit then.
        let mut shown = stand.view.clone();
        for delta in held {
            shown.apply(delta)?;
            self.held += delta.entries();
        }
        stand.held.extend(held.iter().cloned());
        self.stands.push(stand);
        Ok(shown == *now)
    }

    /// Returns stands that hold nothing.
    pub(crate) fn closed(is_too_much: bool) -> Self {
        Self { is_too_much, ..Self::default() }
    }

    /// Adds a stand of which `first` is the keyframe of cycle 0; `view` is that at the start.
    pub(crate) fn open(&mut self, vantage: Vantage, delay: u32, view: View, first: Delta) {
        self.stands.retain(|stand| stand.vantage != vantage);
        self.stands.push(Stand::new(vantage, delay, view));
        self.push(vantage, || first);
    }

    /// Takes what is told of the present cycle; `delta` is only called where there is a stand for it.
    pub(crate) fn push(&mut self, vantage: Vantage, delta: impl FnOnce() -> Delta) {
        let Some(stand) = self.stands.iter_mut().find(|stand| stand.vantage == vantage) else { return };
        let (more, less) = stand.push(delta());
        self.held = self.held + more - less;
        if self.held > HELD_ENTRIES_MAX {
            self.is_too_much = true;
            self.held = 0;
            self.stands.clear();
        }
    }

    /// Shows all that is held back.
    pub(crate) fn release(&mut self) {
        for stand in &mut self.stands {
            stand.release();
        }
        self.held = 0;
    }

    /// Returns the stand of a view, in a match of so many seats.
    pub(crate) fn stand(&self, vantage: Vantage, seats: usize) -> Result<&Stand, WatchError> {
        if self.is_too_much {
            return Err(WatchError::TooMuch);
        }
        if self.stands.is_empty() {
            return Err(WatchError::NotPermitted);
        }
        if vantage.seat().is_some_and(|seat| seat.index() >= seats) {
            return Err(WatchError::NoSuchSeat { seats: u16::try_from(seats).unwrap_or(u16::MAX) });
        }
        self.stands.iter().find(|stand| stand.vantage == vantage).ok_or(WatchError::SeatsOnly)
    }
}

#[cfg(test)]
mod tests {
    use maniple_view::Seat;

    use super::*;

    const VANTAGE: Vantage = Vantage::Seat(Seat(0));

    #[test]
    fn what_is_shown_is_as_old_as_the_delay_and_at_the_end_all_is_shown() {
        for delay in [0, 1, 5] {
            let mut stands = stands(delay);
            for cycle in 1..20 {
                stands.push(VANTAGE, || empty(cycle));
                let stand = stands.stand(VANTAGE, 1).unwrap();
                let shown: Vec<u32> = stand.shown().iter().map(|delta| delta.cycle.0).collect();
                let expected: Vec<u32> = cycle.checked_sub(delay).into_iter().collect();
                assert_eq!(shown, expected, "delay {delay}, cycle {cycle}");
                assert_eq!(stand.cycle().0, cycle.saturating_sub(delay));
                assert_eq!(stand.keyframe().is_some(), cycle >= delay);
            }
            stands.release();
            let stand = stands.stand(VANTAGE, 1).unwrap();
            let shown: Vec<u32> = stand.shown().iter().map(|delta| delta.cycle.0).collect();
            assert_eq!(shown, (19 - delay..20).collect::<Vec<u32>>());
        }
    }

    #[test]
    fn more_than_can_be_held_closes_the_stands_for_good() {
        let mut stands = stands(3);
        let mut many = empty(1);
        many.walls = vec![(0.0, 0.0, 1.0, 0.0); HELD_ENTRIES_MAX];
        stands.push(VANTAGE, || many);
        for _ in 0..2 {
            assert_eq!(stands.stand(VANTAGE, 1).err(), Some(WatchError::TooMuch));
            stands.push(VANTAGE, || panic!("nothing is held any more"));
        }
    }

    #[test]
    fn what_is_shown_is_held_no_more() {
        let mut stands = stands(3);
        for cycle in 1..50 {
            stands.push(VANTAGE, || empty(cycle));
        }
        assert_eq!(stands.held, 3 * empty(0).entries());
    }

    fn stands(delay: u32) -> Stands {
        let mut stands = Stands::default();
        stands.open(VANTAGE, delay, View::default(), empty(0));
        stands
    }

    fn empty(cycle: u32) -> Delta {
        let mut view = View::default();
        let mut delta = Delta { cycle: Cycle(cycle), ..Delta::default() };
        // The first time only to learn the hash of an empty view of this cycle.
        let _ = view.apply(&delta);
        delta.check = view.check();
        delta
    }
}
