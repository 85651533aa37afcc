//! The test of one sphere against many, in the widest vectors that the processor has.
//!
//! It is the one place with `unsafe` code: a function that is compiled for wider vectors may only be called where the
//! processor has them. It pays: see the table in `docs/KINEMATICS.md`. The wide forms do the same operations in the
//! same order, each rounded on its own, so they find the same pairs.

use maniple_geometry::Scalar;

use crate::bands::Bands;
use crate::graph::Edge;
use crate::sphere::MotionSphere;

/// Spheres that are tested at once.
const LANES: u32 = 8;

/// The pairs of a node with those nodes from `from` to `to` whose spheres intersect its own. A macro, since each form has to
/// be compiled as a whole for the vectors of that form.
macro_rules! add_near {
    ($lanes:expr, $of:expr, $range:expr, $base:expr, $pairs:expr, $form:ident) => {{
        let ((node, sphere), (from, to)) = ($of, $range);
        let mut at: u32 = from;
        while at < to {
            let hits = $form::intersecting($lanes.block(at), sphere) & low_bits(to - at);
            $pairs.add_hits(node, ($base + at, hits), (0, 0));
            at += LANES;
        }
    }};
}

/// The pairs of a row of sectors; see [`add_pairs_of_row`]. Sphere by sphere and not sector by sector, and always the first
/// lanes of both runs at once: a loop more would be guessed wrong too often.
macro_rules! add_pairs {
    ($bands:expr, $band:expr, $row:expr, $pairs:expr, $form:ident) => {{
        let this = &$bands.bands[$band];
        let (below, row_below) = $bands.below($band, $row);
        let below = &$bands.bands[below];
        let (own, next) = (this.starts_of_row($row), below.starts_of_row(row_below));
        let last = own.len() - 2;
        let mut tested = 0;
        for place in own[0]..own[last + 1] {
            let sphere = this.sphere(place);
            let column = this.squares.column(f64::from(sphere.x)) as usize;
            let right = (column + 2).min(last + 1);
            let of = (this.base + place, sphere);
            let (here, near) = ((place + 1, own[right]), (next[column.saturating_sub(1)], next[right]));
            let (count_here, count_near) = (here.1 - here.0, near.1 - near.0);
            let hits_here = $form::intersecting(this.lanes().block(here.0), sphere) & low_bits(count_here);
            let hits_near = $form::intersecting(below.lanes().block(near.0), sphere) & low_bits(count_near);
            $pairs.add_hits(of.0, (this.base + here.0, hits_here), (below.base + near.0, hits_near));
            tested += count_here + count_near;
            if count_here > LANES || count_near > LANES {
                add_near!(this.lanes(), of, (here.0 + LANES, here.1), this.base, $pairs, $form);
                add_near!(below.lanes(), of, (near.0 + LANES, near.1), below.base, $pairs, $form);
            }
            if column == last {
                add_near!(this.lanes(), of, (own[0], own[1]), this.base, $pairs, $form);
                add_near!(below.lanes(), of, (next[0], next[1]), below.base, $pairs, $form);
                tested += own[1] - own[0] + next[1] - next[0];
            }
            if column == 0 {
                add_near!(below.lanes(), of, (next[last], next[last + 1]), below.base, $pairs, $form);
                tested += next[last + 1] - next[last];
            }
        }
        tested as usize
    }};
}

/// As many low bits as asked for, but not more than there are lanes.
#[inline(always)]
fn low_bits(count: u32) -> u32 {
    (1 << count.min(LANES)) - 1
}

/// Spheres as arrays of their fields, followed by [`LANES`] that intersect nothing.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lanes {
    xs: Vec<f32>,
    ys: Vec<f32>,
    radii: Vec<f32>,
}

impl Lanes {
    pub(crate) fn resize(&mut self, count: usize) {
        for field in [&mut self.xs, &mut self.ys, &mut self.radii] {
            field.resize(count + LANES as usize, 0.0);
        }
    }

    pub(crate) fn set(&mut self, place: usize, sphere: &MotionSphere) {
        self.xs[place] = sphere.x;
        self.ys[place] = sphere.y;
        self.radii[place] = sphere.radius;
    }

    pub(crate) fn sphere(&self, place: usize) -> MotionSphere {
        MotionSphere { x: self.xs[place], y: self.ys[place], radius: self.radii[place] }
    }

    /// Adds the pairs of a node with those nodes from `from` to `to` whose spheres intersect its own.
    fn add_near(&self, of: (u32, MotionSphere), range: (u32, u32), base: u32, pairs: &mut Pairs) {
        add_near!(self, of, range, base, pairs, plain);
    }

    /// Some spheres that lie one behind the other, perhaps some of the filling among them.
    #[inline(always)]
    fn block(&self, from: u32) -> [&[f32; LANES as usize]; 3] {
        let block = from as usize..(from + LANES) as usize;
        [&self.xs, &self.ys, &self.radii]
            .map(|field| field[block.clone()].try_into().expect("as many as lanes"))
    }

    pub(crate) fn bytes(&self) -> usize {
        size_of::<f32>() * (self.xs.capacity() + self.ys.capacity() + self.radii.capacity())
    }
}

/// Adds the pairs of spheres of a row that intersect each other or one that comes later, as nodes. Returns how many were
/// tested.
///
/// The later half of the neighbourhood of a sector is the sector itself, the one to the right, and the three in the row
/// below; spheres of neighbouring sectors lie one behind the other, so these are two runs, and more only where the table
/// wraps around. So each pair of neighbouring sectors comes up once.
pub(crate) fn add_pairs_of_row<S: Scalar>(
    bands: &Bands<S>,
    band: usize,
    row: u32,
    pairs: &mut Pairs,
) -> usize {
    #[cfg(target_arch = "x86_64")]
    if let Some(tested) = wide::add_pairs_of_row(bands, band, row, pairs) {
        return tested;
    }
    add_pairs!(bands, band, row, pairs, plain)
}

/// Adds the pairs of a sphere, with its node, and those of another level that it intersects; a band stands for the level.
/// Returns how many were tested.
pub(crate) fn add_pairs_with_level<S: Scalar>(
    bands: &Bands<S>,
    level: usize,
    (node, sphere): (u32, MotionSphere),
    pairs: &mut Pairs,
) -> usize {
    let reach = sphere.radius + bands.bands[level].radius_max;
    let mut tested = 0;
    bands.visit_box(level, (sphere.x, sphere.y), reach, |span| {
        let other = &bands.bands[span.band];
        other.lanes().add_near((node, sphere), (span.from, span.to), other.base, pairs);
        tested += (span.to - span.from) as usize;
    });
    tested
}

/// Room for pairs from the start: few rows have more.
const PAIRS_MIN: usize = 2048;

/// Pairs of nodes, written many at a time.
#[derive(Clone, Debug, Default)]
pub(crate) struct Pairs {
    firsts: Vec<u32>,
    seconds: Vec<u32>,
    count: usize,
}

impl Pairs {
    pub(crate) fn clear(&mut self) {
        self.count = 0;
    }

    pub(crate) fn len(&self) -> usize {
        self.count
    }

    /// Returns a pair by its place.
    #[inline]
    pub(crate) fn at(&self, place: usize) -> Edge {
        (self.firsts[place], self.seconds[place])
    }

    /// Adds the pairs of a node with those that have a bit, counted from each of two numbers on.
    #[inline(always)]
    fn add_hits(&mut self, node: u32, (first, hits): (u32, u32), (second, more): (u32, u32)) {
        let end = self.count + 2 * LANES as usize;
        if self.firsts.len() < end {
            self.firsts.resize(PAIRS_MIN.max(4 * end), 0);
            self.seconds.resize(PAIRS_MIN.max(4 * end), 0);
        }
        let mut left = hits | more << LANES;
        // How many there are cannot be guessed, but hardly ever are there more than two: so two are written down in any
        // case, and what is too much is written over.
        for _ in 0..2 {
            self.put(node, (first, second), left);
            self.count += usize::from(left != 0);
            left &= left.wrapping_sub(1);
        }
        while left != 0 {
            self.put(node, (first, second), left);
            self.count += 1;
            left &= left - 1;
        }
    }

    /// Writes the pair of the lowest bit down, if there is one.
    #[inline(always)]
    fn put(&mut self, node: u32, (first, second): (u32, u32), bits: u32) {
        let bit = bits.trailing_zeros();
        let base = if bit < LANES { first } else { second.wrapping_sub(LANES) };
        (self.firsts[self.count], self.seconds[self.count]) = (node, base.wrapping_add(bit));
    }

    /// Bytes on the heap.
    pub(crate) fn bytes(&self) -> usize {
        size_of::<u32>() * (self.firsts.capacity() + self.seconds.capacity())
    }
}

mod plain {
    use super::{LANES, MotionSphere};

    /// Which of the lanes intersect a sphere, one bit each: `|c - d|² <= (R + S)²`, which needs no root.
    #[inline(always)]
    pub(super) fn intersecting([xs, ys, radii]: [&[f32; LANES as usize]; 3], sphere: MotionSphere) -> u32 {
        let mut gaps = [0.0f32; LANES as usize];
        for (lane, gap) in gaps.iter_mut().enumerate() {
            let (x, y) = (xs[lane] - sphere.x, ys[lane] - sphere.y);
            let reach = radii[lane] + sphere.radius;
            *gap = x * x + y * y - reach * reach;
        }
        (0u32..).zip(gaps).fold(0, |hits, (lane, gap)| hits | u32::from(gap <= 0.0) << lane)
    }
}

#[cfg(target_arch = "x86_64")]
mod wide {
    use super::{Bands, Pairs, Scalar};

    /// The widest vectors that the processor has; the standard library asks it once a process.
    pub(super) fn add_pairs_of_row<S: Scalar>(
        bands: &Bands<S>,
        band: usize,
        row: u32,
        pairs: &mut Pairs,
    ) -> Option<usize> {
        if is_x86_feature_detected!("avx2") {
            #[expect(
                unsafe_code,
                reason = "the processor was asked for exactly this feature one line above"
            )]
            return Some(unsafe { super::avx2::add_pairs(bands, band, row, pairs) });
        }
        None
    }
}

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use std::arch::x86_64::{
        __m256, _CMP_LE_OQ, _mm256_add_ps, _mm256_cmp_ps, _mm256_movemask_ps, _mm256_mul_ps, _mm256_set_ps,
        _mm256_set1_ps, _mm256_setzero_ps, _mm256_sub_ps,
    };

    use super::{Bands, LANES, MotionSphere, Pairs, Scalar, avx2, low_bits};

    #[target_feature(enable = "avx2")]
    pub(super) fn add_pairs<S: Scalar>(bands: &Bands<S>, band: usize, row: u32, pairs: &mut Pairs) -> usize {
        add_pairs!(bands, band, row, pairs, avx2)
    }

    #[inline]
    #[target_feature(enable = "avx2")]
    fn intersecting(block: [&[f32; LANES as usize]; 3], sphere: MotionSphere) -> u32 {
        let [xs, ys, radii] = [load(block[0]), load(block[1]), load(block[2])];
        let x = _mm256_sub_ps(xs, _mm256_set1_ps(sphere.x));
        let y = _mm256_sub_ps(ys, _mm256_set1_ps(sphere.y));
        let reach = _mm256_add_ps(radii, _mm256_set1_ps(sphere.radius));
        let square = _mm256_add_ps(_mm256_mul_ps(x, x), _mm256_mul_ps(y, y));
        let gap = _mm256_sub_ps(square, _mm256_mul_ps(reach, reach));
        _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(gap, _mm256_setzero_ps())).cast_unsigned()
    }

    /// Compiles to one load.
    #[inline]
    #[target_feature(enable = "avx2")]
    fn load(f: &[f32; 8]) -> __m256 {
        _mm256_set_ps(f[7], f[6], f[5], f[4], f[3], f[2], f[1], f[0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use crate::bands::nobody;
    use crate::batch::Batch;

    /// Spheres strewn over a square, some of them giants.
    fn strewn(count: u32, giants: u32) -> Batch<f64> {
        let mut state = count;
        let mut unit = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f32::from(u16::try_from(state >> 16).expect("16 bits")) / 65536.0
        };
        let mut batch = Batch::new();
        batch.slots = (0..count).collect();
        for place in 0..count {
            let radius = if place >= giants { 0.5 + unit() } else { 5.0 + 10.0 * unit() };
            batch.add_sphere(MotionSphere { x: 100.0 * unit() - 50.0, y: 100.0 * unit(), radius });
        }
        batch
    }

    #[test]
    fn every_pair_of_spheres_that_intersect_comes_up_once_with_vectors_of_any_width() {
        for (count, giants) in [(1, 0), (2, 0), (30, 0), (3000, 0), (30, 3), (3000, 20)] {
            let mut batch = strewn(count, giants);
            for threads in [1, 3] {
                let mut bands = Bands::new();
                bands.fill(std::slice::from_mut(&mut batch), threads, |_| nobody());
                let levels: Vec<usize> = bands.levels().collect();
                let (mut wide, mut plain) = (Pairs::default(), Pairs::default());
                for band in 0..bands.all().len() {
                    for row in bands.all()[band].rows() {
                        add_pairs_of_row(&bands, band, row, &mut wide);
                        add_pairs!(bands, band, row, plain, plain);
                    }
                }
                let sorted = |pairs: &Pairs| {
                    let slot = |node: u32| {
                        let (band, place) = bands.find(node, 0);
                        band.tags[place].slot()
                    };
                    let edges = (0..pairs.len()).map(|place| pairs.at(place));
                    let mut slots: Vec<Edge> =
                        edges.map(|(a, b)| (slot(a).min(slot(b)), slot(a).max(slot(b)))).collect();
                    slots.sort_unstable();
                    slots
                };
                assert_eq!(
                    sorted(&wide),
                    sorted(&plain),
                    "{count} spheres, {giants} giants, {threads} threads"
                );
                if levels.len() == 1 {
                    assert_eq!(
                        sorted(&wide),
                        all_pairs(&batch),
                        "{count} spheres, {giants} giants, {threads} threads"
                    );
                }
            }
        }
    }

    fn all_pairs(batch: &Batch<f64>) -> Vec<Edge> {
        let mut pairs = Vec::new();
        for (a, one) in (0u32..).zip(&batch.spheres) {
            for (b, other) in (0u32..).zip(&batch.spheres).skip(a as usize + 1) {
                let (x, y, reach) = (one.x - other.x, one.y - other.y, one.radius + other.radius);
                if x * x + y * y <= reach * reach {
                    pairs.push((a, b));
                }
            }
        }
        pairs
    }
}
