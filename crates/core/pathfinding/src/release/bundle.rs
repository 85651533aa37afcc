//! Lanes side by side along a whole way, where the ground is wide.
//!
//! Shortest ways go around the same corners, each circle in the track of the one before. Who goes beside others needs a way that is as wide
//! as all of them: that of one large circle, and the lanes are its parallels.

use glam::DVec2;

use super::ends::{mean_of, middle_of};
use super::lanes::{Cut, extent};
use crate::around::Detours;
use crate::ground::Ground;
use crate::planner::length;
use crate::pull::pull;
use crate::tighten::{Hit, Tightening};

/// How much farther apart lanes are than circles that touch, in world units: whoever is in one does not look at the next.
const APART: f64 = 1.0 / 16.0;

/// Fewer circles do not go side by side.
pub(crate) const CIRCLES_MIN: usize = 4;

/// More lanes than these are not tried.
const LANES_MAX: usize = 16;

/// Lanes of the same distance from each other, from the edge of a group to that of its goals.
#[derive(Clone, Debug)]
pub(crate) struct Bundle {
    /// For each lane, from the left of who goes along it, its points.
    pub(crate) lanes: Vec<Vec<DVec2>>,
}

/// Where lanes are on the way that they share.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Keeping {
    /// In its middle.
    Middle,
    /// To the right of it, with as much room to the left for others who come the other way.
    Right,
}

impl Keeping {
    /// How many lanes are worth to be tried.
    pub(crate) fn lanes_min(self) -> usize {
        match self {
            Self::Middle => 2,
            Self::Right => 1,
        }
    }

    /// How many lanes are tried where so many get stuck: to the right there may be ways for a few more.
    pub(crate) fn fewer(self, lanes: usize) -> usize {
        match self {
            Self::Middle => lanes / 2,
            Self::Right => fewer(lanes),
        }
    }
}

/// One end of a bundle: the middle of a group or of its goals, and how far the farthest of them is from it, in world units.
#[derive(Clone, Copy, Debug)]
pub(crate) struct End {
    pub(crate) middle: DVec2,
    pub(crate) extent: f64,
}

impl End {
    /// Returns the end at some points.
    pub(crate) fn of(ground: &Ground, keeping: Keeping, points: &[DVec2]) -> Self {
        // Two groups that change places have the same way if it leads from the mean of one to that of the other.
        let mean = mean_of(points);
        let is_mean = keeping == Keeping::Right && ground.holds(mean);
        let middle = if is_mean { mean } else { middle_of(points) };
        Self { middle, extent: extent(points, middle) }
    }

    fn contains(self, point: DVec2) -> bool {
        point.distance(self.middle) <= self.extent
    }
}

/// How many lanes are tried for so many circles at first: as many as stand beside each other in a square, and one more. Still more save
/// less time than their way takes.
pub(crate) fn lanes_max(circles: usize) -> usize {
    (circles.isqrt() + 1).min(LANES_MAX)
}

/// How many lanes are tried where so many do not fit.
pub(crate) fn fewer(lanes: usize) -> usize {
    (lanes - 1).min(lanes * 4 / 5)
}

impl Bundle {
    /// Returns so many lanes, at least two in the middle, or one on the right; `None` where they do not fit. `reach` is how far the middles of two circles are apart at least.
    pub(crate) fn new(
        (ground, detours): (&Ground, &mut Detours<'_>),
        (from, to): (End, End),
        (lanes, keeping, reach): (usize, Keeping, f64),
    ) -> Option<Self> {
        let left = match keeping {
            Keeping::Middle => 0,
            Keeping::Right => lanes,
        };
        let count = left + lanes;
        let strip = Strip { count, spacing: reach + APART };
        let room = ground.room() + strip.half();
        let is_wide = |point: DVec2| ground.walls.has_room(point, room);
        // A group may stand where so many cannot go side by side.
        let is_within = |end: End, point: DVec2| !is_wide(end.middle) && end.contains(point);
        let is_allowed = |point: DVec2| is_wide(point) || is_within(from, point) || is_within(to, point);
        let mut path = detours.way(from.middle, to.middle, is_allowed)?;
        let first = path.iter().position(|&point| !from.contains(point))?;
        let last = path.iter().rposition(|&point| !to.contains(point))?;
        if first >= last {
            return None;
        }
        path.truncate(last + 1);
        path.drain(..first);
        for point in &mut path {
            *point = ground.walls.roomiest(*point).0;
        }
        let blocker = |from, to| strip.blocker(ground, from, to);
        pull(|from, to| blocker(from, to).is_none(), &mut path);
        Tightening::default().tighten(&blocker, room, &mut path);
        let lanes = (left..count).map(|lane| strip.lane(ground, lane, &path));
        Some(Self { lanes: lanes.collect::<Option<_>>()? })
    }

    /// How long the lane in the middle is, in world units.
    pub(crate) fn length(&self) -> f64 {
        let lane = &self.lanes[self.lanes.len() / 2];
        length(lane[0], &lane[1..])
    }

    /// The lines across all lanes where they begin and where they end.
    pub(crate) fn cuts(&self) -> [Cut; 2] {
        let (left, right) = (&self.lanes[0], &self.lanes[self.lanes.len() - 1]);
        [0, left.len() - 1].map(|index| Cut { left: left[index], right: right[index] })
    }
}

/// So many lanes, so far apart.
#[derive(Clone, Copy, Debug)]
struct Strip {
    count: usize,
    spacing: f64,
}

impl Strip {
    /// How far the outermost lanes are from the middle.
    fn half(self) -> f64 {
        0.5 * (self.count - 1) as f64 * self.spacing
    }

    /// How far a lane is to the right of the middle.
    fn offset(self, lane: usize) -> f64 {
        lane as f64 * self.spacing - self.half()
    }

    /// What a lane comes too near to beside a leg.
    fn blocker(self, ground: &Ground, from: DVec2, to: DVec2) -> Option<Hit> {
        let right = right_of(from, to);
        (0..self.count).find_map(|lane| {
            let aside = right * self.offset(lane);
            ground.walls.blocker(from + aside, to + aside).map(|&wall| Hit::Wall(wall))
        })
    }

    /// The points of a lane beside a path; `None` where it is not clear, or where turns are too near to each other for it.
    ///
    /// Around a corner at the distance `d` from the path, lanes turn like the path does, around circles of the radii `d` and their offsets:
    /// with unit vectors `a` and `b` across the legs, both legs of a lane are `o` from those of the path where it turns at
    /// `o (a + b) / (1 + a·b)` from where the path does.
    fn lane(self, ground: &Ground, lane: usize, path: &[DVec2]) -> Option<Vec<DVec2>> {
        let &[first, second, ..] = path else { return None };
        let &[.., before, last] = path else { return None };
        let offset = self.offset(lane);
        let mut points = vec![first + right_of(first, second) * offset];
        for turn in path.windows(3) {
            let (a, b) = (right_of(turn[0], turn[1]), right_of(turn[1], turn[2]));
            points.push(turn[1] + (a + b) * (offset / (1.0 + a.dot(b))));
        }
        points.push(last + right_of(before, last) * offset);
        let is_good = |(leg, beside): (&[DVec2], &[DVec2])| {
            (leg[1] - leg[0]).dot(beside[1] - beside[0]) > 0.0 && ground.is_clear(leg[0], leg[1])
        };
        points.windows(2).zip(path.windows(2)).all(is_good).then_some(points)
    }
}

/// The unit vector to the right of who goes from one point to another, as a map shows it, with y down.
fn right_of(from: DVec2, to: DVec2) -> DVec2 {
    (to - from).normalize_or_zero().perp()
}

#[cfg(test)]
mod tests {
    use maniple_geometry::{Scalar, Segment};

    use super::*;
    use crate::tests::{Dice, scattered};

    /// How near two legs come to each other that do not cross.
    fn distance(one: &[DVec2], other: &[DVec2]) -> f64 {
        let near = |point: DVec2, leg: &[DVec2]| {
            let line: Segment = Segment::new(leg[0], leg[1]);
            line.nearest(point).distance(point)
        };
        let ends = [near(one[0], other), near(one[1], other), near(other[0], one), near(other[1], one)];
        ends.into_iter().fold(f64::INFINITY, Scalar::lesser)
    }

    #[test]
    fn lanes_are_clear_and_farther_apart_than_circles() {
        let (radius, reach) = (0.35, 0.7);
        let (mut turned, mut right) = (0, 0);
        for seed in 0..60 {
            let mut dice = Dice(seed);
            let map = scattered(&mut dice, 60, 0.008);
            let ground = Ground::new(&map, radius).unwrap();
            let mut detours = Detours::new(&ground);
            let end = |point: DVec2| End { middle: point, extent: 4.0 };
            let (from, to) = (dice.place(&map, &ground), dice.place(&map, &ground));
            for (count, keeping) in
                [(2, Keeping::Middle), (5, Keeping::Middle), (1, Keeping::Right), (3, Keeping::Right)]
            {
                let tools = (&ground, &mut detours);
                let Some(bundle) = Bundle::new(tools, (end(from), end(to)), (count, keeping, reach)) else {
                    continue;
                };
                assert_eq!(bundle.lanes.len(), count, "seed {seed}");
                for (index, lane) in bundle.lanes.iter().enumerate() {
                    assert!(lane.windows(2).all(|leg| ground.is_clear(leg[0], leg[1])), "seed {seed}");
                    for other in &bundle.lanes[index + 1..] {
                        let pairs = lane
                            .windows(2)
                            .flat_map(|leg| other.windows(2).map(move |beside| distance(leg, beside)));
                        let least = pairs.fold(f64::INFINITY, Scalar::lesser);
                        assert!(least > reach, "seed {seed}: {least}");
                    }
                }
                turned += usize::from(bundle.lanes[0].len() > 2);
                right += usize::from(keeping == Keeping::Right);
            }
        }
        assert!(turned > 40 && right > 40, "{turned} {right}");
    }
}
