//! Chance without a stream.

use twox_hash::XxHash3_64;

use super::kind::Kind;

/// Sets this use of the seed apart from all others.
const DOMAIN: &[u8] = b"generate map";

/// Numbers that follow from a seed, a kind of map, an attempt, a purpose and an index, and from nothing else: what is asked for
/// first changes nothing.
#[derive(Clone, Copy, Debug)]
pub(super) struct Dice {
    seed: u64,
    kind: Kind,
    attempt: u32,
}

impl Dice {
    pub(super) fn new(seed: u64, kind: Kind, attempt: u32) -> Self {
        Self { seed, kind, attempt }
    }

    pub(super) fn attempt(self) -> u32 {
        self.attempt
    }

    /// Returns a number from 0 to `sides - 1`; 0 where there are no sides.
    pub(super) fn below(self, purpose: &str, index: u64, sides: i32) -> i32 {
        let sides = u64::from(sides.max(1).cast_unsigned());
        i32::try_from(self.roll(purpose, index) % sides).unwrap_or(0)
    }

    /// Returns a number from `least` to `most`; `least` where that is no range.
    pub(super) fn between(self, purpose: &str, index: u64, (least, most): (i32, i32)) -> i32 {
        least + self.below(purpose, index, most - least + 1)
    }

    /// Returns a number from 0 up to 1, a multiple of 2^-32, so that it is exact.
    pub(super) fn share(self, purpose: &str, index: u64) -> f64 {
        let high = u32::try_from(self.roll(purpose, index) >> 32).unwrap_or(0);
        f64::from(high) / 4_294_967_296.0
    }

    fn roll(self, purpose: &str, index: u64) -> u64 {
        let mut key = [0; 64];
        let mut length = 0;
        let (kind, attempt, index) = (self.kind.name(), self.attempt.to_le_bytes(), index.to_le_bytes());
        for part in [DOMAIN, &attempt, &index, kind.as_bytes(), b" ", purpose.as_bytes()] {
            key[length..length + part.len()].copy_from_slice(part);
            length += part.len();
        }
        XxHash3_64::oneshot_with_seed(self.seed, &key[..length])
    }
}
