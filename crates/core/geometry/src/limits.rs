//! What numbers the world accepts, and the distance that follows from them.

use glam::DVec2;
use thiserror::Error;

use crate::scalar::Scalar;

/// Magnitude below which a stored number is zero: 2^-80, about 8.3e-25.
///
/// The exact predicates multiply up to eight differences of such numbers; with 53 bits each, no product
/// falls below the smallest number that a double can hold (2^-1074), so they cannot underflow.
pub const TINY: f64 = 1.0 / (1u128 << 80) as f64;

/// Largest magnitude of a coordinate that any scenario can declare, in world units: 2^30, about 1.07e9.
pub const COORDINATE_MAX: f64 = (1u64 << 30) as f64;

/// Largest speed that any scenario can declare, in world units a cycle: 2^20, about 1.05e6.
pub const SPEED_MAX: f64 = (1u64 << 20) as f64;

/// Smallest speed other than 0, in world units a cycle: 2^-40, about 9.1e-13.
pub const SPEED_MIN: f64 = 1.0 / (1u64 << 40) as f64;

/// Smallest radius, in world units: 2^-20, about 9.5e-7.
pub const RADIUS_MIN: f64 = 1.0 / (1u64 << 20) as f64;

/// Largest radius that any scenario can declare, in world units: 2^16.
pub const RADIUS_MAX: f64 = (1u64 << 16) as f64;

/// A number that the world does not accept. The caller adds which object and which field it was.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum NumberError {
    /// Not a number.
    #[error("is not a number")]
    NotANumber,
    /// Infinite.
    #[error("is infinite")]
    Infinite,
    /// Negative zero, which equals zero but has other bits.
    #[error("is -0; write 0")]
    NegativeZero,
    /// Nearer to zero than the exact predicates can work with.
    #[error("is {0:e}, nearer to zero than {TINY:e}; write 0")]
    Tiny(f64),
    /// Negative where only zero or more makes sense.
    #[error("is {0}; it must not be negative")]
    Negative(f64),
    /// Zero or less where only more makes sense.
    #[error("is {0}; it must be positive")]
    NotPositive(f64),
    /// Below the declared limit.
    #[error("is {value}; the smallest allowed is {limit:e}")]
    TooSmall {
        /// The number.
        value: f64,
        /// The limit.
        limit: f64,
    },
    /// Above the declared limit.
    #[error("is {value}; the largest allowed is {limit}")]
    TooLarge {
        /// The number.
        value: f64,
        /// The limit.
        limit: f64,
    },
}

/// The numbers that a world declares when it is made; they never change. The skin follows from them and
/// from nothing else, unless a world is asked for another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    coordinate_max: f64,
    radius_max: f64,
    speed_max: f64,
}

impl Limits {
    /// Returns the limits of a world whose coordinates have at most the magnitude `coordinate_max` (world
    /// units), whose radii are at most `radius_max` (world units) and whose speeds at most `speed_max`
    /// (world units a cycle).
    ///
    /// # Errors
    /// A limit that is not a positive number, or above [`COORDINATE_MAX`], [`RADIUS_MAX`], [`SPEED_MAX`]; the
    /// name says which.
    pub fn new(
        coordinate_max: f64,
        radius_max: f64,
        speed_max: f64,
    ) -> Result<Self, (&'static str, NumberError)> {
        for (name, value, limit) in [
            ("coordinate limit", coordinate_max, COORDINATE_MAX),
            ("radius limit", radius_max, RADIUS_MAX),
            ("speed limit", speed_max, SPEED_MAX),
        ] {
            positive(value, limit).map_err(|error| (name, error))?;
        }
        Ok(Self { coordinate_max, radius_max, speed_max })
    }

    /// Returns the largest magnitude of a coordinate, in world units.
    #[must_use]
    pub fn coordinate_max(&self) -> f64 {
        self.coordinate_max
    }

    /// Returns the largest radius, in world units.
    #[must_use]
    pub fn radius_max(&self) -> f64 {
        self.radius_max
    }

    /// Returns the largest speed, in world units a cycle.
    #[must_use]
    pub fn speed_max(&self) -> f64 {
        self.speed_max
    }

    /// Returns the skin: how far above touching a colliding circle stops, in world units.
    ///
    /// `32 u (c + r + v)` with the unit roundoff `u`, the largest coordinate `c`, radius `r` and speed `v`.
    /// A position within a cycle is `p + v t` with two roundings, an error of at most `u (c + 2 v)`; the
    /// collision time carries at most `8 u` relative, `8 u v` in position; a pair doubles both, and the
    /// rest is room. For a map of 512 tiles in doubles it is about 2e-12 world units.
    #[must_use]
    pub fn skin<S: Scalar>(&self) -> S {
        let sum = S::from_f64(self.coordinate_max + self.radius_max + self.speed_max);
        S::from_f64(32.0) * S::ROUNDOFF * sum
    }

    /// Checks a point.
    ///
    /// # Errors
    /// Names the coordinate, `x` or `y`, and what is wrong with it.
    pub fn check_point(&self, point: DVec2) -> Result<(), (&'static str, NumberError)> {
        self.check_coordinate(point.x).map_err(|error| ("x", error))?;
        self.check_coordinate(point.y).map_err(|error| ("y", error))
    }

    /// Checks one coordinate.
    ///
    /// # Errors
    /// A number that is not finite, is `-0` or tiny, or is beyond the limit.
    pub fn check_coordinate(&self, value: f64) -> Result<(), NumberError> {
        finite(value)?;
        if value.abs() > self.coordinate_max {
            return Err(NumberError::TooLarge { value, limit: self.coordinate_max });
        }
        Ok(())
    }

    /// Checks a radius.
    ///
    /// # Errors
    /// A number that is not positive, below [`RADIUS_MIN`] or above the limit.
    pub fn check_radius(&self, value: f64) -> Result<(), NumberError> {
        positive(value, self.radius_max)?;
        if value < RADIUS_MIN {
            return Err(NumberError::TooSmall { value, limit: RADIUS_MIN });
        }
        Ok(())
    }

    /// Checks a speed in world units a cycle; 0 is allowed and means to stand.
    ///
    /// # Errors
    /// A number that is negative, not 0 but below [`SPEED_MIN`], or above the limit.
    pub fn check_speed(&self, value: f64) -> Result<(), NumberError> {
        finite(value)?;
        if value < 0.0 {
            return Err(NumberError::Negative(value));
        }
        if value > self.speed_max {
            return Err(NumberError::TooLarge { value, limit: self.speed_max });
        }
        if value != 0.0 && value < SPEED_MIN {
            return Err(NumberError::TooSmall { value, limit: SPEED_MIN });
        }
        Ok(())
    }

    /// Checks the fraction of a cycle, `0.0..=1.0`.
    ///
    /// # Errors
    /// A number outside of that range, `-0` or tiny.
    pub fn check_fraction(&self, value: f64) -> Result<(), NumberError> {
        finite(value)?;
        if value < 0.0 {
            return Err(NumberError::Negative(value));
        }
        if value > 1.0 {
            return Err(NumberError::TooLarge { value, limit: 1.0 });
        }
        Ok(())
    }
}

fn finite(value: f64) -> Result<(), NumberError> {
    if value.is_nan() {
        return Err(NumberError::NotANumber);
    }
    if value.is_infinite() {
        return Err(NumberError::Infinite);
    }
    if value == 0.0 && value.is_sign_negative() {
        return Err(NumberError::NegativeZero);
    }
    if value != 0.0 && value.abs() < TINY {
        return Err(NumberError::Tiny(value));
    }
    Ok(())
}

fn positive(value: f64, limit: f64) -> Result<(), NumberError> {
    finite(value)?;
    if value <= 0.0 {
        return Err(NumberError::NotPositive(value));
    }
    if value > limit {
        return Err(NumberError::TooLarge { value, limit });
    }
    Ok(())
}
