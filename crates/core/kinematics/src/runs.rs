//! Many short lists that grow and shrink, the items of each one behind the other.

/// The place and the length of a list. Its room is the next power of two.
#[derive(Clone, Copy, Debug, Default)]
struct Run {
    first: u32,
    length: u32,
}

impl Run {
    fn room(self) -> usize {
        if self.length == 0 { 0 } else { self.length.next_power_of_two() as usize }
    }

    fn range(self) -> std::ops::Range<usize> {
        self.first as usize..self.first as usize + self.length as usize
    }
}

/// Numbered lists of items in one memory: to read one asks the memory twice, however long it is. A list moves when it
/// outgrows its room or needs but half of it, so that a change costs little whatever the other lists are.
#[derive(Clone, Debug)]
pub(crate) struct Runs<T> {
    runs: Vec<Run>,
    items: Vec<T>,
    /// For each power of two where there is unused room of that size.
    free: Vec<Vec<u32>>,
}

impl<T: Copy> Runs<T> {
    /// Returns so many empty lists.
    pub(crate) fn new(lists: usize) -> Self {
        Self { runs: vec![Run::default(); lists], items: Vec::new(), free: Vec::new() }
    }

    /// Returns a list.
    #[inline]
    pub(crate) fn list(&self, list: usize) -> &[T] {
        &self.items[self.runs[list].range()]
    }

    /// Adds an item to a list.
    pub(crate) fn push(&mut self, list: usize, item: T) {
        self.resize(list, self.runs[list].length + 1, item);
        let last = self.runs[list].range().end - 1;
        self.items[last] = item;
    }

    /// Takes the first item for which something holds out of a list; the last one takes its place. Returns whether there is
    /// one.
    pub(crate) fn remove(&mut self, list: usize, is_it: impl Fn(&T) -> bool) -> bool {
        let range = self.runs[list].range();
        let Some(place) = self.items[range.clone()].iter().position(is_it) else { return false };
        let last = self.items[range.end - 1];
        self.items[range.start + place] = last;
        self.resize(list, self.runs[list].length - 1, last);
        true
    }

    /// Gives a list another length, and room for it; `filler` fills room that was never used before.
    fn resize(&mut self, list: usize, length: u32, filler: T) {
        let before = self.runs[list];
        let mut run = Run { first: before.first, length };
        if run.room() != before.room() {
            run.first = self.take(run.room(), filler);
            let kept = before.length.min(length) as usize;
            let from = before.first as usize;
            self.items.copy_within(from..from + kept, run.first as usize);
            self.give_back(before);
        }
        self.runs[list] = run;
    }

    fn take(&mut self, room: usize, filler: T) -> u32 {
        if room == 0 {
            return 0;
        }
        let unused = self.free.get_mut(room.trailing_zeros() as usize).and_then(Vec::pop);
        unused.unwrap_or_else(|| {
            let first = u32::try_from(self.items.len()).expect("items are numbered with 32 bits");
            self.items.resize(self.items.len() + room, filler);
            first
        })
    }

    fn give_back(&mut self, run: Run) {
        if run.room() == 0 {
            return;
        }
        let size = run.room().trailing_zeros() as usize;
        if self.free.len() <= size {
            self.free.resize_with(size + 1, Vec::new);
        }
        self.free[size].push(run.first);
    }

    /// Bytes on the heap.
    pub(crate) fn bytes(&self) -> usize {
        let free: usize = self.free.iter().map(Vec::capacity).sum();
        size_of::<Run>() * self.runs.capacity()
            + size_of::<T>() * self.items.capacity()
            + size_of::<u32>() * free
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_hold_what_was_put_in_and_not_taken_out() {
        let mut state = 7u32;
        let mut random = |below: u32| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) % below
        };
        let mut runs = Runs::new(5);
        let mut plain = vec![Vec::new(); 5];
        for step in 0..5000u32 {
            let list = random(5) as usize;
            // Now more are put in, now more are taken out.
            if random(100) < if step / 500 % 2 == 0 { 60 } else { 40 } {
                runs.push(list, step);
                plain[list].push(step);
            } else {
                let item = plain[list].get(random(50) as usize).copied().unwrap_or(u32::MAX);
                let found = plain[list].iter().position(|&held| held == item);
                assert_eq!(runs.remove(list, |&held| held == item), found.is_some(), "step {step}");
                if let Some(place) = found {
                    plain[list].swap_remove(place);
                }
            }
            assert_eq!(runs.list(list), plain[list], "step {step}");
        }
        assert!(runs.items.len() < 5 * 512, "room is used again, but there are {}", runs.items.len());
    }
}
