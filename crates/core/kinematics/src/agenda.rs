//! What lies ahead in a component, by time.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

use maniple_geometry::Scalar;

use crate::room::make_room;

/// The times of numbered items, and which comes first: a priority queue whose items can be put to another time.
#[derive(Clone, Debug)]
pub(crate) struct Agenda<S: Scalar> {
    /// For each item when it happens; infinity if it does not.
    times: Vec<S>,
    /// All times that items had; one that is no longer so is dropped when it comes up.
    heap: BinaryHeap<Reverse<Entry<S>>>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Entry<S: Scalar> {
    time: S,
    item: u32,
}

impl<S: Scalar> Eq for Entry<S> {}

impl<S: Scalar> PartialOrd for Entry<S> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl<S: Scalar> Ord for Entry<S> {
    fn cmp(&self, other: &Self) -> Ordering {
        let by_time = self.time.partial_cmp(&other.time).expect("times are numbers");
        by_time.then(self.item.cmp(&other.item))
    }
}

impl<S: Scalar> Agenda<S> {
    pub(crate) fn new() -> Self {
        Self { times: Vec::new(), heap: BinaryHeap::new() }
    }

    /// Takes the memory for so many items.
    pub(crate) fn make_room(&mut self, items: usize) {
        make_room(&mut self.times, items);
        self.heap.reserve_exact(items.saturating_sub(self.heap.len()));
    }

    /// Begins anew, with so many items, none of which happens.
    pub(crate) fn begin(&mut self, items: usize) {
        self.times.clear();
        self.times.resize(items, S::INFINITY);
        self.heap.clear();
    }

    /// Puts an item to a time, or takes it off.
    #[inline]
    pub(crate) fn set(&mut self, item: u32, time: Option<S>) {
        self.times[item as usize] = time.unwrap_or(S::INFINITY);
        if let Some(time) = time {
            self.heap.push(Reverse(Entry { time, item }));
        }
    }

    /// Takes the items that come first off, all of one time, and adds them to a list; returns that time, or `None` if
    /// nothing happens any more.
    pub(crate) fn take_first(&mut self, items: &mut Vec<u32>) -> Option<S> {
        let mut first = None;
        while let Some(&Reverse(Entry { time, item })) = self.heap.peek() {
            if first.is_some_and(|first| first != time) {
                break;
            }
            self.heap.pop();
            let planned = &mut self.times[item as usize];
            if *planned == time {
                *planned = S::INFINITY;
                first = Some(time);
                items.push(item);
            }
        }
        first
    }

    /// Bytes on the heap.
    pub(crate) fn bytes(&self) -> usize {
        size_of::<S>() * self.times.capacity() + size_of::<Entry<S>>() * self.heap.capacity()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn items_come_by_time_wherever_they_were_before() {
        for count in [20u32, 200] {
            let mut agenda = Agenda::new();
            agenda.begin(count as usize);
            for item in 0..count {
                agenda.set(item, Some(f64::from(item * 7 % 5)));
            }
            agenda.set(0, Some(2.5));
            agenda.set(1, None);
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
