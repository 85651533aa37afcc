//! Turns of a path moved to the corners that make them.

use glam::DVec2;
use maniple_geometry::Segment;

use crate::walls::Walls;

/// How often all turns are looked at: each moves its neighbours' best places.
const PASSES_MAX: usize = 3;

/// A turn is only moved if the path becomes shorter by this much, in world units.
const GAIN_MIN: f64 = 1.0 / 1024.0;

/// A second turn is only made if the path becomes shorter by this much: each is a command, and a change that all see.
const SPLIT_GAIN_MIN: f64 = 1.0 / 64.0;

/// The memory of passes, kept from one path to the next.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tightening {
    points: Vec<DVec2>,
}

impl Tightening {
    /// Makes a path shorter without changing on which side of things it passes; each leg stays clear.
    pub(crate) fn tighten(&mut self, walls: &Walls, room: f64, path: &mut Vec<DVec2>) {
        for _ in 0..PASSES_MAX {
            if !self.pass(walls, room, path) {
                break;
            }
        }
    }

    /// Returns whether anything changed.
    fn pass(&mut self, walls: &Walls, room: f64, path: &mut Vec<DVec2>) -> bool {
        let Some((&first, rest)) = path.split_first() else { return false };
        self.points.clear();
        self.points.push(first);
        let mut before = first;
        let mut has_changed = false;
        for turn in rest.windows(2) {
            let (via, after) = (turn[0], turn[1]);
            let Some(wall) = walls.blocker(before, after) else {
                has_changed = true;
                continue;
            };
            let better = better_turn(walls, wall, (before, via, after), room);
            has_changed |= better.is_some();
            let turn = better.unwrap_or(Turn { first: via, second: None });
            self.points.push(turn.first);
            self.points.extend(turn.second);
            before = turn.second.unwrap_or(turn.first);
        }
        self.points.extend(rest.last());
        std::mem::swap(&mut self.points, path);
        has_changed
    }
}

/// The points at which a path turns around one corner.
#[derive(Clone, Copy)]
struct Turn {
    first: DVec2,
    second: Option<DVec2>,
}

impl Turn {
    fn length(&self, before: DVec2, after: DVec2) -> f64 {
        let last = self.second.unwrap_or(self.first);
        before.distance(self.first) + self.first.distance(last) + last.distance(after)
    }

    fn is_clear(&self, walls: &Walls, before: DVec2, after: DVec2) -> bool {
        let last = self.second.unwrap_or(self.first);
        walls.is_clear(before, self.first)
            && (last == self.first || walls.is_clear(self.first, last))
            && walls.is_clear(last, after)
    }
}

/// Returns a shorter way around the wall that is between two points, on the side of `via`; `None` where none was found.
fn better_turn(
    walls: &Walls,
    wall: &Segment,
    (before, via, after): (DVec2, DVec2, DVec2),
    room: f64,
) -> Option<Turn> {
    let across = after - before;
    let side = if across.perp_dot(via - before) < 0.0 { -1.0 } else { 1.0 };
    let height = |point: DVec2| across.perp_dot(point - before) * side;
    let corner = if height(wall.end) > height(wall.start) { wall.end } else { wall.start };
    let (one, two) = around(before, after, corner, side * room)?;
    let old = Turn { first: via, second: None }.length(before, after);
    let (one_length, two_length) =
        (one.map_or(f64::INFINITY, |turn| turn.length(before, after)), two.length(before, after));
    let wanted = |gain: f64, length: f64| length < old - gain;
    let split = Some(two).filter(|_| {
        wanted(GAIN_MIN, two_length) && (one.is_none() || two_length < one_length - SPLIT_GAIN_MIN)
    });
    let single = one.filter(|_| wanted(GAIN_MIN, one_length));
    split.into_iter().chain(single).find(|turn| turn.is_clear(walls, before, after))
}

/// Returns the ways from one point to another around a corner, at a distance of `room` from it, which is negative where the
/// corner stays to the other side: with one turn (`None` where that would be behind one of the points, or far away), and
/// with two.
///
/// The line from `a` that touches the circle of radius `R` around the corner `q` leaves the line to `q` by the angle whose sine
/// is `R / |q - a|`. One turn is where the lines from both points meet; two are where both meet the tangent between
/// them, square to the line that halves the turn.
fn around(a: DVec2, b: DVec2, corner: DVec2, room: f64) -> Option<(Option<Turn>, Turn)> {
    let (from_a, from_b) = (tangent(a, corner, room)?, tangent(b, corner, -room)?);
    let outward = (from_a + from_b).normalize_or_zero();
    let reach = room.abs();
    let (slope_a, slope_b) = (from_a.dot(outward), from_b.dot(outward));
    if slope_a <= 0.0 || slope_b <= 0.0 {
        return None;
    }
    let first = a + from_a * ((reach - (a - corner).dot(outward)) / slope_a);
    let second = b + from_b * ((reach - (b - corner).dot(outward)) / slope_b);
    let cross = from_a.perp_dot(from_b);
    let along = (b - a).perp_dot(from_b) / cross;
    let back = (b - a).perp_dot(from_a) / cross;
    let one = (along > 0.0 && back > 0.0).then(|| Turn { first: a + from_a * along, second: None });
    Some((one, Turn { first, second: Some(second) }))
}

/// Returns the direction from a point along the tangent of a circle, on the side that the sign of `room` says; `None` from
/// within the circle.
fn tangent(from: DVec2, center: DVec2, room: f64) -> Option<DVec2> {
    let to = center - from;
    let distance = to.length();
    let sine = room / distance;
    let square = 1.0 - sine * sine;
    (square > 0.0).then(|| {
        let cosine = square.sqrt();
        DVec2::new(to.x * cosine - to.y * sine, to.x * sine + to.y * cosine) / distance
    })
}
