//! The places between which agents step.

use glam::DVec2;
use maniple_geometry::{Circle, Segment};
use thiserror::Error;

use crate::{Ground, MARGIN};

/// Largest radius of circles that can walk any plan in step, in world units: √2/4 of the pitch of 1, rounded down so that the
/// rounding of a world never decides.
///
/// The closest that two get is where one follows the other around a right angle: at the time `t` of the step the one is
/// `1 - t` before the turn and the other `t` behind it, so that they are `√((1 - t)² + t²)` apart, at least `√2/2`. That has
/// to be twice the radius.
pub const RADIUS_IN_STEP_MAX: f64 = 0.35355;

/// No place: where a tile is none.
const NONE: u32 = u32::MAX;

/// Why a ground is no board.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum BoardError {
    /// The circles are too large to follow each other around a corner.
    #[error(
        "a radius of {radius} is too large to walk in step: on a pitch of 1 it can be {RADIUS_IN_STEP_MAX} at most; plan for \
         smaller circles, or another way"
    )]
    Radius {
        /// The radius, in world units.
        radius: f64,
    },
}

/// A place on a board: the middle of a tile, by its number among those that are free.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Place(pub(crate) u32);

impl Place {
    /// No place at all.
    pub(crate) const NOWHERE: Self = Self(NONE);

    /// Returns the number of the place, from 0 on, row by row.
    #[must_use]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// Which middles of tiles are places: every so many columns and rows, from the first of them on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Raster {
    /// Tiles from one to the next; at least 1.
    pub(crate) pitch: u32,
    /// The column and the row of the first; less than the pitch.
    pub(crate) first: (u32, u32),
}

impl Raster {
    /// All tiles.
    const WHOLE: Self = Self { pitch: 1, first: (0, 0) };

    /// Returns all rasters of the finest pitch on which circles of a radius can go in step.
    pub(crate) fn finest(radius: f64) -> Vec<Self> {
        let pitch = (1..).find(|&pitch| radius <= RADIUS_IN_STEP_MAX * f64::from(pitch));
        let pitch = pitch.expect("a radius has a limit");
        let all = (0..pitch).flat_map(|y| (0..pitch).map(move |x| (x, y)));
        all.map(|first| Self { pitch, first }).collect()
    }
}

/// The middles of tiles in which a circle has room, and the straight steps between them that are clear of every wall. Never
/// changes.
#[derive(Clone, Debug)]
pub struct Board {
    /// In places, as the height.
    width: u32,
    height: u32,
    raster: Raster,
    radius: f64,
    /// The place of each tile, or [`NONE`].
    of_tile: Vec<u32>,
    /// The tile of each place.
    tiles: Vec<u32>,
    /// Where the neighbours of each place begin in `neighbours`, and where the last end.
    first: Vec<u32>,
    neighbours: Vec<Place>,
}

impl Board {
    /// Returns the board of a ground, for circles of its radius.
    ///
    /// # Errors
    /// A radius above [`RADIUS_IN_STEP_MAX`].
    pub fn new(ground: &Ground) -> Result<Self, BoardError> {
        Self::on(ground, Raster::WHOLE, &[])
    }

    /// Returns the board of every so many tiles, without the places and steps where others are in the way.
    ///
    /// # Errors
    /// A radius above [`RADIUS_IN_STEP_MAX`] of the pitch.
    pub(crate) fn on(ground: &Ground, raster: Raster, others: &[Circle]) -> Result<Self, BoardError> {
        let radius = ground.radius();
        if radius > RADIUS_IN_STEP_MAX * f64::from(raster.pitch) {
            return Err(BoardError::Radius { radius });
        }
        let size = ground.size();
        let count = |tiles: u32, first: u32| tiles.saturating_sub(first).div_ceil(raster.pitch);
        let (width, height) = (count(size.0, raster.first.0), count(size.1, raster.first.1));
        let mut board = Self {
            width,
            height,
            raster,
            radius,
            of_tile: vec![NONE; width as usize * height as usize],
            tiles: Vec::new(),
            first: vec![0],
            neighbours: Vec::new(),
        };
        board.number_places(ground, others);
        board.connect(ground, others);
        Ok(board)
    }

    /// Returns how many places there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.tiles.len()
    }

    /// Returns whether there is no place.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.tiles.is_empty()
    }

    /// Returns the radius of the circles that the board is for, in world units.
    #[must_use]
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Returns the places, in their order.
    pub fn places(&self) -> impl ExactSizeIterator<Item = Place> + use<> {
        (0..u32::try_from(self.len()).expect("there are fewer places than tiles")).map(Place)
    }

    /// Returns the place in column `x` and row `y`, those of the map; `None` where there is none.
    #[must_use]
    pub fn place(&self, x: u32, y: u32) -> Option<Place> {
        if x >= self.width || y >= self.height {
            return None;
        }
        let place = self.of_tile[y as usize * self.width as usize + x as usize];
        (place != NONE).then_some(Place(place))
    }

    /// Returns column and row of a place.
    #[must_use]
    pub fn tile(&self, place: Place) -> (u32, u32) {
        let tile = self.tiles[place.index()];
        (tile % self.width, tile / self.width)
    }

    /// Returns where a place is, in world units.
    #[must_use]
    pub fn point(&self, place: Place) -> DVec2 {
        let (x, y) = self.tile(place);
        self.middle(x, y)
    }

    /// Returns how far a step leads, in world units.
    pub(crate) fn pitch(&self) -> f64 {
        f64::from(self.raster.pitch)
    }

    /// Returns the places within so many columns and rows of the one that is nearest to a point.
    pub(crate) fn places_around(&self, point: DVec2, columns: u32) -> impl Iterator<Item = Place> {
        let first = self.middle(0, 0);
        let near = ((point - first) / self.pitch()).round();
        let range = move |near: f64, count: u32| {
            (0..count).filter(move |&index| (f64::from(index) - near).abs() <= f64::from(columns))
        };
        let rows = range(near.y, self.height);
        rows.flat_map(move |y| range(near.x, self.width).filter_map(move |x| self.place(x, y)))
    }

    fn middle(&self, x: u32, y: u32) -> DVec2 {
        let Raster { pitch, first } = self.raster;
        DVec2::new(f64::from(first.0 + x * pitch), f64::from(first.1 + y * pitch)) + 0.5
    }

    /// Returns the places to which a step leads, at most four, in their order.
    #[must_use]
    pub fn neighbours(&self, place: Place) -> &[Place] {
        let index = place.index();
        &self.neighbours[self.first[index] as usize..self.first[index + 1] as usize]
    }

    fn number_places(&mut self, ground: &Ground, others: &[Circle]) {
        let mut count = 0;
        for (tile, index) in (0..).zip(0..self.of_tile.len()) {
            let middle = self.middle(tile % self.width, tile / self.width);
            if ground.holds(middle) && !self.is_near((middle, middle), others) {
                self.of_tile[index] = count;
                self.tiles.push(tile);
                count += 1;
            }
        }
    }

    /// Whether a circle that goes straight from one point to another comes too near to somebody.
    fn is_near(&self, (from, to): (DVec2, DVec2), others: &[Circle]) -> bool {
        let line: Segment = Segment::new(from, to);
        others.iter().any(|other| {
            let reach = self.radius + other.radius + MARGIN;
            line.nearest(other.center).distance_squared(other.center) < reach * reach
        })
    }

    fn connect(&mut self, ground: &Ground, others: &[Circle]) {
        self.first.reserve_exact(self.tiles.len());
        for place in self.places() {
            let (x, y) = self.tile(place);
            let around = [
                y.checked_sub(1).and_then(|y| self.place(x, y)),
                x.checked_sub(1).and_then(|x| self.place(x, y)),
                self.place(x + 1, y),
                self.place(x, y + 1),
            ];
            for next in around.into_iter().flatten() {
                // Asked from the lower to the higher, so that the answer is one for both.
                let (from, to) = (self.point(place.min(next)), self.point(place.max(next)));
                if ground.is_clear(from, to) && !self.is_near((from, to), others) {
                    self.neighbours.push(next);
                }
            }
            self.first.push(u32::try_from(self.neighbours.len()).expect("four for each tile fit"));
        }
    }
}
