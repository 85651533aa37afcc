//! The border between open and blocked, as the fewest segments.

use glam::DVec2;
use maniple_geometry::Segment;

use crate::{Corner, SIZE_MAX, TileMap, TileShape};

/// Returns the border of a map; see [`TileMap::border`].
///
/// A tile edge is a wall where exactly one of the two tiles at it is blocked along it, and the hypotenuse of every
/// half-blocked tile is one. One pass over the rows lengthens, on every straight line of the lattice, the run
/// that the wall continues, or starts a new one: so runs are maximal, and no wall is in two of them.
pub(crate) fn border(map: &TileMap) -> Vec<Segment> {
    let rows: Vec<_> = map.tiles().chunks(map.width() as usize).collect();
    let mut lines = Lines::new(map.width(), map.height());
    for y in 0..=map.height() {
        let above = (y > 0).then(|| rows[y as usize - 1]);
        let below = rows.get(y as usize);
        for x in 0..map.width() {
            let is_above_blocked = above.is_none_or(|row| row[x as usize].shape.blocks_south());
            let is_below_blocked = below.is_none_or(|row| row[x as usize].shape.blocks_north());
            if is_above_blocked != is_below_blocked {
                lines.horizontal.wall(y, x, direction(is_below_blocked));
            }
        }
        let Some(row) = below else { continue };
        let mut is_left_blocked = true;
        for x in 0..=map.width() {
            let tile = row.get(x as usize).map_or(TileShape::Blocked, |tile| tile.shape);
            // Down has the blocked side to the left of the line, up to the right of it.
            if is_left_blocked != tile.blocks_west() {
                lines.vertical.wall(x, y, direction(is_left_blocked));
            }
            is_left_blocked = tile.blocks_east();
            if let TileShape::Diagonal(corner) = tile {
                lines.diagonal(x, y, corner);
            }
        }
    }
    lines.segments()
}

fn direction(is_forward: bool) -> Direction {
    if is_forward { Direction::Forward } else { Direction::Backward }
}

/// Whether a run goes the way in which its position grows. It says which side of the run is blocked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Direction {
    Forward,
    Backward,
}

/// A straight piece of border, from one position to another on its line.
#[derive(Clone, Copy)]
struct Run {
    line: u32,
    from: u32,
    to: u32,
    direction: Direction,
}

/// The runs on all lines of one of the four directions.
struct Parallels {
    /// The run that was lengthened last, per line.
    open: Vec<Option<Run>>,
    done: Vec<Run>,
}

impl Parallels {
    fn new(lines: u32) -> Self {
        Self { open: vec![None; lines as usize], done: Vec::new() }
    }

    /// Adds the wall from `position` to the one after it; positions of a line come in growing order.
    fn wall(&mut self, line: u32, position: u32, direction: Direction) {
        let open = &mut self.open[line as usize];
        match open {
            Some(run) if run.to == position && run.direction == direction => run.to += 1,
            _ => self.done.extend(open.replace(Run { line, from: position, to: position + 1, direction })),
        }
    }

    /// Returns the runs by (line, position), as segments between the points that `point(line, position)` names.
    fn segments(mut self, point: impl Fn(u32, u32) -> DVec2) -> impl Iterator<Item = Segment> {
        self.done.extend(self.open.into_iter().flatten());
        self.done.sort_unstable_by_key(|run| (run.line, run.from));
        self.done.into_iter().map(move |run| {
            let (from, to) = (point(run.line, run.from), point(run.line, run.to));
            match run.direction {
                Direction::Forward => Segment::new(from, to),
                Direction::Backward => Segment::new(to, from),
            }
        })
    }
}

struct Lines {
    height: u32,
    /// Line y, position x.
    horizontal: Parallels,
    /// Line x, position y.
    vertical: Parallels,
    /// Line x - y + height, position y: from upper left to lower right.
    falling: Parallels,
    /// Line x + y, position y: from upper right to lower left.
    rising: Parallels,
}

impl Lines {
    fn new(width: u32, height: u32) -> Self {
        Self {
            height,
            horizontal: Parallels::new(height + 1),
            vertical: Parallels::new(width + 1),
            falling: Parallels::new(width + height + 1),
            rising: Parallels::new(width + height + 1),
        }
    }

    /// Adds the hypotenuse of a half-blocked tile.
    fn diagonal(&mut self, x: u32, y: u32, corner: Corner) {
        let fallen = x + self.height - y;
        match corner {
            Corner::Northwest => self.rising.wall(x + 1 + y, y, Direction::Forward),
            Corner::Southeast => self.rising.wall(x + 1 + y, y, Direction::Backward),
            Corner::Southwest => self.falling.wall(fallen, y, Direction::Forward),
            Corner::Northeast => self.falling.wall(fallen, y, Direction::Backward),
        }
    }

    fn segments(self) -> Vec<Segment> {
        let height = f64::from(self.height);
        let mut segments: Vec<Segment> =
            self.horizontal.segments(|y, x| DVec2::new(f64::from(x), f64::from(y))).collect();
        segments.extend(self.vertical.segments(|x, y| DVec2::new(f64::from(x), f64::from(y))));
        segments.extend(
            self.falling
                .segments(|line, y| DVec2::new(f64::from(line) - height + f64::from(y), f64::from(y))),
        );
        segments
            .extend(self.rising.segments(|line, y| DVec2::new(f64::from(line) - f64::from(y), f64::from(y))));
        segments
    }
}

/// The eight directions of the lattice, clockwise on a screen from right; opposite ones are 4 apart.
const DIRECTIONS: [(i64, i64); 8] = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)];

/// Returns how many closed loops a [`TileMap::border`] forms.
///
/// Where several walls meet, as between two open tiles that touch at a corner only, the loop goes on along the wall
/// that turns most to the left, which is the open side: it stays with the open ground that it came along. So open
/// ground that touches at a corner has two loops, blocked ground that touches at a corner has one, as befits a
/// circle, which cannot pass there. Chains that do not close are not counted, nor are segments that do not run
/// between the corners of tiles along the axes or at 45 degrees.
#[must_use]
pub fn loops(border: &[Segment]) -> usize {
    let walls: Vec<Walls> = border.iter().filter_map(lattice_walls).collect();
    let right = walls.iter().map(|wall| wall.x.max(wall.x + wall.step.0 * wall.count)).max().unwrap_or(0);
    let bottom = walls.iter().map(|wall| wall.y.max(wall.y + wall.step.1 * wall.count)).max().unwrap_or(0);
    let mut corners = Corners::new(right, bottom);
    for wall in &walls {
        for index in 0..wall.count {
            let place = corners.index(wall.x + wall.step.0 * index, wall.y + wall.step.1 * index);
            corners.leaving[place] |= 1 << wall.direction;
        }
    }
    let mut count = 0;
    for place in 0..corners.leaving.len() {
        while corners.leaving[place] != corners.visited[place] {
            count += usize::from(corners.follow(place));
        }
    }
    count
}

/// A segment as walls of one tile's length, or of one tile's diagonal.
struct Walls {
    x: i64,
    y: i64,
    step: (i64, i64),
    direction: usize,
    count: i64,
}

fn lattice_walls(segment: &Segment) -> Option<Walls> {
    let (x, y) = (lattice(segment.start.x)?, lattice(segment.start.y)?);
    let (dx, dy) = (lattice(segment.end.x)? - x, lattice(segment.end.y)? - y);
    let is_straight = dx == 0 || dy == 0 || dx.abs() == dy.abs();
    let step = (dx.signum(), dy.signum());
    let direction = DIRECTIONS.iter().position(|&other| other == step)?;
    is_straight.then_some(Walls { x, y, step, direction, count: dx.abs().max(dy.abs()) })
}

#[expect(clippy::cast_possible_truncation, reason = "the number is whole and small, as just checked")]
fn lattice(value: f64) -> Option<i64> {
    let is_corner = (0.0..=f64::from(SIZE_MAX)).contains(&value) && value.floor() == value;
    is_corner.then_some(value as i64)
}

/// The corners of all tiles, each with a bit per direction.
struct Corners {
    width: i64,
    /// Where walls leave the corner.
    leaving: Vec<u8>,
    /// Which of them a walk has taken.
    visited: Vec<u8>,
}

impl Corners {
    fn new(right: i64, bottom: i64) -> Self {
        let corners = usize::try_from((right + 1) * (bottom + 1)).unwrap_or(0);
        Self { width: right + 1, leaving: vec![0; corners], visited: vec![0; corners] }
    }

    fn index(&self, x: i64, y: i64) -> usize {
        usize::try_from(y * self.width + x).unwrap_or(0)
    }

    /// Walks along the walls from a corner, each once, and returns whether the walk comes back to where it began.
    fn follow(&mut self, start: usize) -> bool {
        let first = (self.leaving[start] & !self.visited[start]).trailing_zeros() as usize;
        let (mut place, mut direction) = (start, first);
        loop {
            self.visited[place] |= 1 << direction;
            let step = DIRECTIONS[direction].1 * self.width + DIRECTIONS[direction].0;
            place = place.wrapping_add_signed(isize::try_from(step).unwrap_or(0));
            // From the sharpest left turn, 135 degrees, to the sharpest right turn.
            let leaving = self.leaving[place];
            let mut turns = (5..12).map(|turn| (direction + turn) % 8);
            let Some(next) = turns.find(|&next| leaving & 1 << next != 0) else { return false };
            if self.visited[place] & 1 << next != 0 {
                return (place, next) == (start, first);
            }
            direction = next;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::{BTreeMap, BTreeSet};

    use twox_hash::XxHash3_64;

    use super::*;
    use crate::map::Builder;
    use crate::octile;

    /// A piece of border as long as one tile edge or one tile diagonal.
    type Piece = ((i64, i64), (i64, i64));

    #[test]
    fn the_border_of_random_maps_is_complete_minimal_and_oriented() {
        for seed in 0..600 {
            let map = random_map(seed);
            let segments = map.border();
            let mut pieces = BTreeMap::new();
            for segment in &segments {
                for piece in pieces_of(segment) {
                    *pieces.entry(piece).or_insert(0) += 1;
                }
            }
            assert!(pieces.values().all(|&count| count == 1), "seed {seed}: a piece is there twice");
            let pieces: BTreeSet<Piece> = pieces.into_keys().collect();
            assert_eq!(pieces, brute_force(&map), "seed {seed}");
            for (a, b) in segments.iter().flat_map(|a| segments.iter().map(move |b| (a, b))) {
                let is_straight_on = a.end == b.start
                    && a.direction().perp_dot(b.direction()) == 0.0
                    && a.direction().dot(b.direction()) > 0.0;
                assert!(!is_straight_on, "seed {seed}: {a:?} and {b:?} could be one");
            }
        }
    }

    #[test]
    fn the_loops_of_random_maps_agree_with_their_euler_characteristic() {
        for seed in 0..600 {
            let map = random_map(seed);
            assert_eq!(loops(&map.border()), loops_by_euler(&map), "seed {seed}");
        }
    }

    #[test]
    fn an_open_map_has_its_four_edges_with_the_outside_to_the_right() {
        let map = octile::read(b"type octile\nheight 2\nwidth 3\nmap\n...\n...\n").unwrap();
        let expected = [((3, 0), (0, 0)), ((0, 2), (3, 2)), ((0, 0), (0, 2)), ((3, 2), (3, 0))];
        let found: Vec<Piece> = map.segments().iter().map(ends).collect();
        assert_eq!(found, expected);
    }

    #[test]
    fn runs_do_not_turn_over_where_open_tiles_touch_at_a_corner() {
        let map = octile::read(b"type octile\nheight 2\nwidth 2\nmap\n.@\n@.\n").unwrap();
        let border = map.border();
        assert_eq!(border.len(), 8);
        assert_eq!(loops(&border), 2);
        let blocked = octile::read(b"type octile\nheight 4\nwidth 4\nmap\n....\n.@..\n..@.\n....\n");
        assert_eq!(loops(&blocked.unwrap().border()), 2);
    }

    #[test]
    fn a_diamond_of_half_blocked_tiles_has_four_sloped_sides() {
        let mut builder = Builder::new(4, 4);
        for (x, y, corner) in [
            (1, 0, Corner::Northwest),
            (0, 1, Corner::Northwest),
            (2, 0, Corner::Northeast),
            (3, 1, Corner::Northeast),
            (0, 2, Corner::Southwest),
            (1, 3, Corner::Southwest),
            (3, 2, Corner::Southeast),
            (2, 3, Corner::Southeast),
        ] {
            builder.put(x, y, TileShape::Diagonal(corner), None);
        }
        for (x, y) in [(0, 0), (3, 0), (0, 3), (3, 3)] {
            builder.put(x, y, TileShape::Blocked, None);
        }
        let border = builder.finish().border();
        let found: Vec<Piece> = border.iter().map(ends).collect();
        let expected = [((0, 2), (2, 4)), ((4, 2), (2, 0)), ((2, 0), (0, 2)), ((2, 4), (4, 2))];
        assert_eq!(found, expected);
        assert_eq!(loops(&border), 1);
    }

    #[test]
    fn what_is_no_border_of_tiles_forms_no_loop() {
        let wall = |x1, y1, x2, y2| Segment::new(DVec2::new(x1, y1), DVec2::new(x2, y2));
        assert_eq!(loops(&[]), 0);
        assert_eq!(loops(&[wall(0.0, 0.0, 5.0, 0.0), wall(0.5, 1.0, 3.0, 1.0), wall(0.0, 0.0, 2.0, 1.0)]), 0);
        assert_eq!(
            loops(&[wall(f64::NAN, 0.0, 1e300, 0.0), wall(-1.0, 0.0, 4.0, 0.0), wall(1.0, 1.0, 1.0, 1.0)]),
            0
        );
    }

    /// A map of up to 12 x 12 tiles of all shapes; the seed says how many of which.
    fn random_map(seed: u64) -> TileMap {
        let dice = |purpose: &[u32], sides: u32| {
            let bytes: Vec<u8> = purpose.iter().flat_map(|part| part.to_le_bytes()).collect();
            u32::try_from(XxHash3_64::oneshot_with_seed(seed, &bytes) % u64::from(sides)).unwrap()
        };
        let (width, height) = (1 + dice(&[1], 12), 1 + dice(&[2], 12));
        let (open, blocked) = (1 + dice(&[3], 8), dice(&[4], 8));
        let corners = [Corner::Northwest, Corner::Northeast, Corner::Southwest, Corner::Southeast];
        let diagonals = if dice(&[5], 3) == 0 { 0 } else { 1 + dice(&[6], 6) };
        let mut builder = Builder::new(width, height);
        for y in 0..height {
            for x in 0..width {
                let at = |purpose| [purpose, x, y];
                let roll = dice(&at(7), open + blocked + diagonals);
                let corner = corners[dice(&at(8), 4) as usize];
                if roll >= open + blocked {
                    builder.put(x, y, TileShape::Diagonal(corner), None);
                } else if roll >= open {
                    builder.put(x, y, TileShape::Blocked, None);
                }
            }
        }
        builder.finish()
    }

    fn ends(segment: &Segment) -> Piece {
        let whole = |point: DVec2| (lattice(point.x).unwrap(), lattice(point.y).unwrap());
        (whole(segment.start), whole(segment.end))
    }

    fn pieces_of(segment: &Segment) -> Vec<Piece> {
        let ((x1, y1), (x2, y2)) = ends(segment);
        let count = (x2 - x1).abs().max((y2 - y1).abs());
        assert!(count > 0, "{segment:?} has no length");
        let (dx, dy) = ((x2 - x1) / count, (y2 - y1) / count);
        let point = |index| (x1 + dx * index, y1 + dy * index);
        assert_eq!(point(count), (x2, y2), "{segment:?} has an odd angle");
        (0..count).map(|index| (point(index), point(index + 1))).collect()
    }

    /// The pieces of border, found by looking at a point on either side of every edge and every diagonal.
    fn brute_force(map: &TileMap) -> BTreeSet<Piece> {
        let mut pieces = BTreeSet::new();
        for y in 0..=i64::from(map.height()) {
            for x in 0..=i64::from(map.width()) {
                for (to_x, to_y) in [(x + 1, y), (x, y + 1), (x + 1, y + 1), (x + 1, y - 1)] {
                    let (from, to) = (DVec2::new(x as f64, y as f64), DVec2::new(to_x as f64, to_y as f64));
                    // A quarter along, as the two diagonals of a tile cross in the middle.
                    let middle = from + (to - from) / 4.0;
                    let right = (to - from).perp() / 16.0;
                    match (is_blocked(map, middle + right), is_blocked(map, middle - right)) {
                        (true, false) => pieces.insert(((x, y), (to_x, to_y))),
                        (false, true) => pieces.insert(((to_x, to_y), (x, y))),
                        _ => false,
                    };
                }
            }
        }
        pieces
    }

    fn is_blocked(map: &TileMap, point: DVec2) -> bool {
        let (x, y) = (point.x.floor(), point.y.floor());
        let is_inside = x >= 0.0 && y >= 0.0 && x < f64::from(map.width()) && y < f64::from(map.height());
        if !is_inside {
            return true;
        }
        let (right, down) = (point.x - x, point.y - y);
        match map.tile(map.tile_at(point).0, map.tile_at(point).1).shape {
            TileShape::Open => false,
            TileShape::Blocked => true,
            TileShape::Diagonal(Corner::Northwest) => right + down < 1.0,
            TileShape::Diagonal(Corner::Northeast) => right > down,
            TileShape::Diagonal(Corner::Southwest) => right < down,
            TileShape::Diagonal(Corner::Southeast) => right + down > 1.0,
        }
    }

    /// Every tile is four triangles around its middle. With C parts of open ground and H holes in them, the open
    /// triangles, minus the edges between them, plus the points within them, are C - H; the loops are C + H.
    fn loops_by_euler(map: &TileMap) -> usize {
        let (width, height) = (i64::from(map.width()), i64::from(map.height()));
        // North, east, south, west of the middle of a tile.
        let offsets = [(0.5, 0.25), (0.75, 0.5), (0.5, 0.75), (0.25, 0.5)];
        let is_open = |(x, y, side): (i64, i64, usize)| {
            !is_blocked(map, DVec2::new(x as f64 + offsets[side].0, y as f64 + offsets[side].1))
        };
        let mut open: BTreeSet<_> = (0..width)
            .flat_map(|x| (0..height).flat_map(move |y| (0..4).map(move |side| (x, y, side))))
            .filter(|&triangle| is_open(triangle))
            .collect();
        let next_to = |(x, y, side): (i64, i64, usize)| {
            let across = [(x, y - 1, 2), (x + 1, y, 3), (x, y + 1, 0), (x - 1, y, 1)][side];
            [(x, y, (side + 1) % 4), (x, y, (side + 3) % 4), across]
        };
        let borders =
            open.iter().flat_map(|&triangle| next_to(triangle)).filter(|&other| is_open(other)).count();
        let mut points = 0_isize;
        for (x, y) in (0..=width).flat_map(|x| (0..=height).map(move |y| (x, y))) {
            let around = [(x - 1, y - 1, [1, 2]), (x, y - 1, [2, 3]), (x - 1, y, [0, 1]), (x, y, [0, 3])];
            points +=
                isize::from(around.iter().all(|&(x, y, sides)| sides.iter().all(|&s| is_open((x, y, s)))));
            points += isize::from((0..4).all(|side| is_open((x, y, side))));
        }
        let characteristic = open.len().cast_signed() - borders.cast_signed() / 2 + points;
        let mut parts = 0;
        while let Some(first) = open.pop_first() {
            parts += 1;
            let mut waiting = vec![first];
            while let Some(triangle) = waiting.pop() {
                waiting.extend(next_to(triangle).into_iter().filter(|other| open.remove(other)));
            }
        }
        usize::try_from(2 * parts - characteristic).unwrap()
    }
}
