//! What must not change anything: where a scene is, how large it is, which way it is turned, who is in it besides.
//!
//! A property is *bit for bit* where all that the core computes from the changed scene is the same number, or the same
//! times a power of two, or with the other sign, or with x and y swapped. The scenes are on a lattice of 2^-10, so that
//! moving them by whole numbers rounds nothing; all velocities and times are as they were, so positions inside the cycle
//! are rounded to another grid if the magnitude changes. Where that is so, the property says what is left of it.

use std::collections::BTreeMap;

use glam::DVec2;
use maniple_geometry::{Circle, Limits, ObjectId, Segment};
use maniple_kinematics::{Event, EventKind, Layers, Stops, Wall, WallKind};
use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};

use super::scene::{Order, Random, Scene};

/// Scenes for each property in the ordinary run; `MANIPLE_LONG=1` plays fifty times as many.
const SCENES: u32 = 500;

/// The seed of all properties: what proptest draws is the number from which a scene is made, and the change.
const SEED: u64 = 20_261_001;

/// Finer than any place, radius and speed of these scenes.
const LATTICE: f64 = 1.0 / 1024.0;

/// Most objects of a scene.
const OBJECTS_MAX: u32 = 24;

/// Collisions nearer to each other than this, in cycles, may come in another order where the cycle is split.
const TIE: f64 = 1e-6;

/// Edge of the field, and its place: all coordinates lie within one power of two, 2^10 to 2^11, wherever it is moved.
const FIELD: f64 = 24.0;
const CORNER: f64 = 1284.0;

/// Copies in a row and in a column, and from one to the next: they fill that power of two.
const TILES: u32 = 32;
const PITCH: f64 = 32.0;

/// What is compared: what happened, and where everybody is after each cycle.
#[derive(Clone, Debug, PartialEq)]
struct Course {
    events: Vec<Told>,
    /// By id, after each cycle.
    places: Vec<BTreeMap<u32, DVec2>>,
    retreats: usize,
}

/// An event with all bits of its time.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Told {
    cycle: u32,
    time: u64,
    object: u32,
    kind: EventKind,
    other: Option<u32>,
}

/// A collision, with its time in cycles of the whole scene.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Happened {
    time: f64,
    object: u32,
    kind: EventKind,
    other: Option<u32>,
}

#[test]
fn a_scene_that_is_moved_by_a_power_of_two_comes_out_the_same() {
    // Bit for bit: coordinates stay within one power of two, so every sum of a position and a way is rounded to the same
    // grid, of which the change is a multiple. Offsets, velocities and times are the same numbers. The limits stay.
    check(("translation", SCENES), any::<u64>().prop_map(|bits| power(bits, -3, 7)), |scene, &step| {
        let moved = |point: DVec2| point + DVec2::new(step, -step);
        let changed = mapped(scene, &moved, 1.0);
        prop_assert_eq!(course(&changed), remapped(&course(scene), &moved));
        Ok(())
    });
}

#[test]
fn a_scene_that_is_scaled_by_a_power_of_two_comes_out_the_same() {
    // Bit for bit: every product and quotient has the same digits; times do not change. The limits scale, so the skin does.
    check(("scaling", SCENES), any::<u64>().prop_map(|bits| power(bits, -6, 6)), |scene, &factor| {
        let moved = |point: DVec2| point * factor;
        let changed = mapped(scene, &moved, factor);
        prop_assert_eq!(course(&changed), remapped(&course(scene), &moved));
        Ok(())
    });
}

#[test]
fn a_scene_that_is_mirrored_or_turned_by_quarters_comes_out_the_same() {
    // Bit for bit: signs and the names of the axes do not change how a number is rounded, and every formula adds its x
    // term to its y term, which commutes.
    check(("mirrors and quarter turns", SCENES), 0u32..8, |scene, &turn| {
        let moved = |point: DVec2| {
            let point = if turn & 4 == 0 { point } else { DVec2::new(-point.x, point.y) };
            (0..turn & 3).fold(point, |point, _| DVec2::new(-point.y, point.x))
        };
        let changed = mapped(scene, &moved, 1.0);
        prop_assert_eq!(course(&changed), remapped(&course(scene), &moved));
        Ok(())
    });
}

#[test]
fn other_ids_and_another_order_of_insertion_come_out_the_same() {
    // Bit for bit, with the ids renamed; of several partners the one with the smallest id is told of, so who that is may
    // change, and is not compared.
    check(("permuted ids", SCENES), any::<u64>(), |scene, &seed| {
        let mut random = Random(seed);
        let mut names: Vec<u32> = (0..OBJECTS_MAX).map(|place| 3 * place + 1).collect();
        shuffle(&mut names, &mut random);
        let name = |id: u32| names[id as usize];
        let mut changed = scene.clone();
        for object in &mut changed.objects {
            object.0 = name(object.0);
        }
        for order in &mut changed.orders {
            order.id = name(order.id);
        }
        shuffle(&mut changed.objects, &mut random);
        let (mut expected, mut found) = (course(scene), course(&changed));
        for event in &mut expected.events {
            event.object = name(event.object);
        }
        for event in expected.events.iter_mut().chain(&mut found.events) {
            event.other = event.other.map(|_| 0);
        }
        expected.events.sort_by_key(|event| (event.cycle, event.time, event.object));
        for places in &mut expected.places {
            *places = places.iter().map(|(&id, &place)| (name(id), place)).collect();
        }
        prop_assert_eq!(found, expected);
        Ok(())
    });
}

#[test]
fn a_far_away_object_changes_nothing() {
    // Bit for bit: the skin follows from the declared limits alone, and broad phase and components only sort out. What is fast
    // or large, and alone, also makes sectors wider or a level of its own.
    check(("a far-away object", SCENES), any::<u64>(), |scene, &seed| {
        let mut random = Random(seed);
        let id = u32::MAX;
        let mut changed = scene.clone();
        let place = DVec2::new(random.between(-900.0, -100.0), random.between(-900.0, -100.0));
        changed.objects.insert(0, (id, place, random.between(0.01, 4.0), 1));
        if random.chance(0.7) {
            let goal = DVec2::new(random.between(-900.0, -100.0), random.between(-900.0, -100.0));
            changed = changed.go(0, id, goal.into(), random.between(0.01, 60.0));
        }
        let mut found = course(&changed);
        found.events.retain(|event| event.object != id);
        for places in &mut found.places {
            places.remove(&id);
        }
        prop_assert_eq!(found, course(scene));
        Ok(())
    });
}

#[test]
fn a_copy_of_a_world_in_mid_match_goes_on_the_same_way() {
    // Bit for bit: what a world keeps for its memory only decides nothing.
    check(("a copy in mid-match", SCENES), any::<u64>(), |scene, &seed| {
        let cycle = Random(seed).below(scene.cycles);
        prop_assert_eq!(course_copied_in(scene, Some(cycle)), course(scene));
        Ok(())
    });
}

#[test]
fn an_object_that_is_never_touched_can_be_taken_away() {
    // Bit for bit: who collides with nobody is in nobody's result. Who was next to an object that was pulled back might
    // have been its reason, so scenes with retreats are left out.
    check(("a never-touched object removed", SCENES), any::<u64>(), |scene, &seed| {
        let expected = course(scene);
        if expected.retreats > 0 {
            return Ok(());
        }
        let mut free: Vec<u32> = scene.objects.iter().map(|object| object.0).collect();
        for event in &expected.events {
            free.retain(|id| event.other.is_none() || (*id != event.object && Some(*id) != event.other));
        }
        if free.is_empty() {
            return Ok(());
        }
        let id = Random(seed).pick(&free);
        let mut changed = scene.clone();
        changed.objects.retain(|object| object.0 != id);
        changed.orders.retain(|order| order.id != id);
        let mut expected = expected;
        expected.events.retain(|event| event.object != id);
        for places in &mut expected.places {
            places.remove(&id);
        }
        prop_assert_eq!(course(&changed), expected);
        Ok(())
    });
}

#[test]
fn a_scene_goes_the_same_way_beside_a_thousand_copies_of_it_in_any_number_of_threads() {
    // Bit for bit, for the same reason as a translation: all copies lie within one power of two. Together they have so
    // many objects that seven threads get a share.
    let few = SCENES / 50;
    check(("copies and threads", few), proptest::sample::select(vec![1, 2, 3, 7]), |scene, &threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        let expected = tiled_course(&course(scene));
        prop_assert_eq!(pool.install(|| course(&tiled(scene))) == expected, true, "{} threads", threads);
        Ok(())
    });
}

#[test]
fn a_cycle_split_into_several_has_the_same_collisions_in_the_same_order() {
    // Not bit for bit: positions are rounded at the end of each cycle. The same pairs collide in the same order, at the
    // same times up to rounding. A scene with equal times is left out: there rounding may decide which comes first.
    let (compared, skipped) = (std::cell::Cell::new(0), std::cell::Cell::new(0));
    check(("a cycle in k", SCENES), 2u32..9, |scene, &parts| {
        let mut whole = scene.clone();
        whole.orders.retain(|order| order.cycle == 0 && order.start.is_none());
        let mut split = whole.clone();
        split.cycles *= parts;
        for order in &mut split.orders {
            for leg in &mut order.legs {
                leg.1 /= f64::from(parts);
            }
        }
        let (expected, found) = (moments(&whole, 1.0), moments(&split, f64::from(parts)));
        let is_tie = |two: &[Happened]| {
            let is_same = two[1].other == Some(two[0].object) && two[0].other == Some(two[1].object);
            two[1].time - two[0].time < TIE && !is_same
        };
        if expected.windows(2).any(is_tie) {
            skipped.set(skipped.get() + 1);
            return Ok(());
        }
        compared.set(compared.get() + 1);
        let names =
            |list: &[Happened]| list.iter().map(|it| (it.object, it.kind, it.other)).collect::<Vec<_>>();
        prop_assert_eq!(names(&expected), names(&found), "{:?} {:?}", expected, found);
        for (one, other) in expected.iter().zip(&found) {
            prop_assert!((one.time - other.time).abs() < TIE, "{:?} {:?}", one, other);
        }
        Ok(())
    });
    println!("{} compared, {} left out", compared.get(), skipped.get());
    assert!(compared.get() > SCENES / 4, "{} compared", compared.get());
}

/// Draws scenes and changes, and asks a property of each.
fn check<C: std::fmt::Debug>(
    (name, scenes): (&str, u32),
    change: impl Strategy<Value = C>,
    property: impl Fn(&Scene, &C) -> Result<(), TestCaseError>,
) {
    let cases = if std::env::var_os("MANIPLE_LONG").is_some() { 50 * scenes } else { scenes };
    println!("property {name}: seed {SEED}, {cases} scenes");
    let mut seed = [0; 32];
    seed[..8].copy_from_slice(&SEED.to_le_bytes());
    let config = Config { cases, failure_persistence: None, ..Config::default() };
    let mut runner = TestRunner::new_with_rng(config, TestRng::from_seed(RngAlgorithm::ChaCha, &seed));
    let (events, collisions) = (std::cell::Cell::new(0), std::cell::Cell::new(0));
    let strategy = (any::<u64>().no_shrink(), 2..=OBJECTS_MAX, change);
    let result = runner.run(&strategy, |(seed, objects, change)| {
        let scene = scene(seed, objects);
        let course = course(&scene);
        events.set(events.get() + course.events.len());
        let is_collision = |event: &&Told| !matches!(event.kind, EventKind::Arrived | EventKind::Ordered);
        collisions.set(collisions.get() + course.events.iter().filter(is_collision).count());
        property(&scene, &change)
    });
    println!("property {name}: {} events, {} collisions", events.get(), collisions.get());
    if let Err(error) = result {
        panic!("{name}: {error}");
    }
    assert!(collisions.get() > cases as usize, "there is something to compare");
}

/// A scene on the lattice. A scene of fewer objects is a part of one of more, so that a failure shrinks.
fn scene(seed: u64, objects: u32) -> Scene {
    let mut random = Random(seed);
    let limits = Limits::new(2048.0, 4.0, 64.0).expect("good limits");
    let stops = random.pick(&[Stops::Both, Stops::Approaching]);
    let (walls, orders) = (Vec::new(), Vec::new());
    let mut scene = Scene { limits, stops, walls, objects: Vec::new(), orders, cycles: 5 };
    for _ in 0..random.below(4) {
        let segment = Segment::new(place(&mut random), place(&mut random));
        let wall = Wall { segment, kind: WallKind::Segment, layers: Layers(u32::MAX) };
        scene.walls.extend((segment.start != segment.end).then_some(wall));
    }
    let mut world = scene.world();
    for id in 0..objects {
        let mut random = Random(seed ^ (u64::from(id) << 32));
        let (center, radius) = (place(&mut random), lattice(random.between(0.1, 1.5)));
        if world.insert(ObjectId(id), Circle::new(center, radius), Layers::GROUND).is_err() {
            continue;
        }
        scene.objects.push((id, center, radius, Layers::GROUND.0));
        for cycle in [0, 0, 1, 3] {
            if !random.chance(0.5) {
                continue;
            }
            let speed =
                |random: &mut Random| lattice(random.pick(&[0.7, 3.0, 20.0]) * random.between(0.1, 2.0));
            let legs = (0..1 + random.below(2)).map(|_| (place(&mut random), speed(&mut random))).collect();
            let start = random.chance(0.3).then(|| (cycle, lattice(random.unit())));
            scene.orders.push(Order { cycle, id, legs, queue: random.chance(0.4), start });
        }
    }
    scene.orders.sort_by_key(|order| order.cycle);
    scene
}

fn place(random: &mut Random) -> DVec2 {
    let mut axis = || CORNER + lattice(random.between(0.0, FIELD));
    DVec2::new(axis(), axis())
}

fn lattice(number: f64) -> f64 {
    (number / LATTICE).ceil() * LATTICE
}

/// The same scene with all places changed, and all lengths times a factor.
fn mapped(scene: &Scene, moved: &impl Fn(DVec2) -> DVec2, factor: f64) -> Scene {
    let mut changed = scene.clone();
    let limits = &scene.limits;
    changed.limits = Limits::new(
        limits.coordinate_max() * factor,
        limits.radius_max() * factor,
        limits.speed_max() * factor,
    )
    .expect("good limits");
    for wall in &mut changed.walls {
        wall.segment = Segment::new(moved(wall.segment.start), moved(wall.segment.end));
    }
    for object in &mut changed.objects {
        object.1 = moved(object.1);
        object.2 *= factor;
    }
    for leg in changed.orders.iter_mut().flat_map(|order| &mut order.legs) {
        *leg = (moved(leg.0), leg.1 * factor);
    }
    changed
}

fn remapped(course: &Course, moved: &impl Fn(DVec2) -> DVec2) -> Course {
    let mut changed = course.clone();
    for place in changed.places.iter_mut().flat_map(BTreeMap::values_mut) {
        *place = moved(*place);
    }
    changed
}

/// The way from the scene to each of its copies, by number.
fn tiles() -> impl Iterator<Item = (u32, DVec2)> {
    let way = |tile: u32| {
        let place = DVec2::new(f64::from(tile % TILES), f64::from(tile / TILES));
        DVec2::splat(1028.0 - CORNER) + place * PITCH
    };
    (0..TILES * TILES).map(move |tile| (tile, way(tile)))
}

/// Copies of a scene side by side, with ids of their own.
fn tiled(scene: &Scene) -> Scene {
    let mut all = Scene { walls: Vec::new(), objects: Vec::new(), orders: Vec::new(), ..scene.clone() };
    for (tile, way) in tiles() {
        let copy = mapped(scene, &|point: DVec2| point + way, 1.0);
        all.walls.extend(copy.walls);
        let name = |id: u32| tile * OBJECTS_MAX + id;
        all.objects.extend(copy.objects.iter().map(|object| (name(object.0), object.1, object.2, object.3)));
        all.orders.extend(copy.orders.into_iter().map(|order| Order { id: name(order.id), ..order }));
    }
    all
}

fn tiled_course(course: &Course) -> Course {
    let mut all = Course { events: Vec::new(), places: Vec::new(), retreats: 0 };
    all.places.resize(course.places.len(), BTreeMap::new());
    for (tile, way) in tiles() {
        let name = |id: u32| tile * OBJECTS_MAX + id;
        let renamed =
            |event: &Told| Told { object: name(event.object), other: event.other.map(name), ..*event };
        all.events.extend(course.events.iter().map(renamed));
        for (all, places) in all.places.iter_mut().zip(&course.places) {
            all.extend(places.iter().map(|(&id, &place)| (name(id), place + way)));
        }
        all.retreats += course.retreats;
    }
    all.events.sort_by_key(|event| (event.cycle, event.time, event.object));
    all
}

/// Plays a scene; no coordinate is zero, so equal places are equal bits.
fn course(scene: &Scene) -> Course {
    course_copied_in(scene, None)
}

/// As [`course`], but goes on with a copy of the world from a cycle on.
fn course_copied_in(scene: &Scene, cycle: Option<u32>) -> Course {
    let mut world = scene.world();
    let mut course = Course { events: Vec::new(), places: Vec::new(), retreats: 0 };
    for now in 0..scene.cycles {
        if cycle == Some(now) {
            let copy = world.clone();
            assert_eq!(copy.digest(), world.digest());
            world = copy;
        }
        scene.give(&mut world);
        course.events.extend(world.step().iter().map(told));
        course.retreats += world.activity().retreats;
        assert_eq!(world.overlaps(), []);
        let center = |id: ObjectId| (id.0, world.circle(id).expect("it is there").center);
        course.places.push(world.ids().into_iter().map(center).collect());
    }
    course
}

fn told(event: &Event) -> Told {
    let &Event { cycle, time, object, kind, other, .. } = event;
    Told { cycle: cycle.0, time: time.to_bits(), object: object.0, kind, other: other.map(|other| other.0) }
}

/// The collisions of a scene, by time, where a cycle of the whole scene has so many parts.
fn moments(scene: &Scene, parts: f64) -> Vec<Happened> {
    let happened = |event: &Told| Happened {
        time: (f64::from(event.cycle) + f64::from_bits(event.time)) / parts,
        object: event.object,
        kind: event.kind,
        other: event.other,
    };
    let is_collision = |event: &&Told| !matches!(event.kind, EventKind::Arrived | EventKind::Ordered);
    course(scene).events.iter().filter(is_collision).map(happened).collect()
}

/// A power of two with an exponent in a range, from the bits of a number.
fn power(bits: u64, low: i32, high: i32) -> f64 {
    let span = u64::try_from(high - low).expect("a range") + 1;
    let exponent = low + i32::try_from(bits % span).expect("small");
    2f64.powi(exponent)
}

fn shuffle<T>(list: &mut [T], random: &mut Random) {
    for place in (1..list.len()).rev() {
        list.swap(place, random.below(u32::try_from(place).expect("a short list") + 1) as usize);
    }
}
