//! The walls, by where they are.

use glam::DVec2;
use maniple_geometry::{Planar, Scalar};

use crate::squares::Squares;
use crate::wall::Wall;

/// As a link: the end of a list.
const END: u32 = u32::MAX;

/// Edge of the smallest squares, in world units: walls come from tiles, which are one unit wide. With 2 a cycle on a map of
/// many walls took a third longer.
const EDGE_MIN: f64 = 1.0;

/// A wall that would lie in more squares than this along a side goes to larger ones.
const SQUARES_A_WALL_MAX: f64 = 512.0;

/// Squares for each one that a wall passes: most squares have no wall, so that most objects meet none. Walls are few, and a square
/// costs 4 bytes.
const SQUARES_A_PASSED: f64 = 16.0;

/// The most squares of a level: 2^22, 32 MiB.
const SQUARES_MAX: f64 = (1u32 << 22) as f64;

/// How much larger the squares of the next level are.
const EDGE_STEP: f64 = 4.0;

/// Walls in numbered places, and lists of them by the squares that they pass; long ones in larger squares. A change
/// costs as much as the wall is long, however many there are.
#[derive(Clone, Debug)]
pub(crate) struct Walls<S: Scalar> {
    walls: Vec<Option<Wall<S>>>,
    free: Vec<u32>,
    levels: Vec<Level>,
    entries: Vec<Entry>,
    free_entry: u32,
}

#[derive(Clone, Debug)]
struct Level {
    edge: f64,
    squares: Squares,
    heads: Vec<u32>,
    /// For each square how many entries there are in it and in the eight around it.
    around: Vec<u32>,
    held: usize,
    /// How many squares of the plane the walls pass, about; more than of the table, where they come round.
    passed: f64,
}

/// A wall in the list of a square.
#[derive(Clone, Copy, Debug)]
struct Entry {
    /// The bounding box of the wall, so that most walls need not be fetched.
    low: DVec2,
    high: DVec2,
    wall: u32,
    next: u32,
}

impl Entry {
    fn new<S: Scalar>(number: u32, wall: &Wall<S>, next: u32) -> Self {
        let (start, end) = (wall.segment.start.to_dvec2(), wall.segment.end.to_dvec2());
        let ((left, right), (top, bottom)) = (ordered(start.x, end.x), ordered(start.y, end.y));
        Self { low: DVec2::new(left, top), high: DVec2::new(right, bottom), wall: number, next }
    }

    #[inline]
    fn meets(&self, low: DVec2, high: DVec2) -> bool {
        self.low.x <= high.x && low.x <= self.high.x && self.low.y <= high.y && low.y <= self.high.y
    }
}

impl<S: Scalar> Walls<S> {
    pub(crate) fn new() -> Self {
        Self { walls: Vec::new(), free: Vec::new(), levels: Vec::new(), entries: Vec::new(), free_entry: END }
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
        let Self { levels, entries, free_entry, .. } = self;
        let level = &mut levels[place];
        let Level { squares, heads, around, held, edge, passed } = level;
        *passed -= squares_passed(&wall, *edge);
        visit_squares(squares, *edge, &wall, |square| {
            let mut link = heads[square];
            let mut before = END;
            while entries[link as usize].wall != number {
                before = link;
                link = entries[link as usize].next;
            }
            let after = std::mem::replace(&mut entries[link as usize].next, *free_entry);
            *free_entry = link;
            *held -= 1;
            squares.visit_around(square, |near| around[near] -= 1);
            if before == END {
                heads[square] = after;
            } else {
                entries[before as usize].next = after;
            }
        });
        self.walls[number as usize] = None;
        self.free.push(number);
        Some(wall)
    }

    /// Visits the walls that may come within `reach` of a point, some of them more than once.
    #[inline]
    pub(crate) fn near(&self, center: DVec2, reach: f64, mut visit: impl FnMut(&Wall<S>)) {
        self.near_numbered(center, reach, |_, wall| visit(wall));
    }

    /// As [`Walls::near`], with the number of each wall.
    #[inline]
    pub(crate) fn near_numbered(&self, center: DVec2, reach: f64, mut visit: impl FnMut(u32, &Wall<S>)) {
        let (low, high) = (center - DVec2::splat(reach), center + DVec2::splat(reach));
        let mut last = END;
        for level in self.levels.iter().filter(|level| level.held > 0) {
            if level.is_clear(center, reach) {
                continue;
            }
            level.squares.visit((low.x, low.y), (high.x, high.y), |square| {
                let mut link = level.heads[square];
                while link != END {
                    let entry = &self.entries[link as usize];
                    if entry.meets(low, high) && entry.wall != last {
                        last = entry.wall;
                        let wall = self.walls[entry.wall as usize].as_ref();
                        visit(entry.wall, wall.expect("a listed wall is there"));
                    }
                    link = entry.next;
                }
            });
        }
    }

    /// Returns whether it is plain that no wall comes within `reach` of a point.
    #[inline]
    pub(crate) fn is_clear(&self, center: DVec2, reach: f64) -> bool {
        self.levels.iter().all(|level| level.is_clear(center, reach))
    }

    /// Bytes on the heap.
    pub(crate) fn bytes(&self) -> usize {
        let squares: usize =
            self.levels.iter().map(|level| level.heads.capacity() + level.around.capacity()).sum();
        size_of::<u32>() * (squares + self.free.capacity())
            + size_of::<Entry>() * self.entries.capacity()
            + size_of::<Option<Wall<S>>>() * self.walls.capacity()
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
        let Level { edge, ref heads, .. } = self.levels[place];
        for &head in heads {
            let mut link = head;
            while link != END {
                let next = std::mem::replace(&mut self.entries[link as usize].next, self.free_entry);
                self.free_entry = link;
                link = next;
            }
        }
        let passed = self.levels[place].passed;
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
        let Self { levels, entries, free_entry, .. } = self;
        let Level { squares, heads, around, held, edge, .. } = &mut levels[place];
        visit_squares(squares, *edge, &wall, |square| {
            let entry = Entry::new(number, &wall, heads[square]);
            heads[square] = *free_entry;
            *held += 1;
            squares.visit_around(square, |near| around[near] += 1);
            if *free_entry == END {
                heads[square] = u32::try_from(entries.len()).expect("entries are numbered with 32 bits");
                entries.push(entry);
            } else {
                *free_entry = std::mem::replace(&mut entries[heads[square] as usize], entry).next;
            }
        });
    }
}

impl Level {
    #[inline]
    fn is_clear(&self, center: DVec2, reach: f64) -> bool {
        let middle = self.squares.place(self.squares.row(center.y), self.squares.column(center.x));
        reach <= self.edge && self.around[middle] == 0
    }

    fn new(edge: f64, count: usize) -> Self {
        let squares = Squares::new(edge, count);
        let count = squares.count();
        Self { edge, squares, heads: vec![END; count], around: vec![0; count], held: 0, passed: 0.0 }
    }
}

/// How many squares a level wants whose walls pass so many.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a rough number is enough")]
fn squares_wanted(passed: f64) -> usize {
    let wanted = SQUARES_A_PASSED * passed;
    (if wanted < SQUARES_MAX { wanted } else { SQUARES_MAX }) as usize
}

/// How many squares of the plane a wall passes, about.
fn squares_passed<S: Scalar>(wall: &Wall<S>, edge: f64) -> f64 {
    let extent = wall.segment.end.to_dvec2() - wall.segment.start.to_dvec2();
    (extent.x.abs() + extent.y.abs()) / edge + 1.0
}

/// Visits the squares that a wall passes, and perhaps some beside it; the same ones each time it is asked.
fn visit_squares<S: Scalar>(squares: &Squares, edge: f64, wall: &Wall<S>, mut visit: impl FnMut(usize)) {
    let (start, end) = (wall.segment.start.to_dvec2(), wall.segment.end.to_dvec2());
    let (left, right) = ordered(start.x, end.x);
    let (top, bottom) = ordered(start.y, end.y);
    // A part of a square more on each side outweighs the rounding.
    let room = edge / 64.0;
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
