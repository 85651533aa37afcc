//! Which nodes of the lattice are free, as bits in rows, so that one look sees 64 of them.

/// Rows of bits; one that is set is free. Around them lies a border that is not.
#[derive(Clone, Debug)]
pub(crate) struct Bits {
    words_a_row: usize,
    words: Vec<u64>,
}

impl Bits {
    /// Returns `rows` rows of `length` bits, none of them free.
    pub(crate) fn new(rows: u32, length: u32) -> Self {
        let words_a_row = (length as usize + 2).div_ceil(64);
        Self { words_a_row, words: vec![0; words_a_row * (rows as usize + 2)] }
    }

    pub(crate) fn set_free(&mut self, row: u32, place: u32) {
        let bit = place as usize + 1;
        self.words[(row as usize + 1) * self.words_a_row + bit / 64] |= 1 << (bit % 64);
    }

    /// Returns whether a bit is free; the ones just outside may be asked for, too.
    pub(crate) fn is_free(&self, row: i32, place: i32) -> bool {
        let (row, bit) = ((row + 1).cast_unsigned() as usize, (place + 1).cast_unsigned() as usize);
        self.words[row * self.words_a_row + bit / 64] >> (bit % 64) & 1 == 1
    }

    /// Returns in the three lowest bits which of a place, the one before it and the one behind it are free, the one before it lowest.
    pub(crate) fn around(&self, row: i32, place: i32) -> u64 {
        let (row, bit) = ((row + 1).cast_unsigned() as usize, place.cast_unsigned() as usize);
        let (word, shift) = (row * self.words_a_row + bit / 64, bit % 64);
        let next = if shift > 61 { self.words[word + 1] << (64 - shift) } else { 0 };
        (self.words[word] >> shift | next) & 0b111
    }

    /// Returns the first place behind `place` in the row at which a straight run has to be looked at: the goal, or a place
    /// beside which a bit is free while the one before it is not. `None` where the run ends before.
    pub(crate) fn jump(&self, row: u32, place: u32, goal: Option<u32>) -> Option<u32> {
        let first = row as usize * self.words_a_row;
        let [above, own, below] = [0, 1, 2]
            .map(|line| &self.words[first + line * self.words_a_row..first + (line + 1) * self.words_a_row]);
        let next = place as usize + 2;
        let goal = goal.map_or(usize::MAX, |goal| goal as usize + 1);
        let mut word = next / 64;
        let mut mask = u64::MAX << (next % 64);
        loop {
            let opens = |side: &[u64]| {
                let before = if word == 0 { 0 } else { side[word - 1] >> 63 };
                side[word] & !(side[word] << 1 | before)
            };
            let blocked = !own[word];
            let goal = if goal / 64 == word { 1 << (goal % 64) } else { 0 };
            let stops = (blocked | opens(above) | opens(below) | goal) & mask;
            if stops != 0 {
                let bit = stops.trailing_zeros();
                let is_blocked = blocked >> bit & 1 == 1;
                return (!is_blocked).then(|| u32::try_from(word * 64).expect("rows are short") + bit - 1);
            }
            word += 1;
            mask = u64::MAX;
        }
    }
}
