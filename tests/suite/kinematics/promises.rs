//! The promises K1 to K9, each under both rules of who stops.

use glam::DVec2;
use maniple_geometry::limits::TINY;
use maniple_geometry::{Circle, Cycle, Moment, NumberError, ObjectId};
use maniple_kinematics::{
    Event, EventKind, InsertError, Layers, Leg, OrderError, Placement, Stops, Wall, WallError, World,
};

use super::scene::{Order, Random, Scene};

const BOTH_RULES: [Stops; 2] = [Stops::Both, Stops::Approaching];

/// Plays a scene under both rules and hands the world and its events to a check.
fn under_both(make: impl Fn(Stops) -> Scene, check: impl Fn(&World, &[Event])) {
    for stops in BOTH_RULES {
        let (world, events, _) = make(stops).play();
        check(&world, &events);
    }
}

fn at(world: &World, id: u32) -> DVec2 {
    world.circle(ObjectId(id)).expect("the object is there").center
}

fn kinds(events: &[Event], id: u32) -> Vec<EventKind> {
    events.iter().filter(|event| event.object == ObjectId(id)).map(|event| event.kind).collect()
}

#[test]
fn k1_circles_that_would_overlap_stop_a_skin_apart() {
    under_both(
        |stops| {
            Scene::boxed(20.0, stops)
                .object(1, (2.0, 5.0), 0.5)
                .object(2, (8.0, 5.0), 0.5)
                .go(0, 1, (12.0, 5.0), 4.0)
                .go(0, 2, (1.0, 5.0), 4.0)
        },
        |world, events| {
            let gap = at(world, 2).x - at(world, 1).x - 1.0;
            assert!(0.0 < gap && gap < 3.0 * world.skin(), "gap {gap:e}");
            assert_eq!(kinds(events, 1), [EventKind::Object]);
            assert_eq!(events[0].other, Some(ObjectId(2)));
            assert!((events[0].time - 0.625).abs() < 1e-9, "{events:?}");
        },
    );
}

#[test]
fn k1_holds_exactly_after_every_cycle_of_a_dense_crowd() {
    let seed = 7;
    println!("seed {seed}");
    for number in 0..20 {
        // Scene::play checks all pairs with the exact predicate after each cycle.
        let (_, events, _) = Scene::crowd(&mut Random(seed + number)).play();
        assert!(events.len() > 50);
    }
}

#[test]
fn k2_nothing_passes_through_anything_however_fast() {
    for speed in [1.0, 10.0, 60.0, 1000.0, 9999.0] {
        under_both(
            |stops| {
                Scene::boxed(100.0, stops)
                    .wall((50.0, 0.0), (50.0, 100.0))
                    .object(1, (10.0, 20.0), 0.001)
                    .object(2, (10.0, 40.0), 0.001)
                    .object(3, (30.0, 40.0), 0.001)
                    .go(0, 1, (90.0, 20.0), speed)
                    .go(0, 2, (90.0, 40.0), speed)
                    .cycles(100)
            },
            |world, events| {
                assert_eq!(kinds(events, 1), [EventKind::Segment], "speed {speed}");
                assert!(at(world, 1).x < 50.0);
                assert_eq!(kinds(events, 2), [EventKind::Object], "speed {speed}");
                assert!(at(world, 2).x < 30.0);
            },
        );
    }
}

#[test]
fn k2_a_wall_is_solid_at_its_ends_and_joints_too() {
    let check = |from: (f64, f64), to: (f64, f64), expected: EventKind| {
        under_both(
            |stops| {
                Scene::boxed(40.0, stops)
                    .wall((20.0, 10.0), (20.0, 20.0))
                    .wall((20.0, 20.0), (30.0, 20.0))
                    .object(1, from, 0.5)
                    .go(0, 1, to, 100.0)
            },
            |_, events| assert_eq!(kinds(events, 1), [expected], "from {from:?} to {to:?}"),
        );
    };
    check((10.0, 15.0), (35.0, 15.0), EventKind::Segment);
    check((10.0, 9.51), (35.0, 9.51), EventKind::Segment);
    check((10.0, 9.5), (35.0, 9.5), EventKind::Arrived);
    check((10.0, 30.0), (25.0, 15.0), EventKind::Segment);
    check((20.0, 5.0), (20.0, 30.0), EventKind::Segment);
    check((19.5, 5.0), (19.5, 30.0), EventKind::Arrived);
    check((19.6, 5.0), (19.6, 30.0), EventKind::Segment);
    check((5.0, 5.0), (5.0, 39.7), EventKind::Edge);
}

#[test]
fn k3_a_free_motion_ends_exactly_on_its_goal_and_never_drifts() {
    let seed = 11;
    println!("seed {seed}");
    let mut random = Random(seed);
    for _ in 0..200 {
        let goal = (random.between(1.0, 99.0), random.between(1.0, 99.0));
        let speed = random.between(0.01, 3.0);
        under_both(
            |stops| {
                Scene::boxed(100.0, stops).object(1, (3.0, 4.0), 0.25).go(0, 1, goal, speed).cycles(15_000)
            },
            |world, events| {
                assert_eq!(at(world, 1), DVec2::from(goal));
                assert_eq!(kinds(events, 1), [EventKind::Arrived]);
                let way = DVec2::from(goal) - DVec2::new(3.0, 4.0);
                let expected = way.dot(way).sqrt() / speed;
                let took = events[0].cycle.since(Cycle(0)) + events[0].time;
                assert!((took - expected).abs() < 1e-9, "took {took}, expected {expected}");
            },
        );
    }
}

#[test]
fn k3_the_position_is_a_closed_form_of_the_start() {
    for stops in BOTH_RULES {
        let scene = Scene::boxed(100.0, stops).object(1, (0.7, 0.9), 0.25).go(0, 1, (97.3, 61.1), 0.013);
        let mut world = scene.world();
        scene.give(&mut world);
        world.step();
        let motion = world.motion(ObjectId(1)).expect("the object is there");
        for _ in 0..5000 {
            world.step();
            assert_eq!(world.motion(ObjectId(1)), Some(motion), "the motion never changes");
            assert_eq!(at(&world, 1), motion.start + motion.velocity * f64::from(world.cycle().0));
        }
    }
}

#[test]
fn k3_a_goal_that_touches_is_reached_and_one_that_overlaps_is_not() {
    let check = |goal: f64, expected: EventKind| {
        under_both(
            |stops| {
                Scene::boxed(20.0, stops)
                    .object(1, (2.0, 5.0), 0.5)
                    .object(2, (8.0, 5.0), 0.5)
                    .go(0, 1, (goal, 5.0), 1.5)
                    .cycles(8)
            },
            |_, events| assert_eq!(kinds(events, 1), [expected], "goal {goal}"),
        );
    };
    check(7.0, EventKind::Arrived);
    check(7.0_f64.next_down(), EventKind::Arrived);
    check(7.0_f64.next_up(), EventKind::Object);
}

#[test]
fn k4_the_bits_do_not_depend_on_threads_or_the_order_of_insertion() {
    let seed = 13;
    println!("seed {seed}");
    for number in 0..60 {
        let mut random = Random(seed + number);
        let scene = Scene::random(&mut random);
        let expected = digests(&scene);
        for threads in [1, 2, 3, 7] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
            assert_eq!(pool.install(|| digests(&scene)), expected, "{threads} threads, scene {number}");
        }
        let mut shuffled = scene.clone();
        for place in (1..shuffled.objects.len()).rev() {
            shuffled
                .objects
                .swap(place, random.below(u32::try_from(place).expect("few objects") + 1) as usize);
        }
        assert_eq!(digests(&shuffled), expected, "shuffled, scene {number}");
    }
}

/// A change of these bits is a change of what every replay means. `UPDATE_GOLDEN=1` writes the file anew.
#[test]
fn k4_the_hash_of_a_fixed_scene_never_changes() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../tests/golden/kinematics/crowd.hash");
    let hash = format!("{:016x}\n", digests(&Scene::crowd(&mut Random(1)))[5]);
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        std::fs::write(path, &hash).expect("the golden file can be written");
    }
    assert_eq!(std::fs::read_to_string(path).expect("the golden file is there"), hash);
}

fn digests(scene: &Scene) -> Vec<u64> {
    let mut world = scene.world();
    let step = |_| {
        scene.give(&mut world);
        world.step();
        world.digest()
    };
    (0..scene.cycles).map(step).collect()
}

#[test]
fn k5_touching_objects_part_and_slide_but_are_refused_into_each_other() {
    let check = |goal: (f64, f64), expected: EventKind, moved: bool| {
        under_both(
            |stops| {
                Scene::boxed(20.0, stops)
                    .object(1, (5.0, 5.0), 0.5)
                    .object(2, (6.0, 5.0), 0.5)
                    .go(0, 1, goal, 1.0)
            },
            |world, events| {
                assert_eq!(kinds(events, 1), [expected], "to {goal:?}");
                assert_eq!(at(world, 1) != DVec2::new(5.0, 5.0), moved, "to {goal:?}");
                if !moved {
                    assert_eq!(events[0].time, 0.0);
                }
            },
        );
    };
    check((4.0, 5.0), EventKind::Arrived, true);
    check((5.0, 6.0), EventKind::Arrived, true);
    check((5.0, 4.0), EventKind::Arrived, true);
    check((4.5, 5.5), EventKind::Arrived, true);
    check((5.1, 5.0), EventKind::Object, false);
    check((5.5, 5.5), EventKind::Object, false);
}

#[test]
fn k5_objects_at_rest_at_skin_distance_slide_along_each_other() {
    under_both(
        |stops| {
            Scene::boxed(20.0, stops)
                .object(1, (2.0, 5.0), 0.5)
                .object(2, (6.0, 5.0), 0.5)
                .go(0, 1, (6.0, 5.0), 4.0)
                .go(1, 1, (5.0, 9.0), 1.0)
                .cycles(8)
        },
        |world, events| {
            assert_eq!(kinds(events, 1), [EventKind::Object, EventKind::Arrived]);
            assert_eq!(at(world, 1), DVec2::new(5.0, 9.0));
        },
    );
}

#[test]
fn k5_a_corridor_of_exactly_the_diameter_can_be_walked() {
    under_both(
        |stops| {
            Scene::boxed(50.0, stops)
                .wall((5.0, 10.0), (40.0, 10.0))
                .wall((40.0, 11.0), (5.0, 11.0))
                .object(1, (2.0, 10.5), 0.5)
                .go(0, 1, (45.0, 10.5), 0.7)
                .cycles(80)
        },
        |world, events| {
            assert_eq!(kinds(events, 1), [EventKind::Arrived]);
            assert_eq!(at(world, 1), DVec2::new(45.0, 10.5));
        },
    );
}

#[test]
fn k5_under_approaching_nobody_is_halted_by_being_bumped() {
    let chase = |stops| {
        Scene::boxed(50.0, stops)
            .object(1, (2.0, 5.0), 0.5)
            .object(2, (4.0, 5.0), 0.5)
            .go(0, 1, (40.0, 5.0), 3.0)
            .go(0, 2, (40.0, 5.0), 1.0)
            .cycles(1)
    };
    let (_, events, _) = chase(Stops::Approaching).play();
    assert_eq!((kinds(&events, 1), kinds(&events, 2)), (vec![EventKind::Object], vec![]));
    let (_, events, _) = chase(Stops::Both).play();
    assert_eq!((kinds(&events, 1), kinds(&events, 2)), (vec![EventKind::Object], vec![EventKind::Object]));
}

#[test]
fn k5_an_object_at_rest_that_is_bumped_keeps_its_queue_and_start() {
    under_both(
        |stops| {
            let waits = Order {
                cycle: 0,
                id: 2,
                legs: vec![(DVec2::new(6.0, 9.0), 1.0)],
                queue: true,
                start: Some((3, 0.5)),
            };
            Scene::boxed(20.0, stops)
                .object(1, (2.0, 5.0), 0.5)
                .object(2, (6.0, 5.0), 0.5)
                .order(waits)
                .go(0, 1, (9.0, 5.0), 4.0)
                .cycles(8)
        },
        |world, events| {
            assert_eq!(kinds(events, 1), [EventKind::Object]);
            assert_eq!(kinds(events, 2), [EventKind::Arrived]);
            assert_eq!((events[1].cycle, events[1].time), (Cycle(7), 0.5));
            assert_eq!(at(world, 2), DVec2::new(6.0, 9.0));
        },
    );
}

#[test]
fn k6_time_left_at_a_waypoint_goes_into_the_next_leg() {
    let legs =
        vec![(DVec2::new(2.25, 2.0), 1.0), (DVec2::new(2.25, 2.25), 1.0), (DVec2::new(2.0, 2.25), 0.5)];
    under_both(
        |stops| {
            let order = Order { cycle: 0, id: 1, legs: legs.clone(), queue: false, start: None };
            Scene::boxed(10.0, stops).object(1, (2.0, 2.0), 0.5).order(order)
        },
        |world, events| {
            let times: Vec<(f64, bool)> = events.iter().map(|event| (event.time, event.rests)).collect();
            assert_eq!(times, [(0.25, false), (0.5, false), (1.0, true)]);
            assert_eq!(at(world, 1), DVec2::new(2.0, 2.25));
        },
    );
}

#[test]
fn k6_a_start_within_a_cycle_is_kept() {
    let order = |queue| Order {
        cycle: 0,
        id: 1,
        legs: vec![(DVec2::new(9.0, 2.0), 1.0)],
        queue,
        start: Some((1, 0.25)),
    };
    for queue in [false, true] {
        under_both(
            |stops| Scene::boxed(10.0, stops).object(1, (2.0, 2.0), 0.5).order(order(queue)).cycles(2),
            |world, _| assert_eq!(at(world, 1), DVec2::new(2.75, 2.0)),
        );
    }
    // What runs goes on until then.
    under_both(
        |stops| {
            Scene::boxed(10.0, stops)
                .object(1, (2.0, 2.0), 0.5)
                .go(0, 1, (2.0, 9.0), 1.0)
                .order(order(false))
                .cycles(2)
        },
        |world, _| {
            let motion = world.motion(ObjectId(1)).expect("the object is there");
            assert_eq!(motion.start, DVec2::new(2.0, 3.25));
            assert_eq!(motion.from, Moment { cycle: Cycle(1), fraction: 0.25 });
        },
    );
}

#[test]
fn k7_every_stop_has_a_reason_and_a_time() {
    let halt = |cycle| Order { cycle, id: 4, legs: vec![], queue: false, start: Some((cycle, 0.5)) };
    under_both(
        |stops| {
            Scene::boxed(40.0, stops)
                .wall((10.0, 10.0), (10.0, 20.0))
                .object(1, (5.0, 5.0), 0.5)
                .object(2, (5.0, 15.0), 0.5)
                .object(3, (5.0, 30.0), 0.5)
                .object(4, (20.0, 30.0), 0.5)
                .object(5, (5.0, 8.0), 0.5)
                .object(6, (5.0, 2.0), 0.5)
                .go(0, 1, (10.0, 5.0), 10.0)
                .go(0, 2, (20.0, 15.0), 9.0)
                .go(0, 3, (5.0, 39.9), 19.0)
                .go(0, 4, (30.0, 30.0), 2.0)
                .go(0, 5, (5.0, 1.0), 10.0)
                .order(halt(0))
        },
        |_, events| {
            let mut told: Vec<(u32, EventKind, Option<ObjectId>)> =
                events.iter().map(|event| (event.object.0, event.kind, event.other)).collect();
            told.sort_unstable();
            let expected = [
                (1, EventKind::Arrived, None),
                (2, EventKind::Segment, None),
                (3, EventKind::Edge, None),
                (4, EventKind::Ordered, None),
                (5, EventKind::Object, Some(ObjectId(6))),
            ];
            assert_eq!(told, expected);
            assert!(events.iter().all(|event| (event.time - 0.5).abs() < 1e-9), "{events:?}");
        },
    );
}

#[test]
fn k8_objects_at_rest_cost_nothing() {
    // On the way, and a while after it came to rest.
    let activity = |stops, crowd| {
        let scene = mover_beside(crowd, stops);
        let mut world = scene.world();
        scene.give(&mut world);
        world.step();
        let moving = world.activity();
        for _ in 0..60 {
            world.step();
        }
        (moving, world.activity())
    };
    for stops in BOTH_RULES {
        assert_eq!(activity(stops, 0), activity(stops, 5000));
        let (moving, after) = activity(stops, 5000);
        assert_eq!((moving.runners, after.runners), (1, 0));
    }
}

/// One object that goes 25 units at half a unit a cycle, and a crowd at rest apart from it.
fn mover_beside(crowd: u32, stops: Stops) -> Scene {
    let mut scene = Scene::boxed(500.0, stops).object(0, (5.0, 5.0), 0.4).object(1, (9.0, 5.0), 0.4).go(
        0,
        0,
        (5.0, 30.0),
        0.5,
    );
    for id in 0..crowd {
        let place = (100.0 + f64::from(id % 100), 100.0 + f64::from(id / 100));
        scene = scene.object(10 + id, place, 0.4);
    }
    scene
}

#[test]
fn k9_bad_numbers_are_refused_by_name() {
    BOTH_RULES.into_iter().for_each(check_bad_numbers);
}

fn check_bad_numbers(stops: Stops) {
    let mut world = Scene::boxed(100.0, stops).object(1, (5.0, 5.0), 0.5).world();
    let mut insert =
        |x: f64, y: f64, r: f64| world.insert(ObjectId(9), Circle::new(DVec2::new(x, y), r), Layers::GROUND);
    let bad = |field, problem| Err(InsertError::BadNumber { field, problem });
    assert_eq!(insert(f64::INFINITY, 1.0, 1.0), bad("x", NumberError::Infinite));
    assert_eq!(insert(1.0, -0.0, 1.0), bad("y", NumberError::NegativeZero));
    assert_eq!(insert(1.0, 1e-300, 1.0), bad("y", NumberError::Tiny(1e-300)));
    assert_eq!(insert(1.0, TINY / 2.0, 1.0), bad("y", NumberError::Tiny(TINY / 2.0)));
    assert_eq!(insert(1e308, 1.0, 1.0), bad("x", NumberError::TooLarge { value: 1e308, limit: 100.0 }));
    assert_eq!(insert(9.0, 9.0, 0.0), bad("r", NumberError::NotPositive(0.0)));
    assert_eq!(insert(9.0, 9.0, -1.0), bad("r", NumberError::NotPositive(-1.0)));
    assert_eq!(insert(9.0, 9.0, 21.0), bad("r", NumberError::TooLarge { value: 21.0, limit: 20.0 }));
    assert!(matches!(insert(9.0, f64::NAN, 1.0), Err(InsertError::BadNumber { field: "y", .. })));
    assert_eq!(insert(5.5, 5.0, 0.5), Err(InsertError::OverlapsObject { other: ObjectId(1) }));
    assert!(matches!(insert(0.4, 5.0, 0.5), Err(InsertError::OverlapsWall { .. })));

    let mut go = |x: f64, s: f64, fraction: f64| {
        let leg = Leg { goal: DVec2::new(x, 5.0), speed: s };
        let start = Moment { cycle: Cycle(0), fraction };
        world.go(ObjectId(1), &[leg], Placement::Replace, Some(start))
    };
    let bad = |field, problem| Err(OrderError::BadNumber { field, problem });
    assert_eq!(go(6.0, -1.0, 0.0), bad("s", NumberError::Negative(-1.0)));
    assert_eq!(go(6.0, 0.0, 0.0), bad("s", NumberError::NotPositive(0.0)));
    assert_eq!(go(6.0, 2e4, 0.0), bad("s", NumberError::TooLarge { value: 2e4, limit: 1e4 }));
    assert_eq!(go(-101.0, 1.0, 0.0), bad("x", NumberError::TooLarge { value: -101.0, limit: 100.0 }));
    assert_eq!(go(6.0, 1.0, 1.5), bad("start", NumberError::TooLarge { value: 1.5, limit: 1.0 }));
    assert!(matches!(go(6.0, f64::NAN, 0.0), Err(OrderError::BadNumber { field: "s", .. })));
    assert_eq!(go(6.0, 1.0, 0.5), Ok(()));
}

#[test]
fn k9_a_leg_that_ends_within_a_tiny_part_of_a_cycle_is_walked() {
    under_both(
        |stops| {
            let mut scene = Scene::boxed(20.0, stops)
                .object(1, (0.0, 5.0), 0.5)
                .object(2, (1.0, 5.0), 0.5)
                .go(0, 1, (1e-24, 5.0), 1e4);
            scene.walls.clear();
            scene
        },
        |world, events| {
            assert_eq!(kinds(events, 1), [EventKind::Object]);
            assert_eq!(at(world, 1), DVec2::new(0.0, 5.0));
        },
    );
}

#[test]
fn k9_a_wall_without_length_is_refused() {
    let scene = Scene::boxed(20.0, Stops::Both).wall((5.0, 6.0), (5.0, 6.0));
    let refused = World::new(scene.limits, scene.stops, &scene.walls).map(|_| ());
    assert_eq!(refused, Err(WallError::NoLength { index: 4, x: 5.0, y: 6.0 }));
}

#[test]
fn orders_are_taken_whole_or_refused_whole() {
    let mut world = Scene::boxed(100.0, Stops::Both).object(1, (5.0, 5.0), 0.5).world();
    let leg = |x: f64| Leg { goal: DVec2::new(x, 5.0), speed: 1.0 };
    let legs: Vec<Leg> = (0..64).map(|place| leg(6.0 + f64::from(place))).collect();
    let id = ObjectId(1);
    let too_many = Err(OrderError::TooManyWaypoints { max: 64 });
    assert_eq!(world.go(id, &[leg(6.0), leg(1e9)], Placement::Replace, None).map_err(|_| ()), Err(()));
    assert_eq!(world.waypoints(id), Some(0));
    assert_eq!(world.go(id, &legs, Placement::Queue, None), Ok(()));
    assert_eq!(world.go(id, &[leg(6.0)], Placement::Queue, None), too_many);
    assert_eq!(world.waypoints(id), Some(64));
    assert_eq!(world.go(id, &[], Placement::Queue, None), Err(OrderError::EmptyPath));
    assert_eq!(world.go(ObjectId(2), &legs, Placement::Queue, None), Err(OrderError::UnknownObject));
    world.step();
    let past = Some(Moment { cycle: Cycle(0), fraction: 1.0 });
    let refused = Err(OrderError::StartInPast { now: Cycle(1) });
    assert_eq!(world.go(id, &[leg(6.0)], Placement::Replace, past), refused);
}

#[test]
fn layers_do_not_collide_with_each_other() {
    let mut scene = Scene::boxed(20.0, Stops::Both).wall((10.0, 0.0), (10.0, 20.0));
    scene.objects = vec![(1, DVec2::new(5.0, 5.0), 0.5, Layers::AIR.0), (2, DVec2::new(7.0, 5.0), 0.5, 1)];
    let (world, events, _) = scene.go(0, 1, (15.0, 5.0), 20.0).play();
    assert_eq!(kinds(&events, 1), [EventKind::Arrived]);
    assert_eq!(at(&world, 1), DVec2::new(15.0, 5.0));
}

/// A crowd in single precision, with walls; after each cycle nothing overlaps in exact arithmetic.
#[test]
fn k1_holds_in_single_precision_too() {
    let seed = 17;
    println!("seed {seed}");
    let mut random = Random(seed);
    let scene = Scene::boxed(30.0, Stops::Both).wall((10.0, 5.0), (20.0, 25.0));
    let walls: Vec<Wall<f32>> = scene
        .walls
        .iter()
        .map(|wall| Wall { segment: wall.segment.rounded(), kind: wall.kind, layers: wall.layers })
        .collect();
    let mut world = World::<f32>::new(scene.limits, scene.stops, &walls).expect("the walls are good");
    let point =
        |random: &mut Random| DVec2::new(random.between(1.0, 29.0), random.between(1.0, 29.0)).as_vec2();
    for id in 0..200 {
        let _ = world.insert(ObjectId(id), Circle::new(point(&mut random), 0.4), Layers::GROUND);
    }
    assert!(world.len() > 100);
    let mut collisions = 0;
    for _ in 0..60 {
        for id in world.ids() {
            if random.chance(0.3) {
                let leg = Leg { goal: point(&mut random), speed: 0.7 };
                world.go(id, &[leg], Placement::Replace, None).expect("the order is good");
            }
        }
        collisions += world.step().iter().filter(|event| event.kind == EventKind::Object).count();
        assert_eq!(world.overlaps(), [], "after cycle {}", world.cycle());
    }
    assert!(collisions > 500, "{collisions}");
}
