//! The plane in rational arithmetic: what the exact decisions of the core are compared with.

use dashu_ratio::Relaxed;
use glam::DVec2;

/// A number without rounding. Sums and products of doubles have powers of two below the line, and this type divides
/// by nothing else on the way.
pub(crate) type Rational = Relaxed;

/// A point or vector without rounding.
#[derive(Clone)]
pub(crate) struct Exact(pub(crate) Rational, pub(crate) Rational);

impl Exact {
    pub(crate) fn of(vector: DVec2) -> Self {
        Self(number(vector.x), number(vector.y))
    }

    pub(crate) fn minus(&self, other: &Self) -> Self {
        Self(&self.0 - &other.0, &self.1 - &other.1)
    }

    pub(crate) fn plus(&self, other: &Self, factor: &Rational) -> Self {
        Self(&self.0 + &other.0 * factor, &self.1 + &other.1 * factor)
    }

    pub(crate) fn dot(&self, other: &Self) -> Rational {
        &self.0 * &other.0 + &self.1 * &other.1
    }

    pub(crate) fn cross(&self, other: &Self) -> Rational {
        &self.0 * &other.1 - &self.1 * &other.0
    }
}

pub(crate) fn number(value: f64) -> Rational {
    Rational::try_from(value).expect("the number is finite")
}

/// The square of the distance from a point to the straight way between two points.
pub(crate) fn square_distance(point: &Exact, from: &Exact, to: &Exact) -> Rational {
    let (way, offset) = (to.minus(from), point.minus(from));
    let (along, square) = (way.dot(&offset), way.dot(&way));
    let part = if along <= Rational::ZERO || square == Rational::ZERO {
        Rational::ZERO
    } else if along >= square {
        Rational::ONE
    } else {
        along / square
    };
    let gap = offset.minus(&Exact(&way.0 * &part, &way.1 * &part));
    gap.dot(&gap)
}

/// Whether two straight ways have a point in common that is an end of neither.
pub(crate) fn cross(a: &Exact, b: &Exact, c: &Exact, d: &Exact) -> bool {
    let side = |from: &Exact, to: &Exact, point: &Exact| to.minus(from).cross(&point.minus(from));
    let opposite = |one: Rational, other: Rational| one * other < Rational::ZERO;
    opposite(side(a, b, c), side(a, b, d)) && opposite(side(c, d, a), side(c, d, b))
}
