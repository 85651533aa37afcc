//! Who fires at whom, when, and when a task to fight ends.

use glam::DVec2;
use maniple_view::{Command, EndOfTask, EndReason, Handle, Refusal, Task};

use super::stage::{
    Plan, Stage, Stand, attack, attack_at, attack_move, cancel, go, hold, nobodys, own, stop, switch,
};

/// `gun` reaches 4 and fires once a second, `tower` stands, `big` has splash, `runner` is fast and `jet` flies.
const FIGHT: &str = "
[combat]
[harvest]
patch = 'ore'
[unit.gun]
radius = 0.25
speed = 2
sight = 6
hit_points = 100
weapon = { range = 4, cooldown_seconds = 1, damage_min = 10, damage_max = 10 }
[unit.tower]
width = 2
height = 2
speed = 0
sight = 6
hit_points = 100
weapon = { range = 4, cooldown_seconds = 1, damage_min = 10, damage_max = 10, targets = ['ground'] }
[unit.big]
radius = 0.25
speed = 2
hit_points = 100
weapon = { range = 6, range_min = 2, cooldown_seconds = 1, damage_min = 10, damage_max = 10, splash_radius = 1 }
[unit.runner]
radius = 0.25
speed = 4
hit_points = 10
[unit.jet]
radius = 0.25
speed = 4
layer = 'air'
hit_points = 100
weapon = { range = 4, cooldown_seconds = 1, damage_min = 10, damage_max = 10 }
[unit.ore]
radius = 0.25
speed = 0
patch = { places = 1 }
[unit.sheep]
radius = 0.25
speed = 0
hit_points = 10
";

fn stage(stands: &[Stand<'_>]) -> Stage {
    Plan { tables: FIGHT, ..Plan::default() }.stage(stands)
}

#[test]
fn a_target_at_the_end_of_the_range_is_hit_and_an_ulp_beyond_it_is_not() {
    let check = |target: &str, at: (f64, f64), expected: bool| {
        let mut stage = stage(&[own(0, "gun", 3.0, 6.0), own(1, target, at.0, at.1)]);
        stage.tell(&hold(0)).unwrap();
        stage.step(20);
        assert_eq!(!stage.shots.is_empty(), expected, "{target} {at:?}");
        assert_eq!(stage.hit_points(1) < 100, expected);
        assert_eq!(stage.place(0), DVec2::new(3.0, 6.0), "who holds does not move");
    };
    check("gun", (7.5, 6.0), true);
    check("gun", (7.5_f64.next_up(), 6.0), false);
    check("tower", (8.25, 6.0), true);
    check("tower", (8.25_f64.next_up(), 6.0), false);
    check("tower", (8.25, 7.0), true);
    check("gun", (3.0, 6.5), true);
}

#[test]
fn who_is_told_to_attack_at_the_end_of_the_range_fires_at_once_and_an_ulp_beyond_it_goes_first() {
    let check = |shooter: &str, command: Command, at: f64, expected: bool| {
        let mut stage = stage(&[own(0, shooter, 3.0, 6.0), own(1, "gun", at, 6.0)]);
        stage.tell(&command).unwrap();
        stage.step(1);
        assert_eq!(
            (stage.shots.len() == 1, stage.place(0).x == 3.0),
            (expected, expected),
            "{command:?} {at}"
        );
        stage.step(1);
        assert_eq!(stage.shots.len(), 1, "a short way, and it is there");
    };
    check("gun", attack(0, 1), 7.5, true);
    check("gun", attack(0, 1), 7.5_f64.next_up(), false);
    check("big", attack_at(0, 9.25, 6.0), 12.0, true);
    check("big", attack_at(0, 9.25_f64.next_up(), 6.0), 12.0, false);
}

#[test]
fn a_target_nearer_than_the_least_range_is_not_hit() {
    let check = |command: Command, x: f64, expected: bool| {
        let mut stage = stage(&[own(0, "big", 3.0, 6.0), own(1, "gun", x, 6.0)]);
        stage.tell(&command).unwrap();
        stage.step(20);
        assert_eq!(!stage.shots.is_empty(), expected, "{command:?} {x}");
        assert_eq!(stage.place(0).x, 3.0);
    };
    for command in [hold(0), attack(0, 1), attack_move(0, 3.0, 6.0)] {
        check(command.clone(), 5.5, true);
        check(command.clone(), 5.5_f64.next_down(), false);
        check(command, 4.0, false);
    }
    // A point has no hull.
    check(attack_at(0, 5.25, 6.0), 9.0, true);
    check(attack_at(0, 5.25_f64.next_down(), 6.0), 9.0, false);
    let mut stage = stage(&[own(0, "big", 3.0, 6.0), own(1, "gun", 4.0, 6.0), own(1, "gun", 3.0, 9.0)]);
    stage.tell(&hold(0)).unwrap();
    stage.step(1);
    assert_eq!(stage.shots, [(0, 0, Some(2))], "of two enemies the one that can be hit");
}

#[test]
fn a_weapon_fires_once_a_cooldown_whatever_the_task() {
    let check = |commands: [Command; 2]| {
        let mut stage = stage(&[own(0, "gun", 3.0, 6.0), own(1, "gun", 6.0, 6.0)]);
        stage.tell(&commands[0]).unwrap();
        stage.step(3);
        stage.tell(&commands[1]).unwrap();
        stage.step(18);
        let cycles: Vec<u32> = stage.shots.iter().map(|&(cycle, ..)| cycle).collect();
        assert_eq!(cycles, [0, 8, 16], "{commands:?}");
    };
    check([hold(0), hold(0)]);
    check([attack(0, 1), attack(0, 1)]);
    check([hold(0), attack(0, 1)]);
    check([attack_move(0, 5.0, 6.0), hold(0)]);
}

#[test]
fn who_attacks_goes_straight_into_range_and_stands_there_until_the_target_is_dead() {
    let mut stage = stage(&[own(0, "gun", 2.0, 2.0), own(1, "tower", 12.0, 10.0)]);
    stage.tell(&attack(0, 1)).unwrap();
    let start = stage.place(0);
    stage.step(4);
    let way = stage.place(0) - start;
    assert!((way.length() - 1.0).abs() < 1e-9, "four cycles at full speed: {way}");
    assert_eq!(stage.outcome(0), EndOfTask::Done);
    assert!(stage.see(1).is_none());
    let distance = (DVec2::new(11.0, 9.0) - stage.place(0)).length() - 0.25;
    assert!((3.9..=4.0).contains(&distance), "{distance}");
    assert!(!stage.is_moving(0));
    assert_eq!(stage.task(0), Task::None);
    assert_eq!(stage.shots.len(), 10);
}

#[test]
fn a_target_that_goes_away_is_followed() {
    let mut stage = stage(&[own(0, "gun", 2.0, 6.0), own(1, "runner", 6.0, 6.0)]);
    stage.tell(&go(1, 20.0, 6.0)).unwrap();
    stage.step(12);
    stage.tell(&attack(0, 1)).unwrap();
    assert_eq!(stage.outcome(0), EndOfTask::Done);
    assert!(stage.place(0).x > 8.0);
}

#[test]
fn an_attack_ends_as_done_whoever_killed_the_target() {
    let check = |end: fn(&mut Stage)| {
        let mut stage = Plan {
            tables: &format!("{FIGHT}[production]\n"),
            seats: &["team = 0", "", "team = 0", ""],
            ..Plan::default()
        }
        .stage(&[
            own(0, "gun", 2.0, 6.0),
            own(1, "runner", 14.0, 6.0),
            own(2, "gun", 14.0, 8.0),
            own(1, "runner", 22.0, 2.0),
        ]);
        stage.tell(&attack(0, 1)).unwrap();
        end(&mut stage);
        stage.step(2);
        stage.ended.retain(|&(_, object, ..)| object == 0);
        assert_eq!(stage.ended, [(0, 0, Task::Attack, EndOfTask::Done)]);
        assert!(!stage.is_moving(0));
    };
    check(|stage| stage.tell(&attack(2, 1)).unwrap());
    check(|stage| stage.tell_as(1, &Command::Resign).unwrap());
}

#[test]
fn an_attack_ends_as_lost_when_the_target_goes_out_of_sight() {
    let mut stage = Plan { tables: &format!("[vision]\n{FIGHT}"), ..Plan::default() }
        .stage(&[own(0, "gun", 2.0, 6.0), own(1, "runner", 8.0, 6.0)]);
    stage.tell(&attack(0, 1)).unwrap();
    stage.tell(&go(1, 23.0, 6.0)).unwrap();
    assert_eq!(stage.outcome(0), EndOfTask::Lost);
    assert!(!stage.is_moving(0) && stage.see(1).is_some());
    let place = stage.place(0);
    stage.step(8);
    assert_eq!(stage.place(0), place);
    assert_eq!(stage.tell(&attack(0, 1)), Err(Refusal::UnknownTarget));
}

#[test]
fn an_attack_that_is_stopped_on_its_way_ends_as_blocked_and_is_not_tried_again() {
    let walled = "........................\n".repeat(3)
        + &".......@................\n".repeat(6)
        + &"........................\n".repeat(3);
    let check = |rows: &str, others: &[Stand<'_>], command: Command| {
        let stands = [&[own(0, "gun", 3.0, 6.0), own(1, "tower", 16.0, 6.0)], others].concat();
        let mut stage = Plan { tables: FIGHT, rows, ..Plan::default() }.stage(&stands);
        stage.tell(&command).unwrap();
        assert_eq!(stage.outcome(0), EndOfTask::Blocked, "{command:?}");
        let place = stage.place(0);
        assert!((6.0..7.0).contains(&place.x), "{place}");
        stage.step(30);
        assert_eq!(stage.place(0), place);
        let is_holding = matches!(command, Command::AttackMove { .. });
        assert_eq!(stage.task(0), if is_holding { Task::Hold } else { Task::None });
    };
    let open = super::stage::OPEN;
    for command in [attack(0, 1), attack_move(0, 16.0, 9.0)] {
        check(&walled, &[], command);
    }
    check(open, &[own(0, "gun", 7.0, 6.0)], attack(0, 1));
    check(open, &[nobodys("ore", 7.0, 6.0, 5)], attack(0, 1));
    check(open, &[own(0, "gun", 7.0, 6.75)], attack_move(0, 16.0, 9.0));
}

#[test]
fn an_attack_move_stands_for_every_enemy_and_goes_on_to_its_goal_where_it_holds() {
    let mut stage = stage(&[
        own(0, "gun", 2.0, 6.0),
        own(1, "runner", 9.0, 9.0),
        own(1, "runner", 14.0, 3.0),
        own(1, "runner", 23.0, 11.0),
    ]);
    stage.tell(&attack_move(0, 18.0, 6.0)).unwrap();
    stage.step_until(|stage| stage.see(1).is_none());
    let fought_at = stage.place(0);
    assert!(fought_at.x < 9.0 && !stage.is_moving(0), "{fought_at}");
    stage.step(2);
    assert!(stage.is_moving(0), "nobody is in range any more, whether the weapon is ready or not");
    assert_eq!(stage.outcome(0), EndOfTask::Done);
    assert_eq!(stage.place(0), DVec2::new(18.0, 6.0));
    assert!(stage.see(2).is_none() && stage.see(3).is_some());
    assert_eq!(stage.task(0), Task::Hold);
    stage.tell(&go(3, 20.0, 6.0)).unwrap();
    stage.step(30);
    assert!(stage.see(3).is_none(), "who has arrived fires at who comes into range");
    assert_eq!(stage.place(0), DVec2::new(18.0, 6.0));
}

#[test]
fn the_nearest_enemy_is_fired_at_and_neither_friends_nor_what_is_nobodys() {
    let mut stage = Plan { tables: FIGHT, seats: &["team = 0", "", "team = 0"], ..Plan::default() }.stage(&[
        own(0, "gun", 6.0, 6.0),
        own(2, "runner", 7.0, 6.0),
        nobodys("sheep", 5.0, 6.0, 0),
        nobodys("ore", 6.0, 5.0, 9),
        own(1, "runner", 6.0, 9.0),
        own(1, "runner", 9.0, 6.0),
        own(1, "runner", 6.0, 3.2),
    ]);
    stage.tell(&hold(0)).unwrap();
    stage.step(40);
    let targets: Vec<Option<u32>> = stage.shots.iter().map(|&(.., target)| target).collect();
    assert_eq!(targets, [Some(6), Some(5), Some(4)], "nearest first, of several as far by y");
    assert_eq!(stage.hit_points(1), 10);
}

#[test]
fn who_has_no_task_does_not_fight() {
    let mut stage = stage(&[own(0, "gun", 6.0, 6.0), own(1, "gun", 8.0, 6.0), own(0, "tower", 7.0, 9.0)]);
    stage.step(10);
    assert_eq!(stage.shots, []);
    stage.tell(&hold(0)).unwrap();
    stage.step(1);
    stage.tell(&go(0, 6.0, 5.0)).unwrap();
    stage.step(20);
    assert_eq!(stage.shots, [(10, 0, Some(1))], "a command replaces what the unit does");
}

#[test]
fn who_stands_for_good_can_be_told_to_cease_fire() {
    let mut stage = stage(&[own(0, "tower", 6.0, 6.0), own(1, "gun", 9.0, 6.0), own(1, "tower", 20.0, 6.0)]);
    stage.tell(&hold(0)).unwrap();
    stage.step(1);
    assert_eq!(stage.tell(&stop(0)), Ok(()));
    assert_eq!(stage.tell(&go(0, 5.0, 6.0)), Err(Refusal::UnknownAction));
    stage.step(20);
    assert_eq!((stage.shots.len(), stage.task(0)), (1, Task::None));
    stage.tell(&attack(0, 2)).unwrap();
    stage.step(20);
    assert_eq!((stage.shots.len(), stage.task(0)), (1, Task::Attack), "it cannot go, and waits");
}

#[test]
fn what_is_no_target_is_refused_with_the_reason() {
    let check = |command: &Command, seat: u16, expected: Result<(), Refusal>| {
        let tables = format!("[vision]\n{FIGHT}");
        let plan = Plan { tables: &tables, seats: &["team = 0", "", "team = 0"], ..Plan::default() };
        let mut stage = plan.stage(&[
            own(0, "gun", 6.0, 6.0),
            own(0, "runner", 7.0, 6.0),
            own(2, "runner", 8.0, 6.0),
            own(1, "runner", 9.0, 6.0),
            nobodys("sheep", 10.0, 6.0, 0),
            nobodys("ore", 11.0, 6.0, 9),
            own(1, "jet", 6.0, 7.0),
            own(0, "tower", 6.0, 10.0),
            own(1, "post", 9.0, 7.0),
            own(1, "gun", 23.0, 11.0),
            own(0, "big", 6.0, 5.0),
        ]);
        let before = stage.world.hash();
        assert_eq!(stage.tell_as(seat, command), expected, "{seat} {command:?}");
        if expected.is_err() {
            stage.step(1);
            assert_ne!(stage.world.hash(), before);
            assert_eq!(stage.task(0), Task::None, "what is refused changes nothing");
        }
    };
    let (action, bad) = (Err(Refusal::UnknownAction), Err(Refusal::BadTarget));
    let unknown = Err(Refusal::UnknownTarget);
    check(&attack(0, 3), 0, Ok(()));
    check(&attack(0, 4), 0, Ok(()));
    check(&attack(0, 6), 0, Ok(()));
    check(&attack(0, 0), 0, bad.clone());
    check(&attack(0, 1), 0, bad.clone());
    check(&attack(0, 2), 0, bad.clone());
    check(&attack(0, 5), 0, bad.clone());
    check(&attack(0, 8), 0, bad.clone());
    check(&attack(7, 6), 0, bad);
    check(&attack(0, 9), 0, unknown.clone());
    check(&attack(0, 99), 0, unknown);
    check(&attack(1, 3), 0, action.clone());
    check(&hold(1), 0, action.clone());
    check(&attack_at(0, 3.0, 3.0), 0, action.clone());
    check(&attack_at(10, 3.0, 3.0), 0, Ok(()));
    check(&attack_at(10, 3.0, 12.5), 0, Err(Refusal::OutOfWorld { width: 24, height: 12 }));
    check(&attack_move(7, 3.0, 3.0), 0, action.clone());
    check(&attack_move(1, 3.0, 3.0), 0, action.clone());
    check(&switch(0), 0, action);
    check(&cancel(0), 0, Err(Refusal::NothingToCancel));
    for seat in [1, 2] {
        check(&attack(0, 3), seat, Err(Refusal::UnknownHandle));
        check(&hold(0), seat, Err(Refusal::UnknownHandle));
    }
    check(&go(4, 3.0, 3.0), 0, Err(Refusal::UnknownHandle));
    check(&hold(5), 0, Err(Refusal::UnknownHandle));
}

#[test]
fn without_a_table_combat_nobody_fights() {
    let tables = FIGHT.replace("[combat]", "");
    let mut stage = Plan { tables: &tables, ..Plan::default() }
        .stage(&[own(0, "gun", 6.0, 6.0), own(1, "gun", 8.0, 6.0)]);
    assert_eq!(stage.tell(&attack(0, 1)), Err(Refusal::UnknownAction));
    assert_eq!(stage.tell(&hold(0)), Err(Refusal::UnknownAction));
    assert_eq!(stage.see(0).unwrap().status.hit_points, None);
}

#[test]
fn a_weapon_fires_at_a_point_until_it_is_told_otherwise() {
    let mut stage = stage(&[own(0, "big", 2.0, 6.0), own(1, "gun", 14.0, 6.0)]);
    stage.tell(&attack_at(0, 13.0, 6.0)).unwrap();
    stage.step_until(|stage| stage.hit_points(1) == 70);
    assert!((stage.place(0).x - 6.75).abs() < 0.01, "in range of the point: {}", stage.place(0));
    assert!(stage.shots.iter().all(|&(.., target)| target.is_none()));
    assert_eq!(stage.task(0), Task::AttackAt);
    stage.tell(&stop(0)).unwrap();
    stage.step(20);
    assert_eq!((stage.hit_points(1), stage.task(0)), (70, Task::None));
}

#[test]
fn a_target_that_its_owner_gives_up_is_a_dead_one_whichever_command_comes_first() {
    let tables = format!("{FIGHT}[production]\n[unit.mason]\nradius = 0.25\nspeed = 2\nbuilds = ['tower']\n");
    let check = |attack_first: bool| {
        let mut stage = Plan { tables: &tables, ..Plan::default() }
            .stage(&[own(0, "mason", 6.0, 6.0), own(1, "gun", 18.0, 6.0)]);
        let tower = stage.unit_type("tower");
        let build = Command::Build { object: Handle(0), unit_type: tower, x: 8.0, y: 6.0 };
        stage.tell(&build).unwrap();
        stage.step_until(|stage| stage.see(2).is_some());
        let (attack, cancel) = (attack(1, 2), cancel(2));
        for command in if attack_first { [&attack, &cancel] } else { [&cancel, &attack] } {
            assert_eq!(stage.tell(command), Ok(()), "{command:?}");
        }
        assert_eq!(stage.tell(&super::stage::cancel(2)), Err(Refusal::NothingToCancel), "once is enough");
        stage.step(2);
        let hash = stage.world.hash();
        assert!(stage.see(2).is_none());
        assert!(stage.ended.iter().any(|&(_, id, _, why)| (id, why) == (1, EndOfTask::Done)));
        assert!(stage.ended.iter().any(|&(_, id, _, why)| (id, why) == (0, EndOfTask::Lost)));
        hash
    };
    assert_eq!(check(true), check(false));
}

#[test]
fn who_is_killed_in_a_cycle_has_still_fired_in_it() {
    let check = |objective: &str, expected: Option<(EndReason, Vec<u16>)>| {
        let tables = format!("{FIGHT}[objective]\nkind = '{objective}'\n")
            .replace("damage_min = 10, damage_max = 10", "damage_min = 100, damage_max = 100");
        let mut stage = Plan { tables: &tables, ..Plan::default() }
            .stage(&[own(0, "gun", 6.0, 6.0), own(1, "gun", 8.0, 6.0)]);
        stage.tell(&attack(0, 1)).unwrap();
        stage.tell(&attack(1, 0)).unwrap();
        stage.step(1);
        assert_eq!(stage.world.died(maniple_view::Seat(0)).len(), 2, "both are dead");
        assert_eq!(stage.shots.len(), 2);
        assert_eq!(stage.ended, [], "the tasks of the dead do not end");
        assert_eq!(stage.ending(), expected, "{objective}");
        for seat in stage.seats.clone() {
            let tally = stage.world.tally(seat);
            assert_eq!((tally.units_destroyed, tally.units_lost), (1, 1));
        }
    };
    let draw = Some((EndReason::Objective, vec![]));
    check("last_standing", draw.clone());
    check("kills", draw);
    check("resources", None);
}
