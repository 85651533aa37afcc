//! What no path between two middles of tiles can be shorter than.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use maniple_tilemap::{TileMap, TileShape};

/// The cost of half a tile along an axis.
const STRAIGHT: u64 = 100_000;

/// The cost of half a tile along a diagonal; √2 rounded down, so that a bound stays one.
const DIAGONAL: u64 = 141_421;

/// cos(π/8) rounded down: how much shorter a straight line is at most than steps in eight directions between its ends.
const SHORTEST_SHARE: f64 = 0.923_879;

const FAR: u64 = u64::MAX;

/// Finds lower bounds of paths on a map.
///
/// The shortest way of a point is not longer than that of a circle. It turns at corners of tiles only, so that between its turns it leads
/// from vertex to vertex of the grid of half tiles, of which middles of tiles are vertices, too. A shortest way in eight directions
/// along the edges and diagonals of open cells of such a grid is at most 1 / cos(π/8) = 1.0824 times as long (Bailey, Tovey, Uras,
/// Koenig and Nash, *Path Planning on Grids: The Effect of Vertex Placement on Path Length*, 2015). So its length times cos(π/8) is a
/// bound, and so is the straight line. Half-blocked tiles count as open, and walls of any angle as none.
pub(super) struct Bound<'a> {
    map: &'a TileMap,
    columns: usize,
    rows: usize,
    costs: Vec<u64>,
    reached: Vec<usize>,
    queue: BinaryHeap<Reverse<(u64, usize)>>,
}

impl<'a> Bound<'a> {
    pub(super) fn new(map: &'a TileMap) -> Self {
        let (columns, rows) = (2 * map.width() as usize + 1, 2 * map.height() as usize + 1);
        let costs = vec![FAR; columns * rows];
        Self { map, columns, rows, costs, reached: Vec::new(), queue: BinaryHeap::new() }
    }

    /// Returns a lower bound of the length of a path between the middles of two tiles, in tiles; `None` where there is no way.
    pub(super) fn length_min(&mut self, start: (u32, u32), goal: (u32, u32)) -> Option<f64> {
        let apart = |a: u32, b: u32| f64::from(a) - f64::from(b);
        let straight = apart(start.0, goal.0).hypot(apart(start.1, goal.1));
        let cost = self.cost(self.vertex(start), self.vertex(goal))?;
        Some((SHORTEST_SHARE * 0.5 * cost as f64 / STRAIGHT as f64).max(straight))
    }

    /// The vertex in the middle of a tile.
    fn vertex(&self, (x, y): (u32, u32)) -> usize {
        (2 * y as usize + 1) * self.columns + 2 * x as usize + 1
    }

    /// The cost of a shortest way in eight directions, by A*.
    fn cost(&mut self, start: usize, goal: usize) -> Option<u64> {
        for vertex in self.reached.drain(..) {
            self.costs[vertex] = FAR;
        }
        self.queue.clear();
        self.reach(start, 0, goal);
        while let Some(Reverse((estimate, vertex))) = self.queue.pop() {
            let cost = self.costs[vertex];
            if vertex == goal {
                return Some(cost);
            }
            if estimate == cost + self.octile(vertex, goal) {
                self.expand(vertex, cost, goal);
            }
        }
        None
    }

    fn expand(&mut self, vertex: usize, cost: u64, goal: usize) {
        let (x, y) = (vertex % self.columns, vertex / self.columns);
        let is_open = |x: usize, y: usize| self.is_open(x, y);
        // The cells around: above and to the left of the vertex, and so on; one outside has no number and is closed.
        let (left, above) = (x.wrapping_sub(1), y.wrapping_sub(1));
        let cells = [is_open(left, above), is_open(x, above), is_open(left, y), is_open(x, y)];
        let steps = [
            (cells[0], -1, -1),
            (cells[0] || cells[1], 0, -1),
            (cells[1], 1, -1),
            (cells[0] || cells[2], -1, 0),
            (cells[1] || cells[3], 1, 0),
            (cells[2], -1, 1),
            (cells[2] || cells[3], 0, 1),
            (cells[3], 1, 1),
        ];
        for (is_free, to_x, to_y) in steps {
            if is_free {
                let next = vertex.wrapping_add_signed(to_y * self.columns.cast_signed() + to_x);
                let step = if to_x != 0 && to_y != 0 { DIAGONAL } else { STRAIGHT };
                self.reach(next, cost + step, goal);
            }
        }
    }

    fn reach(&mut self, vertex: usize, cost: u64, goal: usize) {
        if cost < self.costs[vertex] {
            self.costs[vertex] = cost;
            self.reached.push(vertex);
            self.queue.push(Reverse((cost + self.octile(vertex, goal), vertex)));
        }
    }

    /// Whether a cell of half a tile is open.
    fn is_open(&self, x: usize, y: usize) -> bool {
        if x >= self.columns - 1 || y >= self.rows - 1 {
            return false;
        }
        let index = y / 2 * self.map.width() as usize + x / 2;
        self.map.tiles()[index].shape != TileShape::Blocked
    }

    fn octile(&self, from: usize, to: usize) -> u64 {
        let across = (from % self.columns).abs_diff(to % self.columns) as u64;
        let down = (from / self.columns).abs_diff(to / self.columns) as u64;
        let (short, long) = (across.min(down), across.max(down));
        short * DIAGONAL + (long - short) * STRAIGHT
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use maniple_tilemap::{Resolver, read};

    struct Nothing;

    impl Resolver for Nothing {
        fn resolve(&self, path: &str) -> Result<Vec<u8>, String> {
            Err(path.to_owned())
        }
    }

    fn bound(rows: &[&str], start: (u32, u32), goal: (u32, u32)) -> Option<f64> {
        let size = format!("type octile\nheight {}\nwidth {}\nmap\n", rows.len(), rows[0].len());
        let map = read("x.map", (size + &rows.join("\n")).as_bytes(), &Nothing).expect("a map");
        let mut bounds = Bound::new(&map);
        let found = bounds.length_min(start, goal);
        assert_eq!(found, bounds.length_min(goal, start));
        found
    }

    #[test]
    fn bounds_are_below_the_shortest_way_of_a_point_and_not_far() {
        // The shortest way, by hand: straight, and around the corners of a wall.
        let wall = [".......", "...@...", "...@...", "...@...", "...@..."];
        let cases: [(&[&str], _, _, f64); 4] = [
            (&["....", "....", "...."], (0, 0), (3, 0), 3.0),
            (&["....", "....", "...."], (0, 0), (3, 2), 13.0_f64.sqrt()),
            (&["..", "@."], (0, 0), (1, 1), 2.0_f64.sqrt()),
            (&wall, (1, 4), (5, 4), 2.0 * 3.5_f64.hypot(1.5) + 1.0),
        ];
        for (rows, start, goal, shortest) in cases {
            let bound = bound(rows, start, goal).expect("a way");
            assert!(bound <= shortest + 1e-9 && bound >= 0.92 * shortest, "{bound} {shortest}");
        }
        assert_eq!(bound(&[".@@.", "@@@."], (0, 0), (3, 0)), None);
    }
}
