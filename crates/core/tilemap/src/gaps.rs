//! Where a circle does not fit between walls although the tiles are passable.

use glam::DVec2;
use maniple_geometry::Segment;

use crate::TileMap;
use crate::regions::neighbours;

/// Largest distance, in tiles, at which two corners are compared: wider gaps between corners are not looked for, as
/// the work grows with its square. Gaps between facing edges are found at any width.
const CORNER_DISTANCE_MAX: i32 = 16;

/// Distance, in world units, below which a free wall touches what it is drawn up to: Tiled rounds to a fraction
/// of a pixel.
const TOUCHING: f64 = 1.0 / 256.0;

/// What is not narrow.
const WIDE: u32 = u32::MAX;

/// A place that is too narrow.
pub(crate) struct Gap {
    /// The tile in the narrowest part of it.
    pub(crate) tile: (u32, u32),
    /// How wide it is there, in world units.
    pub(crate) width: f64,
    /// How many tiles hang together that are too narrow.
    pub(crate) tiles: u32,
}

/// Returns the gaps between tiles that are narrower than `width`, in world units, by the first of their tiles.
/// Half-blocked tiles count as blocked.
///
/// Two walls are nearest to each other either between facing edges, which is a row or column of passable tiles
/// between blocked ones, or between two corners that face each other: each lies in the quarter that is opposite to
/// the other's blocked tile, and everything between them is open.
pub(crate) fn between_tiles(map: &TileMap, width: f64) -> Vec<Gap> {
    let mut narrow = Narrow { map, limit: width * width, squares: vec![WIDE; map.tiles().len()] };
    for y in 0..map.height() {
        narrow.runs((0..map.width()).map(|x| (x, y)));
    }
    for x in 0..map.width() {
        narrow.runs((0..map.height()).map(|y| (x, y)));
    }
    narrow.corners(width);
    narrow.gaps()
}

/// The square of the width of the narrowest gap through each tile, where it is below the limit.
struct Narrow<'a> {
    map: &'a TileMap,
    limit: f64,
    squares: Vec<u32>,
}

impl Narrow<'_> {
    fn index(&self, tile: (u32, u32)) -> usize {
        tile.1 as usize * self.map.width() as usize + tile.0 as usize
    }

    fn mark(&mut self, tile: (u32, u32), square: u32) {
        let index = self.index(tile);
        self.squares[index] = self.squares[index].min(square);
    }

    /// Marks the runs of passable tiles on a line across the map; the edges of the map are blocked.
    fn runs(&mut self, line: impl Iterator<Item = (u32, u32)> + Clone) {
        let mut rest = line.peekable();
        while let Some(&(x, y)) = rest.peek() {
            if !self.map.is_passable(x, y) {
                rest.next();
                continue;
            }
            let run = rest.clone().take_while(|&(x, y)| self.map.is_passable(x, y));
            let tiles: Vec<_> = run.collect();
            let length = u32::try_from(tiles.len()).unwrap_or(0);
            if f64::from(length) * f64::from(length) < self.limit {
                tiles.iter().for_each(|&tile| self.mark(tile, length * length));
            }
            rest.nth(tiles.len() - 1);
        }
    }

    fn is_open(&self, x: i32, y: i32) -> bool {
        let (Ok(x), Ok(y)) = (u32::try_from(x), u32::try_from(y)) else { return false };
        self.map.is_passable(x, y)
    }

    /// Marks the tiles half-way between corners that face each other.
    fn corners(&mut self, width: f64) {
        let distances = 1..=CORNER_DISTANCE_MAX;
        let reach = distances.take_while(|&distance| f64::from(distance) < width).last().unwrap_or(0);
        for y in 0..=self.map.height().cast_signed() {
            for x in 0..=self.map.width().cast_signed() {
                for side in [1, -1] {
                    if self.is_corner(x, y, -side, -1) {
                        self.facing(x, y, side, reach);
                    }
                }
            }
        }
    }

    /// Whether the tile on this side of a corner (-1: left of it, above it) is blocked and its two neighbours at
    /// the corner are open.
    fn is_corner(&self, x: i32, y: i32, side_x: i32, side_y: i32) -> bool {
        let (column, row) = (x + (side_x - 1) / 2, y + (side_y - 1) / 2);
        let (other_column, other_row) = (x + (-side_x - 1) / 2, y + (-side_y - 1) / 2);
        !self.is_open(column, row) && self.is_open(other_column, row) && self.is_open(column, other_row)
    }

    /// Marks the gaps from the corner at (x, y) down and to the `side` (1: right, -1: left).
    fn facing(&mut self, x: i32, y: i32, side: i32, reach: i32) {
        for dy in 0..=reach {
            for dx in 0..=reach {
                let square = (dx * dx + dy * dy).cast_unsigned();
                if square == 0 || f64::from(square) >= self.limit {
                    continue;
                }
                if self.is_corner(x + side * dx, y + dy, side, 1) && self.is_clear((x, y), side, (dx, dy)) {
                    let column = column(x, side, (dx / 2).min((dx - 1).max(0)));
                    let row = y + (dy / 2).min((dy - 1).max(0));
                    self.mark((column.cast_unsigned(), row.cast_unsigned()), square);
                }
            }
        }
    }

    /// Whether every tile between a corner and the one `offset` away is open; along the edges of tiles those on both
    /// sides are.
    fn is_clear(&self, from: (i32, i32), side: i32, offset: (i32, i32)) -> bool {
        let (dx, dy) = offset;
        let (columns, rows) = (if dx == 0 { -1..1 } else { 0..dx }, if dy == 0 { -1..1 } else { 0..dy });
        rows.into_iter().all(|j| {
            columns.clone().all(|i| {
                // The line from (0, 0) to (dx, dy) passes the inside of tile (i, j) if it has corners on both sides.
                let is_crossed = dx == 0 || dy == 0 || i * dy < (j + 1) * dx && (i + 1) * dy > j * dx;
                !is_crossed || self.is_open(column(from.0, side, i), from.1 + j)
            })
        })
    }

    /// Gathers narrow tiles that hang together into one gap each.
    fn gaps(mut self) -> Vec<Gap> {
        let mut gaps = Vec::new();
        let mut waiting = Vec::new();
        for y in 0..self.map.height() {
            for x in 0..self.map.width() {
                if self.squares[self.index((x, y))] == WIDE {
                    continue;
                }
                let mut narrowest = (WIDE, (y, x));
                let mut tiles = 0;
                waiting.push((x, y));
                while let Some((x, y)) = waiting.pop() {
                    let is_inside = x < self.map.width() && y < self.map.height();
                    let index = if is_inside { self.index((x, y)) } else { continue };
                    let square = std::mem::replace(&mut self.squares[index], WIDE);
                    if square != WIDE {
                        narrowest = narrowest.min((square, (y, x)));
                        tiles += 1;
                        waiting.extend(neighbours(x, y));
                    }
                }
                let (square, (y, x)) = narrowest;
                gaps.push(Gap { tile: (x, y), width: f64::from(square).sqrt(), tiles });
            }
        }
        gaps
    }
}

/// The column `distance` tiles to the right of a lattice line, or to the left of it.
fn column(x: i32, side: i32, distance: i32) -> i32 {
    if side > 0 { x + distance } else { x - 1 - distance }
}

/// Returns, per free wall, the narrowest gap between it and a wall that it does not touch, where that is narrower
/// than `width`, in world units. Walls that share a corner with one that it touches are left out: next to that corner
/// they are near without a gap.
pub(crate) fn at_free_walls(map: &TileMap, segments: &[Segment], width: f64) -> Vec<Gap> {
    let mut gaps = Vec::new();
    for wall in map.free_walls() {
        let touching: Vec<&Segment> =
            segments.iter().filter(|other| distance(wall, other).0 <= TOUCHING).collect();
        let mut narrowest: Option<(f64, DVec2)> = None;
        for other in segments {
            let (gap, middle) = distance(wall, other);
            if gap >= width || narrowest.is_some_and(|(least, _)| gap >= least) {
                continue;
            }
            if !touching.iter().any(|near| shares_corner(near, other)) {
                narrowest = Some((gap, middle));
            }
        }
        gaps.extend(narrowest.map(|(width, middle)| Gap { tile: map.tile_at(middle), width, tiles: 1 }));
    }
    gaps
}

fn shares_corner(a: &Segment, b: &Segment) -> bool {
    a.start == b.start || a.start == b.end || a.end == b.start || a.end == b.end
}

/// Returns how far two segments are apart, in world units, and the point half-way between them.
fn distance(a: &Segment, b: &Segment) -> (f64, DVec2) {
    if is_crossing(a, b) {
        return (0.0, a.start);
    }
    let ends = [(a.start, b), (a.end, b), (b.start, a), (b.end, a)];
    let mut least = (f64::INFINITY, a.start);
    for (point, segment) in ends {
        let nearest = nearest(segment, point);
        let apart = (nearest - point).length();
        if apart < least.0 {
            least = (apart, (nearest + point) / 2.0);
        }
    }
    least
}

fn is_crossing(a: &Segment, b: &Segment) -> bool {
    let side = |segment: &Segment, point: DVec2| segment.direction().perp_dot(point - segment.start);
    side(a, b.start) * side(a, b.end) < 0.0 && side(b, a.start) * side(b, a.end) < 0.0
}

/// Returns the point of a segment that is nearest to `point`.
pub(crate) fn nearest(segment: &Segment, point: DVec2) -> DVec2 {
    let direction = segment.direction();
    let along = (point - segment.start).dot(direction) / direction.length_squared();
    if along <= 0.0 {
        segment.start
    } else if along >= 1.0 {
        segment.end
    } else {
        segment.start + direction * along
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::octile;

    /// The gaps narrower than `width` as (tile, width, tiles).
    fn gaps(rows: &[&str], width: f64) -> Vec<((u32, u32), f64, u32)> {
        let header = format!("type octile\nheight {}\nwidth {}\nmap\n", rows.len(), rows[0].len());
        let map = octile::read((header + &rows.join("\n")).as_bytes()).unwrap();
        between_tiles(&map, width).into_iter().map(|gap| (gap.tile, gap.width, gap.tiles)).collect()
    }

    #[test]
    fn a_door_is_a_gap_for_what_is_wider_and_none_for_what_just_fits() {
        let rows = ["...@...", "...@...", ".......", "...@...", "...@..."];
        assert_eq!(gaps(&rows, 1.5), [((3, 2), 1.0, 1)]);
        assert_eq!(gaps(&rows, 1.0), []);
    }

    #[test]
    fn corners_that_face_each_other_over_open_tiles_are_a_gap() {
        let rows = ["........", ".@......", "........", "........", "....@...", "........", "........"];
        // From (2, 2) to (4, 4); beside the edge of the map it is narrow as well.
        let gap = ((3, 3), 8.0_f64.sqrt(), 1);
        assert!(gaps(&rows, 2.9).contains(&gap));
        assert!(!gaps(&rows, 2.8).contains(&gap));
    }

    #[test]
    fn corners_side_by_side_on_the_same_line_are_a_gap() {
        let rows = ["@@@...", "@@@...", "....@@", "....@@", "......"];
        let found = gaps(&rows, 1.9);
        assert_eq!(found[0], ((3, 2), 1.0, 1));
    }

    #[test]
    fn a_staircase_is_no_gap() {
        let rows = ["........", "@.......", "@@......", "@@@.....", "@@@@....", "........", "........"];
        assert_eq!(gaps(&rows, 1.9), [((0, 0), 1.0, 1)]);
    }
}
