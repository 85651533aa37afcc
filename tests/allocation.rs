//! A warm cycle takes no memory: one that needs no more than those before. Only a chain of objects that is longer than
//! any before would, and at these densities there are no long ones.
//!
//! A program of its own, since it puts itself in the place of the allocator.

#[path = "suite/kinematics/march.rs"]
mod march;

use glam::DVec2;
use maniple_geometry::{Circle, Limits, ObjectId};
use maniple_kinematics::{Layers, Leg, Placement, Stops, World};

use crate::march::{Field, March, unit};

/// What takes memory, counted by thread.
mod counting {
    use std::alloc::{GlobalAlloc, Layout, System};
    use std::cell::Cell;

    thread_local! {
        static TAKEN: Cell<u64> = const { Cell::new(0) };
    }

    /// Returns how often this thread has taken memory, or made a piece of it larger.
    pub(crate) fn taken() -> u64 {
        TAKEN.with(Cell::get)
    }

    /// The allocator of the system; each request is counted.
    struct Counting;

    #[global_allocator]
    static ALLOCATOR: Counting = Counting;

    fn count() {
        // The counter needs no memory of its own: it is constant at the start and nothing is dropped at the end.
        TAKEN.with(|taken| taken.set(taken.get() + 1));
    }

    #[expect(unsafe_code, reason = "an allocator cannot be written without")]
    // SAFETY: every request goes to the system's allocator as it is, and so does every answer.
    unsafe impl GlobalAlloc for Counting {
        unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
            count();
            // SAFETY: the caller keeps the promises of `alloc`, which are those of the system's allocator.
            unsafe { System.alloc(layout) }
        }

        unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
            count();
            // SAFETY: as above.
            unsafe { System.alloc_zeroed(layout) }
        }

        unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
            count();
            // SAFETY: as above; the piece is one of the system's allocator, since all are.
            unsafe { System.realloc(pointer, layout, size) }
        }

        unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
            // SAFETY: as above.
            unsafe { System.dealloc(pointer, layout) }
        }
    }
}

/// Cycles until a march is warm: by then hardly a list will ever be longer than it has been.
const WARM_UP: u32 = 600;

/// Cycles that are counted: more than there are between two tidyings of memory.
const CYCLES: u32 = 40;

#[test]
fn a_warm_cycle_of_constant_activity_takes_no_memory_in_one_thread() {
    for (objects, side, walls) in [(300, 40.0, 4), (5000, 150.0, 80), (20_000, 300.0, 300)] {
        let seed = 37;
        println!("seed {seed}, {objects} objects");
        let field = Field::boxed(side, walls, seed);
        let places = field.places(objects, seed, |_| true);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
        let taken = pool.install(|| {
            let mut march = March::new(&field, &places, seed);
            for _ in 0..WARM_UP {
                march.order();
                march.step();
            }
            let counted = |_| {
                march.order();
                let before = counting::taken();
                march.step();
                counting::taken() - before
            };
            (0..CYCLES).map(counted).collect::<Vec<u64>>()
        });
        assert_eq!(taken, vec![0; CYCLES as usize], "{objects} objects: so often each cycle took memory");
    }
}

#[test]
fn a_warm_cycle_that_pulls_objects_back_takes_no_memory() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
    let cycles = pool.install(|| {
        let limits = Limits::new(1000.0, COLUMN_RADIUS, 5.0).expect("good limits");
        let mut world = World::new(limits, Stops::Both, &[]).expect("there are no walls");
        world.reserve((COLUMN_SIDE * COLUMN_SIDE) as usize);
        (0..WARM_UP + 10 * CYCLES)
            .map(|cycle| {
                if cycle % 10 == 0 {
                    line_up(&mut world, u64::from(cycle));
                }
                let before = counting::taken();
                world.step();
                (counting::taken() - before, world.activity().retreats)
            })
            .skip(WARM_UP as usize)
            .collect::<Vec<(u64, usize)>>()
    });
    let pulled_back = cycles.iter().filter(|cycle| cycle.1 > 0).count();
    println!("in {pulled_back} of {} cycles somebody was pulled back", cycles.len());
    assert!(pulled_back > 0, "rounding alone makes some of them overlap, so the certificate has work");
    assert!(cycles.iter().all(|cycle| cycle.0 == 0), "times memory was taken, and retreats: {cycles:?}");
}

#[test]
fn the_counter_counts() {
    let before = counting::taken();
    let mut list = vec![1u8];
    list.reserve_exact(1 << 20);
    assert_eq!(counting::taken() - before, 2);
}

/// Circles along a side of the square that marches in step.
const COLUMN_SIDE: u32 = 8;

const COLUMN_RADIUS: f64 = 0.37;

/// Puts circles that touch into the world, in the place of those that are there, and sends them all the same way.
fn line_up(world: &mut World, seed: u64) {
    let share = |purpose: u64| unit(&[seed, purpose]);
    let corner = DVec2::new(200.0 + 100.0 * share(1), 200.0 + 100.0 * share(2));
    let way = DVec2::new(share(3) - 0.5, share(4) - 0.5) * 200.0;
    for id in world.ids() {
        world.remove(id).expect("it is there");
    }
    for number in 0..COLUMN_SIDE * COLUMN_SIDE {
        let (id, place) =
            (ObjectId(number), DVec2::new((number % COLUMN_SIDE).into(), (number / COLUMN_SIDE).into()));
        let center = corner + place * (2.0 * COLUMN_RADIUS);
        if world.insert(id, Circle::new(center, COLUMN_RADIUS), Layers::GROUND).is_ok() {
            let leg = Leg { goal: center + way, speed: 0.5 + 4.0 * share(5) };
            world.go(id, &[leg], Placement::Replace, None).expect("the goal is in the field");
        }
    }
}
