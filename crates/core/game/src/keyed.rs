//! Randomness without a stream.

use maniple_geometry::Cycle;
use maniple_view::Seat;
use twox_hash::XxHash3_64;

/// What a random number is for: different purposes get independent numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// The choice of start points and zones on a map that has none.
    Placement,
    /// The damage of a shot.
    Damage,
    /// Who comes first of those who come at the same time.
    Precedence,
    /// Whether a neutral unit sets out.
    Departure,
    /// Where a neutral unit goes, to the right.
    GoalX,
    /// Where a neutral unit goes, downwards.
    GoalY,
    /// Who gets a kill of those who did as much damage.
    Kill,
}

impl Purpose {
    /// Part of every replay's hash chain: a number stays with its purpose for good.
    fn number(self) -> u32 {
        match self {
            Self::Placement => 1,
            Self::Damage => 2,
            Self::Precedence => 3,
            Self::Departure => 4,
            Self::GoalX => 5,
            Self::GoalY => 6,
            Self::Kill => 7,
        }
    }
}

/// Returns 64 random bits that depend on nothing but the arguments: the xxh3-64 of seed, cycle, seat, index within
/// the seat and purpose, little-endian, one after the other; nobody's seat counts as 2^16 - 1.
///
/// A stream would make every number depend on how many were drawn before; this does not.
#[must_use]
pub fn keyed(seed: u64, cycle: Cycle, seat: Option<Seat>, index: u32, purpose: Purpose) -> u64 {
    let mut bytes = [0; 22];
    bytes[..8].copy_from_slice(&seed.to_le_bytes());
    bytes[8..12].copy_from_slice(&cycle.0.to_le_bytes());
    bytes[12..14].copy_from_slice(&seat.map_or(u16::MAX, |seat| seat.0).to_le_bytes());
    bytes[14..18].copy_from_slice(&index.to_le_bytes());
    bytes[18..].copy_from_slice(&purpose.number().to_le_bytes());
    XxHash3_64::oneshot(&bytes)
}

/// Returns the number from 0 up to, but not including, 1 that random bits stand for: the upper 53 of them.
pub(crate) fn fraction(bits: u64) -> f64 {
    const STEPS: f64 = (1u64 << 53) as f64;
    (bits >> 11) as f64 / STEPS
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_argument_changes_the_number() {
        let number =
            |seed, cycle, seat, index| keyed(seed, Cycle(cycle), Some(Seat(seat)), index, Purpose::Placement);
        let mut numbers = vec![
            number(0, 0, 0, 0),
            number(1, 0, 0, 0),
            number(0, 1, 0, 0),
            number(0, 0, 1, 0),
            number(0, 0, 0, 1),
        ];
        numbers.sort_unstable();
        numbers.dedup();
        assert_eq!(numbers.len(), 5);
        assert_eq!(number(7, 8, 9, 10), number(7, 8, 9, 10));
    }
}
