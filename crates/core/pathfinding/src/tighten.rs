//! Turns of a path moved to the corners that make them.

use glam::DVec2;
use maniple_geometry::Segment;

use crate::walls::Walls;

/// How often all turns are looked at: each moves its neighbours' best places.
const PASSES_MAX: usize = 3;

/// How many corners one turn can be made of, and how often another is looked for.
const CORNERS_MAX: usize = 6;

/// A turn is only moved if the path becomes shorter by this much, in world units.
const GAIN_MIN: f64 = 1.0 / 1024.0;

/// Cosine of the largest angle that is turned at once, 60 degrees: around a corner, two turns of half the angle are a
/// quarter as far from the arc, but each is a command, and a change that all see.
const TURN_COSINE_MIN: f64 = 0.5;

/// Sine of the smallest angle at which two lines have a place where they meet.
const TURN_SINE_MIN: f64 = 1e-6;

/// The memory of passes, kept from one path to the next.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tightening {
    points: Vec<DVec2>,
    bend: Bend,
}

impl Tightening {
    /// Makes a path shorter; each leg stays clear. `room` is how far from
    /// corners it turns, in world units.
    pub(crate) fn tighten(&mut self, walls: &Walls, room: f64, path: &mut Vec<DVec2>) {
        for _ in 0..PASSES_MAX {
            if !self.pass(walls, room, path) {
                break;
            }
        }
        // Steps of eight directions may have led to the wrong side of something; for a whole path that is one bend, the other
        // side is as easily tried.
        if let &[first, ref turns @ .., last] = &path[..]
            && !turns.is_empty()
            && self.bend.find(walls, (first, turns, last), room)
        {
            path.truncate(1);
            path.extend_from_slice(&self.bend.turns);
            path.push(last);
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
            if self.bend.find(walls, (before, &[via], after), room) {
                self.points.extend_from_slice(&self.bend.turns);
                has_changed = true;
            } else if let &[.., last, _] = &self.points[..]
                && self.bend.find(walls, (last, &[before, via], after), room)
            {
                // Corners that belong to one hull had been shared out to two turns.
                self.points.pop();
                self.points.extend_from_slice(&self.bend.turns);
                has_changed = true;
            } else {
                self.points.push(via);
            }
            before = self.points[self.points.len() - 1];
        }
        self.points.extend(rest.last());
        std::mem::swap(&mut self.points, path);
        has_changed
    }
}

/// The shortest way between two points that leaves what is between them to one side.
///
/// Such a way is the hull of the corners between the points: it goes along the tangent of the first corner's circle, along
/// lines that touch two circles, and along the tangent of the last one. Legs turn where two such lines meet.
#[derive(Clone, Debug, Default)]
struct Bend {
    corners: Vec<DVec2>,
    turns: Vec<DVec2>,
    /// For each leg the number of its line; `None` for one that cuts a corner's angle in two.
    lines: Vec<Option<usize>>,
}

/// A straight line.
#[derive(Clone, Copy)]
struct Line {
    point: DVec2,
    direction: DVec2,
}

impl Bend {
    /// Finds turns between two points that are shorter than the old ones, on the same side or else on the other one, and
    /// returns whether there are any. Where the straight way is clear, there are none on it.
    fn find(&mut self, walls: &Walls, way: (DVec2, &[DVec2], DVec2), room: f64) -> bool {
        let (before, old, after) = way;
        let last = old.last().copied().unwrap_or(before);
        let side = if (after - before).perp_dot(last - before) < 0.0 { -1.0 } else { 1.0 };
        let length = length(before, old, after);
        [side, -side].into_iter().any(|side| self.find_beside(walls, (before, after), (side, room), length))
    }

    /// Finds turns that leave everything to one side.
    ///
    /// Corners are found one by one: a leg that is not clear meets a wall whose end belongs to the hull.
    fn find_beside(
        &mut self,
        walls: &Walls,
        (before, after): (DVec2, DVec2),
        (side, room): (f64, f64),
        old: f64,
    ) -> bool {
        self.corners.clear();
        for _ in 0..=CORNERS_MAX {
            if !self.lay((before, after), side * room) {
                return false;
            }
            // More corners only make it longer.
            if !self.turns.is_empty() && length(before, &self.turns, after) > old - GAIN_MIN {
                return false;
            }
            let Some((leg, wall)) = self.blocked(walls, before, after) else { return true };
            if !self.insert(leg, wall, (before, after), side) {
                return false;
            }
        }
        false
    }

    /// Puts the turns around the corners; returns whether the lines meet one after the other.
    fn lay(&mut self, ends: (DVec2, DVec2), room: f64) -> bool {
        self.turns.clear();
        self.lines.clear();
        let mut last = ends.0;
        for index in 0..self.corners.len() {
            let (Some(to), Some(from)) = (self.line(index, ends, room), self.line(index + 1, ends, room))
            else {
                return false;
            };
            let (first, second) = meeting(to, from, self.corners[index], room);
            if (first - last).dot(to.direction) < 0.0 {
                return false;
            }
            self.turns.push(first);
            self.lines.push(Some(index));
            if second != first {
                self.turns.push(second);
                self.lines.push(None);
            }
            last = second;
            let is_end = index + 1 == self.corners.len();
            if is_end && (ends.1 - last).dot(from.direction) < 0.0 {
                return false;
            }
        }
        self.lines.push(Some(self.corners.len()));
        true
    }

    /// The line to the corner of a number, from the one before it or from an end; `None` from within a corner's circle.
    fn line(&self, index: usize, (before, after): (DVec2, DVec2), room: f64) -> Option<Line> {
        match (index.checked_sub(1).map(|last| self.corners[last]), self.corners.get(index)) {
            (None, None) => None,
            (None, Some(&corner)) => Some(Line { point: before, direction: tangent(before, corner, room)? }),
            (Some(corner), None) => Some(Line { point: after, direction: -tangent(after, corner, -room)? }),
            (Some(last), Some(&corner)) => {
                let direction = (corner - last).normalize_or_zero();
                Some(Line { point: last + direction.perp() * room, direction })
            }
        }
    }

    /// The first leg that is not clear, as its number and its ends, and a wall that it meets.
    fn blocked<'a>(&self, walls: &'a Walls, before: DVec2, after: DVec2) -> Option<(Leg, &'a Segment)> {
        let starts = std::iter::once(before).chain(self.turns.iter().copied());
        let ends = self.turns.iter().copied().chain(std::iter::once(after));
        let mut legs = starts.zip(ends).zip(&self.lines);
        legs.find_map(|((from, to), &line)| {
            walls.blocker(from, to).map(|wall| (Leg { from, to, line }, wall))
        })
    }

    /// Adds the end of a wall to the hull, and takes off what does not stick out any more. Returns whether it is a new one.
    fn insert(&mut self, leg: Leg, wall: &Segment, (before, after): (DVec2, DVec2), side: f64) -> bool {
        let Some(place) = leg.line else { return false };
        let height = |point: DVec2| (leg.to - leg.from).perp_dot(point - leg.from) * side;
        let corner = if height(wall.end) > height(wall.start) { wall.end } else { wall.start };
        if self.corners.contains(&corner) {
            return false;
        }
        self.corners.insert(place, corner);
        for index in [Some(place + 1), place.checked_sub(1)].into_iter().flatten() {
            let Some(&own) = self.corners.get(index) else { continue };
            let last = index.checked_sub(1).map_or(before, |last| self.corners[last]);
            let next = self.corners.get(index + 1).copied().unwrap_or(after);
            if (next - last).perp_dot(own - last) * side <= 0.0 {
                self.corners.remove(index);
            }
        }
        true
    }
}

fn length(before: DVec2, turns: &[DVec2], after: DVec2) -> f64 {
    let mut last = before;
    let mut sum = 0.0;
    for &turn in turns.iter().chain(std::iter::once(&after)) {
        sum += last.distance(turn);
        last = turn;
    }
    sum
}

/// A leg of a bend, and the number of its line.
#[derive(Clone, Copy)]
struct Leg {
    from: DVec2,
    to: DVec2,
    line: Option<usize>,
}

/// Returns where a way turns from one line to another around a corner: where they meet, twice, or for a wide turn where
/// both meet the tangent that is square to the line that halves it.
fn meeting(to: Line, from: Line, corner: DVec2, room: f64) -> (DVec2, DVec2) {
    let sine = to.direction.perp_dot(from.direction);
    let cosine = to.direction.dot(from.direction);
    if cosine < TURN_COSINE_MIN {
        let outward = (to.direction - from.direction).normalize_or_zero();
        let reach = room.abs();
        let at = |line: Line| {
            let missing = reach - (line.point - corner).dot(outward);
            line.point + line.direction * (missing / line.direction.dot(outward))
        };
        return (at(to), at(from));
    }
    if sine.abs() < TURN_SINE_MIN {
        let touch = corner + to.direction.perp() * room;
        return (touch, touch);
    }
    let along = (from.point - to.point).perp_dot(from.direction) / sine;
    let point = to.point + to.direction * along;
    (point, point)
}

/// Returns the direction from a point along the tangent of a circle of radius `|room|`, on the side that the sign of `room` says;
/// `None` from within the circle.
///
/// The tangent leaves the line to the centre by the angle whose sine is the radius over the distance.
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
