//! Walls cut at the edges of tiles, so that who knows a part of a map can be told the walls of that part.

use glam::DVec2;
use maniple_geometry::Segment;

use crate::{Corner, TileMap, TileShape};

impl TileMap {
    /// Returns the wall on the upper edge of tile (x, y), the blocked side to the right; `None` where there is none. `y` may be the
    /// height of the map: that is its lower edge.
    ///
    /// # Panics
    /// Outside of the map.
    #[must_use]
    pub fn wall_above(&self, x: u32, y: u32) -> Option<Segment> {
        assert!(x < self.width() && y <= self.height(), "no tile edge above ({x}, {y})");
        let is_above_blocked = y == 0 || self.tile(x, y - 1).shape.blocks_south();
        let is_below_blocked = y == self.height() || self.tile(x, y).shape.blocks_north();
        let ends = [corner(x, y), corner(x + 1, y)];
        (is_above_blocked != is_below_blocked).then(|| directed(ends, is_below_blocked))
    }

    /// Returns the wall on the left edge of tile (x, y), the blocked side to the right; `None` where there is none. `x` may be the
    /// width of the map: that is its right edge.
    ///
    /// # Panics
    /// Outside of the map.
    #[must_use]
    pub fn wall_left_of(&self, x: u32, y: u32) -> Option<Segment> {
        assert!(x <= self.width() && y < self.height(), "no tile edge left of ({x}, {y})");
        let is_left_blocked = x == 0 || self.tile(x - 1, y).shape.blocks_east();
        let is_right_blocked = x == self.width() || self.tile(x, y).shape.blocks_west();
        let ends = [corner(x, y), corner(x, y + 1)];
        (is_left_blocked != is_right_blocked).then(|| directed(ends, is_left_blocked))
    }

    /// Returns the wall across a half-blocked tile, the blocked side to the right; `None` where there is none.
    ///
    /// # Panics
    /// Outside of the map.
    #[must_use]
    pub fn wall_across(&self, x: u32, y: u32) -> Option<Segment> {
        let TileShape::Diagonal(blocked) = self.tile(x, y).shape else { return None };
        let falling = [corner(x, y), corner(x + 1, y + 1)];
        let rising = [corner(x + 1, y), corner(x, y + 1)];
        Some(match blocked {
            Corner::Northwest => directed(rising, true),
            Corner::Southeast => directed(rising, false),
            Corner::Southwest => directed(falling, true),
            Corner::Northeast => directed(falling, false),
        })
    }

    /// Returns the free walls cut at the edges of tiles, each part with column and row of its tile, by (row, column). A part that runs
    /// along an edge belongs to the tile to the right of it or below, where the map has one.
    #[must_use]
    pub fn free_wall_pieces(&self) -> Vec<((u32, u32), Segment)> {
        let mut pieces = Vec::new();
        for wall in self.free_walls() {
            let points = cuts(wall);
            for pair in points.windows(2) {
                let &[start, end] = pair else { continue };
                pieces.push((self.tile_at((start + end) * 0.5), Segment::new(start, end)));
            }
        }
        pieces.sort_by_key(|&((x, y), _)| (y, x));
        pieces
    }
}

fn corner(x: u32, y: u32) -> DVec2 {
    DVec2::new(f64::from(x), f64::from(y))
}

fn directed([from, to]: [DVec2; 2], is_forward: bool) -> Segment {
    if is_forward { Segment::new(from, to) } else { Segment::new(to, from) }
}

/// Returns the ends of a wall and the points between at which it crosses edges of tiles, in order, none twice.
fn cuts(wall: &Segment) -> Vec<DVec2> {
    let direction = wall.direction();
    let mut crossings: Vec<(f64, DVec2)> = Vec::new();
    for line in lines_between(wall.start.x, wall.end.x) {
        let part = (line - wall.start.x) / direction.x;
        crossings.push((part, DVec2::new(line, wall.start.y + direction.y * part)));
    }
    for line in lines_between(wall.start.y, wall.end.y) {
        let part = (line - wall.start.y) / direction.y;
        crossings.push((part, DVec2::new(wall.start.x + direction.x * part, line)));
    }
    crossings.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    let mut points = vec![wall.start];
    points.extend(crossings.into_iter().map(|(_, point)| point));
    points.push(wall.end);
    points.dedup();
    points
}

/// Returns the whole numbers strictly between two coordinates of a map.
fn lines_between(one: f64, other: f64) -> impl Iterator<Item = f64> {
    let (low, high) = if one < other { (one, other) } else { (other, one) };
    std::iter::successors(Some(low.floor() + 1.0), |line| Some(line + 1.0))
        .take_while(move |&line| line < high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read;
    use crate::read::Resolver;

    struct Nothing;

    impl Resolver for Nothing {
        fn resolve(&self, _path: &str) -> Result<Vec<u8>, String> {
            Err("no file".to_owned())
        }
    }

    #[test]
    fn the_walls_of_tiles_are_the_border_and_nothing_else() {
        let rows = ["..@@.", ".@...", "@@..@", "....."];
        let text = format!("type octile\nheight {}\nwidth {}\nmap\n{}\n", rows.len(), 5, rows.join("\n"));
        let map = read("a.map", text.as_bytes(), &Nothing).unwrap();
        check(&map);
    }

    #[test]
    fn half_blocked_tiles_are_cut_alike() {
        for seed in 0..50u32 {
            let mut state = seed;
            let mut builder = crate::map::Builder::new(7, 5);
            for (x, y) in (0..5).flat_map(|y| (0..7).map(move |x| (x, y))) {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                let corners = [Corner::Northwest, Corner::Northeast, Corner::Southwest, Corner::Southeast];
                let shape = match state >> 28 {
                    0..7 => TileShape::Open,
                    7..11 => TileShape::Blocked,
                    other => TileShape::Diagonal(corners[other as usize % 4]),
                };
                builder.put(x, y, shape, None);
            }
            check(&builder.finish());
        }
    }

    #[test]
    fn a_free_wall_is_cut_where_it_leaves_a_tile() {
        let mut builder = crate::map::Builder::new(5, 4);
        builder.add_free_wall(Segment::new(DVec2::new(0.5, 0.5), DVec2::new(3.5, 2.0)));
        builder.add_free_wall(Segment::new(DVec2::new(2.0, 4.0), DVec2::new(2.0, 2.5)));
        let map = builder.finish();
        let pieces = map.free_wall_pieces();
        let tiles: Vec<(u32, u32)> = pieces.iter().map(|&(tile, _)| tile).collect();
        assert_eq!(tiles, [(0, 0), (1, 0), (1, 1), (2, 1), (3, 1), (2, 2), (2, 3)]);
        let length: f64 = pieces.iter().map(|(_, piece)| piece.direction().length()).sum();
        assert!((length - (11.25f64.sqrt() + 1.5)).abs() < 1e-12, "{length}");
        for ((x, y), piece) in pieces {
            for end in [piece.start, piece.end] {
                let aside = (end - corner(x, y) - 0.5).abs();
                assert!(aside.max_element() <= 0.5 + 1e-12, "{piece:?} is not in ({x}, {y})");
            }
        }
    }

    /// Every wall of a tile is a part of exactly one segment of the border, in its direction, and together they are as long.
    fn check(map: &TileMap) {
        let (width, height) = (map.width(), map.height());
        let mut walls = Vec::new();
        for (x, y) in (0..=height).flat_map(|y| (0..=width).map(move |x| (x, y))) {
            walls.extend((x < width).then(|| map.wall_above(x, y)).flatten());
            walls.extend((y < height).then(|| map.wall_left_of(x, y)).flatten());
            walls.extend((x < width && y < height).then(|| map.wall_across(x, y)).flatten());
        }
        let border = map.border();
        for wall in &walls {
            let is_part = |segment: &&Segment| {
                let along = segment.direction();
                let lies_on = |point: DVec2| {
                    let offset = point - segment.start;
                    offset.perp_dot(along) == 0.0 && (0.0..=along.dot(along)).contains(&offset.dot(along))
                };
                lies_on(wall.start) && lies_on(wall.end) && wall.direction().dot(along) > 0.0
            };
            assert_eq!(border.iter().filter(is_part).count(), 1, "{wall:?}");
        }
        let length = |segments: &[Segment]| -> f64 { segments.iter().map(|s| s.direction().length()).sum() };
        assert!((length(&walls) - length(&border)).abs() < 1e-9);
    }
}
