//! What one decision costs, with and without exact arithmetic: `cargo bench -p maniple-geometry`.

use divan::{Bencher, black_box};
use glam::DVec2;
use maniple_geometry::contact::{Mover, Straight, Window, segment_contact, straight_contact};
use maniple_geometry::predicate::circles_overlap;
use maniple_geometry::{Piece, Segment};

/// World units, as everything here.
const RADIUS: f64 = 0.4;

/// About that of a map of 512 tiles.
const SKIN: f64 = 2e-12;

fn main() {
    divan::main();
}

/// Pairs of straight motions.
mod straight {
    use super::*;

    /// They run into each other; the nearest point of their lines lies within the cycle.
    #[divan::bench]
    fn hit(bencher: Bencher<'_, '_>) {
        check(bencher, ((0.0, 0.0), (0.9, 0.1)), ((1.5, 0.3), (-0.8, 0.0)), true);
    }

    /// They approach each other, but their lines do not come nearer than touching.
    #[divan::bench]
    fn miss(bencher: Bencher<'_, '_>) {
        check(bencher, ((0.0, 0.0), (0.9, 0.1)), ((1.5, 1.3), (-0.8, 0.0)), false);
    }

    /// They move apart.
    #[divan::bench]
    fn parting(bencher: Bencher<'_, '_>) {
        check(bencher, ((0.0, 0.0), (-0.9, 0.1)), ((1.5, 0.3), (0.8, 0.0)), false);
    }

    /// They would touch without an overlap, which only exact arithmetic can tell.
    #[divan::bench]
    fn graze(bencher: Bencher<'_, '_>) {
        check(bencher, ((0.0, 0.0), (0.9, 0.0)), ((1.5, 2.0 * RADIUS), (-0.8, 0.0)), false);
    }

    type Way = ((f64, f64), (f64, f64));

    fn check(bencher: Bencher<'_, '_>, first: Way, second: Way, collides: bool) {
        let straight = |(point, velocity): Way| Straight {
            point: DVec2::from(point),
            velocity: DVec2::from(velocity),
            radius: RADIUS,
        };
        let (first, second) = (straight(first), straight(second));
        let contact = || straight_contact(black_box(&first), black_box(&second), SKIN);
        assert_eq!(contact().is_some(), collides);
        bencher.bench_local(contact);
    }
}

/// A moving circle and a segment of 3 world units.
mod segment {
    use super::*;

    /// It runs into the flat side.
    #[divan::bench]
    fn hit_flat(bencher: Bencher<'_, '_>) {
        check(bencher, (1.5, 1.0), (0.2, -0.9), true);
    }

    /// It runs into an end.
    #[divan::bench]
    fn hit_end(bencher: Bencher<'_, '_>) {
        check(bencher, (3.7, 0.3), (-0.9, -0.2), true);
    }

    /// It passes by so near that boxes do not tell.
    #[divan::bench]
    fn miss(bencher: Bencher<'_, '_>) {
        check(bencher, (3.2, 1.0), (0.9, -0.8), false);
    }

    /// It is too far away for a box of its way to meet that of the segment.
    #[divan::bench]
    fn miss_by_boxes(bencher: Bencher<'_, '_>) {
        check(bencher, (1.5, 4.0), (0.2, -0.9), false);
    }

    /// It slides along, touching, which only exact arithmetic can tell.
    #[divan::bench]
    fn graze(bencher: Bencher<'_, '_>) {
        check(bencher, (0.5, RADIUS), (0.9, 0.0), false);
    }

    fn check(bencher: Bencher<'_, '_>, point: (f64, f64), velocity: (f64, f64), collides: bool) {
        let segment = Segment::new(DVec2::ZERO, DVec2::new(3.0, 0.0));
        let piece =
            Piece { point: point.into(), velocity: velocity.into(), since: 0.0, until: 1.0, goal: None };
        let window = Window { from: 0.0, to: 1.0, skin: SKIN };
        let contact = || {
            let mover = Mover { piece: black_box(&piece), radius: RADIUS };
            segment_contact(mover, black_box(&segment), window)
        };
        assert_eq!(contact().is_some(), collides);
        bencher.bench_local(contact);
    }
}

/// Whether two circles overlap.
mod overlap {
    use super::*;

    /// They are apart, and rounded numbers tell.
    #[divan::bench]
    fn plain(bencher: Bencher<'_, '_>) {
        check(bencher, (0.9, 0.3));
    }

    /// They touch, which only exact arithmetic can tell.
    #[divan::bench]
    fn exact(bencher: Bencher<'_, '_>) {
        check(bencher, (2.0 * RADIUS, 0.0));
    }

    fn check(bencher: Bencher<'_, '_>, offset: (f64, f64)) {
        let (center, other) = (DVec2::new(8.0, 16.0), DVec2::new(8.0, 16.0) + DVec2::from(offset));
        let overlap = || circles_overlap(black_box(center), RADIUS, black_box(other), RADIUS);
        assert!(!overlap());
        bencher.bench_local(overlap);
    }
}
