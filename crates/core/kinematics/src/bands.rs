//! The sectors: motion spheres in the order of square buckets.
//!
//! Spheres of one order of magnitude make a *level*, whose sectors are as wide as its largest sphere, so that spheres
//! that intersect lie in the same sector or in neighbouring ones. A level is cut into *bands* of rows, one for each
//! thread.

use maniple_geometry::contact::Straight;
use maniple_geometry::{Planar, Scalar};

use crate::batch::Batch;
use crate::lanes::Lanes;
use crate::sphere::MotionSphere;
use crate::squares::Squares;
use crate::state::Tag;

/// How many times smaller the largest sphere of a level is than that of the level above.
const LEVEL_STEP: f32 = 4.0;

/// The most levels: all spheres that are smaller still are in the last.
const LEVELS_MAX: usize = 10;

/// Sectors for so many spheres each, at least: fewer sectors are cheaper to clear, more have fewer strangers in them.
const SPHERES_A_SECTOR: f64 = 1.5;

/// A level with fewer spheres than this is not worth more than one thread.
const SPHERES_A_BAND_MIN: usize = 2048;

/// Sectors are wider than needed by 2^-10, which outweighs all rounding.
const ROUNDING: f64 = 1.0 + 1.0 / 1024.0;

/// Rows of sectors of one level, and the spheres in them, row by row and sector by sector.
#[doc(alias = "grid cell")]
#[derive(Clone, Debug)]
pub(crate) struct Band<S: Scalar> {
    pub(crate) level: usize,
    pub(crate) squares: Squares,
    /// Radius of the largest sphere of the level.
    pub(crate) radius_max: f32,
    first_row: u32,
    rows: u32,
    /// The number of the first sector among those of all bands.
    first_sector: u32,
    /// The number of the first sphere among those of all bands.
    pub(crate) base: u32,
    /// For each sector where its spheres begin; one more for the end.
    starts: Vec<u32>,
    lanes: Lanes,
    /// For each sphere the tag of its object.
    pub(crate) tags: Vec<Tag>,
    /// For each sphere its object, if it goes straight on in the cycle.
    pub(crate) straights: Vec<Straight<S>>,
}

/// Some of the spheres of a band that lie one behind the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Span {
    /// The band.
    pub(crate) band: usize,
    pub(crate) from: u32,
    pub(crate) to: u32,
}

/// The grids of a cycle.
#[derive(Clone, Copy, Debug)]
struct Levels {
    /// Radius of the largest sphere.
    largest: f32,
    /// For each level that has spheres its squares, and the number of the first sector among those of all levels.
    grids: [Option<(Squares, u32)>; LEVELS_MAX],
    /// For each level how many spheres it has.
    counts: [usize; LEVELS_MAX],
}

impl Levels {
    /// Returns the number of the sector of a sphere, among those of all levels.
    #[inline]
    fn sector(&self, sphere: &MotionSphere) -> u32 {
        let (squares, first) =
            self.grids[level_of(sphere.radius, self.largest)].expect("the level has a sphere");
        let place = squares.place(squares.row(f64::from(sphere.y)), squares.column(f64::from(sphere.x)));
        first + u32::try_from(place).expect("sectors are numbered with 32 bits")
    }
}

/// The spheres of a cycle, in sectors.
#[derive(Clone, Debug)]
pub(crate) struct Bands<S: Scalar> {
    levels: Levels,
    pub(crate) bands: Vec<Band<S>>,
    /// How many of the bands are in use.
    used: usize,
    /// Where all coordinates of spheres are counted from.
    pub(crate) anchor: glam::DVec2,
}

impl<S: Scalar> Bands<S> {
    pub(crate) fn new() -> Self {
        let levels = Levels { largest: 0.0, grids: [None; LEVELS_MAX], counts: [0; LEVELS_MAX] };
        Self { levels, bands: Vec::new(), used: 0, anchor: glam::DVec2::ZERO }
    }

    /// Returns the bands of this cycle.
    pub(crate) fn all(&self) -> &[Band<S>] {
        &self.bands[..self.used]
    }

    /// Returns the band and the place in it of a sphere; quick where it is in the band that is guessed.
    #[inline]
    pub(crate) fn find(&self, node: u32, guess: usize) -> (&Band<S>, usize) {
        let guessed = &self.bands[guess];
        let place = node.wrapping_sub(guessed.base) as usize;
        if place < guessed.tags.len() {
            return (guessed, place);
        }
        let band = &self.all()[self.band_of(node)];
        (band, (node - band.base) as usize)
    }

    /// Returns the centre of a sphere in the world.
    #[inline]
    pub(crate) fn center(&self, sphere: &MotionSphere) -> glam::DVec2 {
        glam::DVec2::new(f64::from(sphere.x), f64::from(sphere.y)) + self.anchor
    }

    /// Returns the band that a sphere is in.
    fn band_of(&self, node: u32) -> usize {
        self.all().partition_point(|band| band.base <= node) - 1
    }

    /// Puts the spheres of all batches into sectors, for so many threads; `straight` tells what is kept beside a sphere.
    pub(crate) fn fill(
        &mut self,
        batches: &mut [Batch<S>],
        threads: usize,
        straight: impl Fn(Tag) -> Straight<S> + Sync,
    ) {
        self.lay_out(batches, threads);
        let levels = &self.levels;
        crate::cycle::each(batches, |batch| batch.find_sectors(|sphere| levels.sector(sphere)));
        let Self { bands, used, .. } = self;
        let batches = &*batches;
        crate::cycle::each(&mut bands[..*used], |band| band.fill(batches, &straight));
        let mut base = 0;
        for band in &mut bands[..*used] {
            band.base = base;
            base += u32::try_from(band.tags.len()).expect("objects have u32 ids");
        }
    }

    /// Decides on levels and bands.
    fn lay_out(&mut self, batches: &[Batch<S>], threads: usize) {
        let mut radii = (f32::INFINITY, 0.0f32);
        for batch in batches.iter().filter(|batch| !batch.spheres.is_empty()) {
            if batch.radii.0 < radii.0 {
                radii.0 = batch.radii.0;
            }
            if batch.radii.1 > radii.1 {
                radii.1 = batch.radii.1;
            }
        }
        let mut levels = [(0usize, 0.0f32); LEVELS_MAX];
        if radii.0 * LEVEL_STEP > radii.1 {
            levels[0] = (batches.iter().map(|batch| batch.spheres.len()).sum(), radii.1);
        } else {
            for sphere in batches.iter().flat_map(|batch| &batch.spheres) {
                let level = &mut levels[level_of(sphere.radius, radii.1)];
                level.0 += 1;
                if sphere.radius > level.1 {
                    level.1 = sphere.radius;
                }
            }
        }
        self.levels =
            Levels { largest: radii.1, grids: [None; LEVELS_MAX], counts: levels.map(|level| level.0) };
        self.used = 0;
        let mut first_sector = 0;
        for (level, &(count, radius_max)) in levels.iter().enumerate().filter(|(_, level)| level.0 > 0) {
            let edge = 2.0 * f64::from(radius_max) * ROUNDING;
            let squares = Squares::new(edge, sectors_for(count));
            self.levels.grids[level] = Some((squares, first_sector));
            let bands = if count < SPHERES_A_BAND_MIN { 1 } else { threads.min(squares.rows() as usize) };
            for band in 0..bands {
                let row = |band: usize| {
                    squares.rows() * u32::try_from(band).unwrap_or(0) / u32::try_from(bands).unwrap_or(1)
                };
                let (first_row, end) = (row(band), row(band + 1));
                if self.bands.len() == self.used {
                    self.bands.push(Band::new(squares));
                }
                let made = &mut self.bands[self.used];
                (made.level, made.squares, made.radius_max) = (level, squares, radius_max);
                (made.first_row, made.rows) = (first_row, end - first_row);
                made.first_sector = first_sector + first_row * squares.columns();
                self.used += 1;
            }
            first_sector += squares.rows() * squares.columns();
        }
    }

    /// The band of the same level that a row lies in.
    fn band_with_row(&self, near: usize, row: u32) -> usize {
        let holds = |band: &Band<S>| row.wrapping_sub(band.first_row) < band.rows;
        if holds(&self.bands[near]) {
            return near;
        }
        let level = self.bands[near].level;
        let place = self.all().iter().position(|band| band.level == level && holds(band));
        place.expect("the bands of a level hold all its rows")
    }

    /// Returns the band that holds the row below a row of another band, of the same level, and which row that is.
    pub(crate) fn below(&self, band: usize, row: u32) -> (usize, u32) {
        let next = (row + 1) & (self.bands[band].squares.rows() - 1);
        (self.band_with_row(band, next), next)
    }

    /// Visits the spheres of a level that may be within `reach` of a place, given by one of its bands.
    pub(crate) fn visit_box(
        &self,
        level_band: usize,
        (x, y): (f32, f32),
        reach: f32,
        mut visit: impl FnMut(Span),
    ) {
        let squares = self.bands[level_band].squares;
        let (x, y, reach) = (f64::from(x), f64::from(y), f64::from(reach));
        let columns = squares.columns_from(x - reach, x + reach).runs();
        for row in squares.rows_from(y - reach, y + reach) {
            for (first, count) in columns.into_iter().filter(|run| run.1 > 0) {
                let band = self.band_with_row(level_band, row);
                visit(self.bands[band].span(band, row, (first, first + count - 1)));
            }
        }
    }

    /// Returns the first band of each level.
    pub(crate) fn levels(&self) -> impl Iterator<Item = usize> + '_ {
        let bands = self.all();
        (0..bands.len()).filter(move |&band| band == 0 || bands[band - 1].level != bands[band].level)
    }

    /// Returns the first band of each other level that the spheres of a band look through for pairs: of two levels the one
    /// with fewer spheres looks through the other, so that neither a few dwarfs nor a few giants cost all others anything.
    pub(crate) fn levels_seen_from(&self, band: usize) -> impl Iterator<Item = usize> + '_ {
        let level = self.bands[band].level;
        let counts = &self.levels.counts;
        // Where they are equally many, the smaller spheres look: they have but few sectors to look into.
        let rank = move |level: usize| (counts[level], std::cmp::Reverse(level));
        self.levels().filter(move |&other| {
            let other = self.bands[other].level;
            other != level && rank(level) < rank(other)
        })
    }

    /// Bytes on the heap.
    pub(crate) fn bytes(&self) -> usize {
        self.bands.iter().map(Band::bytes).sum()
    }

    /// Visits the slots of objects whose spheres may be within `reach` of a place.
    pub(crate) fn near(&self, center: glam::DVec2, reach: f64, mut visit: impl FnMut(u32)) {
        let place = MotionSphere::outward(center - self.anchor, crate::sphere::outward_radius(reach));
        for first in self.levels() {
            let reach = place.radius + self.bands[first].radius_max;
            self.visit_box(first, (place.x, place.y), reach, |span| {
                self.bands[span.band].tags[span.from as usize..span.to as usize]
                    .iter()
                    .for_each(|tag| visit(tag.slot()));
            });
        }
    }
}

impl<S: Scalar> Band<S> {
    fn new(squares: Squares) -> Self {
        Self {
            level: 0,
            squares,
            radius_max: 0.0,
            first_row: 0,
            rows: 0,
            first_sector: 0,
            base: 0,
            starts: Vec::new(),
            lanes: Lanes::default(),
            tags: Vec::new(),
            straights: Vec::new(),
        }
    }

    /// Counting sort of the spheres that belong here.
    fn fill(&mut self, batches: &[Batch<S>], straight: &impl Fn(Tag) -> Straight<S>) {
        let sectors = self.rows * self.squares.columns();
        let first = self.first_sector;
        self.starts.clear();
        self.starts.resize(sectors as usize + 2, 0);
        for &sector in batches.iter().flat_map(|batch| &batch.sectors) {
            let sector = sector.wrapping_sub(first);
            if sector < sectors {
                self.starts[sector as usize + 2] += 1;
            }
        }
        let mut sum = 0;
        for start in &mut self.starts {
            sum += *start;
            *start = sum;
        }
        self.lanes.resize(sum as usize);
        self.tags.resize(sum as usize, Tag::new(0, false));
        self.straights.resize(sum as usize, nobody());
        for batch in batches {
            for ((sphere, tag), &sector) in batch.tagged().zip(&batch.sectors) {
                let sector = sector.wrapping_sub(first);
                if sector < sectors {
                    let place = self.starts[sector as usize + 1] as usize;
                    self.starts[sector as usize + 1] += 1;
                    self.lanes.set(place, sphere);
                    self.tags[place] = tag;
                    self.straights[place] = straight(tag);
                }
            }
        }
    }

    fn sector(&self, row: u32, column: u32) -> usize {
        self.squares.place(row - self.first_row, column)
    }

    /// The spheres of a row from one column to another, as a span of this band, which has the given number.
    #[inline]
    fn span(&self, band: usize, row: u32, (first, last): (u32, u32)) -> Span {
        Span { band, from: self.starts[self.sector(row, first)], to: self.starts[self.sector(row, last) + 1] }
    }

    /// Returns where the spheres of each sector of a row begin; one more for the end of the row.
    #[inline]
    pub(crate) fn starts_of_row(&self, row: u32) -> &[u32] {
        let first = self.sector(row, 0);
        &self.starts[first..=first + self.squares.columns() as usize]
    }

    /// Returns the rows of the band.
    pub(crate) fn rows(&self) -> std::ops::Range<u32> {
        self.first_row..self.first_row + self.rows
    }

    /// Returns a sphere by its place in the band.
    #[inline]
    pub(crate) fn sphere(&self, place: u32) -> MotionSphere {
        self.lanes.sphere(place as usize)
    }

    pub(crate) fn lanes(&self) -> &Lanes {
        &self.lanes
    }

    /// Bytes on the heap.
    pub(crate) fn bytes(&self) -> usize {
        size_of::<u32>() * (self.starts.capacity() + self.tags.capacity())
            + size_of::<Straight<S>>() * self.straights.capacity()
            + self.lanes.bytes()
    }
}

/// What stands for an object where there is none.
pub(crate) fn nobody<S: Scalar>() -> Straight<S> {
    Straight { point: S::Vector::zero(), velocity: S::Vector::zero(), radius: S::ZERO }
}

/// How many sectors so many spheres get.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::cast_precision_loss,
    reason = "a rough number is enough"
)]
fn sectors_for(count: usize) -> usize {
    (count as f64 / SPHERES_A_SECTOR) as usize
}

/// The level of a sphere, where the largest of all has `largest`.
fn level_of(radius: f32, largest: f32) -> usize {
    let mut bound = largest / LEVEL_STEP;
    let mut level = 0;
    while radius <= bound && level + 1 < LEVELS_MAX {
        bound /= LEVEL_STEP;
        level += 1;
    }
    level
}
