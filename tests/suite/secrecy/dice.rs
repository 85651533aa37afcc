//! Random choices of a generated scene.

/// A stream of numbers that follows from a seed (`SplitMix64`; Steele, Lea and Flood, 2014).
#[derive(Clone)]
pub(super) struct Dice(u64);

impl Dice {
    /// Returns the stream with this number of the scene with this seed.
    pub(super) fn new(seed: u64, stream: u64) -> Self {
        let mut dice = Self(seed.wrapping_mul(0xd134_2543_de82_ef95).wrapping_add(stream));
        dice.bits();
        dice
    }

    pub(super) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    /// Returns a number from 0 up to, but not including, `end`.
    pub(super) fn below(&mut self, end: u32) -> u32 {
        u32::try_from((self.bits() >> 32) % u64::from(end)).expect("it is below a number of 32 bits")
    }

    /// Returns true so many times in a hundred.
    pub(super) fn percent(&mut self, times: u32) -> bool {
        self.below(100) < times
    }

    pub(super) fn one<T: Clone>(&mut self, of: &[T]) -> T {
        let place = self.below(u32::try_from(of.len()).expect("a list of choices is short"));
        of[place as usize].clone()
    }

    /// Returns a number from `low` to `high` in steps of 1/16, which no arithmetic of a scene rounds.
    pub(super) fn between(&mut self, low: u32, high: u32) -> f64 {
        f64::from(low) + f64::from(self.below(16 * (high - low) + 1)) / 16.0
    }
}
