//! What the broad phase and a whole cycle cost, in one thread: `cargo bench -p maniple-kinematics`.
//!
//! Circles march on random ways at a share of the area, and get another way where they are stopped. The scenes are smaller
//! and plainer than those of `maniple bench scale`, which has the figures that are compared.

use std::cell::RefCell;

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use glam::DVec2;
use maniple_geometry::{Circle, Limits, ObjectId, Scalar};
use maniple_kinematics::{BroadPhase, Layers, Leg, Placement, Stops, World};

const OBJECTS: u32 = 10_000;

/// Of the area that circles cover.
const SHARES: [f64; 2] = [0.05, 0.25];

/// World units.
const RADIUS: f64 = 0.4;

/// World units a cycle.
const SPEEDS: (f64, f64) = (0.1, 1.0);

/// The longest way along each axis, in world units.
const WAY_MAX: f64 = 50.0;

/// Cycles until all memory is taken and everybody has met a neighbour or two.
const WARM_UP: usize = 10;

fn main() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build_global();
    pool.expect("nobody has asked for threads before");
    divan::main();
}

/// Motion spheres into sectors, and the pairs that intersect.
#[divan::bench(args = SHARES)]
fn near_pairs(bencher: Bencher<'_, '_>, share: f64) {
    let march = March::warmed_up(share);
    let spheres: Vec<Circle> = (0..OBJECTS).map(|id| march.motion_sphere(ObjectId(id))).collect();
    let mut broad = BroadPhase::new();
    assert!(broad.near_pairs(&spheres).found > 0);
    bencher.counter(ItemsCount::new(OBJECTS)).bench_local(|| broad.near_pairs(black_box(&spheres)));
}

/// A whole cycle, without the orders before it. One sample is one cycle, since the next one needs orders.
#[divan::bench(args = SHARES, sample_size = 1, sample_count = 200)]
fn step(bencher: Bencher<'_, '_>, share: f64) {
    let march = RefCell::new(March::warmed_up(share));
    bencher
        .counter(ItemsCount::new(OBJECTS))
        .with_inputs(|| march.borrow_mut().order())
        .bench_local_values(|()| march.borrow_mut().step());
}

/// Circles that march in a square, and the state of their random numbers.
struct March {
    world: World,
    side: f64,
    stopped: Vec<ObjectId>,
    random: u64,
}

impl March {
    fn warmed_up(share: f64) -> Self {
        let side = (f64::from(OBJECTS) * std::f64::consts::PI * RADIUS * RADIUS / share).sqrt();
        let limits = Limits::new(side, RADIUS, SPEEDS.1).expect("the square is not too large");
        let world = World::new(limits, Stops::Both, &[]).expect("there are no walls");
        let mut march = Self { world, side, stopped: (0..OBJECTS).map(ObjectId).collect(), random: 1 };
        for id in (0..OBJECTS).map(ObjectId) {
            while {
                let circle = Circle::new(march.place(), RADIUS);
                march.world.insert(id, circle, Layers::GROUND).is_err()
            } {}
        }
        for _ in 0..WARM_UP {
            march.order();
            march.step();
        }
        march.order();
        march
    }

    /// Sends everybody who was stopped somewhere around: not to any place of the square, since all of them would pass its
    /// middle.
    fn order(&mut self) {
        for object in std::mem::take(&mut self.stopped) {
            let center = self.world.circle(object).expect("nobody is taken out").center;
            let way = DVec2::new(2.0 * self.unit() - 1.0, 2.0 * self.unit() - 1.0) * WAY_MAX;
            let inside = |coordinate: f64| coordinate.greater(0.0).lesser(self.side);
            let goal = DVec2::new(inside(center.x + way.x), inside(center.y + way.y));
            let speed = SPEEDS.0 + (SPEEDS.1 - SPEEDS.0) * self.unit();
            let sent = self.world.go(object, &[Leg { goal, speed }], Placement::Replace, None);
            sent.expect("the place is in the square");
        }
    }

    fn step(&mut self) {
        let rested = self.world.step().iter().filter(|event| event.rests).map(|event| event.object);
        self.stopped.extend(rested);
    }

    fn motion_sphere(&self, object: ObjectId) -> Circle {
        let circle = self.world.circle(object).expect("nobody is taken out");
        let half = self.world.motion(object).expect("nobody is taken out").velocity * 0.5;
        Circle::new(circle.center + half, circle.radius + half.length())
    }

    fn place(&mut self) -> DVec2 {
        DVec2::new(self.unit(), self.unit()) * self.side
    }

    /// A random number in `0.0..1.0` (Knuth's MMIX generator; its upper half is random enough for places).
    fn unit(&mut self) -> f64 {
        self.random =
            self.random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.random >> 11) as f64 / (1u64 << 53) as f64
    }
}
