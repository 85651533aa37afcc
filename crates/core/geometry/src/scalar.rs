//! The scalar and the plane vector that the kinematic code is generic over.

use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

use glam::{DVec2, Vec2};

/// A floating-point type that kinematics can run in: `f64`, the default, or `f32`.
///
/// Only operations that IEEE 754 rounds correctly are here, so that the bits are the same on every platform.
pub trait Scalar:
    Copy
    + Debug
    + PartialOrd
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// The plane vector of this scalar: `glam`'s `DVec2` or `Vec2`.
    type Vector: Planar<Scalar = Self>;

    /// Zero.
    const ZERO: Self;
    /// One.
    const ONE: Self;
    /// Positive infinity: later than any time.
    const INFINITY: Self;
    /// The unit roundoff: half the distance from 1 to the next larger number, the largest relative error of
    /// one rounded operation.
    const ROUNDOFF: Self;

    /// Returns the nearest scalar to `value`.
    #[must_use]
    fn from_f64(value: f64) -> Self;
    /// Returns the same number as `f64`; nothing is lost.
    #[must_use]
    fn to_f64(self) -> f64;
    /// Returns the correctly rounded square root; `self` must not be negative.
    #[must_use]
    fn sqrt(self) -> Self;
    /// Returns the magnitude.
    #[must_use]
    fn abs(self) -> Self;
    /// Returns the largest integer that is not above `self`.
    #[must_use]
    fn floor(self) -> Self;

    /// Returns the smaller of two numbers, `self` where they are equal.
    #[must_use]
    fn lesser(self, other: Self) -> Self {
        if other < self { other } else { self }
    }
    /// Returns the larger of two numbers, `self` where they are equal.
    #[must_use]
    fn greater(self, other: Self) -> Self {
        if other > self { other } else { self }
    }
    /// Returns `self`, or zero where its magnitude is below [`crate::limits::TINY`]; never `-0`.
    ///
    /// What is stored goes through here, so that the exact predicates cannot underflow.
    #[must_use]
    fn flushed(self) -> Self {
        if self.to_f64().abs() < crate::limits::TINY { Self::ZERO } else { self }
    }
}

/// A vector of the plane; also a point, as its offset from the origin.
pub trait Planar:
    Copy
    + Debug
    + PartialEq
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Self::Scalar, Output = Self>
    + Neg<Output = Self>
{
    /// The type of the components.
    type Scalar: Scalar<Vector = Self>;

    /// Returns the vector (x, y).
    #[must_use]
    fn new(x: Self::Scalar, y: Self::Scalar) -> Self;
    /// Returns the component to the right.
    #[must_use]
    fn x(self) -> Self::Scalar;
    /// Returns the component downwards.
    #[must_use]
    fn y(self) -> Self::Scalar;

    /// Returns the zero vector.
    #[must_use]
    fn zero() -> Self {
        Self::new(Self::Scalar::ZERO, Self::Scalar::ZERO)
    }
    /// Returns `x1 x2 + y1 y2`.
    #[must_use]
    fn dot(self, other: Self) -> Self::Scalar {
        self.x() * other.x() + self.y() * other.y()
    }
    /// Returns `x1 y2 - y1 x2`: positive where `other` points to the right of `self` on a screen (y down).
    #[must_use]
    fn cross(self, other: Self) -> Self::Scalar {
        self.x() * other.y() - self.y() * other.x()
    }
    /// Returns the length.
    #[must_use]
    fn length(self) -> Self::Scalar {
        self.dot(self).sqrt()
    }
    /// Returns the vector with both components [`Scalar::flushed`].
    #[must_use]
    fn flushed(self) -> Self {
        Self::new(self.x().flushed(), self.y().flushed())
    }
    /// Returns the vector in `f64`; nothing is lost.
    #[must_use]
    fn to_dvec2(self) -> DVec2 {
        DVec2::new(self.x().to_f64(), self.y().to_f64())
    }
    /// Returns the nearest vector to `value`.
    #[must_use]
    fn from_dvec2(value: DVec2) -> Self {
        Self::new(Self::Scalar::from_f64(value.x), Self::Scalar::from_f64(value.y))
    }
}

macro_rules! scalar {
    ($scalar:ident, $vector:ty, $from:expr) => {
        impl Scalar for $scalar {
            type Vector = $vector;

            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const INFINITY: Self = $scalar::INFINITY;
            const ROUNDOFF: Self = $scalar::EPSILON / 2.0;

            fn from_f64(value: f64) -> Self {
                $from(value)
            }
            fn to_f64(self) -> f64 {
                f64::from(self)
            }
            fn sqrt(self) -> Self {
                self.sqrt()
            }
            fn abs(self) -> Self {
                self.abs()
            }
            fn floor(self) -> Self {
                self.floor()
            }
        }

        impl Planar for $vector {
            type Scalar = $scalar;

            fn new(x: $scalar, y: $scalar) -> Self {
                Self::new(x, y)
            }
            fn x(self) -> $scalar {
                self.x
            }
            fn y(self) -> $scalar {
                self.y
            }
        }
    };
}

scalar!(f64, DVec2, |value: f64| value);
scalar!(f32, Vec2, nearest_f32);

#[expect(clippy::cast_possible_truncation, reason = "rounding to the nearest f32 is what is asked for")]
fn nearest_f32(value: f64) -> f32 {
    value as f32
}
