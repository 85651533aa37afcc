//! The test of one sphere against many, in the widest vectors that the processor has.
//!
//! It is the one place with `unsafe` code: a function that is compiled for wider vectors may only be called where the
//! processor has them. It pays: see the table in `docs/KINEMATICS.md`. The wide forms do the same operations in the
//! same order, each rounded on its own, so they find the same pairs.

use crate::bands::{Bands, Span};
use crate::sphere::MotionSphere;

/// Spheres that are tested at once.
pub(crate) const LANES: usize = 16;

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
            field.resize(count + LANES, 0.0);
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

    /// Adds the pairs of a node with those nodes from `from` to `to` whose spheres intersect its own:
    /// `|c - d|² <= (R + S)²`, which needs no root.
    #[inline(always)]
    pub(crate) fn add_near(
        &self,
        (node, sphere): (u32, &MotionSphere),
        (from, to): (u32, u32),
        base: u32,
        pairs: &mut Vec<(u32, u32)>,
    ) {
        let mut at = from;
        while at < to {
            let block = at as usize..at as usize + LANES;
            let (xs, ys, radii) = (&self.xs[block.clone()], &self.ys[block.clone()], &self.radii[block]);
            let mut hits = 0u32;
            for lane in 0..LANES {
                let (x, y) = (xs[lane] - sphere.x, ys[lane] - sphere.y);
                let reach = radii[lane] + sphere.radius;
                hits |= u32::from(x * x + y * y <= reach * reach) << lane;
            }
            let left = to - at;
            if left < LANES as u32 {
                hits &= (1 << left) - 1;
            }
            while hits != 0 {
                pairs.push((node, base + at + hits.trailing_zeros()));
                hits &= hits - 1;
            }
            at += LANES as u32;
        }
    }

    pub(crate) fn bytes(&self) -> usize {
        size_of::<f32>() * (self.xs.capacity() + self.ys.capacity() + self.radii.capacity())
    }
}

/// Adds the pairs of spheres of a row that intersect each other or one that comes later: nodes, and which other. Returns
/// how many were tested.
pub(crate) fn add_pairs_of_row(bands: &Bands, band: usize, row: u32, pairs: &mut Vec<(u32, u32)>) -> usize {
    #[cfg(target_arch = "x86_64")]
    if let Some(tested) = wide::add_pairs_of_row(bands, band, row, pairs) {
        return tested;
    }
    add_pairs(bands, band, row, pairs)
}

/// Inlined into each form, so that it is compiled for the vectors of that form.
#[inline(always)]
fn add_pairs(bands: &Bands, band: usize, row: u32, pairs: &mut Vec<(u32, u32)>) -> usize {
    let this = &bands.bands[band];
    let mut tested = 0;
    for column in 0..this.squares.columns() {
        let Some(near) = bands.neighbourhood(band, row, column) else { continue };
        for place in near.own.from..near.own.to {
            let (node, sphere) = (this.base + place, this.sphere(place));
            // With the spheres of its own sector each pair comes up once.
            let right = Span { from: place + 1, ..near.right };
            for span in std::iter::once(&right).chain(&near.others[..near.count]) {
                let other = &bands.bands[span.band];
                other.lanes().add_near((node, &sphere), (span.from, span.to), other.base, pairs);
                tested += (span.to - span.from) as usize;
            }
        }
    }
    tested
}

#[cfg(target_arch = "x86_64")]
mod wide {
    use super::{Bands, add_pairs};

    /// The widest vectors that the processor has, asked once a process by the standard library.
    pub(super) fn add_pairs_of_row(
        bands: &Bands,
        band: usize,
        row: u32,
        pairs: &mut Vec<(u32, u32)>,
    ) -> Option<usize> {
        if is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512vl") {
            #[expect(
                unsafe_code,
                reason = "the processor was asked for exactly these features one line above"
            )]
            return Some(unsafe { add_pairs_avx512(bands, band, row, pairs) });
        }
        if is_x86_feature_detected!("avx2") {
            #[expect(
                unsafe_code,
                reason = "the processor was asked for exactly this feature one line above"
            )]
            return Some(unsafe { add_pairs_avx2(bands, band, row, pairs) });
        }
        None
    }

    #[target_feature(enable = "avx512f,avx512vl")]
    fn add_pairs_avx512(bands: &Bands, band: usize, row: u32, pairs: &mut Vec<(u32, u32)>) -> usize {
        add_pairs(bands, band, row, pairs)
    }

    #[target_feature(enable = "avx2")]
    fn add_pairs_avx2(bands: &Bands, band: usize, row: u32, pairs: &mut Vec<(u32, u32)>) -> usize {
        add_pairs(bands, band, row, pairs)
    }
}
