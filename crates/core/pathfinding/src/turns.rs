//! From corners that a way goes around, one after the other, to the points at which its legs turn.

use glam::DVec2;
use maniple_geometry::Scalar;

/// Cosine of the largest angle that is turned at once, 60 degrees: around a corner, two turns of half the angle are a
/// quarter as far from the arc, but each is a command, and a change that all see.
const TURN_COSINE_MIN: f64 = 0.5;

/// Sine of the smallest angle at which two lines have a place where they meet.
const TURN_SINE_MIN: f64 = 1e-6;

/// A corner that a way goes around.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pass {
    pub(crate) corner: DVec2,
    /// How far from the corner the way keeps, in world units: positive where the corner lies to the left of the way as a map shows
    /// it, with y pointing down, and negative where it lies to the right.
    pub(crate) room: f64,
}

/// A straight line.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    pub(crate) point: DVec2,
    /// The unit vector along it.
    pub(crate) direction: DVec2,
}

/// The turns of a way around corners.
#[derive(Clone, Debug, Default)]
pub(crate) struct Turns {
    pub(crate) points: Vec<DVec2>,
    /// For each leg the number of its line, the one to the corner of that number; `None` for a leg that cuts a corner's angle in two.
    pub(crate) lines: Vec<Option<usize>>,
}

impl Turns {
    /// Puts the turns of a way between two points around corners; returns whether its lines meet one after the other.
    pub(crate) fn lay(&mut self, (before, after): (DVec2, DVec2), passes: &[Pass]) -> bool {
        self.points.clear();
        self.lines.clear();
        let mut last = before;
        for (index, &pass) in passes.iter().enumerate() {
            let to = match index.checked_sub(1) {
                None => Some(line_to(before, pass)),
                Some(index) => line_between(passes[index], pass),
            };
            let from = match passes.get(index + 1) {
                None => Some(line_from(pass, after)),
                Some(&next) => line_between(pass, next),
            };
            let (Some(to), Some(from)) = (to, from) else { return false };
            let (first, second) = meeting(to, from, pass);
            if (first - last).dot(to.direction) < 0.0 {
                return false;
            }
            self.points.push(first);
            self.lines.push(Some(index));
            if second != first {
                self.points.push(second);
                self.lines.push(None);
            }
            last = second;
            let is_end = index + 1 == passes.len();
            if is_end && (after - last).dot(from.direction) < 0.0 {
                return false;
            }
        }
        self.lines.push(Some(passes.len()));
        true
    }

    /// Returns the ends of each leg, and the number of its line.
    pub(crate) fn legs(
        &self,
        before: DVec2,
        after: DVec2,
    ) -> impl Iterator<Item = (DVec2, DVec2, Option<usize>)> {
        let starts = std::iter::once(before).chain(self.points.iter().copied());
        let ends = self.points.iter().copied().chain(std::iter::once(after));
        starts.zip(ends).zip(&self.lines).map(|((from, to), &line)| (from, to, line))
    }

    /// Returns how long the way is, in world units.
    pub(crate) fn length(&self, before: DVec2, after: DVec2) -> f64 {
        length(before, &self.points, after)
    }
}

/// Returns how long a way by some turns is, in world units.
pub(crate) fn length(before: DVec2, turns: &[DVec2], after: DVec2) -> f64 {
    let mut last = before;
    let mut sum = 0.0;
    for &turn in turns.iter().chain(std::iter::once(&after)) {
        sum += last.distance(turn);
        last = turn;
    }
    sum
}

/// Returns the line from a point that touches the circle around a corner, through the place where it touches.
///
/// It leaves the line to the middle by the angle whose sine is the radius over the distance. Ends of paths may be nearer to a corner
/// than turns are placed, by less than the margin: there the line touches a circle through the end itself.
pub(crate) fn line_to(from: DVec2, pass: Pass) -> Line {
    let to = pass.corner - from;
    let distance = to.length();
    let sine = (pass.room / distance).lesser(1.0).greater(-1.0);
    let cosine = (1.0 - sine * sine).sqrt();
    let direction = DVec2::new(to.x * cosine - to.y * sine, to.x * sine + to.y * cosine) / distance;
    Line { point: from + direction * (distance * cosine), direction }
}

/// Returns the line to a point that touches the circle around a corner, through the place where it touches.
pub(crate) fn line_from(pass: Pass, to: DVec2) -> Line {
    let turned = line_to(to, Pass { room: -pass.room, ..pass });
    Line { direction: -turned.direction, ..turned }
}

/// Returns the line that touches the circles around two corners, through the place where it touches the second; `None` where
/// one would have to go between circles that overlap.
///
/// With the unit `u` from one corner to the other and `v` across it, the normal of the line is `u s + v √(1 - s²)`, where
/// `s` is the difference of the signed radii over the distance.
pub(crate) fn line_between(last: Pass, next: Pass) -> Option<Line> {
    let offset = next.corner - last.corner;
    let distance = offset.length();
    let along = (last.room - next.room) / distance;
    let square = 1.0 - along * along;
    (square > 0.0).then(|| {
        let unit = offset / distance;
        let normal = unit * along + unit.perp() * square.sqrt();
        Line { point: next.corner + normal * next.room, direction: -normal.perp() }
    })
}

/// Returns where a way turns from one line to another around a corner: where they meet, twice, or for a wide turn where
/// both meet the tangent that is square to the line that halves it.
pub(crate) fn meeting(to: Line, from: Line, pass: Pass) -> (DVec2, DVec2) {
    let sine = to.direction.perp_dot(from.direction);
    let cosine = to.direction.dot(from.direction);
    if cosine < TURN_COSINE_MIN {
        let outward = (to.direction - from.direction).normalize_or_zero();
        let reach = pass.room.abs();
        let at = |line: Line| {
            let missing = reach - (line.point - pass.corner).dot(outward);
            line.point + line.direction * (missing / line.direction.dot(outward))
        };
        return (at(to), at(from));
    }
    if sine.abs() < TURN_SINE_MIN {
        let touch = pass.corner + to.direction.perp() * pass.room;
        return (touch, touch);
    }
    let along = (from.point - to.point).perp_dot(from.direction) / sine;
    let point = to.point + to.direction * along;
    (point, point)
}

/// Returns how much longer the legs of a turn around a corner are than what of them lies before the first place where they touch, and
/// behind the last one, in world units.
///
/// A leg that turns by `a` goes `2 r tan(a/2)` beyond these places; two turns of half the angle `4 r tan(a/4)`. Tangents of
/// halves are sines over one more than cosines.
pub(crate) fn turn_length(to: DVec2, from: DVec2, room: f64) -> f64 {
    let cosine = to.dot(from);
    if cosine >= TURN_COSINE_MIN {
        return 2.0 * room.abs() * to.perp_dot(from).abs() / (1.0 + cosine);
    }
    let square = (0.5 + 0.5 * cosine).greater(0.0);
    4.0 * room.abs() * (1.0 - square).sqrt() / (1.0 + square.sqrt())
}
