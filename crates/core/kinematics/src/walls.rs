//! The walls, by where they are.

use glam::DVec2;
use maniple_geometry::{Planar, Scalar};

use crate::runs::Runs;
use crate::squares::Squares;
use crate::wall::Wall;

/// Edge of the smallest squares, in world units: walls come from tiles, which are one unit wide. With 2 a cycle on a map of
/// many walls took a third longer.
const EDGE_MIN: f64 = 1.0;

/// A wall that would lie in more squares than this along a side goes to larger ones.
const SQUARES_A_WALL_MAX: f64 = 512.0;

/// Squares for each one that a wall passes: most squares have no wall near, so that most objects meet none. Walls are few, and
/// a square costs 8 bytes and a bit.
const SQUARES_A_PASSED: f64 = 4.0;

/// The fewest squares of a level: in a smaller table all places of the plane are near each other. As many as a map of 256
/// tiles has.
const SQUARES_MIN: f64 = (1u32 << 16) as f64;

/// The most squares of a level: 2^22, 33 MiB.
const SQUARES_MAX: f64 = (1u32 << 22) as f64;

/// How much larger the squares of the next level are.
const EDGE_STEP: f64 = 4.0;

/// Walls in numbered places, and lists of them by squares; long ones in larger squares. A change costs as much as the wall
/// is long, however many there are.
///
/// The list of a square holds all walls that come within an edge of it. So who reaches no further than an edge looks into one
/// square only, that of its centre.
#[derive(Clone, Debug)]
pub(crate) struct Walls<S: Scalar> {
    walls: Vec<Option<Wall<S>>>,
    free: Vec<u32>,
    levels: Vec<Level>,
}

#[derive(Clone, Debug)]
struct Level {
    edge: f64,
    squares: Squares,
    /// For each square the walls that come near it.
    lists: Runs<u32>,
    /// For each square one bit, whether its list is not empty: all that most objects ask for, and small enough for the nearer
    /// caches.
    walled: Vec<u64>,
    held: usize,
    /// How many squares of the plane the walls pass, about; more than of the table, where they come round.
    passed: f64,
}

impl<S: Scalar> Walls<S> {
    pub(crate) fn new() -> Self {
        Self { walls: Vec::new(), free: Vec::new(), levels: Vec::new() }
    }

    /// Puts a wall in and returns its number.
    pub(crate) fn insert(&mut self, wall: Wall<S>) -> u32 {
        let number = self.free.pop().unwrap_or_else(|| {
            self.walls.push(None);
            u32::try_from(self.walls.len() - 1).expect("walls are numbered with 32 bits")
        });
        self.walls[number as usize] = Some(wall);
        let place = self.level_of(&wall);
        let level = &mut self.levels[place];
        level.passed += squares_passed(&wall, level.edge);
        if squares_wanted(level.passed) > level.squares.count() {
            let wanted = squares_wanted(2.0 * level.passed);
            self.grow(place, wanted);
        } else {
            self.link(place, number);
        }
        number
    }

    /// Takes a wall out; `None` where there is none of this number.
    pub(crate) fn remove(&mut self, number: u32) -> Option<Wall<S>> {
        let wall = (*self.walls.get(number as usize)?)?;
        let place = self.level_of(&wall);
        let level = &mut self.levels[place];
        let Level { squares, lists, walled, held, edge, passed } = level;
        *passed -= squares_passed(&wall, *edge);
        visit_squares(squares, *edge, &wall, |square| {
            assert!(lists.remove(square, |&listed| listed == number), "the wall was listed here");
            *held -= 1;
            if lists.list(square).is_empty() {
                walled[square / 64] &= !(1 << (square % 64));
            }
        });
        self.walls[number as usize] = None;
        self.free.push(number);
        Some(wall)
    }

    /// Visits the walls that come within `reach` of a point, up to rounding, some of them more than once.
    #[inline]
    pub(crate) fn near(&self, center: DVec2, reach: f64, mut visit: impl FnMut(&Wall<S>)) {
        self.near_numbered(center, reach, |_, wall| visit(wall));
    }

    /// As [`Walls::near`], with the number of each wall.
    #[inline]
    pub(crate) fn near_numbered(&self, center: DVec2, reach: f64, mut visit: impl FnMut(u32, &Wall<S>)) {
        for level in self.levels.iter().filter(|level| level.held > 0) {
            let mut look_into = |square: usize| {
                for &number in level.lists.list(square) {
                    let wall = self.walls[number as usize].as_ref().expect("a listed wall is there");
                    if comes_near(wall, center, reach) {
                        visit(number, wall);
                    }
                }
            };
            if reach <= level.edge {
                look_into(level.square_of(center));
            } else {
                let (low, high) =
                    (center - DVec2::splat(reach - level.edge), center + DVec2::splat(reach - level.edge));
                level.squares.visit((low.x, low.y), (high.x, high.y), look_into);
            }
        }
    }

    /// Asks for the walls near some points, one right after the other, so that the memory answers all at once when they are
    /// looked at next.
    pub(crate) fn fetch(&self, centers: impl Iterator<Item = DVec2>) {
        let mut seen = 0;
        for center in centers {
            for level in &self.levels {
                if let [first, .., last] | [first @ last] = level.lists.list(level.square_of(center)) {
                    let start = |&number: &u32| {
                        self.walls[number as usize].map_or(S::ZERO, |wall| wall.segment.start.x())
                    };
                    seen ^= start(first).to_f64().to_bits() ^ start(last).to_f64().to_bits();
                }
            }
        }
        std::hint::black_box(seen);
    }

    /// Returns whether it is plain that no wall comes within `reach` of a point.
    #[inline]
    pub(crate) fn is_clear(&self, center: DVec2, reach: f64) -> bool {
        self.levels.iter().all(|level| level.is_clear(center, reach))
    }

    /// Bytes on the heap.
    pub(crate) fn bytes(&self) -> usize {
        let level = |level: &Level| level.lists.bytes() + size_of::<u64>() * level.walled.capacity();
        size_of::<u32>() * self.free.capacity()
            + size_of::<Option<Wall<S>>>() * self.walls.capacity()
            + self.levels.iter().map(level).sum::<usize>()
    }

    /// The place of the level for a wall; made if it is not there.
    fn level_of(&mut self, wall: &Wall<S>) -> usize {
        let extent = wall.segment.end.to_dvec2() - wall.segment.start.to_dvec2();
        let longer = if extent.x.abs() > extent.y.abs() { extent.x.abs() } else { extent.y.abs() };
        let mut edge = EDGE_MIN;
        while longer > SQUARES_A_WALL_MAX * edge {
            edge *= EDGE_STEP;
        }
        if let Some(place) = self.levels.iter().position(|level| level.edge == edge) {
            return place;
        }
        self.levels.push(Level::new(edge, 0));
        self.levels.len() - 1
    }

    /// Makes at least so many squares; all walls of the level are listed anew.
    fn grow(&mut self, place: usize, count: usize) {
        let Level { edge, passed, .. } = self.levels[place];
        self.levels[place] = Level { passed, ..Level::new(edge, count) };
        for number in (0..self.walls.len()).filter_map(|number| u32::try_from(number).ok()) {
            if let Some(wall) = self.walls[number as usize]
                && self.level_of(&wall) == place
            {
                self.link(place, number);
            }
        }
    }

    fn link(&mut self, place: usize, number: u32) {
        let wall = self.walls[number as usize].expect("the wall was just put in");
        let Level { squares, lists, walled, held, edge, .. } = &mut self.levels[place];
        visit_squares(squares, *edge, &wall, |square| {
            lists.push(square, number);
            walled[square / 64] |= 1 << (square % 64);
            *held += 1;
        });
    }
}

impl Level {
    #[inline]
    fn is_clear(&self, center: DVec2, reach: f64) -> bool {
        let square = self.square_of(center);
        reach <= self.edge && self.walled[square / 64] >> (square % 64) & 1 == 0
    }

    #[inline]
    fn square_of(&self, point: DVec2) -> usize {
        self.squares.place(self.squares.row(point.y), self.squares.column(point.x))
    }

    fn new(edge: f64, count: usize) -> Self {
        let squares = Squares::new(edge, count);
        let walled = vec![0; squares.count().div_ceil(64)];
        Self { edge, squares, lists: Runs::new(squares.count()), walled, held: 0, passed: 0.0 }
    }
}

/// Returns whether a wall comes within `reach` of a point, up to rounding.
#[inline]
fn comes_near<S: Scalar>(wall: &Wall<S>, point: DVec2, reach: f64) -> bool {
    let (start, end) = (wall.segment.start.to_dvec2(), wall.segment.end.to_dvec2());
    let (e, q, p) = (end - start, point - start, point - end);
    let (foot, cross, length, square) = (e.dot(q), e.perp_dot(q), e.dot(e), reach * reach);
    let beside = (foot >= 0.0) & (foot <= length) & (cross * cross <= square * length);
    beside | (q.dot(q) <= square) | (p.dot(p) <= square)
}

/// How many squares a level wants whose walls pass so many.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a rough number is enough")]
fn squares_wanted(passed: f64) -> usize {
    let wanted = SQUARES_A_PASSED * passed;
    between(wanted, SQUARES_MIN, SQUARES_MAX) as usize
}

/// How many squares of the plane a wall passes, about.
fn squares_passed<S: Scalar>(wall: &Wall<S>, edge: f64) -> f64 {
    let extent = wall.segment.end.to_dvec2() - wall.segment.start.to_dvec2();
    (extent.x.abs() + extent.y.abs()) / edge + 1.0
}

/// Visits the squares that a wall comes within an edge of, and perhaps some more; the same ones each time it is asked.
fn visit_squares<S: Scalar>(squares: &Squares, edge: f64, wall: &Wall<S>, mut visit: impl FnMut(usize)) {
    let (start, end) = (wall.segment.start.to_dvec2(), wall.segment.end.to_dvec2());
    let (left, right) = ordered(start.x, end.x);
    let (top, bottom) = ordered(start.y, end.y);
    // A part of a square more outweighs the rounding.
    let room = edge + edge / 64.0;
    if right - left < edge || bottom - top < edge {
        squares.visit((left - room, top - room), (right + room, bottom + room), visit);
        return;
    }
    let slope = (end.x - start.x) / (end.y - start.y);
    let x_at = |y: f64| between(start.x + (between(y, top, bottom) - start.y) * slope, left, right);
    // One row of squares in the plane after the other; in the table they may come round to the same row.
    let mut middle = ((top - room) / edge).round_ties_even() * edge;
    while middle - 0.5 * edge <= bottom + room {
        let (low, high) = ordered(x_at(middle - 0.5 * edge - room), x_at(middle + 0.5 * edge + room));
        let row = squares.row(middle);
        for column in squares.columns_from(low - room, high + room) {
            visit(squares.place(row, column));
        }
        middle += edge;
    }
}

fn ordered(a: f64, b: f64) -> (f64, f64) {
    if a < b { (a, b) } else { (b, a) }
}

fn between(value: f64, low: f64, high: f64) -> f64 {
    if value < low {
        low
    } else if value > high {
        high
    } else {
        value
    }
}
