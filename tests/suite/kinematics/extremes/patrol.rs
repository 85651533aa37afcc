//! A long patrol: nothing drifts, nothing sinks in, and no cycle costs more than the one before.

use std::collections::BTreeMap;

use glam::DVec2;
use maniple_geometry::{Limits, Moment, ObjectId};
use maniple_kinematics::{Event, EventKind, Leg, Placement, World};

use super::super::scene::Random;
use super::site::{Site, across, direction};
use super::tally::SEED;

/// Cycles of the ordinary run, and of that with `MANIPLE_LONG=1`.
const CYCLES: u32 = 20_000;
const CYCLES_LONG: u32 = 1_000_000;

/// Objects that go side by side, touching up to the last bits, and such that go alone.
const ABREAST: u32 = 12;
const ALONE: u32 = 12;

/// Between how many cycles everything is checked for overlaps.
const CHECK: u32 = 50;

/// What a part of the run had to do.
#[derive(Clone, Copy, Debug, Default)]
struct Work {
    runners: usize,
    pairs: usize,
    components: usize,
    retreats: usize,
}

/// The patrols of a run, and what was seen of them.
struct Watch {
    world: World,
    patrols: Patrols,
    /// By id: how many legs were ended.
    legs: BTreeMap<u32, usize>,
    arrivals: u64,
    collisions: u64,
    /// Ends of legs that were compared with their goals.
    looks: u64,
    /// Largest distance between the end of a leg and its goal.
    worst: f64,
}

#[test]
fn a_long_patrol_neither_drifts_nor_sinks_in_nor_gets_dearer() {
    let cycles = if std::env::var_os("MANIPLE_LONG").is_some() { CYCLES_LONG } else { CYCLES };
    println!("class long patrol: seed {SEED}, {cycles} cycles");
    let mut watch = Watch::new(&mut Random(SEED));
    let first = watch.go_on(cycles / 10);
    let bytes = watch.world.bytes();
    let last = (0..9).map(|_| watch.go_on(cycles / 10)).last().expect("nine more parts");
    let Watch { world, arrivals, collisions, looks, worst, .. } = watch;
    println!(
        "| class | cycles | arrivals | collisions | largest error at a goal | first tenth | last tenth |"
    );
    println!("| long patrol | {cycles} | {arrivals} | {collisions} | {worst:e} | {first:?} | {last:?} |");
    assert!(looks > u64::from(cycles) && 20 * looks > 19 * arrivals, "{looks} of {arrivals}");
    assert_eq!(worst, 0.0, "every leg ends exactly on its goal");
    let is_flat = |first: usize, last: usize| last as f64 <= 1.1 * first as f64 + 8.0;
    assert_eq!(first.runners, last.runners);
    assert!(is_flat(first.pairs, last.pairs), "{first:?} {last:?}");
    assert!(is_flat(first.components, last.components), "{first:?} {last:?}");
    assert!(last.retreats as f64 <= 1.5 * first.retreats as f64 + 64.0, "{first:?} {last:?}");
    // A chain of objects that is longer than any before takes a little, once.
    assert!(world.bytes() <= bytes + bytes / 100, "{} bytes, after the first tenth {bytes}", world.bytes());
}

impl Watch {
    fn new(random: &mut Random) -> Self {
        let (world, patrols) = patrols(random);
        let legs = patrols.keys().map(|&id| (id, 0)).collect();
        let mut watch = Self { world, patrols, legs, arrivals: 0, collisions: 0, looks: 0, worst: 0.0 };
        for id in watch.world.ids() {
            watch.send(id, 0..3);
        }
        watch
    }

    /// Lets so many cycles pass, and returns what they had to do.
    fn go_on(&mut self, cycles: u32) -> Work {
        let mut work = Work::default();
        for _ in 0..cycles {
            let events = self.world.step().to_vec();
            for (place, event) in events.iter().enumerate() {
                let later: Vec<EventKind> = events[place + 1..]
                    .iter()
                    .filter(|later| later.object == event.object)
                    .map(|later| later.kind)
                    .collect();
                self.see(event, &later);
            }
            let activity = self.world.activity();
            work.runners += activity.runners;
            work.pairs += activity.pairs_tested;
            work.components += activity.components;
            work.retreats += activity.retreats;
            if self.world.cycle().0.is_multiple_of(CHECK) {
                assert_eq!(self.world.overlaps(), [], "after cycle {}", self.world.cycle());
            }
        }
        work
    }

    /// Notes what happened to an object, given what else happened to it later in the cycle, and sends it on.
    fn see(&mut self, event: &Event, later: &[EventKind]) {
        let id = event.object;
        let leg = self.legs.get_mut(&id.0).expect("it patrols");
        let goals = &self.patrols[&id.0].0;
        let goal = goals[*leg % goals.len()];
        *leg += 1;
        let next = *leg;
        if event.kind == EventKind::Arrived {
            self.arrivals += 1;
            let motion = self.world.motion(id).expect("it is there");
            if motion.from == (Moment { cycle: event.cycle, fraction: event.time }) {
                // What turns in mid-cycle begins its next leg where the last one ended, unless it was pulled back then.
                self.looks += 1;
                self.worst = self.worst.max((motion.start - goal).length());
            }
            if later.iter().all(|kind| *kind == EventKind::Arrived) {
                self.send(id, next + 2..next + 3);
            }
        } else {
            // Who slides along another one up to the last bits may collide with it, and turns round.
            assert!((ABREAST..2 * ABREAST).contains(&id.0), "nobody else is in the way: {event:?}");
            self.collisions += 1;
            self.send(id, next..next + 3);
        }
    }

    fn send(&mut self, id: ObjectId, legs: std::ops::Range<usize>) {
        let (goals, speed) = &self.patrols[&id.0];
        for leg in legs {
            let leg = Leg { goal: goals[leg % goals.len()], speed: *speed };
            self.world.go(id, &[leg], Placement::Queue, None).expect("a good leg");
        }
    }
}

/// For each object the goals between which it goes to and fro, and its speed.
type Patrols = BTreeMap<u32, (Vec<DVec2>, f64)>;

/// Objects abreast in a row along an axis, which never touch by rounding; abreast in a slanted row, which do; and alone.
fn patrols(random: &mut Random) -> (World, Patrols) {
    let limits = Limits::new(4096.0, 2.0, 8.0).expect("good limits");
    let mut site = Site::new(limits, random, &[]);
    let mut patrols = Patrols::new();
    let speed = random.between(0.3, 0.6);
    for (way, radius, corner) in [
        (DVec2::X, 0.375, DVec2::new(64.0, 64.0)),
        (direction(random), random.between(0.3, 0.7), DVec2::new(213.7, 177.1)),
    ] {
        for place in 0..ABREAST {
            let start = corner + across(way) * (2.0 * radius * f64::from(place));
            let id = site.put_outwards(start, across(way), radius).expect("a place beside");
            // In step but for the last half, which is slower and slides along.
            let speed = if place < ABREAST / 2 { speed } else { speed * random.between(0.5, 0.99) };
            let start = site.center(id);
            patrols.insert(id, (vec![start + way * 7.25, start], speed));
        }
    }
    for place in 0..ALONE {
        let start = DVec2::new(-900.0 + 90.0 * f64::from(place), -700.0);
        let id = site.put(start, random.between(0.1, 1.9)).expect("a place apart");
        let mut goal = || start + DVec2::new(random.between(-30.0, 30.0), random.between(-30.0, 30.0));
        patrols.insert(id, (vec![goal(), goal(), goal()], random.between(0.1, 5.0)));
    }
    (site.scene(0).world(), patrols)
}
