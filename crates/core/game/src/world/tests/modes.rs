//! Units that switch between two modes.

use maniple_view::{Command, EndOfTask, Handle, Mode, Refusal, Task};

use super::stage::{Plan, Stage, attack, attack_move, cancel, gather, go, hold, nobodys, own, stop, switch};

/// A `tank` takes a second to become a `siege` tank, which stands and reaches farther.
const TABLES: &str = "
[combat]
[modes]
[unit.tank]
radius = 0.25
speed = 4
hit_points = 100
weapon = { range = 2, cooldown_seconds = 1, damage_min = 10, damage_max = 10 }
[unit.tank.alternate]
name = 'siege'
switch_seconds = 1
speed = 0
weapon = { range = 8, cooldown_seconds = 2, damage_min = 30, damage_max = 30 }
[unit.gun]
radius = 0.25
speed = 2
hit_points = 100
";

fn stage() -> Stage {
    Plan { tables: TABLES, ..Plan::default() }.stage(&[own(0, "tank", 4.0, 6.0), own(1, "gun", 11.0, 6.0)])
}

/// Returns the mode at the end of each of so many cycles; in those of `switches` the unit is told to switch before.
fn modes(stage: &mut Stage, cycles: u32, switches: &[u32]) -> Vec<Mode> {
    let mut modes = Vec::new();
    for cycle in 0..cycles {
        for _ in switches.iter().filter(|&&at| at == cycle) {
            stage.tell(&switch(0)).unwrap();
        }
        stage.step(1);
        modes.push(stage.mode(0));
    }
    modes
}

#[test]
fn a_switch_takes_its_time_in_either_direction() {
    let (over, back) = (Mode::Switching, Mode::SwitchingBack);
    let expected = [vec![over; 7], vec![Mode::Alternate; 3], vec![back; 7], vec![Mode::Normal; 3]].concat();
    assert_eq!(modes(&mut stage(), 20, &[0, 10]), expected);
}

#[test]
fn a_switch_that_is_turned_back_takes_as_long_as_it_has_been_at_it() {
    let (over, back) = (Mode::Switching, Mode::SwitchingBack);
    let (normal, other) = (Mode::Normal, Mode::Alternate);
    let check = |cycles: u32, switches: &[u32], expected: &[(Mode, usize)]| {
        let expected: Vec<Mode> = expected.iter().flat_map(|&(mode, count)| vec![mode; count]).collect();
        assert_eq!(modes(&mut stage(), cycles, switches), expected, "{switches:?}");
    };
    check(10, &[0, 3], &[(over, 3), (back, 2), (normal, 5)]);
    check(10, &[0, 1], &[(over, 1), (normal, 9)]);
    check(16, &[0, 7], &[(over, 7), (back, 6), (normal, 3)]);
    // From the other mode.
    check(16, &[0, 8, 11], &[(over, 7), (other, 1), (back, 3), (over, 2), (other, 3)]);
    // To and fro: 5 forth, 2 back, and then the 5 that are left.
    check(14, &[0, 5, 7], &[(over, 5), (back, 2), (over, 4), (other, 3)]);
    check(14, &[0, 0], &[(normal, 14)]);
    check(14, &[0, 0, 0], &[(over, 7), (other, 7)]);
}

#[test]
fn who_is_switching_stands_does_nothing_and_is_busy() {
    let mut stage = stage();
    stage.tell(&attack_move(0, 20.0, 6.0)).unwrap();
    stage.step(4);
    let place = stage.place(0);
    stage.tell(&switch(0)).unwrap();
    for command in [
        go(0, 3.0, 3.0),
        stop(0),
        hold(0),
        attack(0, 1),
        attack_move(0, 3.0, 3.0),
        gather(0, 1),
        cancel(0),
        Command::Path { object: Handle(0), points: vec![(3.0, 3.0, None)], start: None },
    ] {
        assert_eq!(stage.tell(&command), Err(Refusal::Busy), "{command:?}");
    }
    stage.step(7);
    assert_eq!((stage.place(0), stage.task(0), stage.mode(0)), (place, Task::None, Mode::Switching));
    assert_eq!(stage.tell(&hold(0)), Err(Refusal::Busy));
    assert_eq!(stage.shots, []);
    stage.step(1);
    assert_eq!(stage.tell(&hold(0)), Ok(()));
}

#[test]
fn weapon_and_speed_are_those_of_the_mode() {
    let mut stage = stage();
    stage.tell(&hold(0)).unwrap();
    stage.step(4);
    assert_eq!(stage.shots, [], "out of range");
    stage.tell(&switch(0)).unwrap();
    stage.step(8);
    assert_eq!(stage.tell(&go(0, 3.0, 3.0)), Err(Refusal::UnknownAction));
    assert_eq!(stage.tell(&attack_move(0, 3.0, 3.0)), Err(Refusal::UnknownAction));
    stage.tell(&hold(0)).unwrap();
    stage.step(17);
    assert_eq!(stage.shots, [(12, 0, Some(1)), (28, 0, Some(1))]);
    assert_eq!(stage.hit_points(1), 40);
    assert_eq!(stage.tell(&stop(0)), Ok(()));
    stage.tell(&switch(0)).unwrap();
    stage.step(8);
    stage.tell(&go(0, 3.0, 6.0)).unwrap();
    stage.step(3);
    assert_eq!(stage.place(0).x, 3.0);
}

#[test]
fn only_who_has_two_modes_switches_and_only_where_there_are_modes() {
    let tables = TABLES.replace("[modes]", "");
    let mut without = Plan { tables: &tables, ..Plan::default() }
        .stage(&[own(0, "tank", 4.0, 6.0), own(1, "gun", 11.0, 6.0)]);
    assert_eq!(without.tell(&switch(0)), Err(Refusal::UnknownAction));
    let mut with = stage();
    assert_eq!(with.tell(&switch(1)), Err(Refusal::UnknownAction));
    assert_eq!(with.tell_as(1, &switch(0)), Err(Refusal::UnknownHandle));
}

#[test]
fn who_switches_gives_up_its_place_at_a_patch() {
    let tables = "[harvest]\npatch = 'mine'\n[modes]\n[unit.mine]\nradius = 0.5\nspeed = 0\npatch = { places = 1 }\n\
         [unit.worker]\nradius = 0.25\nspeed = 4\nharvest = { load_max = 2, seconds_each = 0.5 }\n\
         [unit.worker.alternate]\nname = 'asleep'\nswitch_seconds = 1\nspeed = 0\n";
    let mut stage = Plan { tables, ..Plan::default() }.stage(&[
        own(0, "worker", 5.2, 6.0),
        own(0, "worker", 6.8, 6.0),
        nobodys("mine", 6.0, 6.0, 9),
    ]);
    stage.tell(&gather(0, 2)).unwrap();
    stage.step(6);
    stage.tell(&gather(1, 2)).unwrap();
    stage.tell(&switch(0)).unwrap();
    assert_eq!(stage.outcome(1), EndOfTask::Done);
    assert_eq!([stage.load(0), stage.load(1)], [1, 2]);
}
