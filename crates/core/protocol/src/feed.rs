//! One view on its way to all who get it in the same encoding: each delta is written once.

use std::collections::VecDeque;
use std::sync::Arc;

use maniple_geometry::Cycle;
use maniple_view::{Delta, Merge, Rules};

use crate::encoding::{EncodeError, Encoding, encode_server};
use crate::message::ServerMessage;
use crate::outbound::Outbound;

/// Cycles that are told in one delta: eight seconds at 8 cycles a second. Beyond it a keyframe takes hardly more, and what is merged
/// of it need not be kept.
pub const MERGED_CYCLES_MAX: usize = 64;

/// Entries of the deltas that are kept to be merged: some 4 MB a view.
pub const MERGED_ENTRIES_MAX: usize = 1 << 16;

/// Bytes that go to any number of connections.
pub type SharedBytes = Arc<[u8]>;

/// The deltas of one view in one encoding, for any number of receivers: who keeps up gets the same bytes as all others who do, who
/// lags one delta for all that it missed, and who lags by too much a keyframe.
///
/// What it keeps does not grow with the number of receivers, and neither does what it writes in a cycle: at most one merged delta for
/// each of the last [`MERGED_CYCLES_MAX`] cycles.
#[derive(Clone, Debug)]
pub struct Feed {
    /// Has written all deltas so far.
    outbound: Outbound,
    /// Has written none.
    at_the_start: Outbound,
    /// Up to which cycle all is told; `None`: nothing is.
    cycle: Option<Cycle>,
    /// The last deltas, of consecutive cycles, as far back as somebody was not told them.
    recent: VecDeque<Delta>,
    entries: usize,
    newest: Newest,
}

/// What the last deltas are as bytes, as soon as somebody needs them.
#[derive(Clone, Debug, Default)]
struct Newest {
    /// Up to which cycle was told who gets `bytes`.
    after: Option<Cycle>,
    bytes: Option<SharedBytes>,
    merge: Option<(usize, Merge)>,
    /// By the number of merged deltas.
    merged: Vec<(usize, SharedBytes)>,
    keyframe: Option<SharedBytes>,
}

impl Feed {
    /// Returns the feed of a view of which nobody was told anything yet.
    #[must_use]
    pub fn new(encoding: Encoding, rules: &Rules) -> Self {
        let at_the_start = Outbound::for_deltas(encoding, rules);
        Self {
            outbound: at_the_start.clone(),
            at_the_start,
            cycle: None,
            recent: VecDeque::new(),
            entries: 0,
            newest: Newest::default(),
        }
    }

    /// Returns the bytes of a keyframe of the present cycle, for who begins.
    ///
    /// # Errors
    /// A keyframe that is too long for a message.
    pub fn begin(&mut self, keyframe: Delta) -> Result<Vec<u8>, EncodeError> {
        let mut outbound = self.at_the_start.clone();
        let cycle = keyframe.cycle;
        let bytes = outbound.encode(&ServerMessage::Delta(keyframe))?;
        if self.cycle.is_none() {
            (self.outbound, self.cycle) = (outbound, Some(cycle));
        }
        Ok(bytes)
    }

    /// Takes the next deltas, in their order.
    ///
    /// # Errors
    /// A delta that is too long for a message; nobody can follow any more.
    pub fn push(&mut self, deltas: impl IntoIterator<Item = Delta>) -> Result<(), EncodeError> {
        self.newest = Newest { after: self.cycle, ..Newest::default() };
        let mut bytes = Vec::new();
        for delta in deltas {
            self.cycle = Some(delta.cycle);
            self.entries += delta.entries();
            let message = ServerMessage::Delta(delta);
            bytes.extend(self.outbound.encode(&message)?);
            if let ServerMessage::Delta(delta) = message {
                self.recent.push_back(delta);
            }
        }
        self.newest.bytes = Some(bytes.into());
        Ok(())
    }

    /// Returns what tells all to who was told up to cycle `told`; to whom nothing was told, and to who lags by too much, that is a
    /// keyframe, for which the deltas that are kept are handed in: what it was not told is among them.
    ///
    /// It does the least if who was told the most comes first.
    ///
    /// # Errors
    /// What is too long for a message.
    pub fn next(
        &mut self,
        told: Option<Cycle>,
        keyframe: impl FnOnce(&VecDeque<Delta>) -> Delta,
    ) -> Result<SharedBytes, EncodeError> {
        if let Some(bytes) = self.newest.bytes.as_ref().filter(|_| told == self.newest.after) {
            return Ok(Arc::clone(bytes));
        }
        let first_untold = told.map(Cycle::next);
        let place = self.recent.iter().position(|delta| Some(delta.cycle) == first_untold);
        match place {
            Some(place) => self.merged(self.recent.len() - place),
            None => self.keyframe(keyframe),
        }
    }

    /// Lets go what everybody was told up to cycle `told`, and what is beyond the limits. Returns of the latter what not everybody
    /// was told.
    pub fn forget(&mut self, told: Option<Cycle>) -> Vec<Delta> {
        let mut untold = Vec::new();
        while let Some(oldest) = self.recent.front() {
            let is_told = told.is_some_and(|told| oldest.cycle <= told);
            let is_too_much = self.recent.len() > MERGED_CYCLES_MAX || self.entries > MERGED_ENTRIES_MAX;
            if !is_told && !is_too_much {
                break;
            }
            self.entries -= oldest.entries();
            let oldest = self.recent.pop_front();
            untold.extend(oldest.filter(|_| !is_told));
        }
        untold
    }

    /// Returns up to which cycle it goes; `None`: nothing was to be told yet.
    #[must_use]
    pub fn cycle(&self) -> Option<Cycle> {
        self.cycle
    }

    /// Returns how its messages are written.
    #[must_use]
    pub fn encoding(&self) -> Encoding {
        self.outbound.encoding()
    }

    /// Returns the last `count` deltas in one.
    fn merged(&mut self, count: usize) -> Result<SharedBytes, EncodeError> {
        if let Some((_, bytes)) = self.newest.merged.iter().find(|(merged, _)| *merged == count) {
            return Ok(Arc::clone(bytes));
        }
        let mut earlier = self.recent.iter().rev();
        let (mut merged, mut merge) = match self.newest.merge.take().filter(|(merged, _)| *merged <= count) {
            Some((merged, merge)) => {
                earlier.by_ref().take(merged).for_each(drop);
                (merged, merge)
            }
            None => (1, Merge::new(earlier.next().expect("at least one delta is merged"))),
        };
        for delta in earlier.take(count - merged) {
            merge.precede(delta);
            merged += 1;
        }
        let bytes: SharedBytes = self.outbound.encode_merged(merge.delta())?.into();
        self.newest.merge = Some((merged, merge));
        self.newest.merged.push((count, Arc::clone(&bytes)));
        Ok(bytes)
    }

    fn keyframe(
        &mut self,
        keyframe: impl FnOnce(&VecDeque<Delta>) -> Delta,
    ) -> Result<SharedBytes, EncodeError> {
        if let Some(bytes) = &self.newest.keyframe {
            return Ok(Arc::clone(bytes));
        }
        let mut bytes = encode_server(self.encoding(), &ServerMessage::Keyframe {})?;
        bytes.extend(self.at_the_start.clone().encode(&ServerMessage::Delta(keyframe(&self.recent)))?);
        let bytes: SharedBytes = bytes.into();
        self.newest.keyframe = Some(Arc::clone(&bytes));
        Ok(bytes)
    }
}

#[cfg(test)]
mod tests {
    use maniple_view::{Handle, Shot};

    use super::*;
    use crate::arbitrary::Random;

    #[test]
    fn what_is_kept_has_an_end_and_what_is_let_go_is_handed_back() {
        for (shots, kept) in
            [(0, MERGED_CYCLES_MAX), (MERGED_ENTRIES_MAX / 8, 7), (MERGED_ENTRIES_MAX + 1, 0)]
        {
            let mut feed = Feed::new(Encoding::Json, &Random::new(1).welcome().rules);
            let shots = vec![Shot { object: Handle(1), target: None }; shots];
            let mut handed_back = Vec::new();
            let cycles = 2 * u32::try_from(MERGED_CYCLES_MAX).unwrap();
            for cycle in (1..=cycles).map(Cycle) {
                feed.push([Delta { cycle, shots: shots.clone(), ..Delta::default() }]).unwrap();
                handed_back.extend(feed.forget(None).iter().map(|delta| delta.cycle.0));
                assert!(feed.recent.len() <= kept && feed.entries <= MERGED_ENTRIES_MAX, "{cycle}");
            }
            let gone = cycles - u32::try_from(kept).unwrap();
            assert_eq!(handed_back, (1..=gone).collect::<Vec<u32>>());
            assert_eq!(feed.forget(Some(Cycle(cycles))), [], "everybody was told");
            assert_eq!((feed.recent.len(), feed.entries), (0, 0));
        }
    }
}
