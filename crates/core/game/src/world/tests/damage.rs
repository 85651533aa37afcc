//! What a hit does to whom.

use maniple_view::Seat;

use super::stage::{Plan, Stand, attack, attack_at, go, hold, nobodys, own, switch};

#[test]
fn armour_is_taken_off_each_hit_and_leaves_at_least_one() {
    let check = |damage: u32, armor: u32, shooters: u16, expected: u32| {
        let tables = format!(
            "[combat]\n[unit.gun]\nradius = 0.25\nspeed = 1\n\
             weapon = {{ range = 6, cooldown_seconds = 1, damage_min = {damage}, damage_max = {damage} }}\n\
             [unit.hull]\nradius = 0.25\nspeed = 1\nhit_points = 100\narmor = {armor}\n"
        );
        let guns: Vec<Stand<'_>> =
            (0..shooters).map(|place| own(0, "gun", 4.0 + f64::from(place), 4.0)).collect();
        let mut stage = Plan { tables: &tables, ..Plan::default() }
            .stage(&[&[own(1, "hull", 5.0, 6.0)], &guns[..]].concat());
        for gun in 1..=u32::from(shooters) {
            stage.tell(&attack(gun, 0)).unwrap();
        }
        stage.step(1);
        assert_eq!(100 - stage.hit_points(0), expected, "{damage} {armor} {shooters}");
    };
    check(10, 0, 1, 10);
    check(10, 3, 1, 7);
    check(10, 9, 1, 1);
    check(10, 10, 1, 1);
    check(10, 1_000_000, 1, 1);
    check(10, 3, 3, 21);
    check(1, 50, 2, 2);
}

#[test]
fn damage_is_each_number_of_its_range_and_nothing_else() {
    let tables = "[combat]\n[unit.gun]\nradius = 0.25\nspeed = 1\n\
         weapon = { range = 6, cooldown_seconds = 0, damage_min = 2, damage_max = 5 }\n\
         [unit.hull]\nradius = 0.25\nspeed = 1\nhit_points = 100000\n";
    let mut counts = [0_u32; 8];
    let mut stage =
        Plan { tables, ..Plan::default() }.stage(&[own(0, "gun", 4.0, 4.0), own(1, "hull", 5.0, 6.0)]);
    stage.tell(&attack(0, 1)).unwrap();
    for _ in 0..400 {
        let before = stage.hit_points(1);
        stage.step(1);
        counts[(before - stage.hit_points(1)) as usize] += 1;
    }
    assert_eq!(counts.iter().sum::<u32>(), 400, "a cooldown is at least a cycle");
    assert_eq!([counts[0], counts[1], counts[6], counts[7]], [0; 4]);
    assert!(counts[2..=5].iter().all(|&count| (60..=140).contains(&count)), "{counts:?}");
}

/// `mortar` does 12 damage within 2 of a point; the others take it.
const SPLASH: &str = "
[unit.mortar]
radius = 0.25
speed = 1
hit_points = 100
weapon = { range = 8, cooldown_seconds = 60, damage_min = 12, damage_max = 12, splash_radius = 2 FALLOFF }
[unit.hull]
radius = 0.5
speed = 2
hit_points = 100
[unit.house]
width = 2
height = 2
speed = 0
hit_points = 100
[unit.jet]
radius = 0.25
speed = 1
layer = 'air'
hit_points = 100
";

#[test]
fn splash_hits_everybody_whose_hull_is_within_it_and_falls_off_as_it_says() {
    let check = |falloff: &str, victim: &str, x: f64, expected: u32| {
        let tables = format!("[combat]\n{}", SPLASH.replace("FALLOFF", falloff));
        let mut stage = Plan { tables: &tables, ..Plan::default() }
            .stage(&[own(0, "mortar", 4.0, 4.0), own(1, victim, x, 4.0)]);
        stage.tell(&attack_at(0, 8.0, 4.0)).unwrap();
        stage.step(2);
        assert_eq!(100 - stage.hit_points(1), expected, "{falloff} {victim} {x}");
    };
    let linear = ", splash_falloff = 'linear'";
    check("", "hull", 8.0, 12);
    check("", "hull", 10.0, 12);
    check("", "hull", 10.5, 12);
    check("", "hull", 10.5_f64.next_up(), 0);
    check("", "house", 11.0, 12);
    check("", "house", 11.0_f64.next_up(), 0);
    check("", "jet", 8.0, 12);
    check(linear, "hull", 8.0, 12);
    check(linear, "hull", 8.5, 12);
    check(linear, "hull", 9.5, 6);
    check(linear, "hull", 9.0, 9);
    check(linear, "hull", 9.1, 8);
    check(linear, "hull", 10.25, 1);
    check(linear, "hull", 10.5, 0);
    check(linear, "house", 10.0, 6);
    check(", targets = ['air']", "hull", 8.0, 0);
    check(", targets = ['air']", "jet", 8.0, 12);
}

#[test]
fn splash_hurts_friends_only_where_the_scenario_says_so_and_what_is_nobodys_always() {
    let check = |combat: &str, expected: [u32; 5]| {
        let tables = format!("{combat}\n{}", SPLASH.replace("FALLOFF", ""));
        let mut stage = Plan { tables: &tables, seats: &["team = 0", "", "team = 0"], ..Plan::default() }
            .stage(&[
                own(0, "mortar", 4.0, 4.0),
                own(0, "hull", 4.0, 6.0),
                own(2, "hull", 6.0, 4.0),
                own(1, "hull", 4.5, 2.25),
                nobodys("hull", 5.5, 5.5, 0),
            ]);
        stage.tell(&attack_at(0, 4.5, 4.5)).unwrap();
        stage.step(2);
        let lost: Vec<u32> = (0..5).map(|object| 100 - stage.hit_points(object)).collect();
        assert_eq!(lost, expected, "{combat}");
    };
    check("[combat]", [0, 0, 0, 12, 12]);
    check("[combat]\nfriendly_fire = false", [0, 0, 0, 12, 12]);
    check("[combat]\nfriendly_fire = true", [12; 5]);
}

#[test]
fn splash_goes_off_around_the_centre_of_the_target_where_it_was_at_the_start_of_the_cycle() {
    let tables = format!("[combat]\n{}", SPLASH.replace("FALLOFF", ""));
    let mut stage = Plan { tables: &tables, ..Plan::default() }.stage(&[
        own(0, "mortar", 4.0, 4.0),
        own(1, "hull", 8.0, 4.0),
        own(1, "hull", 10.5, 4.0),
        own(1, "hull", 8.0, 7.0),
    ]);
    stage.tell(&attack(0, 1)).unwrap();
    stage.tell(&go(2, 23.0, 4.0)).unwrap();
    stage.step(1);
    assert_eq!([1, 2, 3].map(|object| stage.hit_points(object)), [88, 88, 100]);
}

#[test]
fn friends_that_one_kills_are_no_kills_and_what_is_nobodys_is_none_either() {
    let tables = format!("[combat]\nfriendly_fire = true\n{}", SPLASH.replace("FALLOFF", ""))
        .replace("hit_points = 100", "hit_points = 10")
        .replace(
            "[unit.mortar]\nradius = 0.25\nspeed = 1\nhit_points = 10",
            "[unit.mortar]\nradius = 0.25\nspeed = 1",
        );
    let mut stage =
        Plan { tables: &tables, seats: &["team = 0", "", "team = 0"], ..Plan::default() }.stage(&[
            own(0, "mortar", 4.0, 4.0),
            own(0, "hull", 8.0, 4.0),
            own(2, "hull", 8.0, 5.5),
            nobodys("hull", 9.0, 3.0, 0),
            own(1, "hull", 8.0, 2.5),
            own(1, "house", 10.0, 5.0),
        ]);
    stage.tell(&attack_at(0, 8.0, 4.0)).unwrap();
    stage.step(1);
    assert_eq!(stage.all().len(), 1, "all but the shooter are dead");
    let tally = |seat| stage.world.tally(Seat(seat));
    assert_eq!([tally(0).units_destroyed, tally(1).units_destroyed, tally(2).units_destroyed], [1, 0, 0]);
    assert_eq!([tally(0).units_lost, tally(1).units_lost, tally(2).units_lost], [1, 1, 1]);
    assert_eq!([tally(0).buildings_destroyed, tally(1).buildings_lost], [1, 1]);
    assert_eq!(tally(0).last_building.0, 1);
}

#[test]
fn a_kill_belongs_to_who_did_most_damage_in_the_cycle_and_of_several_to_one_by_chance() {
    let gun = |name: &str, damage: u32| {
        format!(
            "[unit.{name}]\nradius = 0.25\nspeed = 1\n\
             weapon = {{ range = 6, cooldown_seconds = 1, damage_min = {damage}, damage_max = {damage} }}\n"
        )
    };
    let tables = format!(
        "[combat]\n{}{}[unit.hull]\nradius = 0.25\nspeed = 1\nhit_points = 20\n",
        gun("light", 10),
        gun("heavy", 15)
    );
    let kills = |first: &str, second: &str, seed: u64| {
        let mut stage = Plan { tables: &tables, seats: &["", "", ""], seed, ..Plan::default() }.stage(&[
            own(0, first, 4.0, 4.0),
            own(1, second, 8.0, 4.0),
            own(2, "hull", 6.0, 4.0),
        ]);
        stage.tell(&hold(0)).unwrap();
        stage.tell(&attack(0, 2)).unwrap();
        stage.tell(&attack(1, 2)).unwrap();
        stage.step(1);
        [0, 1].map(|seat| stage.world.tally(Seat(seat)).units_destroyed)
    };
    assert_eq!(kills("heavy", "light", 1), [1, 0]);
    assert_eq!(kills("light", "heavy", 1), [0, 1]);
    let won: u32 = (0..200).map(|seed| kills("light", "light", seed)[0]).sum();
    assert!((70..=130).contains(&won), "the first seat got {won} of 200");
    assert!((0..200).all(|seed| kills("light", "light", seed).iter().sum::<u32>() == 1));
}

#[test]
fn armour_is_that_of_the_mode_and_while_switching_that_of_the_mode_before() {
    let tables = "[combat]\n[modes]\n[unit.gun]\nradius = 0.25\nspeed = 1\n\
         weapon = { range = 9, cooldown_seconds = 0, damage_min = 10, damage_max = 10 }\n\
         [unit.tank]\nradius = 0.25\nspeed = 1\nhit_points = 100000\narmor = 2\n\
         [unit.tank.alternate]\nname = 'dug in'\nswitch_seconds = 1\nspeed = 0\narmor = 6\n";
    let mut stage =
        Plan { tables, ..Plan::default() }.stage(&[own(0, "gun", 4.0, 4.0), own(1, "tank", 8.0, 4.0)]);
    stage.tell(&attack(0, 1)).unwrap();
    let mut lost = Vec::new();
    for cycle in 0..26 {
        if cycle == 1 || cycle == 15 {
            stage.tell(&switch(1)).unwrap();
        }
        let before = stage.hit_points(1);
        stage.step(1);
        lost.push(before - stage.hit_points(1));
    }
    // A switch ends at the end of its last cycle, before the damage of this cycle.
    let expected: Vec<u32> = [vec![8; 8], vec![4; 14], vec![8; 4]].concat();
    assert_eq!(lost, expected);
}
