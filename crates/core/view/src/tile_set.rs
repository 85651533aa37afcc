//! Sets of tiles.

use maniple_tilemap::SIZE_MAX;

/// Bits of a word.
const WORD: u32 = u64::BITS;

/// A set of the tiles of a map, which are numbered row by row from the upper left: tile (x, y) is number `y * width + x`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TileSet {
    width: u32,
    height: u32,
    words: Vec<u64>,
}

impl TileSet {
    /// Returns the empty set of a map of so many tiles, at most [`SIZE_MAX`] each way: what lies beyond is in no set.
    #[must_use]
    pub fn new(width: u32, height: u32) -> Self {
        let (width, height) = (width.min(SIZE_MAX), height.min(SIZE_MAX));
        Self { width, height, words: vec![0; (width * height).div_ceil(WORD) as usize] }
    }

    /// Takes all tiles out.
    pub fn clear(&mut self) {
        self.words.fill(0);
    }

    /// Puts `count` tiles in, from number `first` on.
    ///
    /// # Panics
    /// Beyond the last tile.
    pub fn insert_run(&mut self, first: u32, count: u32) {
        self.change_run(first, count, |word, mask| word | mask);
    }

    /// Puts the tiles in that are not there, and takes out those that are: `count` tiles, from number `first` on.
    ///
    /// # Panics
    /// Beyond the last tile.
    pub fn toggle_run(&mut self, first: u32, count: u32) {
        self.change_run(first, count, |word, mask| word ^ mask);
    }

    fn change_run(&mut self, first: u32, count: u32, change: impl Fn(u64, u64) -> u64) {
        assert!(u64::from(first) + u64::from(count) <= u64::from(self.area()), "beyond the last tile");
        let (mut at, end) = (first, first + count);
        while at < end {
            let bit = at % WORD;
            let bits = (WORD - bit).min(end - at);
            let word = &mut self.words[(at / WORD) as usize];
            *word = change(*word, (u64::MAX >> (WORD - bits)) << bit);
            at += bits;
        }
    }

    /// Calls `each` with first number and count of every longest run of tiles that are in one of two sets of the same map and
    /// not in the other, in ascending order.
    ///
    /// # Panics
    /// If the maps have different sizes.
    pub fn differences(&self, other: &Self, each: impl FnMut(u32, u32)) {
        self.runs(other, |one, other| one ^ other, each);
    }

    /// Calls `each` with first number and count of every longest run of tiles that are in this set and not in `other`, in
    /// ascending order.
    ///
    /// # Panics
    /// If the maps have different sizes.
    pub fn runs_without(&self, other: &Self, each: impl FnMut(u32, u32)) {
        self.runs(other, |one, other| one & !other, each);
    }

    /// Returns first number and count of every longest run of tiles in the set, in ascending order.
    #[must_use]
    pub fn to_runs(&self) -> Vec<(u32, u32)> {
        let mut runs = Vec::new();
        self.runs_without(&Self::new(self.width, self.height), |first, count| runs.push((first, count)));
        runs
    }

    /// Puts the tiles of runs of first number and count in; `None`, and some may be in, where one goes beyond the last tile.
    #[must_use]
    pub fn insert_runs(&mut self, runs: &[(u32, u32)]) -> Option<()> {
        for &(first, count) in runs {
            first.checked_add(count).filter(|&end| end <= self.area())?;
            self.insert_run(first, count);
        }
        Some(())
    }

    fn runs(&self, other: &Self, of: impl Fn(u64, u64) -> u64, mut each: impl FnMut(u32, u32)) {
        assert_eq!((self.width, self.height), (other.width, other.height), "sets of different maps");
        let (mut first, mut count) = (0, 0);
        for (start, (&one, &other)) in (0..).step_by(WORD as usize).zip(self.words.iter().zip(&other.words)) {
            let (mut word, mut at) = (of(one, other), start);
            while word != 0 {
                let skip = word.trailing_zeros();
                let ones = (word >> skip).trailing_ones();
                at += skip;
                if count > 0 && first + count < at {
                    each(first, count);
                    count = 0;
                }
                if count == 0 {
                    first = at;
                }
                count += ones;
                at += ones;
                // In two steps: a shift by all the bits of a word is none.
                word = word >> skip >> (ones - 1) >> 1;
            }
        }
        if count > 0 {
            each(first, count);
        }
    }

    /// Returns whether a tile is in the set; outside of the map none is.
    #[must_use]
    pub fn contains(&self, x: u32, y: u32) -> bool {
        x < self.width && y < self.height && self.has(y * self.width + x)
    }

    /// Returns whether the tile of this number is in the set.
    fn has(&self, number: u32) -> bool {
        self.words[(number / WORD) as usize] >> (number % WORD) & 1 == 1
    }

    /// Returns the tiles to the right, at most [`SIZE_MAX`].
    #[must_use]
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Returns how many tiles the map has.
    #[must_use]
    pub fn area(&self) -> u32 {
        self.width * self.height
    }

    /// Returns how many tiles are in the set.
    #[must_use]
    pub fn count(&self) -> u32 {
        self.words.iter().map(|word| word.count_ones()).sum()
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn a_set_of_bits_does_what_a_set_of_numbers_does() {
        for seed in 0..40u64 {
            let mut state = seed;
            let mut number = |below: u32| {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                u32::try_from(state >> 33).unwrap() % below
            };
            let (width, height) = (1 + number(40), 1 + number(12));
            let area = width * height;
            let mut sets = [TileSet::new(width, height), TileSet::new(width, height)];
            let mut twins = [BTreeSet::new(), BTreeSet::new()];
            for _ in 0..30 {
                let first = number(area + 1);
                let count = number(area + 1 - first + 1).min(area - first);
                let which = number(2) as usize;
                if number(2) == 0 {
                    sets[which].insert_run(first, count);
                    twins[which].extend(first..first + count);
                } else {
                    sets[which].toggle_run(first, count);
                    for tile in first..first + count {
                        if !twins[which].remove(&tile) {
                            twins[which].insert(tile);
                        }
                    }
                }
                let [one, other] = &sets;
                let (mut differ, mut without) = (Vec::new(), Vec::new());
                one.differences(other, |first, count| differ.push((first, count)));
                one.runs_without(other, |first, count| without.push((first, count)));
                let symmetric = twins[0].symmetric_difference(&twins[1]).copied();
                assert_eq!(differ, runs(symmetric), "seed {seed}");
                assert_eq!(without, runs(twins[0].difference(&twins[1]).copied()), "seed {seed}");
                assert_eq!(one.count() as usize, twins[0].len(), "seed {seed}");
                for y in 0..=height {
                    for x in 0..=width {
                        let is_in = x < width && y < height && twins[0].contains(&(y * width + x));
                        assert_eq!(one.contains(x, y), is_in, "seed {seed}");
                    }
                }
            }
            sets[0].clear();
            assert_eq!(sets[0], TileSet::new(width, height));
        }
    }

    fn runs(tiles: impl Iterator<Item = u32>) -> Vec<(u32, u32)> {
        let mut runs: Vec<(u32, u32)> = Vec::new();
        for tile in tiles {
            match runs.last_mut() {
                Some((first, count)) if *first + *count == tile => *count += 1,
                _ => runs.push((tile, 1)),
            }
        }
        runs
    }
}
