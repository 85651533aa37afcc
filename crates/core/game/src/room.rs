//! Where there is room on a map.

use glam::DVec2;
use maniple_geometry::Segment;
use maniple_tilemap::TileMap;

/// Returns whether all tiles under a rectangle are open; no wall of a tile is nearer to its centre then.
pub(crate) fn is_open(map: &TileMap, center: DVec2, half: DVec2) -> bool {
    let Some((left, top)) = tile_of(center - half) else { return false };
    let Some((right, bottom)) = tile_of(center + half) else { return false };
    (top..=bottom).all(|y| (left..=right).all(|x| map.is_passable(x, y)))
}

/// Returns the tile that a point is on; `None` left of or above the map.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "not negative; saturates")]
pub(crate) fn tile_of(point: DVec2) -> Option<(u32, u32)> {
    (point.x >= 0.0 && point.y >= 0.0).then_some((point.x as u32, point.y as u32))
}

/// Returns whether a point is nearer to a segment than `reach`.
pub(crate) fn is_nearer(point: DVec2, segment: &Segment, reach: f64) -> bool {
    let direction = segment.direction();
    let offset = point - segment.start;
    let along = offset.dot(direction) / direction.dot(direction);
    let nearest = if along > 1.0 {
        segment.end
    } else if along > 0.0 {
        segment.start + direction * along
    } else {
        segment.start
    };
    point.distance_squared(nearest) < reach * reach
}

/// The points of the unit lattice by distance from the origin, ties by y, then x.
pub(crate) struct Rings {
    /// Points within `inner` have been given; those that wait are within `outer`, the nearest last.
    inner: i32,
    outer: i32,
    end: i32,
    waiting: Vec<(i32, i32)>,
}

impl Rings {
    /// Returns the points of a disc, a little more than `radius` wide.
    #[expect(clippy::cast_possible_truncation, reason = "saturates, and is limited")]
    pub(crate) fn new(radius: f64) -> Self {
        /// Beyond it the square of a distance would not fit into 32 bits.
        const RADIUS_MAX: i32 = 32_000;
        let end = (radius.floor() as i32).min(RADIUS_MAX) + 1;
        Self { inner: -1, outer: 0, end, waiting: vec![(0, 0)] }
    }

    /// Waits for the points of a ring a quarter wider than all before.
    fn widen(&mut self) {
        self.inner = self.outer;
        self.outer = (self.inner + self.inner / 4 + 4).min(self.end);
        let (inner, outer) = (self.inner * self.inner, self.outer * self.outer);
        let side = -self.outer..=self.outer;
        self.waiting = side
            .clone()
            .flat_map(|y| side.clone().map(move |x| (x, y)))
            .filter(|&(x, y)| (inner + 1..=outer).contains(&(x * x + y * y)))
            .collect();
        self.waiting.sort_by_key(|&(x, y)| std::cmp::Reverse((x * x + y * y, y, x)));
    }
}

impl Iterator for Rings {
    type Item = (i32, i32);

    fn next(&mut self) -> Option<(i32, i32)> {
        while self.waiting.is_empty() && self.outer < self.end {
            self.widen();
        }
        self.waiting.pop()
    }
}

/// Returns the point of a rectangle that is nearest to a point.
pub(crate) fn nearest_within(point: DVec2, low: DVec2, high: DVec2) -> DVec2 {
    let nearest = |value: f64, low: f64, high: f64| {
        if value < low {
            low
        } else if value > high {
            high
        } else {
            value
        }
    };
    DVec2::new(nearest(point.x, low.x, high.x), nearest(point.y, low.y, high.y))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lattice_is_walked_outwards_and_each_point_once() {
        let points: Vec<(i32, i32)> = Rings::new(12.0).collect();
        let keys: Vec<(i32, i32, i32)> = points.iter().map(|&(x, y)| (x * x + y * y, y, x)).collect();
        assert!(keys.is_sorted());
        let mut sorted = points.clone();
        sorted.sort_unstable();
        sorted.dedup();
        assert_eq!(sorted.len(), points.len());
        let side = -13..=13;
        let disc =
            side.clone().flat_map(|y| side.clone().map(move |x| x * x + y * y)).filter(|&d| d <= 169).count();
        assert_eq!(points.len(), disc);
        assert_eq!(points[..5], [(0, 0), (0, -1), (-1, 0), (1, 0), (0, 1)]);
    }
}
