//! Squares of the plane, wrapped around a torus, so that a table of any size covers a world of any size.

/// 1.5 * 2^52: a double of at most 2^51 plus this has the nearest integer in its low bits, negative ones in two's
/// complement.
const TO_INTEGER: f64 = 6_755_399_441_055_744.0;

/// Smallest number of bits of a side: with four columns and rows no square is its own neighbour on two sides.
const SIDE_BITS_MIN: u32 = 2;

/// A table of square buckets over the whole plane: the square of a point counts modulo the size of the table, so
/// places far apart share a bucket, and none is ever outside. Rows lie one behind the other.
///
/// A table with as many squares as items holds few of them in each, however they are strewn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Squares {
    /// Squares a world unit.
    inverse_edge: f64,
    column_bits: u32,
    row_bits: u32,
}

impl Squares {
    /// Returns a table with squares of an edge, in world units, and about `count` of them.
    pub(crate) fn new(edge: f64, count: usize) -> Self {
        let bits = count.max(1).next_power_of_two().trailing_zeros();
        let side = |bits: u32| bits.max(SIDE_BITS_MIN);
        Self { inverse_edge: 1.0 / edge, column_bits: side(bits.div_ceil(2)), row_bits: side(bits / 2) }
    }

    pub(crate) fn columns(&self) -> u32 {
        1 << self.column_bits
    }

    pub(crate) fn rows(&self) -> u32 {
        1 << self.row_bits
    }

    pub(crate) fn count(&self) -> usize {
        1 << (self.column_bits + self.row_bits)
    }

    /// Returns the column of a coordinate.
    #[inline]
    pub(crate) fn column(&self, x: f64) -> u32 {
        low_bits(x * self.inverse_edge) & (self.columns() - 1)
    }

    /// Returns the row of a coordinate.
    #[inline]
    pub(crate) fn row(&self, y: f64) -> u32 {
        low_bits(y * self.inverse_edge) & (self.rows() - 1)
    }

    /// Returns the place of a square in the table.
    #[inline]
    pub(crate) fn place(&self, row: u32, column: u32) -> usize {
        ((row << self.column_bits) | column) as usize
    }

    /// Visits the places of a square and of the eight around it.
    pub(crate) fn visit_around(&self, place: usize, mut visit: impl FnMut(usize)) {
        let place = u32::try_from(place).expect("places have 32 bits");
        let (row, column) = (place >> self.column_bits, place & (self.columns() - 1));
        for down in [self.rows() - 1, 0, 1] {
            for right in [self.columns() - 1, 0, 1] {
                let (row, column) =
                    ((row + down) & (self.rows() - 1), (column + right) & (self.columns() - 1));
                visit(self.place(row, column));
            }
        }
    }

    /// Returns the columns that meet an interval, each once.
    pub(crate) fn columns_from(&self, low: f64, high: f64) -> Wrapped {
        Wrapped::new(low * self.inverse_edge, high * self.inverse_edge, self.columns())
    }

    /// Returns the rows that meet an interval, each once.
    pub(crate) fn rows_from(&self, low: f64, high: f64) -> Wrapped {
        Wrapped::new(low * self.inverse_edge, high * self.inverse_edge, self.rows())
    }

    /// Visits the places of all squares that a box meets.
    #[inline]
    pub(crate) fn visit(&self, low: (f64, f64), high: (f64, f64), mut visit: impl FnMut(usize)) {
        let (columns, rows) = (self.columns_from(low.0, high.0), self.rows_from(low.1, high.1));
        for down in 0..rows.left {
            let row = (rows.first + down) & rows.mask;
            for right in 0..columns.left {
                visit(self.place(row, (columns.first + right) & columns.mask));
            }
        }
    }
}

/// Numbers that follow each other modulo a power of two, each at most once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Wrapped {
    first: u32,
    left: u32,
    mask: u32,
}

impl Wrapped {
    #[inline]
    fn new(low: f64, high: f64, size: u32) -> Self {
        let mask = size - 1;
        let first = low_bits(low);
        // The difference of the rounded ends is exact modulo 2^32, which a span below the size cannot exceed.
        let left = if high - low >= f64::from(mask) { size } else { low_bits(high).wrapping_sub(first) + 1 };
        Self { first: first & mask, left: left.min(size), mask }
    }

    /// Returns the numbers as at most two runs `(first, count)` that do not wrap.
    pub(crate) fn runs(&self) -> [(u32, u32); 2] {
        let size = self.mask + 1;
        let until_wrap = (size - self.first).min(self.left);
        [(self.first, until_wrap), (0, self.left - until_wrap)]
    }
}

impl Iterator for Wrapped {
    type Item = u32;

    fn next(&mut self) -> Option<u32> {
        self.left = self.left.checked_sub(1)?;
        let number = self.first;
        self.first = (number + 1) & self.mask;
        Some(number)
    }
}

/// The low 32 bits of the nearest integer.
#[inline]
#[expect(clippy::cast_possible_truncation, reason = "the low bits are what is asked for")]
fn low_bits(number: f64) -> u32 {
    (number + TO_INTEGER).to_bits() as u32
}

/// Returns the power of two with an exponent.
pub(crate) fn power_of_two(exponent: i32) -> f64 {
    f64::from_bits(u64::try_from(exponent + 1023).expect("exponents of the limits are small") << 52)
}

/// Returns the exponent of the largest power of two that is not above a positive number.
pub(crate) fn exponent(number: f64) -> i32 {
    i32::try_from(number.to_bits() >> 52).expect("positive, so 11 bits") - 1023
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_in_the_plane_are_neighbours_in_the_table() {
        let squares = Squares::new(2.0, 16);
        assert_eq!((squares.columns(), squares.rows()), (4, 4));
        let check = |x: f64, column: u32| assert_eq!(squares.column(x), column, "x {x}");
        check(0.0, 0);
        check(0.9, 0);
        check(1.1, 1);
        check(-1.1, 3);
        check(-8.0, 0);
        check(1e9, (500_000_000u32) & 3);
    }

    #[test]
    fn an_interval_meets_each_square_once() {
        let squares = Squares::new(1.0, 64);
        let check = |low: f64, high: f64, expected: &[u32]| {
            assert_eq!(squares.columns_from(low, high).collect::<Vec<_>>(), expected, "{low} to {high}");
        };
        check(2.0, 2.0, &[2]);
        check(-1.2, 1.2, &[7, 0, 1]);
        check(-100.0, 100.0, &[4, 5, 6, 7, 0, 1, 2, 3]);
        check(-1e12, 1e12, &squares.columns_from(-1e12, 1e12).collect::<Vec<_>>());
        assert_eq!(squares.columns_from(-1e12, 1e12).count(), 8);
        assert_eq!(squares.columns_from(-1.2, 1.2).runs(), [(7, 1), (0, 2)]);
    }

    #[test]
    fn exponents_are_those_of_the_number() {
        assert_eq!(exponent(1.0), 0);
        assert_eq!(exponent(0.3), -2);
        assert_eq!(exponent(1000.0), 9);
        assert_eq!(power_of_two(-3), 0.125);
    }
}
