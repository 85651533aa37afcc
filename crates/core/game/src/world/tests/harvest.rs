//! Who gathers what, who gets a place, and where loads go.

use maniple_geometry::ObjectId;
use maniple_view::{Action, EndOfTask, EndReason, Refusal, Seat, Task};

use super::stage::{Plan, Stage, Stand, attack, gather, go, nobodys, own, return_load, stop};

/// A `worker` carries 5 and takes one each half second, a `slow` one goes a fifth as fast; a `mine` has two places.
const WORK: &str = "
[combat]
[harvest]
patch = 'mine'
[unit.worker]
radius = 0.25
speed = 4
sight = 6
hit_points = 10
harvest = { load_max = 5, seconds_each = 0.5 }
[unit.slow]
radius = 0.25
speed = 0.8
hit_points = 10
harvest = { load_max = 5, seconds_each = 0.5 }
[unit.mine]
radius = 0.5
speed = 0
patch = { places = 2 }
[unit.home]
width = 2
height = 2
speed = 0
hit_points = 10
takes_loads = true
[unit.gun]
radius = 0.25
speed = 4
hit_points = 10
weapon = { range = 20, cooldown_seconds = 1, damage_min = 10, damage_max = 10 }
";

fn stage(stands: &[Stand<'_>]) -> Stage {
    Plan { tables: WORK, ..Plan::default() }.stage(stands)
}

fn amount(stage: &Stage, patch: u32) -> u32 {
    stage.see(patch).unwrap().status.amount.unwrap()
}

fn works(stage: &Stage, object: u32) -> bool {
    stage.see(object).is_some_and(|sighting| sighting.status.action == Action::Gather)
}

#[test]
fn a_worker_takes_one_at_a_time_until_it_is_full_and_stays() {
    let mut stage = stage(&[own(0, "worker", 2.0, 6.0), nobodys("mine", 6.0, 6.0, 100)]);
    stage.tell(&gather(0, 1)).unwrap();
    let cycles = stage.step_until(|stage| works(stage, 0));
    let distance = (stage.place(1) - stage.place(0)).length() - 0.75;
    assert!((0.0..=0.0625).contains(&distance), "in reach: {distance}");
    assert_eq!(cycles, 7, "3.2 world units at half a one a cycle");
    let mut loads = Vec::new();
    for _ in 0..20 {
        stage.step(1);
        loads.push(stage.load(0));
        assert_eq!(amount(&stage, 1) + stage.load(0), 100);
    }
    let expected: Vec<u32> = (1..=20).map(|cycle| cycle / 4).collect();
    assert_eq!(loads, expected);
    assert_eq!(stage.ended, [(26, 0, Task::Gather, EndOfTask::Done)]);
    let place = stage.place(0);
    stage.step(20);
    assert_eq!((stage.load(0), stage.place(0), stage.task(0)), (5, place, Task::None));
}

#[test]
fn who_is_full_has_gathered_at_once() {
    let mut stage = stage(&[own(0, "worker", 5.0, 6.0), nobodys("mine", 6.0, 6.0, 100)]);
    stage.tell(&gather(0, 1)).unwrap();
    assert_eq!(stage.outcome(0), EndOfTask::Done);
    stage.tell(&go(0, 2.0, 6.0)).unwrap();
    stage.step(20);
    let cycle = stage.world.cycle().0;
    stage.tell(&gather(0, 1)).unwrap();
    stage.step(2);
    assert_eq!(stage.ended.last(), Some(&(cycle, 0, Task::Gather, EndOfTask::Done)));
    assert_eq!((stage.place(0).x, stage.load(0)), (2.0, 5));
}

#[test]
fn a_patch_has_as_many_at_work_as_places_and_who_waits_gets_one_that_is_free() {
    let mut stage = stage(&[
        own(0, "worker", 5.2, 6.0),
        own(0, "worker", 6.8, 6.0),
        own(1, "worker", 6.0, 5.2),
        own(1, "worker", 6.0, 6.8),
        nobodys("mine", 6.0, 6.0, 100),
    ]);
    stage.tell(&gather(0, 4)).unwrap();
    stage.tell(&gather(1, 4)).unwrap();
    stage.step(3);
    stage.tell(&gather(2, 4)).unwrap();
    stage.step(1);
    stage.tell(&gather(3, 4)).unwrap();
    stage.step(2);
    let at_work = |stage: &Stage| [0, 1, 2, 3].map(|object| works(stage, object));
    assert_eq!(at_work(&stage), [true, true, false, false]);
    stage.tell(&stop(1)).unwrap();
    stage.step(1);
    assert_eq!(at_work(&stage), [true, false, true, false], "who waits longest");
    stage.step_until(|stage| !works(stage, 0));
    assert_eq!(at_work(&stage), [false, false, true, true], "in the cycle in which the place is left");
    assert_eq!(stage.ended, [(20, 0, Task::Gather, EndOfTask::Done)]);
}

#[test]
fn the_place_of_who_is_killed_or_goes_is_free() {
    let check = |leave: fn(&mut Stage)| {
        let mut stage = stage(&[
            own(0, "worker", 5.2, 6.0),
            own(0, "worker", 6.8, 6.0),
            own(1, "worker", 6.0, 5.2),
            nobodys("mine", 6.0, 6.0, 100),
            own(1, "gun", 16.0, 6.0),
        ]);
        for worker in 0..3 {
            stage.tell(&gather(worker, 3)).unwrap();
            stage.step(1);
        }
        assert!(!works(&stage, 2));
        leave(&mut stage);
        stage.step(2);
        assert!(works(&stage, 2) && works(&stage, 1));
    };
    check(|stage| stage.tell(&attack(4, 0)).unwrap());
    check(|stage| stage.tell(&go(0, 2.0, 2.0)).unwrap());
    check(|stage| stage.tell(&gather(0, 3)).unwrap());
}

#[test]
fn the_longest_wait_counts_to_the_fraction_of_a_cycle() {
    let check = |first: f64, second: f64, expected: [bool; 2]| {
        let tables = WORK.replace("places = 2", "places = 1");
        let mut stage = Plan { tables: &tables, ..Plan::default() }.stage(&[
            own(0, "worker", first, 6.0),
            own(1, "worker", 12.0 + second, 6.0),
            nobodys("mine", 6.0, 6.0, 100),
        ]);
        stage.tell(&gather(0, 2)).unwrap();
        stage.tell(&gather(1, 2)).unwrap();
        stage.step_until(|stage| works(stage, 0) || works(stage, 1));
        assert_eq!([0, 1].map(|object| works(&stage, object)), expected, "{first} {second}");
    };
    // Both arrive in the same cycle, one of them by a hundredth of a world unit, or less, later.
    check(2.0, -2.01, [false, true]);
    check(2.01, -2.0, [true, false]);
    check(2.0, -2.000_000_1, [false, true]);
    check(2.000_000_1, -2.0, [true, false]);
    check(2.01, -3.0, [false, true]);
}

#[test]
fn of_those_who_come_at_the_same_time_chance_decides_and_not_the_seat() {
    let tables = WORK.replace("places = 2", "places = 1");
    let won: u32 = (0..300)
        .map(|seed| {
            let mut stage = Plan { tables: &tables, seed, ..Plan::default() }.stage(&[
                own(0, "worker", 2.0, 6.0),
                own(1, "worker", 10.0, 6.0),
                nobodys("mine", 6.0, 6.0, 100),
            ]);
            stage.tell(&gather(0, 2)).unwrap();
            stage.tell(&gather(1, 2)).unwrap();
            stage.step(7);
            assert_ne!(works(&stage, 0), works(&stage, 1), "one place, and two who came together");
            u32::from(works(&stage, 0))
        })
        .sum();
    assert!((115..=185).contains(&won), "the first seat got {won} of 300");
}

#[test]
fn the_last_resource_goes_to_one_and_all_others_find_the_patch_empty() {
    let check = |amount: u32, seed: u64| {
        let tables = WORK.replace("places = 2", "places = 3");
        let mut stage = Plan { tables: &tables, seed, ..Plan::default() }.stage(&[
            own(0, "worker", 5.2, 6.0),
            own(1, "worker", 6.8, 6.0),
            own(0, "worker", 6.0, 5.2),
            own(1, "worker", 6.0, 6.8),
            nobodys("mine", 6.0, 6.0, amount),
            own(0, "slow", 14.0, 6.0),
        ]);
        for object in [0, 1, 2, 3, 5] {
            stage.tell(&gather(object, 4)).unwrap();
        }
        stage.step_until(|stage| stage.see(4).is_none());
        let loads = [0, 1, 2, 3, 5].map(|object| stage.load(object));
        assert_eq!(loads.iter().sum::<u32>(), amount, "{loads:?}");
        assert_eq!(loads[4], 0);
        assert_eq!(stage.world.died(Seat(0)), [ObjectId(4)], "the patch is gone");
        let ended: Vec<EndOfTask> = stage.ended.iter().map(|&(.., why)| why).collect();
        let is_full = loads.iter().filter(|&&load| load == 5).count();
        assert_eq!(ended.iter().filter(|&&why| why == EndOfTask::Done).count(), is_full);
        assert_eq!(ended.iter().filter(|&&why| why == EndOfTask::Empty).count(), 5 - is_full);
        stage.step(1);
        assert!((0..6).filter(|&object| object != 4).all(|object| !stage.is_moving(object)));
        loads
    };
    for amount in 1..=16 {
        check(amount, 1);
    }
    let mut winners = [0; 4];
    for seed in 0..200 {
        for (place, &load) in check(1, seed)[..4].iter().enumerate() {
            winners[place] += load;
        }
    }
    assert!(winners.iter().all(|&won| (25..=80).contains(&won)), "{winners:?}");
}

#[test]
fn a_load_is_brought_to_the_nearest_building_of_the_seat_and_counts() {
    let mut stage = Plan { tables: WORK, seats: &["stock = 7\nteam = 1", "", "team = 1"], ..Plan::default() }
        .stage(&[
            own(0, "worker", 6.0, 5.0),
            nobodys("mine", 6.0, 6.0, 3),
            own(1, "home", 6.0, 8.0),
            own(2, "home", 9.0, 6.0),
            own(0, "home", 13.0, 6.0),
            own(0, "home", 20.0, 6.0),
        ]);
    stage.tell(&gather(0, 1)).unwrap();
    assert_eq!(stage.outcome(0), EndOfTask::Empty);
    assert_eq!((stage.load(0), stage.stock(0)), (3, 7));
    stage.tell(&go(0, 6.0, 3.0)).unwrap();
    stage.step(8);
    stage.tell(&return_load(0)).unwrap();
    assert_eq!(stage.outcome(0), EndOfTask::Done);
    let distance = 12.0 - stage.place(0).x - 0.25;
    assert!((0.0..=0.0625).contains(&distance), "{distance}");
    assert_eq!((stage.load(0), stage.stock(0)), (0, 10));
    assert_eq!([1, 2].map(|seat| stage.stock(seat)), [0, 0]);
    assert_eq!(stage.world.tally(Seat(0)).gathered, 3);
    assert_eq!(stage.tell(&return_load(0)), Err(Refusal::NothingToReturn));
}

#[test]
fn who_finds_its_building_destroyed_goes_to_the_next_and_without_one_is_lost() {
    let check = |homes: &[Stand<'_>], expected: EndOfTask| {
        let stands = [
            &[
                own(0, "worker", 6.0, 5.0),
                nobodys("mine", 6.0, 6.0, 3),
                own(1, "gun", 12.0, 1.0),
                own(0, "home", 10.0, 5.0),
            ],
            homes,
        ]
        .concat();
        let mut stage = stage(&stands);
        stage.tell(&gather(0, 1)).unwrap();
        stage.outcome(0);
        stage.tell(&return_load(0)).unwrap();
        stage.step(3);
        stage.tell(&attack(2, 3)).unwrap();
        assert_eq!(stage.outcome(0), expected);
        assert!(stage.see(3).is_none());
        stage.step(1);
        assert!(!stage.is_moving(0));
        stage
    };
    let there = check(&[own(0, "home", 16.0, 8.0)], EndOfTask::Done);
    assert_eq!((there.stock(0), there.load(0)), (3, 0));
    let mut nowhere = check(&[own(1, "home", 16.0, 8.0)], EndOfTask::Lost);
    assert_eq!((nowhere.stock(0), nowhere.load(0)), (0, 3));
    assert_eq!(nowhere.tell(&return_load(0)), Err(Refusal::NothingToReturn));
}

#[test]
fn what_cannot_be_gathered_is_refused_with_the_reason() {
    let check = |object: u32, patch: u32, expected: Result<(), Refusal>| {
        let tables = format!("[vision]\n{WORK}");
        let mut stage = Plan { tables: &tables, ..Plan::default() }.stage(&[
            own(0, "worker", 6.0, 6.0),
            own(0, "gun", 6.0, 8.0),
            nobodys("mine", 8.0, 6.0, 9),
            nobodys("mine", 22.0, 6.0, 9),
            own(0, "home", 3.0, 3.0),
            own(1, "worker", 6.0, 4.0),
        ]);
        assert_eq!(stage.tell_as(0, &gather(object, patch)), expected, "{object} {patch}");
    };
    check(0, 2, Ok(()));
    check(0, 3, Err(Refusal::UnknownTarget));
    check(0, 9, Err(Refusal::UnknownTarget));
    check(0, 4, Err(Refusal::BadTarget));
    check(0, 5, Err(Refusal::BadTarget));
    check(1, 2, Err(Refusal::UnknownAction));
    check(5, 2, Err(Refusal::UnknownHandle));
    let mut stage = stage(&[own(0, "gun", 6.0, 8.0), own(0, "worker", 4.0, 4.0), own(0, "home", 8.0, 2.0)]);
    assert_eq!(stage.tell(&return_load(0)), Err(Refusal::UnknownAction));
    assert_eq!(stage.tell(&return_load(1)), Err(Refusal::NothingToReturn));
}

#[test]
fn a_worker_whose_way_is_blocked_or_whose_patch_goes_out_of_sight_is_told() {
    let mut blocked = stage(&[
        own(0, "worker", 2.0, 6.0),
        own(0, "worker", 4.0, 6.0),
        nobodys("mine", 8.0, 6.0, 9),
        own(0, "home", 14.0, 6.0),
    ]);
    blocked.tell(&gather(0, 2)).unwrap();
    assert_eq!(blocked.outcome(0), EndOfTask::Blocked);
    let place = blocked.place(0);
    blocked.step(10);
    assert_eq!((blocked.place(0), blocked.task(0)), (place, Task::None));

    let tables = format!("[vision]\n{WORK}");
    let mut lost = Plan { tables: &tables, seats: &["team = 1", "", "team = 1"], ..Plan::default() }
        .stage(&[own(0, "worker", 2.0, 6.0), own(2, "worker", 12.0, 6.0), nobodys("mine", 16.0, 6.0, 9)]);
    lost.tell(&gather(0, 2)).unwrap();
    lost.step(2);
    assert_eq!(lost.task(0), Task::Gather, "it is seen by a friend");
    lost.tell(&go(1, 7.0, 11.0)).unwrap();
    assert_eq!(lost.outcome(0), EndOfTask::Lost);
}

#[test]
fn a_goal_of_resources_ends_the_match_in_the_cycle_of_the_delivery() {
    let tables = format!("{WORK}\n[objective]\nkind = 'resources'\ngoal = 3\n");
    let mut stage = Plan { tables: &tables, seats: &["stock = 50", ""], ..Plan::default() }.stage(&[
        own(1, "worker", 6.0, 5.0),
        nobodys("mine", 6.0, 6.0, 3),
        own(1, "home", 9.0, 5.0),
        own(0, "worker", 2.0, 2.0),
    ]);
    stage.tell(&gather(0, 1)).unwrap();
    stage.outcome(0);
    stage.tell(&return_load(0)).unwrap();
    stage.outcome(0);
    assert_eq!(
        stage.ending(),
        Some((EndReason::Objective, vec![1])),
        "what is in stock at the start does not count"
    );
}
