//! The objects at rest, by where they are.

use glam::DVec2;
use maniple_geometry::{Planar, Scalar};

use crate::squares::{Squares, exponent, power_of_two};
use crate::state::State;

/// As a link: the end of a list.
const END: u32 = u32::MAX;

/// A square is at least this many radii wide, so that few squares meet a circle.
const RADII_A_SQUARE: f64 = 4.0;

/// The fewest squares of a level: in a smaller table all places of the plane are near each other.
const SQUARES_MIN: usize = 1 << 12;

/// Lists of slots by the square of their centre, one table for each order of magnitude of radii, so that a giant does
/// not make all squares large. A change costs the same however many there are, and objects at rest cost a cycle
/// nothing.
#[derive(Clone, Debug, Default)]
pub(crate) struct Resting {
    levels: Vec<Level>,
    /// For each slot the next one in its list.
    next: Vec<u32>,
}

/// The objects of one order of magnitude of radii.
#[derive(Clone, Debug)]
struct Level {
    /// The squares have an edge of 2 to this power.
    exponent: i32,
    squares: Squares,
    heads: Vec<u32>,
    /// For each square how many are in it and in the eight around it.
    around: Vec<u32>,
    held: usize,
}

impl Resting {
    /// Puts a slot in; its state says where it rests.
    pub(crate) fn insert<S: Scalar>(&mut self, slot: u32, states: &[State<S>]) {
        if self.next.len() <= slot as usize {
            self.next.resize(slot as usize + 1, END);
        }
        let state = &states[slot as usize];
        let place = self.level_of(state.radius.to_f64());
        let level = &mut self.levels[place];
        if level.held >= level.squares.count() {
            level.grow(&mut self.next, states);
        }
        level.held += 1;
        level.link(slot, state, &mut self.next);
    }

    /// Takes a slot out that rests where its state says.
    ///
    /// # Panics
    /// Where it is not there.
    pub(crate) fn remove<S: Scalar>(&mut self, slot: u32, states: &[State<S>]) {
        let state = &states[slot as usize];
        let place = self.level_of(state.radius.to_f64());
        let level = &mut self.levels[place];
        let square = level.square(state);
        let after = self.next[slot as usize];
        level.held -= 1;
        let Level { squares, around, .. } = level;
        squares.visit_around(square, |near| around[near] -= 1);
        if level.heads[square] == slot {
            level.heads[square] = after;
            return;
        }
        let mut before = level.heads[square];
        while self.next[before as usize] != slot {
            before = self.next[before as usize];
        }
        self.next[before as usize] = after;
    }

    /// Visits the slots whose circles may be within `reach` of a point.
    #[inline]
    pub(crate) fn near(&self, center: DVec2, reach: f64, mut visit: impl FnMut(u32)) {
        for level in self.levels.iter().filter(|level| level.held > 0) {
            let radius_max = power_of_two(level.exponent) / RADII_A_SQUARE;
            let half = DVec2::splat(reach + radius_max);
            let (low, high) = (center - half, center + half);
            level.squares.visit((low.x, low.y), (high.x, high.y), |square| {
                let mut slot = level.heads[square];
                while slot != END {
                    visit(slot);
                    slot = self.next[slot as usize];
                }
            });
        }
    }

    /// Returns whether it is plain that nobody comes within `reach` of a point.
    #[inline]
    pub(crate) fn is_clear(&self, center: DVec2, reach: f64) -> bool {
        self.levels.iter().all(|level| level.held == 0 || level.is_clear(center, reach))
    }

    /// Bytes on the heap.
    pub(crate) fn bytes(&self) -> usize {
        let heads: usize =
            self.levels.iter().map(|level| level.heads.capacity() + level.around.capacity()).sum();
        size_of::<u32>() * (heads + self.next.capacity())
    }

    /// The place of the level for a radius; made if it is not there. Two exponents share one.
    fn level_of(&mut self, radius: f64) -> usize {
        let exponent = (exponent(radius * RADII_A_SQUARE) + 2) & !1;
        if let Some(place) = self.levels.iter().position(|level| level.exponent == exponent) {
            return place;
        }
        self.levels.push(Level::new(exponent, 0));
        self.levels.len() - 1
    }
}

impl Level {
    fn new(exponent: i32, count: usize) -> Self {
        let squares = Squares::new(power_of_two(exponent), count.max(SQUARES_MIN));
        let count = squares.count();
        Self { exponent, squares, heads: vec![END; count], around: vec![0; count], held: 0 }
    }

    #[inline]
    fn is_clear(&self, center: DVec2, reach: f64) -> bool {
        let edge = power_of_two(self.exponent);
        reach + edge / RADII_A_SQUARE <= edge && self.around[self.square_of(center)] == 0
    }

    fn square<S: Scalar>(&self, state: &State<S>) -> usize {
        self.square_of(state.start.to_dvec2())
    }

    #[inline]
    fn square_of(&self, point: DVec2) -> usize {
        self.squares.place(self.squares.row(point.y), self.squares.column(point.x))
    }

    fn link<S: Scalar>(&mut self, slot: u32, state: &State<S>, next: &mut [u32]) {
        let square = self.square(state);
        next[slot as usize] = self.heads[square];
        self.heads[square] = slot;
        let Self { squares, around, .. } = self;
        squares.visit_around(square, |near| around[near] += 1);
    }

    /// Twice as many squares, so that a list stays short.
    fn grow<S: Scalar>(&mut self, next: &mut [u32], states: &[State<S>]) {
        let heads = std::mem::take(&mut self.heads);
        let held = self.held;
        *self = Self::new(self.exponent, 2 * heads.len());
        self.held = held;
        for mut slot in heads {
            while slot != END {
                let after = next[slot as usize];
                self.link(slot, &states[slot as usize], next);
                slot = after;
            }
        }
    }
}
