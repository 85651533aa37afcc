//! Randomness without a stream: a bot's number does not depend on how many were drawn before.

use maniple_view::Seat;
use twox_hash::XxHash3_64;

/// What a random number is for.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Purpose {
    GoalX = 1,
    GoalY = 2,
    Slot = 3,
    DetourX = 4,
    DetourY = 5,
    Wait = 6,
    Strength = 7,
    Training = 8,
}

/// Returns the seed of the bot at a seat of a match: the xxh3-64 of the match's seed and the seat, little-endian.
///
/// It tells a bot nothing about the seed of the match or of other bots.
#[must_use]
pub fn bot_seed(seed: u64, seat: Seat) -> u64 {
    let mut bytes = [0; 10];
    bytes[..8].copy_from_slice(&seed.to_le_bytes());
    bytes[8..].copy_from_slice(&seat.0.to_le_bytes());
    XxHash3_64::oneshot(&bytes)
}

/// Returns 64 random bits that depend on nothing but the bot's seed, the cycle, the index and the
/// purpose.
pub(crate) fn keyed(seed: u64, cycle: u32, index: u32, purpose: Purpose) -> u64 {
    let mut bytes = [0; 17];
    bytes[..8].copy_from_slice(&seed.to_le_bytes());
    bytes[8..12].copy_from_slice(&cycle.to_le_bytes());
    bytes[12..16].copy_from_slice(&index.to_le_bytes());
    bytes[16] = purpose as u8;
    XxHash3_64::oneshot(&bytes)
}

/// Returns the number from 0 up to, but not including, 1 that random bits stand for: the upper 53 of them.
pub(crate) fn fraction(bits: u64) -> f64 {
    const STEPS: f64 = (1u64 << 53) as f64;
    (bits >> 11) as f64 / STEPS
}
