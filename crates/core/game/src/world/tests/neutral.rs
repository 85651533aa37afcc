//! Units of nobody.

use std::collections::BTreeMap;

use glam::DVec2;
use maniple_geometry::ObjectId;
use maniple_view::{Refusal, Seat};

use super::stage::{Plan, Stage, attack, go, hold, nobodys, own};

const TABLES: &str = "
[combat]
[neutral]
groups = [{ unit = 'sheep', count = 1 }]
wander = 2
pause_seconds = 1
[unit.sheep]
radius = 0.25
speed = 2
hit_points = 10
sight = 6
[unit.cow]
radius = 0.25
speed = 0
hit_points = 10
[unit.gun]
radius = 0.25
speed = 4
sight = 4
hit_points = 10
weapon = { range = 20, cooldown_seconds = 1, damage_min = 10, damage_max = 10 }
";

fn stage(seed: u64) -> Stage {
    Plan { tables: TABLES, seed, ..Plan::default() }.stage(&[
        own(0, "gun", 1.0, 11.0),
        nobodys("sheep", 6.0, 6.0, 0),
        nobodys("sheep", 12.0, 6.0, 0),
        nobodys("sheep", 18.0, 6.0, 0),
        nobodys("cow", 22.0, 2.0, 0),
    ])
}

#[test]
fn they_wander_each_within_its_square_and_rest_in_between() {
    let mut stage = stage(3);
    let mut homes: BTreeMap<u32, DVec2> = (1..4).map(|sheep| (sheep, stage.place(sheep))).collect();
    let (mut ways, mut rests) = (0, 0);
    for _ in 0..470 {
        stage.step(1);
        for sheep in 1..4 {
            let (place, home) = (stage.place(sheep), homes[&sheep]);
            let away = (place - home).abs();
            assert!(away.x <= 2.0 && away.y <= 2.0, "{sheep} went from {home} to {place}");
            if stage.see(sheep).unwrap().stop.is_some() {
                ways += 1;
                homes.insert(sheep, place);
            }
            rests += u32::from(!stage.is_moving(sheep));
        }
        assert_eq!(stage.place(4), DVec2::new(22.0, 2.0), "who cannot move stays");
    }
    let pause = f64::from(rests) / f64::from(ways);
    assert!((6.0..10.0).contains(&pause), "they rest eight cycles in the mean: {rests} in {ways}");
    assert!((1..4).all(|sheep| stage.ended.iter().all(|&(_, id, ..)| id != sheep)));
}

#[test]
fn where_they_go_depends_on_nothing_but_the_seed_and_their_own_surroundings() {
    let places = |seed: u64, stop_first: bool| {
        let mut stage = stage(seed);
        if stop_first {
            stage.tell(&attack(0, 1)).unwrap();
        }
        stage.step(60);
        [2, 3].map(|sheep| stage.place(sheep))
    };
    assert_eq!(places(1, false), places(1, true), "who is dead draws no numbers, and takes none away");
    assert_ne!(places(1, false), places(2, false));
}

#[test]
fn nobody_commands_them_and_killing_them_is_no_kill() {
    let mut stage = stage(1);
    for seat in [0, 1] {
        for command in [go(1, 3.0, 3.0), hold(1), go(4, 3.0, 3.0)] {
            assert_eq!(stage.tell_as(seat, &command), Err(Refusal::UnknownHandle), "{command:?}");
        }
    }
    stage.tell(&attack(0, 1)).unwrap();
    stage.step(1);
    assert_eq!(stage.world.died(Seat(0)), [ObjectId(1)]);
    let tally = stage.world.tally(Seat(0));
    assert_eq!((tally.units_destroyed, tally.buildings_destroyed), (0, 0));
    stage.tell(&attack(0, 4)).unwrap();
    stage.step(12);
    assert!(stage.see(4).is_none());
    assert_eq!(stage.world.tally(Seat(0)).buildings_destroyed, 0);
}

#[test]
fn nobody_sees_by_them() {
    let tables = format!("[vision]\n{TABLES}");
    let stage = Plan { tables: &tables, ..Plan::default() }.stage(&[
        own(0, "gun", 2.0, 6.0),
        nobodys("sheep", 5.0, 6.0, 0),
        own(1, "gun", 9.0, 6.0),
    ]);
    let seen: Vec<u32> = stage.world.sightings(Seat(0)).iter().map(|sighting| sighting.object.0).collect();
    assert_eq!(seen, [0, 1]);
}

#[test]
fn units_of_nobody_are_placed_from_the_seed() {
    let tables = TABLES.replace("count = 1", "count = 5");
    let places = |seed: u64| {
        let scenario = format!("seed = {seed}\n{tables}");
        let files = super::files(&scenario, super::PLAIN, super::ONE);
        let loaded = crate::load(&files, "s/tiny.toml", &crate::Overrides::default()).unwrap();
        let places: Vec<(f64, f64)> =
            loaded.setup.units[1..].iter().map(|unit| unit.position.into()).collect();
        assert!(loaded.setup.units[1..].iter().all(|unit| unit.seat.is_none()));
        places
    };
    assert_eq!(places(1).len(), 5);
    assert_eq!(places(1), places(1));
    assert_ne!(places(1), places(2));
}
