//! Numbers without rounding, for the few decisions that an error bound cannot settle.

use std::cmp::Ordering;
use std::ops::{Add, Mul, Sub};

/// A signed integer of 128 bytes; the last parameter lets it panic on overflow in every build.
type Wide = bnum::Int<128, 0, { bnum::OverflowMode::Panic as u8 }>;

/// The weight of the last bit of a stored number: 2^-132. A number of magnitude [`crate::limits::TINY`] (2^-80)
/// or more has 53 bits, so all of them are multiples of it.
const FRACTION_BITS: u32 = 132;

/// The exponent field of an `f64` is above the weight of its last bit by this much.
const EXPONENT_BIAS: i32 = 1075;

/// An integer multiple of 2^(-132 · degree): a polynomial of that degree in stored numbers.
///
/// The largest polynomial of the predicates is the square of a cross product of a position (itself of degree 2,
/// below 2^33) with a velocity or a wall (below 2^32): degree 6, below 2^130, hence below 2^(792 + 130); 1024
/// bits hold it. Products and sums panic on overflow, so a violation of the limits cannot go unseen.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Exact {
    value: Wide,
    degree: u32,
}

impl Exact {
    /// Returns a stored number, exactly.
    ///
    /// # Panics
    /// For a number that is not finite, or nearer to zero than [`crate::limits::TINY`] but not zero: what is
    /// stored was checked or flushed, so this would be our mistake.
    pub(crate) fn new(number: f64) -> Self {
        assert!(number.is_finite(), "stored numbers are finite");
        let bits = number.to_bits();
        let exponent = i32::try_from((bits >> 52) & 0x7ff).expect("11 bits");
        let fraction = bits & ((1 << 52) - 1);
        if exponent == 0 && fraction == 0 {
            return Self { value: Wide::from(false), degree: 1 };
        }
        let mantissa = i64::try_from(fraction | (1 << 52)).expect("53 bits");
        let shift = exponent - EXPONENT_BIAS + FRACTION_BITS.cast_signed();
        let shift = u32::try_from(shift).expect("stored numbers are zero or not tiny");
        let magnitude = Wide::try_from(mantissa).expect("64 bits fit in 1024") << shift;
        Self { value: if number < 0.0 { -magnitude } else { magnitude }, degree: 1 }
    }

    /// Returns the square.
    pub(crate) fn squared(self) -> Self {
        self * self
    }

    /// Returns how the number compares with zero.
    pub(crate) fn sign(self) -> Ordering {
        self.value.cmp(&Wide::from(false))
    }

    fn raised(self, degree: u32) -> Wide {
        self.value << ((degree - self.degree) * FRACTION_BITS)
    }
}

impl Add for Exact {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let degree = self.degree.max(other.degree);
        Self { value: self.raised(degree) + other.raised(degree), degree }
    }
}

impl Sub for Exact {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        let degree = self.degree.max(other.degree);
        Self { value: self.raised(degree) - other.raised(degree), degree }
    }
}

impl Mul for Exact {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        Self { value: self.value * other.value, degree: self.degree + other.degree }
    }
}

/// A vector of the plane without rounding.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ExactVector {
    x: Exact,
    y: Exact,
}

impl ExactVector {
    /// Returns a stored vector, exactly.
    pub(crate) fn new(vector: glam::DVec2) -> Self {
        Self { x: Exact::new(vector.x), y: Exact::new(vector.y) }
    }

    /// Returns `x1 x2 + y1 y2`.
    pub(crate) fn dot(self, other: Self) -> Exact {
        self.x * other.x + self.y * other.y
    }

    /// Returns `x1 y2 - y1 x2`.
    pub(crate) fn cross(self, other: Self) -> Exact {
        self.x * other.y - self.y * other.x
    }

    /// Returns the vector times a number.
    pub(crate) fn scaled(self, factor: Exact) -> Self {
        Self { x: self.x * factor, y: self.y * factor }
    }
}

impl Add for ExactVector {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { x: self.x + other.x, y: self.y + other.y }
    }
}

impl Sub for ExactVector {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self { x: self.x - other.x, y: self.y - other.y }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sign_of_a_sum_survives_any_cancellation() {
        let check = |terms: &[f64], expected| {
            let sum = terms.iter().map(|&term| Exact::new(term)).reduce(|a, b| a + b);
            assert_eq!(sum.map(Exact::sign), Some(expected), "{terms:?}");
        };
        check(&[1e9, crate::limits::TINY, -1e9], Ordering::Greater);
        check(&[1e9, -crate::limits::TINY, -1e9], Ordering::Less);
        check(&[0.1, 0.2, -0.30000000000000004], Ordering::Less);
        check(&[0.5, -0.25, -0.25], Ordering::Equal);
        check(&[0.0, 0.0], Ordering::Equal);
    }

    #[test]
    fn products_of_the_largest_and_the_smallest_numbers_fit() {
        let large = Exact::new(2.0 * crate::limits::COORDINATE_MAX);
        let small = Exact::new(crate::limits::TINY);
        let position = large + large * small;
        assert_eq!((position * large + position * large).squared().sign(), Ordering::Greater);
        assert_eq!((small * small * small - small * small * small).sign(), Ordering::Equal);
        assert_eq!((large.squared() - small.squared()).sign(), Ordering::Greater);
    }
}
