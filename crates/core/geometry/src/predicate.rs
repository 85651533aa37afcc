//! Decisions with an exact sign: an error bound first, arithmetic without rounding only where it cannot tell.
//!
//! All bounds count in `u`, the unit roundoff of `f64`: a rounded operation has a relative error of at most `u`.
//! The bounds are generous (the constants are rounded up by half and more), since all they cost is a few more
//! calls of the exact arithmetic. See Shewchuk, *Adaptive Precision Floating-Point Arithmetic and Fast Robust
//! Geometric Predicates*, 1997, for the method.

use std::cmp::Ordering;

use glam::DVec2;

use crate::exact::{Exact, ExactVector};
use crate::limits::TINY;
use crate::piece::Anchor;
use crate::scalar::{Planar, Scalar};
use crate::segment::Segment;

const U: f64 = f64::EPSILON / 2.0;

/// Returns whether two circles overlap: `|p - q| < r + s`, exactly. Touching is not overlapping.
#[inline]
#[must_use]
pub fn circles_overlap<S: Scalar>(p: S::Vector, r: S, q: S::Vector, s: S) -> bool {
    let (p, q, radii) = (p.to_dvec2(), q.to_dvec2(), (r.to_f64(), s.to_f64()));
    let (d, reach) = (q - p, radii.0 + radii.1);
    let (square, touching) = (d.dot(d), reach * reach);
    // Each of the two squares has at most 3 rounded operations behind it, and two more in the components of `d`.
    if square - touching > 8.0 * U * (square + touching) {
        return false;
    }
    Pair::new(Anchor::still(p), Anchor::still(q), radii).gap_sign() == Ordering::Less
}

/// Returns whether a circle overlaps a segment: the distance from the centre is below the radius, exactly.
/// Touching is not overlapping.
#[must_use]
pub fn circle_overlaps_segment<S: Scalar>(center: S::Vector, radius: S, segment: &Segment<S>) -> bool {
    Approach::new(Anchor::still(center.to_dvec2()), radius.to_f64(), segment).is_overlapping()
}

impl Anchor {
    pub(crate) fn still(point: DVec2) -> Self {
        Self { point, velocity: DVec2::ZERO, since: 0.0, time: 0.0 }
    }

    /// The place, rounded.
    #[inline]
    fn place(&self) -> DVec2 {
        self.point + self.velocity * (self.time - self.since)
    }

    /// A bound of the error of each component of the rounded place.
    #[inline]
    fn error(&self) -> f64 {
        if self.time == self.since || self.velocity == DVec2::ZERO {
            0.0
        } else {
            place_error(self.point, self.velocity)
        }
    }

    fn exact(&self) -> ExactVector {
        let elapsed = Exact::new(self.time) - Exact::new(self.since);
        ExactVector::new(self.point) + ExactVector::new(self.velocity).scaled(elapsed)
    }
}

/// Two circles on straight lines, at one time.
///
/// Symbols: `d` the offset from the first centre to the second, `w` the velocity of the second relative to the
/// first, `R` the sum of the radii.
pub(crate) struct Pair {
    a: Anchor,
    b: Anchor,
    radii: (f64, f64),
    d: DVec2,
    d_error: f64,
    w: DVec2,
    reach: f64,
}

impl Pair {
    #[inline]
    pub(crate) fn new(a: Anchor, b: Anchor, radii: (f64, f64)) -> Self {
        let d = b.place() - a.place();
        let d_error = a.error() + b.error() + U * norm(d);
        Self { a, b, radii, d, d_error, w: b.velocity - a.velocity, reach: radii.0 + radii.1 }
    }

    /// As [`Encounter::enters`].
    #[inline]
    pub(crate) fn enters_plainly(&self, span: f64) -> Option<bool> {
        let Self { d, w, reach, d_error, .. } = *self;
        Encounter { d, d_error, w, reach }.enters(span)
    }

    /// The sign of `d · w`: negative where the circles approach.
    pub(crate) fn approach_sign(&self) -> Ordering {
        let value = self.d.dot(self.w);
        let error = norm(self.w) * (self.d_error + 6.0 * U * norm(self.d));
        sign(value, error, || self.exact_offset().dot(self.exact_velocity()).sign())
    }

    /// The sign of `|d| - R`: negative where the circles overlap. Taken as the sign of `d² - R²`.
    pub(crate) fn gap_sign(&self) -> Ordering {
        let square = self.d.dot(self.d);
        let value = square - self.reach * self.reach;
        let error =
            4.0 * self.d_error * (norm(self.d) + self.d_error) + 6.0 * U * (square + self.reach * self.reach);
        sign(value, error, || {
            let d = self.exact_offset();
            (d.dot(d) - self.exact_reach().squared()).sign()
        })
    }

    /// The sign of `w² R² - (d × w)²`: positive where the lines bring the circles nearer than touching, at some
    /// time before or after. The form has no cancellation from afar, as `(d·w)² - w² (d² - R²)` would.
    pub(crate) fn crossing_sign(&self) -> Ordering {
        let cross = self.d.perp_dot(self.w);
        let cross_error = norm(self.w) * (self.d_error + 6.0 * U * norm(self.d));
        let square = self.w.dot(self.w) * (self.reach * self.reach);
        let value = square - cross * cross;
        let error = 12.0 * U * (square + cross * cross) + 4.0 * cross_error * (cross.abs() + cross_error);
        sign(value, error, || {
            let (d, w) = (self.exact_offset(), self.exact_velocity());
            (w.dot(w) * self.exact_reach().squared() - d.cross(w).squared()).sign()
        })
    }

    /// The sign of `v · d` for the velocity `v` of the first circle: positive where it moves towards the second.
    pub(crate) fn first_advance_sign(&self) -> Ordering {
        let value = self.a.velocity.dot(self.d);
        let error = norm(self.a.velocity) * (self.d_error + 6.0 * U * norm(self.d));
        sign(value, error, || ExactVector::new(self.a.velocity).dot(self.exact_offset()).sign())
    }

    fn exact_offset(&self) -> ExactVector {
        self.b.exact() - self.a.exact()
    }

    fn exact_velocity(&self) -> ExactVector {
        ExactVector::new(self.b.velocity) - ExactVector::new(self.a.velocity)
    }

    fn exact_reach(&self) -> Exact {
        Exact::new(self.radii.0) + Exact::new(self.radii.1)
    }
}

/// A bound of the error of each component of `point + velocity * t` for a `t` from -1 to 1, rounded and
/// [`Scalar::flushed`].
#[inline]
pub(crate) fn place_error(point: DVec2, velocity: DVec2) -> f64 {
    4.0 * U * (norm(point) + 2.0 * norm(velocity)) + TINY
}

/// Two circles on straight lines, at one time, in rounded numbers; symbols as in [`Pair`].
#[derive(Clone, Copy)]
pub(crate) struct Encounter {
    d: DVec2,
    /// A bound of the error of each component of `d`.
    d_error: f64,
    w: DVec2,
    reach: f64,
}

impl Encounter {
    /// Of two circles whose places have errors of at most `error` in all.
    #[inline]
    pub(crate) fn new(d: DVec2, w: DVec2, error: f64, reach: f64) -> Self {
        Self { d, d_error: error + U * norm(d), w, reach }
    }

    /// As [`Encounter::verdict`]; `None` where rounded numbers cannot tell.
    #[inline]
    pub(crate) fn enters(self, span: f64) -> Option<bool> {
        let Verdict { enters, stays_away } = self.verdict(span);
        (enters | stays_away).then_some(enters)
    }

    /// Whether the circles come nearer than touching within `span` from now on, both on their lines: `d · w < 0` and
    /// `w² R² > (d × w)²`, and at the end `(d + w s) · w >= 0` or `|d + w s| < R`.
    ///
    /// Everything is computed before anything is decided: which of the conditions fails cannot be guessed.
    #[inline]
    pub(crate) fn verdict(self, span: f64) -> Verdict {
        let Self { d, w, reach, d_error } = self;
        let (d_norm, w_norm) = (norm(d), norm(w));
        let (approach, cross, square) = (d.dot(w), d.perp_dot(w), w.dot(w));
        let product_error = w_norm * (d_error + 6.0 * U * d_norm);
        let (swept, missed) = (square * (reach * reach), cross * cross);
        let crossing = swept - missed;
        let crossing_error =
            12.0 * U * (swept + missed) + 4.0 * product_error * (cross.abs() + product_error);
        let after = approach + square * span;
        let after_error = product_error + 8.0 * U * square * span;
        let end = d + w * span;
        let end_error = d_error + 6.0 * U * (d_norm + w_norm * span);
        let end_square = end.dot(end);
        let gap = end_square - reach * reach;
        let gap_error = 4.0 * end_error * (norm(end) + end_error) + 6.0 * U * (end_square + reach * reach);
        Verdict {
            enters: (approach < -product_error)
                & (crossing > crossing_error)
                & ((after > after_error) | (gap < -gap_error)),
            // A square of the relative velocity cannot underflow, so it is zero only where the circles go in step.
            stays_away: (approach > product_error)
                | (crossing < -crossing_error)
                | ((after < -after_error) & (gap > gap_error))
                | (square == 0.0),
        }
    }
}

/// What rounded numbers say about an encounter; if neither holds, they cannot tell.
#[derive(Clone, Copy)]
pub(crate) struct Verdict {
    pub(crate) enters: bool,
    pub(crate) stays_away: bool,
}

/// A circle that passes a segment, in rounded numbers, for as long as its feet stay in one of the three parts of the plane
/// beside the segment: before its start, along it, behind its end. Symbols as in [`Approach`].
#[derive(Clone, Copy)]
pub(crate) struct Passage {
    start: Anchor,
    span: f64,
    ends: (DVec2, DVec2),
}

impl Passage {
    /// From an anchor on, for a time `span`.
    #[inline]
    pub(crate) fn new<S: Scalar>(start: Anchor, span: f64, segment: &Segment<S>) -> Self {
        Self { start, span, ends: (segment.start.to_dvec2(), segment.end.to_dvec2()) }
    }

    /// Whether the circle comes nearer than touching. `None` where rounded numbers cannot tell, the feet go from one part to
    /// another, or the circle does not plainly stay off the segment at the start.
    ///
    /// Along the segment it does if `e × q`, from its side at the start, falls below `r |e|`; else where it comes nearer
    /// than touching to the end beside which it is.
    #[inline]
    pub(crate) fn enters(self, radius: f64) -> Option<bool> {
        let (place, error) = (self.start.place(), self.start.error());
        let way = self.start.velocity * self.span;
        let e = self.ends.1 - self.ends.0;
        // Beside the segment, since its rounding there is that of the offset and not that of the world's coordinates.
        let before = place - self.ends.0;
        let after = before + way;
        let product_error = norm(e) * (error + 16.0 * U * (norm(before) + norm(way)));
        let square = e.dot(e);
        let feet = (e.dot(before), e.dot(after));
        let (least, most) = if feet.0 < feet.1 { feet } else { (feet.1, feet.0) };
        if most < -product_error {
            return self.enters_end(self.ends.0, (place, error), radius);
        }
        if least > square * (1.0 + 8.0 * U) + product_error {
            return self.enters_end(self.ends.1, (place, error), radius);
        }
        let sides = (e.perp_dot(before), e.perp_dot(after));
        let touching = radius * square.sqrt();
        let is_along = (least > product_error)
            & (most < square * (1.0 - 8.0 * U) - product_error)
            & (sides.0.abs() > touching + product_error + 8.0 * U * touching);
        let depth = touching - if sides.0 > 0.0 { sides.1 } else { -sides.1 };
        let depth_error = product_error + 8.0 * U * touching;
        (is_along & (depth.abs() > depth_error)).then_some(depth > 0.0)
    }

    #[inline]
    fn enters_end(&self, end: DVec2, (place, error): (DVec2, f64), radius: f64) -> Option<bool> {
        Encounter::new(end - place, -self.start.velocity, error, radius).enters(self.span)
    }
}

/// A circle beside a segment, at one time.
///
/// Symbols: `e` the segment from its start to its end, `q` the offset from its start to the centre, `r` the
/// radius. `e × q` is the distance from the line times `|e|`, `e · q` the foot's place times `|e|`.
pub(crate) struct Approach {
    center: Anchor,
    radius: f64,
    start: DVec2,
    end: DVec2,
}

impl Approach {
    pub(crate) fn new<S: Scalar>(center: Anchor, radius: f64, segment: &Segment<S>) -> Self {
        Self { center, radius, start: segment.start.to_dvec2(), end: segment.end.to_dvec2() }
    }

    /// Whether the distance to the segment is below the radius.
    pub(crate) fn is_overlapping(&self) -> bool {
        if self.foot_sign(self.start, self.end) != Ordering::Greater {
            return self.end_gap_sign(self.start) == Ordering::Less;
        }
        if self.foot_sign(self.end, self.start) != Ordering::Greater {
            return self.end_gap_sign(self.end) == Ordering::Less;
        }
        self.line_gap_sign() == Ordering::Less
    }

    /// The sign of `e × q`: on which side of the line the centre is.
    pub(crate) fn side_sign(&self) -> Ordering {
        let (e, q) = (self.end - self.start, self.center.place() - self.start);
        sign(e.perp_dot(q), self.product_error(e, q), || self.exact_cross().sign())
    }

    /// The sign of `(to - from) · (p - from)` for the centre `p`: positive where the foot lies beyond `from`.
    fn foot_sign(&self, from: DVec2, to: DVec2) -> Ordering {
        let (e, q) = (to - from, self.center.place() - from);
        sign(e.dot(q), self.product_error(e, q), || {
            let from = ExactVector::new(from);
            (ExactVector::new(to) - from).dot(self.center.exact() - from).sign()
        })
    }

    fn end_gap_sign(&self, end: DVec2) -> Ordering {
        Pair::new(self.center, Anchor::still(end), (self.radius, 0.0)).gap_sign()
    }

    /// The sign of `(e × q)² - r² e²`.
    fn line_gap_sign(&self) -> Ordering {
        let (e, q) = (self.end - self.start, self.center.place() - self.start);
        let cross = e.perp_dot(q);
        let cross_error = self.product_error(e, q);
        let square = self.radius * self.radius * e.dot(e);
        let value = cross * cross - square;
        let error = 12.0 * U * (square + cross * cross) + 4.0 * cross_error * (cross.abs() + cross_error);
        sign(value, error, || {
            let e = ExactVector::new(self.end) - ExactVector::new(self.start);
            (self.exact_cross().squared() - Exact::new(self.radius).squared() * e.dot(e)).sign()
        })
    }

    fn product_error(&self, e: DVec2, q: DVec2) -> f64 {
        norm(e) * (self.center.error() + 8.0 * U * norm(q))
    }

    fn exact_cross(&self) -> Exact {
        let start = ExactVector::new(self.start);
        (ExactVector::new(self.end) - start).cross(self.center.exact() - start)
    }
}

/// The sign of `(b - a) × (c - a)` for the straight way from `a` along `velocity`: on which side of it `c` lies.
pub(crate) fn side_of_way(way: &Anchor, c: DVec2) -> Ordering {
    let q = c - way.place();
    let error = norm(way.velocity) * (way.error() + 8.0 * U * norm(q));
    sign(way.velocity.perp_dot(q), error, || {
        ExactVector::new(way.velocity).cross(ExactVector::new(c) - way.exact()).sign()
    })
}

fn sign(value: f64, error: f64, exact: impl FnOnce() -> Ordering) -> Ordering {
    if value > error {
        Ordering::Greater
    } else if value < -error {
        Ordering::Less
    } else {
        exact()
    }
}

/// `|x| + |y|`, an upper bound of the length that is cheap and has a relative error of `u`.
fn norm(vector: DVec2) -> f64 {
    vector.x.abs() + vector.y.abs()
}
