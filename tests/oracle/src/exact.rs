//! Numbers without rounding, and the plane that is made of them.

use dashu_float::FBig;
use dashu_float::round::mode::HalfEven;
use dashu_ratio::Relaxed;

/// Bits of a root.
///
/// The textbook formula for the first of two roots subtracts nearly equal numbers where a circle is a skin away from
/// another far beyond its size; of 256 bits that leaves more than 200.
pub const PRECISION: usize = 256;

/// A rational number: exact, however long it gets.
pub type Exact = Relaxed;

/// A point or an offset in the plane, in world units.
#[derive(Clone, Debug, PartialEq)]
pub struct Vector {
    /// To the right.
    pub x: Exact,
    /// Upwards.
    pub y: Exact,
}

impl Vector {
    /// Returns the vector of two doubles.
    ///
    /// # Panics
    /// Where one of them is not finite.
    #[must_use]
    pub fn new([x, y]: [f64; 2]) -> Self {
        Self { x: exact(x), y: exact(y) }
    }

    /// Returns the nearest doubles.
    #[must_use]
    pub fn to_f64(&self) -> [f64; 2] {
        [rounded(&self.x), rounded(&self.y)]
    }

    pub(crate) fn plus(&self, other: &Self) -> Self {
        Self { x: &self.x + &other.x, y: &self.y + &other.y }
    }

    pub(crate) fn minus(&self, other: &Self) -> Self {
        Self { x: &self.x - &other.x, y: &self.y - &other.y }
    }

    pub(crate) fn times(&self, factor: &Exact) -> Self {
        Self { x: &self.x * factor, y: &self.y * factor }
    }

    pub(crate) fn dot(&self, other: &Self) -> Exact {
        &self.x * &other.x + &self.y * &other.y
    }

    pub(crate) fn cross(&self, other: &Self) -> Exact {
        &self.x * &other.y - &self.y * &other.x
    }

    pub(crate) fn square(&self) -> Exact {
        self.dot(self)
    }

    pub(crate) fn is_zero(&self) -> bool {
        self.x.is_zero() && self.y.is_zero()
    }
}

/// The number that a double stands for.
pub(crate) fn exact(value: f64) -> Exact {
    Exact::try_from(value).expect("the numbers of a scene are finite")
}

/// Returns the nearest double.
#[must_use]
pub fn rounded(value: &Exact) -> f64 {
    value.to_f64().value()
}

/// The square root of a number that is not negative, to [`PRECISION`] bits.
pub(crate) fn root(square: &Exact) -> Exact {
    let float: FBig<HalfEven> = square.to_float(PRECISION).value();
    Exact::try_from(float.sqrt()).expect("a root is finite")
}

/// The number with [`PRECISION`] bits.
pub(crate) fn shortened(value: &Exact) -> Exact {
    let float: FBig<HalfEven> = value.to_float(PRECISION).value();
    Exact::try_from(float).expect("the number is finite")
}

/// The square of the least `|d + w s|` for `s` from 0 to `span`, where the square of the last is given: at the end an
/// object is in its goal, and not where the rounded velocity would have brought it.
pub(crate) fn least_square(d: &Vector, w: &Vector, span: &Exact, last: Exact) -> Exact {
    let (closing, square) = (d.dot(w), w.square());
    if closing >= Exact::ZERO {
        d.square().min(last)
    } else if &closing + &square * span <= Exact::ZERO {
        last
    } else {
        let cross = d.cross(w);
        last.min(&cross * &cross / square)
    }
}

/// The point of a way, given by its ends, that is nearest to another point.
pub(crate) fn nearest(point: &Vector, [start, end]: &[Vector; 2]) -> Vector {
    let (way, offset) = (end.minus(start), point.minus(start));
    let (along, square) = (way.dot(&offset), way.square());
    if along <= Exact::ZERO {
        start.clone()
    } else if along >= square {
        end.clone()
    } else {
        start.plus(&way.times(&(along / square)))
    }
}

/// The square of the least distance between two ways, given by their ends.
pub(crate) fn square_between(one: &[Vector; 2], other: &[Vector; 2]) -> Exact {
    let side = |[from, to]: &[Vector; 2], point: &Vector| to.minus(from).cross(&point.minus(from));
    let parts = |way: &[Vector; 2], ends: &[Vector; 2]| {
        side(way, &ends[0]) * side(way, &ends[1]) < Exact::ZERO // its ends lie on different sides
    };
    if parts(one, other) && parts(other, one) {
        return Exact::ZERO;
    }
    let from_ends = |ends: &[Vector; 2], way: &[Vector; 2]| {
        let square = |end: &Vector| nearest(end, way).minus(end).square();
        square(&ends[0]).min(square(&ends[1]))
    };
    from_ends(one, other).min(from_ends(other, one))
}
