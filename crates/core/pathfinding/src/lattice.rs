//! The points between which a path is searched.

use glam::DVec2;
use maniple_tilemap::{TileMap, TileShape};

use crate::bits::Bits;
use crate::walls::Walls;

/// The region of a node that is not free.
const NONE: u32 = u32::MAX;

/// A step along an axis in the unit of costs. With [`DIAGONAL`] it is 1 : √2 but for 0.005 %, and the longest path of
/// the largest map (8193² / 2 steps) fits into 32 bits.
pub(crate) const STRAIGHT: u32 = 70;

/// A step along a diagonal in the unit of costs.
pub(crate) const DIAGONAL: u32 = 99;

/// How far from an end nodes are looked for, in nodes along each axis.
const ACCESS_NODES: i32 = 3;

/// How many nodes an end is tied to at most.
const ACCESS_MAX: usize = 4;

/// The points between which a path is searched: the middles of tiles, or all points with halves of whole coordinates.
///
/// Steps lead to the eight nodes around, diagonal ones only where both nodes beside them are free, too. Then every step
/// between free nodes is clear. On the middles of tiles (whole tiles, reach below 1/2) that is plain. On the halves,
/// a wall of a tile ends in whole points, and each is nearest to a step in a node; the same goes for what is nearest to
/// an end of a step; and a half-blocked tile that crosses a diagonal step goes through the two nodes beside it. Free
/// walls of any angle have to stay farther away: a point at `s` from both ends of a step of length `l` is at least
/// `√(s² - l²/4)` from it.
#[derive(Clone, Debug)]
pub(crate) struct Lattice {
    pitch: f64,
    offset: f64,
    pub(crate) width: u32,
    pub(crate) height: u32,
    /// To the right, down, to the left, up.
    lines: [Bits; 4],
    regions: Vec<u32>,
}

impl Lattice {
    pub(crate) fn new(map: &TileMap, walls: &Walls, reach: f64) -> Self {
        let is_whole = |shape| matches!(shape, TileShape::Open | TileShape::Blocked);
        let has_whole_tiles =
            map.free_walls().is_empty() && map.tiles().iter().all(|tile| is_whole(tile.shape));
        let (pitch, offset, width, height) = if has_whole_tiles && reach < 0.5 {
            (1.0, 0.5, map.width(), map.height())
        } else {
            (0.5, 0.0, 2 * map.width() + 1, 2 * map.height() + 1)
        };
        let free_walls = (!map.free_walls().is_empty())
            .then(|| Walls::new(map, map.free_walls().to_vec(), (reach * reach + 0.125).sqrt()));
        let across = || Bits::new(height, width);
        let down = || Bits::new(width, height);
        let lines = [across(), down(), across(), down()];
        let mut lattice = Self { pitch, offset, width, height, lines, regions: Vec::new() };
        for y in 0..height {
            for x in 0..width {
                let point = lattice.point(lattice.node(x, y));
                if walls.holds(point) && free_walls.as_ref().is_none_or(|walls| walls.holds(point)) {
                    lattice.lines[0].set_free(y, x);
                    lattice.lines[1].set_free(x, y);
                    lattice.lines[2].set_free(y, width - 1 - x);
                    lattice.lines[3].set_free(x, height - 1 - y);
                }
            }
        }
        lattice.number_regions();
        lattice
    }

    pub(crate) fn nodes(&self) -> usize {
        self.width as usize * self.height as usize
    }

    pub(crate) fn node(&self, x: u32, y: u32) -> u32 {
        y * self.width + x
    }

    /// Returns column and row of a node.
    pub(crate) fn place(&self, node: u32) -> (i32, i32) {
        ((node % self.width).cast_signed(), (node / self.width).cast_signed())
    }

    /// Returns where a node is, in world units.
    pub(crate) fn point(&self, node: u32) -> DVec2 {
        let (x, y) = self.place(node);
        DVec2::new(f64::from(x), f64::from(y)) * self.pitch + self.offset
    }

    /// Returns the tile in which a node is, by its column and row.
    pub(crate) fn tile(&self, place: (i32, i32)) -> (i32, i32) {
        if self.offset > 0.0 { place } else { (place.0 >> 1, place.1 >> 1) }
    }

    /// Returns a length in world units as a cost, rounded down.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the cast stops at both ends"
    )]
    pub(crate) fn cost_of(&self, length: f64) -> u32 {
        (length / self.pitch * f64::from(STRAIGHT)) as u32
    }

    /// Returns a cost as a length in world units.
    pub(crate) fn length_of(&self, cost: u32) -> f64 {
        f64::from(cost) / f64::from(STRAIGHT) * self.pitch
    }

    /// Returns whether a node is free; those just outside are not.
    pub(crate) fn is_free(&self, x: i32, y: i32) -> bool {
        self.lines[0].is_free(y, x)
    }

    /// Returns whether a diagonal step to a node is clear.
    pub(crate) fn is_diagonal_free(&self, from: (i32, i32), to: (i32, i32)) -> bool {
        self.is_free(to.0, to.1) && self.is_free(from.0, to.1) && self.is_free(to.0, from.1)
    }

    /// Returns which of the nodes in the square of nine around one are free, row by row: in each the left one is the lowest bit.
    pub(crate) fn around(&self, place: (i32, i32)) -> [u64; 3] {
        [-1, 0, 1].map(|dy| self.lines[0].around(place.1 + dy, place.0))
    }

    /// Returns the next node of a straight run along an axis that has to be looked at; see [`Bits::jump`].
    pub(crate) fn jump(&self, from: (i32, i32), step: (i32, i32), goal: (i32, i32)) -> Option<(i32, i32)> {
        let (x, y) = (from.0.cast_unsigned(), from.1.cast_unsigned());
        let (goal_x, goal_y) = (goal.0.cast_unsigned(), goal.1.cast_unsigned());
        let (right, bottom) = (self.width - 1, self.height - 1);
        let (place_x, place_y) = match step {
            (1, _) => (self.lines[0].jump(y, x, (goal_y == y).then_some(goal_x))?, y),
            (-1, _) => {
                let goal = (goal_y == y).then(|| right - goal_x);
                (right - self.lines[2].jump(y, right - x, goal)?, y)
            }
            (_, 1) => (x, self.lines[1].jump(x, y, (goal_x == x).then_some(goal_y))?),
            _ => {
                let goal = (goal_x == x).then(|| bottom - goal_y);
                (x, bottom - self.lines[3].jump(x, bottom - y, goal)?)
            }
        };
        Some((place_x.cast_signed(), place_y.cast_signed()))
    }

    /// Returns which region a node is in: nodes of the same region can be reached from each other.
    pub(crate) fn region(&self, node: u32) -> u32 {
        self.regions[node as usize]
    }

    /// Puts the nearest nodes to which a circle can go straight from a point into a list, nearest first.
    #[expect(clippy::cast_possible_truncation, reason = "a point of the map has few nodes before it")]
    pub(crate) fn access(&self, walls: &Walls, point: DVec2, nodes: &mut Vec<u32>) {
        let middle = (point - self.offset) / self.pitch;
        let (x, y) = ((middle.x + 0.5).floor() as i32, (middle.y + 0.5).floor() as i32);
        let columns = (x - ACCESS_NODES).max(0)..=(x + ACCESS_NODES).min(self.width.cast_signed() - 1);
        let rows = (y - ACCESS_NODES).max(0)..=(y + ACCESS_NODES).min(self.height.cast_signed() - 1);
        nodes.clear();
        for y in rows {
            let free = columns.clone().filter(|&x| self.is_free(x, y));
            nodes.extend(free.map(|x| self.node(x.cast_unsigned(), y.cast_unsigned())));
        }
        let distance = |node: u32| self.point(node).distance_squared(point);
        nodes.sort_unstable_by(|&a, &b| distance(a).total_cmp(&distance(b)).then(a.cmp(&b)));
        let mut found = 0;
        nodes.retain(|&node| {
            let is_taken = found < ACCESS_MAX && walls.is_clear(point, self.point(node));
            found += usize::from(is_taken);
            is_taken
        });
    }

    /// Numbers the regions. A diagonal step implies two straight ones, so straight steps reach everything.
    fn number_regions(&mut self) {
        let mut regions = vec![NONE; self.nodes()];
        let mut waiting = Vec::new();
        let mut count = 0;
        for (first, _) in (0..).zip(0..self.nodes()) {
            let (x, y) = self.place(first);
            if !self.is_free(x, y) || regions[first as usize] != NONE {
                continue;
            }
            regions[first as usize] = count;
            waiting.push(first);
            while let Some(node) = waiting.pop() {
                let (x, y) = self.place(node);
                for (x, y) in [(x + 1, y), (x, y + 1), (x - 1, y), (x, y - 1)] {
                    if self.is_free(x, y) {
                        let next = self.node(x.cast_unsigned(), y.cast_unsigned());
                        if regions[next as usize] == NONE {
                            regions[next as usize] = count;
                            waiting.push(next);
                        }
                    }
                }
            }
            count += 1;
        }
        self.regions = regions;
    }
}
