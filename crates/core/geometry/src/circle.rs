//! The shape of every object.

use crate::scalar::Scalar;

/// A circle, in world units.
#[doc(alias = "disc")]
#[doc(alias = "ball")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Circle<S: Scalar = f64> {
    /// The centre.
    pub center: S::Vector,
    /// The radius; positive.
    pub radius: S,
}

impl<S: Scalar> Circle<S> {
    /// Returns the circle with this centre and radius.
    pub fn new(center: S::Vector, radius: S) -> Self {
        Self { center, radius }
    }
}
