//! How a number is written: as the double that it is, or in steps of a grid.

use maniple_view::{GRID_FRACTIONS, Positions};

use super::PackedProblem;
use super::bits::{Reader, write_signed, write_unsigned};

/// How the numbers of one kind are written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Numbers {
    /// As doubles. Two of them differ by so many doubles as lie between.
    Exact,
    /// As multiples of a step, a power of two. Two of them differ by so many steps.
    Steps(f64),
}

impl Numbers {
    /// Returns how coordinates are written.
    pub(super) fn of_places(positions: Positions) -> Self {
        match positions {
            Positions::Exact => Self::Exact,
            Positions::Grid { .. } => Self::Steps(positions.step()),
        }
    }

    /// Returns how components of velocities are written.
    pub(super) fn of_velocities(positions: Positions) -> Self {
        match positions {
            Positions::Exact => Self::Exact,
            Positions::Grid { .. } => Self::Steps(positions.velocity_step()),
        }
    }

    pub(super) fn write(self, bytes: &mut Vec<u8>, number: f64) {
        match self {
            Self::Exact => bytes.extend_from_slice(&number.to_le_bytes()),
            Self::Steps(step) => write_signed(bytes, whole(number / step)),
        }
    }

    pub(super) fn read(self, reader: &mut Reader<'_>) -> Result<f64, PackedProblem> {
        match self {
            Self::Exact => reader.double(),
            Self::Steps(step) => Ok(double(reader.signed()?) * step),
        }
    }

    /// Returns the number of this kind that is nearest to `number`.
    pub(super) fn nearest(self, number: f64) -> f64 {
        match self {
            Self::Exact => number,
            Self::Steps(step) => (number / step + 0.5).floor() * step + 0.0,
        }
    }

    /// Returns how far it is from one number to another.
    pub(super) fn difference(self, from: f64, to: f64) -> i64 {
        match self {
            Self::Exact => rank(to).wrapping_sub(rank(from)),
            Self::Steps(step) => whole(to / step).wrapping_sub(whole(from / step)),
        }
    }

    /// Returns the number that is so far from another.
    pub(super) fn beyond(self, from: f64, difference: i64) -> f64 {
        match self {
            Self::Exact => ranked(rank(from).wrapping_add(difference)),
            Self::Steps(step) => double(whole(from / step).wrapping_add(difference)) * step,
        }
    }

    /// Writes the fraction of a cycle.
    pub(super) fn write_fraction(self, bytes: &mut Vec<u8>, fraction: f64) {
        match self {
            Self::Exact => bytes.extend_from_slice(&fraction.to_le_bytes()),
            Self::Steps(_) => write_unsigned(bytes, whole(fraction * GRID_FRACTIONS).cast_unsigned()),
        }
    }

    pub(super) fn read_fraction(self, reader: &mut Reader<'_>) -> Result<f64, PackedProblem> {
        match self {
            Self::Exact => reader.double(),
            Self::Steps(_) => Ok(f64::from(reader.small()?) / GRID_FRACTIONS),
        }
    }
}

/// Returns the place of a double among all doubles, from the least to the greatest; -0 lies just below 0, which has the place 0.
fn rank(number: f64) -> i64 {
    let bits = number.to_bits().cast_signed();
    if bits < 0 { bits ^ i64::MAX } else { bits }
}

/// Returns the double at a place.
fn ranked(rank: i64) -> f64 {
    let bits = if rank < 0 { rank ^ i64::MAX } else { rank };
    f64::from_bits(bits.cast_unsigned())
}

/// Returns a number without its fraction; what is beyond 64 bits, which only a forged delta holds, becomes the last one within.
#[expect(clippy::cast_possible_truncation, reason = "the trackers of a grid make whole numbers below 2^53")]
fn whole(number: f64) -> i64 {
    number as i64
}

#[expect(clippy::cast_precision_loss, reason = "a server's numbers are below 2^53; of others any will do")]
fn double(number: i64) -> f64 {
    number as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn doubles_are_ranked_in_their_order_and_every_difference_leads_back() {
        let numbers = [
            f64::NEG_INFINITY,
            -1e300,
            -1.0,
            -5e-324,
            -0.0,
            0.0,
            5e-324,
            0.1,
            1.0,
            1.0 + f64::EPSILON,
            4096.0,
            f64::MAX,
        ];
        for (at, &from) in numbers.iter().enumerate() {
            for (other, &to) in numbers.iter().enumerate() {
                let difference = Numbers::Exact.difference(from, to);
                assert_eq!(Numbers::Exact.beyond(from, difference).to_bits(), to.to_bits());
                if at.abs_diff(other) < 3 {
                    assert_eq!(at.cmp(&other), 0.cmp(&difference), "{from} {to}");
                }
            }
        }
        assert_eq!(Numbers::Exact.difference(1.0, 1.0 + 2.0 * f64::EPSILON), 2);
        assert_eq!(Numbers::Exact.difference(0.0, -0.0), -1);
    }

    #[test]
    fn on_a_grid_numbers_differ_by_steps() {
        let grid = Numbers::of_places(Positions::Grid { bits: 4 });
        assert_eq!(grid, Numbers::Steps(1.0 / 16.0));
        assert_eq!(grid.difference(1.0, 0.5), -8);
        assert_eq!(grid.beyond(1.0, -8), 0.5);
        assert_eq!(grid.nearest(0.49), 0.5);
        assert!(grid.nearest(-0.01).is_sign_positive());
        assert_eq!(Numbers::of_velocities(Positions::Grid { bits: 4 }), Numbers::Steps(1.0 / 4096.0));
    }
}
