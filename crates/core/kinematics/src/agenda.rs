//! What lies ahead in a block of components, by time.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

use maniple_geometry::Scalar;

use crate::room::make_room;

/// The times of numbered items, and which comes first: a priority queue whose items can be put to another time.
///
/// What is known from the start is sorted once; only what turns up later needs a heap.
#[derive(Clone, Debug)]
pub(crate) struct Agenda<S: Scalar> {
    /// For each item when it happens; infinity if it does not.
    times: Vec<S>,
    /// What was known from the start, by time.
    known: Vec<Entry<S>>,
    /// How many of the known have come up.
    past: usize,
    /// All times that items had later; in both lists, one that is no longer so is dropped when it comes up.
    later: BinaryHeap<Reverse<Entry<S>>>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Entry<S: Scalar> {
    time: S,
    item: u32,
}

impl<S: Scalar> Entry<S> {
    /// Times are not negative, so that their bits are in their order.
    fn bits(&self) -> u64 {
        self.time.to_f64().to_bits()
    }
}

impl<S: Scalar> Eq for Entry<S> {}

impl<S: Scalar> PartialOrd for Entry<S> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl<S: Scalar> Ord for Entry<S> {
    fn cmp(&self, other: &Self) -> Ordering {
        self.bits().cmp(&other.bits()).then(self.item.cmp(&other.item))
    }
}

impl<S: Scalar> Agenda<S> {
    pub(crate) fn new() -> Self {
        Self { times: Vec::new(), known: Vec::new(), past: 0, later: BinaryHeap::new() }
    }

    /// Takes the memory for so many items.
    pub(crate) fn make_room(&mut self, items: usize) {
        make_room(&mut self.times, items);
        make_room(&mut self.known, items);
        self.later.reserve_exact(items.saturating_sub(self.later.len()));
    }

    /// Begins anew, with items that happen at some time or, at infinity, not.
    pub(crate) fn begin(&mut self, times: impl Iterator<Item = S>) {
        self.times.clear();
        self.times.extend(times);
        self.later.clear();
        self.past = 0;
        self.known.clear();
        self.known.resize(self.times.len(), Entry { time: S::INFINITY, item: 0 });
        // Who happens cannot be guessed, so all are written down, and most over again.
        let mut count = 0;
        for (item, &time) in (0u32..).zip(&self.times) {
            self.known[count] = Entry { time, item };
            count += usize::from(time < S::INFINITY);
        }
        self.known.truncate(count);
        self.known.sort_unstable_by_key(Entry::bits);
    }

    /// Takes an item off.
    #[inline]
    pub(crate) fn take_off(&mut self, item: u32) {
        self.times[item as usize] = S::INFINITY;
    }

    /// Puts an item to a time.
    #[inline]
    pub(crate) fn put(&mut self, item: u32, time: S) {
        self.times[item as usize] = time;
        self.later.push(Reverse(Entry { time, item }));
    }

    /// Takes the items that come first off, all of one time, and adds them to a list; returns that time, or `None` if
    /// nothing happens any more.
    #[inline]
    pub(crate) fn take_first(&mut self, items: &mut Vec<u32>) -> Option<S> {
        let mut first = None;
        loop {
            let known = self.known.get(self.past).copied();
            let Entry { time, item } = match (known, self.later.peek()) {
                (Some(known), Some(Reverse(later))) if later.time < known.time => *later,
                (Some(known), _) => known,
                (None, Some(Reverse(later))) => *later,
                (None, None) => return first,
            };
            if first.is_some_and(|first| first != time) {
                return first;
            }
            if known.is_some_and(|known| known.time == time) {
                self.past += 1;
            } else {
                self.later.pop();
            }
            let planned = &mut self.times[item as usize];
            if *planned == time {
                *planned = S::INFINITY;
                first = Some(time);
                items.push(item);
            }
        }
    }

    /// Bytes on the heap.
    pub(crate) fn bytes(&self) -> usize {
        size_of::<S>() * self.times.capacity()
            + size_of::<Entry<S>>() * (self.known.capacity() + self.later.capacity())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn items_come_by_time_wherever_they_were_before() {
        for count in [20u32, 200] {
            let mut agenda = Agenda::new();
            let time = |item| f64::from(item * 7 % 5);
            let known = |item| if item % 3 == 0 { f64::INFINITY } else { time(item) };
            agenda.begin((0..count).map(known));
            for item in (0..count).step_by(3) {
                agenda.put(item, time(item));
            }
            agenda.put(0, 2.5);
            agenda.take_off(1);
            let (mut order, mut taken) = (Vec::new(), Vec::new());
            while let Some(time) = agenda.take_first(&mut taken) {
                assert!(order.last().is_none_or(|&(last, _)| last < time), "{count} items");
                order.push((time, taken.len()));
                taken.clear();
            }
            let each = count as usize / 5;
            assert_eq!(
                order,
                [(0.0, each - 1), (1.0, each), (2.0, each - 1), (2.5, 1), (3.0, each), (4.0, each)]
            );
        }
    }
}
