//! The walls, by the tiles near which they are.

use glam::DVec2;
use maniple_geometry::{Scalar, Segment};
use maniple_tilemap::{Corner, TileMap, TileShape};

/// Half of the diagonal of a tile, rounded up by more than what [`NUDGE`] can skip, in world units.
const TILE_RADIUS: f64 = 0.7072;

/// How far beyond the edge of a tile the walk along a leg goes on, in world units, so that it comes out of it. What is
/// skipped is near to what is not: [`TILE_RADIUS`] has room for it.
const NUDGE: f64 = 1.0 / (1u64 << 20) as f64;

/// The walls of a map, for legs that have to keep one distance from all of them.
#[derive(Clone, Debug)]
pub(crate) struct Walls {
    width: u32,
    height: u32,
    reach: f64,
    segments: Vec<Segment>,
    shapes: Vec<TileShape>,
    /// For each tile how many steps it is to the nearest one in which a wall can be.
    steps: Vec<u8>,
    /// Where the walls of each tile begin in `near`, and where those of the last one end.
    firsts: Vec<u32>,
    /// The walls that are nearer than `reach` to some point of a tile.
    near: Vec<u32>,
}

impl Walls {
    /// Returns the index of walls of the map for legs that keep `reach` from them, in world units.
    pub(crate) fn new(map: &TileMap, segments: Vec<Segment>, reach: f64) -> Self {
        let mut walls = Self {
            width: map.width(),
            height: map.height(),
            reach,
            segments,
            shapes: map.tiles().iter().map(|tile| tile.shape).collect(),
            steps: Vec::new(),
            firsts: Vec::new(),
            near: Vec::new(),
        };
        walls.steps = steps(map);
        walls.fill();
        walls
    }

    /// Returns all walls.
    pub(crate) fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// Returns whether the middle of a circle can be in a point.
    pub(crate) fn holds(&self, point: DVec2) -> bool {
        self.blocker(point, point).is_none() && self.is_open(point)
    }

    /// Returns whether a circle can go straight from one point, which holds it, to another.
    pub(crate) fn is_clear(&self, from: DVec2, to: DVec2) -> bool {
        self.is_within(to) && self.blocker(from, to).is_none()
    }

    /// Returns how far the middle of a circle can go from a point of the map in any direction at least; negative where that is not known.
    pub(crate) fn clear_around(&self, point: DVec2) -> f64 {
        self.leap(self.tile(point))
    }

    /// Returns whether the roomiest point of the tile of a point is so far from every wall.
    pub(crate) fn has_room(&self, point: DVec2, room: f64) -> bool {
        let steps = f64::from(self.steps[self.tile(point)]);
        // A corner is not farther from walls than there are steps from any of its tiles.
        steps - 0.5 >= room || (steps >= room && self.roomiest(point).1 >= room)
    }

    /// Returns the roomiest point of the tile of a point, its middle or a corner, and how far from every wall that is at least, in world
    /// units.
    pub(crate) fn roomiest(&self, point: DVec2) -> (DVec2, f64) {
        let low = DVec2::new(point.x.floor(), point.y.floor());
        let steps =
            |point: DVec2| if self.is_within(point) { f64::from(self.steps[self.tile(point)]) } else { 0.0 };
        let middle = low + 0.5;
        let mut best = (middle, steps(middle) - 0.5);
        for aside in [(-0.5, -0.5), (0.5, -0.5), (-0.5, 0.5), (0.5, 0.5)].map(DVec2::from) {
            let corner = middle + aside;
            let tiles = [middle, corner + aside, corner + aside.perp(), corner - aside.perp()];
            let least = tiles.map(steps).into_iter().fold(f64::INFINITY, Scalar::lesser);
            if least > best.1 {
                best = (corner, least);
            }
        }
        best
    }

    /// Returns the walls near the tile of a point.
    pub(crate) fn near(&self, point: DVec2) -> impl Iterator<Item = &Segment> {
        let tile = self.tile(point);
        let range = self.firsts[tile] as usize..self.firsts[tile + 1] as usize;
        self.near[range].iter().map(|&wall| &self.segments[wall as usize])
    }

    /// Returns the first wall found that is nearer to the line between two points of the map than the reach; `None` where
    /// every wall keeps the distance.
    ///
    /// Looks at the tiles under the line alone: each knows the walls that are within reach of any point of it. Where
    /// none can be, the walk leaps as far as none can.
    pub(crate) fn blocker(&self, from: DVec2, to: DVec2) -> Option<&Segment> {
        let leg = Segment::new(from, to);
        let length = leg.length();
        let unit = if length > 0.0 { leg.direction() / length } else { DVec2::ZERO };
        let beyond = self.reach + NUDGE;
        let mut along = 0.0;
        let mut last = u32::MAX;
        while along <= length {
            let point = from + unit * along;
            let tile = self.tile(point);
            let leap = self.leap(tile);
            if leap <= 0.0 {
                for &wall in &self.near[self.firsts[tile] as usize..self.firsts[tile + 1] as usize] {
                    let segment = &self.segments[wall as usize];
                    let is_aside = is_aside((from, unit, length), segment, beyond);
                    if wall != last && !is_aside && !is_apart(&leg, segment, self.reach) {
                        return Some(segment);
                    }
                    last = wall;
                }
            }
            along += leap.greater(way_out(point, unit));
        }
        None
    }

    /// Returns how far the middle of a circle, which is held by a point of the map, comes in a direction of length 1 until it is nearer
    /// to a wall than the reach, up to rounding; infinity where that is `far` or more.
    pub(crate) fn way_ahead(&self, from: DVec2, unit: DVec2, far: f64) -> f64 {
        let mut nearest = f64::INFINITY;
        let mut along = 0.0;
        while along <= far.lesser(nearest) {
            let point = from + unit * along;
            let tile = self.tile(point);
            let leap = self.leap(tile);
            if leap <= 0.0 {
                for &wall in &self.near[self.firsts[tile] as usize..self.firsts[tile + 1] as usize] {
                    let wall = &self.segments[wall as usize];
                    nearest = nearest.lesser(way_to(wall, (from, unit), self.reach));
                }
            }
            along += leap.greater(way_out(point, unit));
        }
        if nearest < far { nearest } else { f64::INFINITY }
    }

    /// How far it is from every point of a tile at least to where a circle touches a wall; negative where it may be within the tile.
    fn leap(&self, tile: usize) -> f64 {
        f64::from(self.steps[tile]) - (self.reach + 1.0)
    }

    /// Returns whether a point is on the map.
    pub(crate) fn is_within(&self, point: DVec2) -> bool {
        let (width, height) = (f64::from(self.width), f64::from(self.height));
        (0.0..=width).contains(&point.x) && (0.0..=height).contains(&point.y)
    }

    /// Returns whether a point is in the open part of its tile.
    fn is_open(&self, point: DVec2) -> bool {
        let (right, down) = (point.x - point.x.floor(), point.y - point.y.floor());
        self.is_within(point)
            && match self.shapes[self.tile(point)] {
                TileShape::Open => true,
                TileShape::Blocked => false,
                TileShape::Diagonal(Corner::Northwest) => right + down > 1.0,
                TileShape::Diagonal(Corner::Northeast) => right < down,
                TileShape::Diagonal(Corner::Southwest) => right > down,
                TileShape::Diagonal(Corner::Southeast) => right + down < 1.0,
            }
    }

    /// The tile of a point, or the nearest one.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the cast stops at both ends"
    )]
    fn tile(&self, point: DVec2) -> usize {
        let (x, y) = ((point.x as u32).min(self.width - 1), (point.y as u32).min(self.height - 1));
        y as usize * self.width as usize + x as usize
    }

    /// Lists the walls of each tile: counted first, so that one list holds them all.
    fn fill(&mut self) {
        let tiles = self.steps.len();
        let mut firsts = vec![0_u32; tiles + 1];
        self.visit(|tile, _| firsts[tile + 1] += 1);
        for tile in 0..tiles {
            firsts[tile + 1] += firsts[tile];
        }
        let mut near = vec![0; firsts[tiles] as usize];
        let mut next = firsts.clone();
        self.visit(|tile, wall| {
            near[next[tile] as usize] = wall;
            next[tile] += 1;
        });
        (self.firsts, self.near) = (firsts, near);
    }

    /// Tells every tile and every wall that is within reach of some point of it, wall by wall.
    fn visit(&self, mut tell: impl FnMut(usize, u32)) {
        let around = self.reach + TILE_RADIUS;
        for (wall, segment) in (0..).zip(&self.segments) {
            let (top, bottom) = ordered(segment.start.y, segment.end.y);
            for y in tiles_from_to(top - around, bottom + around, self.height) {
                let (left, right) = part(segment, f64::from(y) + 0.5, around);
                for x in tiles_from_to(left - around, right + around, self.width) {
                    let middle = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                    if segment.nearest(middle).distance_squared(middle) <= around * around {
                        tell(y as usize * self.width as usize + x as usize, wall);
                    }
                }
            }
        }
    }
}

/// Returns whether the distance between two lines is `reach` or more.
///
/// Lines that do not cross are nearest to each other in an end of one of them. All in rounded arithmetic: the margin of the
/// planner is a hundred million times the error.
pub(crate) fn is_apart(leg: &Segment, wall: &Segment, reach: f64) -> bool {
    let square = reach * reach;
    let far = |point: DVec2, line: &Segment| line.nearest(point).distance_squared(point) >= square;
    let is_apart_at_ends = far(leg.start, wall) && far(leg.end, wall);
    if leg.start == leg.end || !is_apart_at_ends {
        return is_apart_at_ends;
    }
    let (along, side) = (leg.direction(), wall.direction());
    let (from, to) = (wall.start - leg.start, wall.end - leg.start);
    let crosses = along.perp_dot(from) * along.perp_dot(to) < 0.0
        && side.perp_dot(-from) * side.perp_dot(leg.end - wall.start) < 0.0;
    !crosses && far(wall.start, leg) && far(wall.end, leg)
}

/// How far a point comes in a direction of length 1 until it is nearer to a wall than `reach`; infinity where it never is.
///
/// All that near is bounded by two lines beside the wall, and by a circle around each end of it.
fn way_to(wall: &Segment, (from, unit): (DVec2, DVec2), reach: f64) -> f64 {
    let (length, direction) = (wall.length(), wall.direction());
    let along = if length > 0.0 { direction / length } else { DVec2::ZERO };
    let offset = from - wall.start;
    let (side, turn) = (along.perp_dot(offset), along.perp_dot(unit));
    let mut nearest = f64::INFINITY;
    if side * turn < 0.0 && side.abs() >= reach {
        let way = (side.abs() - reach) / turn.abs();
        let place = along.dot(offset + unit * way);
        if (0.0..=length).contains(&place) {
            nearest = way;
        }
    }
    for end in [wall.start, wall.end] {
        let away = from - end;
        let slope = unit.dot(away);
        let square = slope * slope - (away.length_squared() - reach * reach);
        if slope < 0.0 && square > 0.0 {
            nearest = nearest.lesser((-slope - square.sqrt()).greater(0.0));
        }
    }
    nearest
}

/// Returns whether a wall is for sure farther than a distance from a line, by its start, its direction of length 1 and its length: if it
/// lies wholly to one side, behind it or before it. It is asked first, as it takes no roots and no divisions, and is so of most walls.
fn is_aside((from, unit, length): (DVec2, DVec2, f64), wall: &Segment, distance: f64) -> bool {
    let (start, end) = (wall.start - from, wall.end - from);
    let (side, other_side) = (unit.perp_dot(start), unit.perp_dot(end));
    let (ahead, other_ahead) = (unit.dot(start), unit.dot(end));
    (side > distance && other_side > distance)
        || (side < -distance && other_side < -distance)
        || (ahead > length + distance && other_ahead > length + distance)
        || (ahead < -distance && other_ahead < -distance)
}

/// How far a point comes in a direction of length 1 until it is just out of its tile.
fn way_out(point: DVec2, unit: DVec2) -> f64 {
    way_to_edge(point.x, unit.x).lesser(way_to_edge(point.y, unit.y)) + NUDGE
}

/// How far a point is from the edge of its tile that it moves towards along one axis, in the direction's lengths.
fn way_to_edge(coordinate: f64, direction: f64) -> f64 {
    let inside = coordinate - whole(coordinate);
    if direction > 0.0 {
        (1.0 - inside) / direction
    } else if direction < 0.0 {
        inside / -direction
    } else {
        f64::INFINITY
    }
}

/// A coordinate rounded down: without the call that `floor` is on processors of which nothing is known.
#[expect(clippy::cast_possible_truncation, reason = "the cast stops at both ends, far beyond every map")]
fn whole(coordinate: f64) -> f64 {
    let whole = f64::from(coordinate as i32);
    if whole > coordinate { whole - 1.0 } else { whole }
}

fn ordered(a: f64, b: f64) -> (f64, f64) {
    if b < a { (b, a) } else { (a, b) }
}

/// The smallest and the largest x of the part of a wall that is not farther than `around` above or below a height.
fn part(wall: &Segment, middle: f64, around: f64) -> (f64, f64) {
    let rise = wall.end.y - wall.start.y;
    if rise.abs() <= 2.0 * around {
        return ordered(wall.start.x, wall.end.x);
    }
    let at = |y: f64| {
        let share = (y - wall.start.y) / rise;
        let share = if share < 0.0 { 0.0 } else { share };
        let share = if share > 1.0 { 1.0 } else { share };
        wall.start.x + (wall.end.x - wall.start.x) * share
    };
    ordered(at(middle - around), at(middle + around))
}

/// The tiles of an axis whose points lie between two coordinates.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the cast stops at both ends")]
fn tiles_from_to(from: f64, to: f64, size: u32) -> std::ops::Range<u32> {
    from.floor() as u32..(to.ceil() as u32).min(size)
}

/// For each tile how many steps it is to the nearest tile in which a wall can be, at most 255: none for such a tile itself. Between the
/// two tiles there are so many world units, less one.
///
/// The border of open ground is part of a tile that is not open, or of the edge of the map. Two passes over the tiles, from
/// the upper left and from the lower right, give the chessboard distance (Rosenfeld and Pfaltz, *Distance Functions
/// on Digital Pictures*, 1968).
fn steps(map: &TileMap) -> Vec<u8> {
    let (width, height) = (map.width() as usize, map.height() as usize);
    let mut steps: Vec<u8> =
        map.tiles().iter().map(|tile| if tile.shape == TileShape::Open { u8::MAX } else { 0 }).collect();
    for wall in map.free_walls() {
        let (top, bottom) = ordered(wall.start.y, wall.end.y);
        for y in tiles_from_to(top - 1.0, bottom + 1.0, map.height()) {
            let (left, right) = part(wall, f64::from(y) + 0.5, 1.0);
            for x in tiles_from_to(left - 1.0, right + 1.0, map.width()) {
                steps[y as usize * width + x as usize] = 0;
            }
        }
    }
    let at = |steps: &[u8], x: usize, y: usize| {
        // One more on each side stands for the outside.
        if x == 0 || y == 0 || x > width || y > height { 0 } else { steps[(y - 1) * width + x - 1] }
    };
    let pass = |steps: &mut [u8], x: usize, y: usize, around: [(usize, usize); 4]| {
        let least = around.iter().map(|&(x, y)| at(steps, x, y)).min().unwrap_or(0).saturating_add(1);
        let own = &mut steps[(y - 1) * width + x - 1];
        *own = least.min(*own);
    };
    for y in 1..=height {
        for x in 1..=width {
            pass(&mut steps, x, y, [(x - 1, y - 1), (x, y - 1), (x + 1, y - 1), (x - 1, y)]);
        }
    }
    for y in (1..=height).rev() {
        for x in (1..=width).rev() {
            pass(&mut steps, x, y, [(x + 1, y), (x - 1, y + 1), (x, y + 1), (x + 1, y + 1)]);
        }
    }
    steps
}
