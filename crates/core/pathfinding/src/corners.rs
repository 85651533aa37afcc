//! The corners that shortest ways go around, by rows of tiles.

use glam::DVec2;

use crate::walls::Walls;

/// The ends of walls around which a circle has room, by the rows of tiles in which they are, from left to right in each.
#[derive(Clone, Debug)]
pub(crate) struct Corners {
    points: Vec<DVec2>,
    /// Where the corners of each row begin, and where those of the last one end.
    firsts: Vec<usize>,
}

impl Corners {
    /// Returns the corners of a map of so many rows for circles that keep `room` from them, in world units.
    pub(crate) fn new(walls: &Walls, height: u32, room: f64) -> Self {
        let mut points = Vec::new();
        for wall in walls.segments() {
            // A corner that sticks out has room straight beside the ends of its walls.
            let beside = wall.direction().normalize_or_zero().perp() * room;
            let has_room = |end: DVec2| walls.holds(end + beside) || walls.holds(end - beside);
            points.extend([wall.start, wall.end].into_iter().filter(|&end| has_room(end)));
        }
        let row = |point: &DVec2| point.y.floor();
        points.sort_by(|a, b| row(a).total_cmp(&row(b)).then(a.x.total_cmp(&b.x)).then(a.y.total_cmp(&b.y)));
        points.dedup();
        // A wall may end at the lower edge of the map, which is the row below the last.
        let rows = (0..=height + 1).map(f64::from);
        let firsts = rows.map(|y| points.partition_point(|point| point.y < y)).collect();
        Self { points, firsts }
    }

    /// Returns the corners in the tiles that a rectangle touches.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the cast stops at both ends, and rows are few"
    )]
    pub(crate) fn within(&self, low: DVec2, high: DVec2) -> impl Iterator<Item = DVec2> {
        let last = self.firsts.len() - 1;
        let rows = (low.y as usize).min(last)..(high.y as usize + 1).min(last);
        rows.flat_map(move |row| {
            let points = &self.points[self.firsts[row]..self.firsts[row + 1]];
            let first = points.partition_point(|point| point.x < low.x);
            points[first..].iter().copied().take_while(move |point| point.x <= high.x)
        })
    }
}
