//! Whether and when moving circles collide with circles and segments.
//!
//! Whether they do is decided exactly. The time is rounded; it is the time at which the circle is a *skin* above
//! touching, so that its error, far below the skin, can never turn into an overlap.

use std::cmp::Ordering;

use crate::piece::Piece;
use crate::predicate::{Approach, Encounter, Pair, Passage, Verdict, place_error, side_of_way};
use crate::scalar::{Planar, Scalar};
use crate::segment::Segment;

/// A circle on a straight piece of its way.
#[derive(Clone, Copy, Debug)]
pub struct Mover<'a, S: Scalar = f64> {
    /// The way.
    pub piece: &'a Piece<S>,
    /// World units.
    pub radius: S,
}

/// A part of a cycle, and how far above touching a collision counts.
#[derive(Clone, Copy, Debug)]
pub struct Window<S: Scalar = f64> {
    /// When it begins, as a fraction of the cycle.
    pub from: S,
    /// When it ends.
    pub to: S,
    /// World units.
    pub skin: S,
}

/// Returns when two circles collide in a window in which both pieces hold, as a fraction of the cycle; swapping
/// the circles gives the same bits.
///
/// `None` means that they never come nearer than touching in that time: they stay apart, touch, slide along each
/// other or move apart. Otherwise it is the time at which `R + skin` lies between the centres, with the sum of the
/// radii `R`; or `from` where they are as near as that, or a skin more, already.
///
/// Solves `|d + w t| = R + skin` for the smaller `t`, with the offset `d` and relative velocity `w`, as
/// `t = c / (sqrt(w² (R + skin)² - (d × w)²) - d·w)` with `c = d² - (R + skin)²`: no nearly equal numbers are
/// subtracted but in `c`, where that is harmless (Press et al., *Numerical Recipes*, 3rd ed., §5.6, with the
/// discriminant in its cross-product form).
#[doc(alias = "time_of_impact")]
#[doc(alias = "contact")]
#[doc(alias = "impact")]
#[must_use]
pub fn circle_contact<S: Scalar>(a: Mover<'_, S>, b: Mover<'_, S>, window: Window<S>) -> Option<S> {
    let Window { from, to, skin } = window;
    let w = b.piece.velocity - a.piece.velocity;
    if w == S::Vector::zero() {
        return None;
    }
    let d = offset(a.piece, b.piece, from);
    enters(a, b, window).then(|| bounded(from + entry(d, w, (a.radius + b.radius + skin, skin)), to))
}

/// A circle that goes straight on for the rest of a cycle, or rests.
#[derive(Clone, Copy, Debug)]
pub struct Straight<S: Scalar = f64> {
    /// Where the centre is, or would have been, when the cycle begins.
    pub point: S::Vector,
    /// World units a cycle.
    pub velocity: S::Vector,
    /// World units.
    pub radius: S,
}

impl<S: Scalar> Straight<S> {
    /// The centre at a time, rounded.
    #[inline]
    fn position(&self, time: S) -> S::Vector {
        if time == S::ZERO { self.point } else { (self.point + self.velocity * time).flushed() }
    }

    /// The same as a piece.
    fn piece(&self) -> Piece<S> {
        Piece { point: self.point, velocity: self.velocity, since: S::ZERO, until: S::ONE, goal: None }
    }
}

/// As [`circle_contact`] for two circles that go straight on for the whole cycle: the same bits with less ado.
#[inline]
#[must_use]
pub fn straight_contact<S: Scalar>(a: &Straight<S>, b: &Straight<S>, skin: S) -> Option<S> {
    let enters = encounter_of(a, b).enters(1.0).unwrap_or_else(|| enters_exactly_straight(a, b, S::ZERO));
    let (d, w) = (b.point - a.point, b.velocity - a.velocity);
    enters.then(|| bounded(entry(d, w, (a.radius + b.radius + skin, skin)), S::ONE))
}

/// Two circles that go straight on, at the start of the cycle.
#[inline]
fn encounter_of<S: Scalar>(a: &Straight<S>, b: &Straight<S>) -> Encounter {
    let d = b.point.to_dvec2() - a.point.to_dvec2();
    let w = b.velocity.to_dvec2() - a.velocity.to_dvec2();
    Encounter::new(d, w, 0.0, a.radius.to_f64() + b.radius.to_f64())
}

/// How many pairs [`Couples`] holds.
pub const COUPLES: usize = 16;

/// Pairs of circles that go straight on for the whole cycle, as arrays of their fields.
#[derive(Clone, Debug)]
pub struct Couples<S: Scalar = f64> {
    ones: Fields<S>,
    others: Fields<S>,
}

#[derive(Clone, Debug)]
struct Fields<S: Scalar> {
    xs: [S; COUPLES],
    ys: [S; COUPLES],
    velocity_xs: [S; COUPLES],
    velocity_ys: [S; COUPLES],
    radii: [S; COUPLES],
}

impl<S: Scalar> Default for Couples<S> {
    fn default() -> Self {
        Self { ones: Fields::new(), others: Fields::new() }
    }
}

impl<S: Scalar> Couples<S> {
    /// Puts a pair into a place.
    #[inline]
    pub fn set(&mut self, place: usize, a: &Straight<S>, b: &Straight<S>) {
        self.ones.set(place, a);
        self.others.set(place, b);
    }

    /// Returns the [`glance`] at each pair.
    #[inline]
    pub fn glance(&self, skins: (S, S), glances: &mut [Glance<S>; COUPLES]) {
        let mut times = [S::ZERO; COUPLES];
        let mut flags = [0u64; COUPLES];
        for place in 0..COUPLES {
            let glance = glance(&self.ones.at(place), &self.others.at(place), skins);
            times[place] = glance.time;
            flags[place] = u64::from(glance.is_sure) | u64::from(glance.ends_near) << 1;
        }
        for (glance, (time, flags)) in glances.iter_mut().zip(times.into_iter().zip(flags)) {
            *glance = Glance { time, is_sure: flags & 1 != 0, ends_near: flags & 2 != 0 };
        }
    }
}

impl<S: Scalar> Fields<S> {
    fn new() -> Self {
        let zeros = [S::ZERO; COUPLES];
        Self { xs: zeros, ys: zeros, velocity_xs: zeros, velocity_ys: zeros, radii: zeros }
    }

    #[inline]
    fn set(&mut self, place: usize, straight: &Straight<S>) {
        self.xs[place] = straight.point.x();
        self.ys[place] = straight.point.y();
        self.velocity_xs[place] = straight.velocity.x();
        self.velocity_ys[place] = straight.velocity.y();
        self.radii[place] = straight.radius;
    }

    #[inline]
    fn at(&self, place: usize) -> Straight<S> {
        Straight {
            point: S::Vector::new(self.xs[place], self.ys[place]),
            velocity: S::Vector::new(self.velocity_xs[place], self.velocity_ys[place]),
            radius: self.radii[place],
        }
    }
}

/// What rounded numbers alone say of two circles that go straight on for the whole cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Glance<S: Scalar = f64> {
    /// When they collide, to the bit, as a fraction of the cycle; infinity if they do not.
    pub time: S,
    /// Whether that is certain. If not, [`straight_contact`] has to be asked.
    pub is_sure: bool,
    /// Whether less than the margin is between them at the end of the cycle, if both go on so long.
    pub ends_near: bool,
}

/// As [`straight_contact`], as far as rounded numbers tell, and without a branch: in a crowd nobody can guess who collides.
/// `margin`, in world units, says what is near.
#[inline]
#[must_use]
pub fn glance<S: Scalar>(a: &Straight<S>, b: &Straight<S>, (skin, margin): (S, S)) -> Glance<S> {
    let (d, w) = (b.point - a.point, b.velocity - a.velocity);
    let verdict = encounter_of(a, b).verdict(1.0);
    let reach = a.radius + b.radius + skin;
    let time = bounded(entry(d, w, (reach, skin)), S::ONE);
    let (end, near) = (d + w, a.radius + b.radius + margin);
    Glance {
        time: if verdict.enters { time } else { S::INFINITY },
        is_sure: verdict.enters | verdict.stays_away,
        ends_near: end.dot(end) < near * near,
    }
}

/// As [`circle_contact`] for a circle at rest and one that goes straight on from a time to the end of the cycle; the
/// velocity of the first is not looked at. Infinity if they do not collide.
#[inline]
#[must_use]
pub fn still_contact<S: Scalar>(still: &Straight<S>, b: &Straight<S>, (from, skin): (S, S)) -> S {
    let (d, w) = (b.position(from) - still.point, b.velocity);
    let (point, velocity) = (b.point.to_dvec2(), b.velocity.to_dvec2());
    let encounter = Encounter::new(
        point + velocity * from.to_f64() - still.point.to_dvec2(),
        velocity,
        place_error(point, velocity),
        still.radius.to_f64() + b.radius.to_f64(),
    );
    let Verdict { mut enters, stays_away } = encounter.verdict(span(from, S::ONE));
    let time = bounded(from + entry(d, w, (still.radius + b.radius + skin, skin)), S::ONE);
    if !(enters | stays_away) {
        enters = enters_exactly_straight(&Straight { velocity: S::Vector::zero(), ..*still }, b, from);
    }
    if enters { time } else { S::INFINITY }
}

#[cold]
#[inline(never)]
fn enters_exactly_straight<S: Scalar>(a: &Straight<S>, b: &Straight<S>, from: S) -> bool {
    let pieces = (a.piece(), b.piece());
    let movers = (Mover { piece: &pieces.0, radius: a.radius }, Mover { piece: &pieces.1, radius: b.radius });
    enters_exactly(movers.0, movers.1, (from, S::ONE))
}

/// Returns when a moving circle collides with a segment in a window in which the piece holds, as a fraction of the
/// cycle.
///
/// `None` means that it never comes nearer than touching in that time. Otherwise it is the time at which its
/// centre is the radius plus the skin from the segment, or `from` where it is as near as that, or a skin more, already.
#[must_use]
pub fn segment_contact<S: Scalar>(
    circle: Mover<'_, S>,
    segment: &Segment<S>,
    window: Window<S>,
) -> Option<S> {
    let Window { from, to, skin } = window;
    let piece = circle.piece;
    if !piece.is_moving() {
        return None;
    }
    let start = piece.position(from);
    let way = piece.velocity * (to - from);
    let reach = circle.radius + skin;
    if is_far_from_segment(start, way, segment, reach + skin) {
        return None;
    }
    let plain = if piece.ends_in_goal(to) {
        None
    } else {
        let radius = circle.radius.to_f64();
        Passage::new(piece.on_line(from), span(from, to), segment).enters(radius)
    };
    let collides = plain.unwrap_or_else(|| enters_segment_exactly(circle, segment, window));
    collides.then(|| bounded(from + segment_entry(start, piece.velocity, segment, (reach, skin)), to))
}

/// Whether a circle that moves comes nearer to a segment than touching.
///
/// The distance from a segment is a convex function of time. Where the way of the centre does not cross the
/// segment, that distance has its smallest value at an end of the window or beside an end of the segment, so
/// four exact decisions settle it.
#[cold]
#[inline(never)]
fn enters_segment_exactly<S: Scalar>(circle: Mover<'_, S>, segment: &Segment<S>, window: Window<S>) -> bool {
    let Window { from, to, .. } = window;
    let piece = circle.piece;
    let ends = [segment.start, segment.end].map(|end| Piece::at_rest(end, from, to));
    let enters_end = |end| enters(circle, Mover { piece: end, radius: S::ZERO }, window);
    let overlaps_at =
        |time| Approach::new(piece.anchored(time), circle.radius.to_f64(), segment).is_overlapping();
    let enters_flat = || {
        overlaps_at(to)
            && (!overlaps_at(from) || is_approaching(piece.position(from), piece.velocity, segment))
    };
    ends.iter().any(enters_end) || enters_flat() || crosses(piece, segment, window)
}

/// Returns whether the first of two circles moves towards the second at a time: `v · d > 0`, exactly, for its
/// velocity `v` and the offset `d` of the centres.
#[must_use]
pub fn is_advancing<S: Scalar>(first: &Piece<S>, second: &Piece<S>, time: S) -> bool {
    let pair = Pair::new(first.anchored(time), second.anchored(time), (0.0, 0.0));
    pair.first_advance_sign() == Ordering::Greater
}

/// Whether two circles that do not overlap when the window begins come nearer than touching until it ends.
///
/// They do if they approach, their lines cross, and either the nearest point of the lines lies in the window or they
/// overlap at its end.
#[inline]
fn enters<S: Scalar>(a: Mover<'_, S>, b: Mover<'_, S>, window: Window<S>) -> bool {
    let Window { from, to, .. } = window;
    let radii = (a.radius.to_f64(), b.radius.to_f64());
    if !a.piece.ends_in_goal(to) && !b.piece.ends_in_goal(to) {
        let before = Pair::new(a.piece.on_line(from), b.piece.on_line(from), radii);
        if let Some(enters) = before.enters_plainly(span(from, to)) {
            return enters;
        }
    }
    enters_exactly(a, b, (from, to))
}

#[cold]
#[inline(never)]
fn enters_exactly<S: Scalar>(a: Mover<'_, S>, b: Mover<'_, S>, (from, to): (S, S)) -> bool {
    let radii = (a.radius.to_f64(), b.radius.to_f64());
    let before = Pair::new(a.piece.anchored(from), b.piece.anchored(from), radii);
    if before.approach_sign() != Ordering::Less || before.crossing_sign() != Ordering::Greater {
        return false;
    }
    let on_lines = Pair::new(a.piece.on_line(to), b.piece.on_line(to), radii);
    let after = Pair::new(a.piece.anchored(to), b.piece.anchored(to), radii);
    on_lines.approach_sign() != Ordering::Less || after.gap_sign() == Ordering::Less
}

/// The smaller root of `|d + w t| = reach`, or zero where `|d|` is within reach and `slack` more; the lines are known to
/// enter.
///
/// Who stopped at that distance is there up to rounding, which must not decide who comes first: with the slack all of them
/// collide at once, and are resolved together.
#[inline]
fn entry<S: Scalar>(d: S::Vector, w: S::Vector, (reach, slack): (S, S)) -> S {
    let square = d.dot(d);
    let at_once = reach + slack;
    let cross = d.cross(w);
    let discriminant = (w.dot(w) * (reach * reach) - cross * cross).greater(S::ZERO);
    let time = (square - reach * reach) / (discriminant.sqrt() - d.dot(w));
    if square <= at_once * at_once { S::ZERO } else { time }
}

/// When the centre is first within reach of the segment; it is known to get there.
fn segment_entry<S: Scalar>(
    start: S::Vector,
    velocity: S::Vector,
    segment: &Segment<S>,
    (reach, slack): (S, S),
) -> S {
    let at_once = reach + slack;
    let e = segment.direction();
    let length = e.length();
    let q = start - segment.start;
    let (side, foot) = (e.cross(q), e.dot(q));
    let beside = S::ZERO <= foot && foot <= e.dot(e);
    if beside && side.abs() <= at_once * length {
        return S::ZERO;
    }
    let mut first: Option<S> = None;
    let mut consider = |time: S| first = Some(first.map_or(time, |other: S| other.lesser(time)));
    // The flat sides: |e × (q + v t)| = reach |e|, with the foot on the segment.
    let closing = e.cross(velocity) * if side < S::ZERO { S::ONE } else { -S::ONE };
    if closing > S::ZERO {
        let time = (side.abs() - reach * length) / closing;
        let foot = foot + e.dot(velocity) * time;
        if S::ZERO <= time && S::ZERO <= foot && foot <= e.dot(e) {
            consider(time);
        }
    }
    for end in [segment.start, segment.end] {
        let d = end - start;
        let w = -velocity;
        let cross = d.cross(w);
        let is_hit = w.dot(w) * (reach * reach) >= cross * cross && d.dot(w) < S::ZERO;
        if d.dot(d) <= at_once * at_once || is_hit {
            consider(entry(d, w, (reach, slack)));
        }
    }
    // Rounding can hide every entry of a graze; the circle then stops where it is, which is always allowed.
    first.unwrap_or(S::ZERO)
}

/// Whether the way of the centre crosses the segment within the window.
fn crosses<S: Scalar>(piece: &Piece<S>, segment: &Segment<S>, window: Window<S>) -> bool {
    let before = Approach::new(piece.anchored(window.from), 0.0, segment).side_sign();
    let after = Approach::new(piece.anchored(window.to), 0.0, segment).side_sign();
    if before == after || before == Ordering::Equal {
        return false;
    }
    let way = piece.anchored(window.from);
    side_of_way(&way, segment.start.to_dvec2()) != side_of_way(&way, segment.end.to_dvec2())
}

/// Whether the distance to the segment falls at the start: asked of a circle that a rounded turn has put an ulp too
/// near, which must be free to go away. The distance is convex, so what does not fall at the start never does.
fn is_approaching<S: Scalar>(start: S::Vector, velocity: S::Vector, segment: &Segment<S>) -> bool {
    (segment.nearest(start) - start).dot(velocity) > S::ZERO
}

fn offset<S: Scalar>(a: &Piece<S>, b: &Piece<S>, time: S) -> S::Vector {
    b.position(time) - a.position(time)
}

/// Whether the boxes of a way and of a segment are further apart than `reach`.
fn is_far_from_segment<S: Scalar>(start: S::Vector, way: S::Vector, segment: &Segment<S>, reach: S) -> bool {
    let apart = |from: S, step: S, s: S, t: S| {
        let to = from + step;
        from.lesser(to) > s.greater(t) + reach || from.greater(to) < s.lesser(t) - reach
    };
    apart(start.x(), way.x(), segment.start.x(), segment.end.x())
        || apart(start.y(), way.y(), segment.start.y(), segment.end.y())
}

/// How long it is from one time to another, rounded as `f64` in every scalar, which the bounds of the decisions count on.
fn span<S: Scalar>(from: S, to: S) -> f64 {
    to.to_f64() - from.to_f64()
}

fn bounded<S: Scalar>(time: S, to: S) -> S {
    time.lesser(to).flushed()
}
