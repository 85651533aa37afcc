//! Sites: where they are founded, by whom, and what becomes of them.

use maniple_geometry::ObjectId;
use maniple_view::{Action, Command, EndOfTask, Mode, Refusal, Seat, Stop, Task};

use super::stage::{Plan, Stage, Stand, attack, build, cancel, go, hold, own, stop, train};

/// A `mason` builds; a `house` takes two seconds, a `hut` is round and takes one, a `keep` needs a `house`.
const TABLES: &str = "
[combat]
[production]
[unit.mason]
radius = 0.25
speed = 4
sight = 6
hit_points = 10
builds = ['house', 'hut', 'keep']
[unit.house]
width = 4
height = 2
speed = 0
sight = 6
hit_points = 100
cost = 100
make_seconds = 2
trains = ['mason']
[unit.hut]
radius = 0.5
speed = 0
hit_points = 50
cost = 30
make_seconds = 1
[unit.keep]
width = 2
height = 2
speed = 0
hit_points = 100
cost = 10
make_seconds = 1
requires = ['house']
[unit.gun]
radius = 0.25
speed = 4
hit_points = 10
weapon = { range = 22, cooldown_seconds = 0, damage_min = 100, damage_max = 100 }
[unit.jet]
radius = 0.25
speed = 4
layer = 'air'
";

fn stage(stands: &[Stand<'_>]) -> Stage {
    Plan { tables: TABLES, seats: &["stock = 500", "stock = 500"], ..Plan::default() }.stage(stands)
}

/// Tells a builder to build, and plays until it works or is told why not.
fn found(stage: &mut Stage, builder: u32, unit_type: &str, (x, y): (f64, f64)) -> Option<EndOfTask> {
    stage.tell(&build(builder, stage.unit_type(unit_type), x, y)).unwrap();
    let known = stage.ended.len();
    stage.step_until(|stage| works(stage, builder) || stage.ended.len() > known);
    stage.ended.get(known).map(|&(.., why)| why)
}

fn works(stage: &Stage, builder: u32) -> bool {
    stage.see(builder).is_some_and(|sighting| sighting.status.action == Action::Build)
}

#[test]
fn a_site_is_paid_when_it_is_founded_and_finished_after_its_time() {
    let mut stage = stage(&[own(0, "mason", 2.0, 6.0), own(1, "mason", 22.0, 6.0)]);
    stage.tell(&build(0, stage.unit_type("house"), 10.0, 6.0)).unwrap();
    stage.step_until(|stage| {
        assert_eq!(stage.stock(0), if works(stage, 0) { 400 } else { 500 });
        works(stage, 0)
    });
    let distance = 8.0 - stage.place(0).x - 0.25;
    assert!((0.0..=0.0625).contains(&distance), "the builder stands in reach: {distance}");
    let site = stage.see(2).unwrap();
    assert_eq!((site.status.mode, site.status.hit_points), (Mode::Site, Some(100)));
    assert_eq!(site.own.due.map(|due| due.0 - stage.world.cycle().0), Some(15));
    stage.step(14);
    assert_eq!((stage.mode(2), stage.task(0)), (Mode::Site, Task::Build));
    for command in [train(2, stage.unit_type("mason")), hold(2), stop(2)] {
        assert_eq!(stage.tell(&command), Err(Refusal::Busy));
    }
    stage.step(1);
    assert_eq!((stage.mode(2), stage.task(0)), (Mode::Normal, Task::None));
    assert_eq!(
        stage.ended.last().map(|&(_, id, task, why)| (id, task, why)),
        Some((0, Task::Build, EndOfTask::Done))
    );
    assert_eq!((stage.stock(0), stage.stock(1)), (400, 500));
    assert_eq!(stage.world.tally(Seat(0)).made, 1);
    assert_eq!(stage.tell(&train(2, stage.unit_type("mason"))), Ok(()));
}

#[test]
fn two_builders_are_no_faster_than_one_and_a_site_is_paid_once() {
    let check = |second: (f64, f64)| {
        let mut stage = stage(&[own(0, "mason", 7.0, 6.0), own(0, "mason", 10.0, 9.0)]);
        found(&mut stage, 0, "house", (10.0, 6.0));
        let founded = stage.world.cycle().0;
        assert_eq!(found(&mut stage, 1, "house", second), None);
        assert_eq!((stage.all().len(), stage.stock(0)), (3, 400), "it joins");
        stage.step_until(|stage| stage.mode(2) == Mode::Normal);
        assert_eq!(stage.world.cycle().0 - founded, 15);
        let ended: Vec<u32> = stage.ended.iter().map(|&(_, object, ..)| object).collect();
        assert_eq!(ended, [0, 1]);
    };
    check((10.0, 6.0));
    // Any point of the site means the site.
    check((8.0, 6.5));
    check((11.9, 5.1));
}

#[test]
fn a_site_only_comes_on_while_somebody_works_at_it() {
    let mut stage = stage(&[own(0, "mason", 7.0, 6.0), own(0, "mason", 2.0, 2.0)]);
    found(&mut stage, 0, "house", (10.0, 6.0));
    stage.step(5);
    stage.tell(&go(0, 2.0, 6.0)).unwrap();
    stage.step(30);
    assert_eq!((stage.mode(2), stage.see(2).unwrap().own.due), (Mode::Site, None));
    assert_eq!(found(&mut stage, 1, "house", (10.0, 6.0)), None);
    assert_eq!(stage.step_until(|stage| stage.mode(2) == Mode::Normal), 9, "one, six and nine are sixteen");
    assert_eq!(stage.stock(0), 400);
}

#[test]
fn without_its_builder_a_site_stays_as_it_is() {
    let mut stage = stage(&[own(0, "mason", 7.0, 6.0), own(1, "gun", 20.0, 2.0)]);
    found(&mut stage, 0, "house", (10.0, 6.0));
    stage.tell(&attack(1, 0)).unwrap();
    stage.step(40);
    assert!(stage.see(0).is_none());
    assert_eq!((stage.mode(2), stage.see(2).unwrap().own.due), (Mode::Site, None));
    assert_eq!(stage.tell(&cancel(2)), Ok(()));
    stage.step(1);
    assert_eq!((stage.stock(0), stage.all().len()), (500, 1));
}

#[test]
fn a_site_that_is_destroyed_is_not_paid_back_and_one_that_is_given_up_is() {
    let check = |end: fn(&mut Stage), stock: u32, lost: u32| {
        let mut stage = stage(&[own(0, "mason", 7.0, 6.0), own(1, "gun", 20.0, 2.0)]);
        found(&mut stage, 0, "house", (10.0, 6.0));
        stage.step(7);
        end(&mut stage);
        assert_eq!(stage.outcome(0), EndOfTask::Lost);
        assert!(stage.see(2).is_none());
        assert_eq!((stage.stock(0), stage.stock(1)), (stock, 500));
        assert_eq!(stage.world.tally(Seat(0)).buildings_lost, lost);
        assert_eq!(stage.world.tally(Seat(1)).buildings_destroyed, lost);
        assert_eq!(found(&mut stage, 0, "house", (10.0, 6.0)), None, "there is room again");
    };
    check(|stage| stage.tell(&attack(1, 2)).unwrap(), 400, 1);
    check(|stage| stage.tell(&cancel(2)).unwrap(), 500, 0);
    let mut stage = stage(&[own(0, "mason", 7.0, 6.0), own(1, "gun", 20.0, 2.0)]);
    found(&mut stage, 0, "house", (10.0, 6.0));
    assert_eq!(stage.tell_as(1, &cancel(2)), Err(Refusal::UnknownHandle));
    stage.step(20);
    assert_eq!(stage.tell(&cancel(2)), Err(Refusal::NothingToCancel), "it is finished");
    assert_eq!(stage.tell(&cancel(0)), Err(Refusal::NothingToCancel));
}

#[test]
fn there_is_no_room_on_anybody_and_room_beside_them() {
    let check = |other: Stand<'_>, at: (f64, f64), expected: Option<EndOfTask>| {
        let tables = format!(
            "{TABLES}[harvest]\npatch = 'ore'\n[unit.ore]\nradius = 0.25\nspeed = 0\npatch = {{ places = 1 }}\n"
        );
        let mut stage = Plan { tables: &tables, seats: &["stock = 500", ""], ..Plan::default() }
            .stage(&[own(0, "mason", 3.0, 2.0), other]);
        assert_eq!(found(&mut stage, 0, "house", at), expected, "{other:?} {at:?}");
        assert_eq!(stage.stock(0), if expected.is_none() { 400 } else { 500 });
        assert_eq!(stage.all().len(), if expected.is_none() { 3 } else { 2 });
    };
    let (at, no_room) = ((10.0, 6.0), Some(EndOfTask::NoRoom));
    for (owner, kind) in
        [(Some(0), "mason"), (Some(1), "gun"), (None, "gun"), (None, "ore"), (Some(1), "keep")]
    {
        check((owner, kind, (11.5, 6.0), 5), at, no_room);
    }
    check(own(1, "jet", 10.0, 6.0), at, None);
    // A unit that stands at the edge: its hull is 1/64 away, and then an ulp less.
    check(own(1, "gun", 12.265_625, 6.0), at, None);
    check(own(1, "gun", 12.265_625_f64.next_down(), 6.0), at, no_room);
    check(own(1, "gun", 12.25, 6.0), at, no_room);
    check(own(1, "keep", 13.015_625, 6.0), at, None);
    check(own(1, "keep", 13.015_625_f64.next_down(), 6.0), at, no_room);
    // Round the corner the hull of a circle is farther.
    check(own(1, "gun", 12.2, 7.2), at, None);
}

#[test]
fn a_builder_is_in_its_own_way() {
    let mut stage = stage(&[own(0, "mason", 10.0, 6.0)]);
    assert_eq!(found(&mut stage, 0, "house", (10.0, 6.0)), Some(EndOfTask::NoRoom));
    assert_eq!(found(&mut stage, 0, "house", (12.25, 6.0)), Some(EndOfTask::NoRoom), "it touches");
    assert_eq!(found(&mut stage, 0, "house", (12.3, 6.0)), None);
}

#[test]
fn what_comes_along_while_the_builder_is_on_its_way_takes_the_room() {
    let mut stage = stage(&[own(0, "mason", 2.0, 6.0), own(1, "mason", 14.0, 2.0)]);
    stage.tell(&build(0, stage.unit_type("house"), 12.0, 6.0)).unwrap();
    stage.tell(&go(1, 12.0, 6.0)).unwrap();
    assert_eq!(stage.outcome(0), EndOfTask::NoRoom);
    assert_eq!(stage.stock(0), 500);
}

#[test]
fn a_wall_or_the_edge_of_the_map_is_no_place() {
    let rows = "........................\n".repeat(5)
        + &"...........@............\n".repeat(2)
        + &"........................\n".repeat(5);
    let check = |unit_type: &str, (x, y): (f64, f64), expected: Result<(), Refusal>| {
        let mut stage = Plan { tables: TABLES, rows: &rows, seats: &["stock = 500", ""], ..Plan::default() }
            .stage(&[own(0, "mason", 6.0, 6.0), own(0, "gun", 6.0, 3.0)]);
        assert_eq!(stage.tell(&build(0, stage.unit_type(unit_type), x, y)), expected, "{unit_type} {x} {y}");
    };
    let bad = || Err(Refusal::BadPlace);
    check("house", (6.0, 9.0), Ok(()));
    check("house", (11.0, 6.0), bad());
    check("house", (9.1, 6.0), bad());
    check("house", (8.9, 6.0), Ok(()));
    check("house", (11.0, 8.2), Ok(()));
    check("house", (11.0, 7.9), bad());
    check("hut", (10.4, 6.0), Ok(()));
    check("hut", (10.6, 6.0), bad());
    check("house", (1.9, 6.0), bad());
    check("house", (2.1, 6.0), Ok(()));
    check("house", (22.1, 6.0), bad());
    check("house", (21.9, 6.0), Ok(()));
    check("house", (6.0, 0.9), bad());
    check("house", (6.0, 11.1), bad());
    check("house", (6.0, 12.1), Err(Refusal::OutOfWorld { width: 24, height: 12 }));
    check(
        "house",
        (f64::NAN, 6.0),
        Err(Refusal::BadNumber { field: "x".into(), problem: "is not a number".into() }),
    );
    check("gun", (6.0, 9.0), Err(Refusal::UnknownAction));
    let mut stage = stage(&[own(0, "gun", 6.0, 6.0)]);
    assert_eq!(stage.tell(&build(0, stage.unit_type("house"), 6.0, 9.0)), Err(Refusal::UnknownAction));
    assert_eq!(stage.tell_as(1, &build(0, stage.unit_type("house"), 6.0, 9.0)), Err(Refusal::UnknownHandle));
}

#[test]
fn what_a_seat_lacks_is_looked_at_when_the_site_is_founded() {
    let check = |stock: &str, unit_type: &str, meanwhile: fn(&mut Stage), expected: Option<EndOfTask>| {
        let mut stage = Plan { tables: TABLES, seats: &[stock, ""], ..Plan::default() }.stage(&[
            own(0, "mason", 2.0, 6.0),
            own(0, "house", 6.0, 2.0),
            own(1, "gun", 20.0, 2.0),
            own(0, "house", 16.0, 10.0),
        ]);
        stage.tell(&build(0, stage.unit_type(unit_type), 12.0, 6.0)).unwrap();
        stage.step(2);
        meanwhile(&mut stage);
        stage.step_until(|stage| works(stage, 0) || stage.ended.iter().any(|&(_, id, ..)| id == 0));
        let outcome = stage.ended.iter().find(|&&(_, id, ..)| id == 0).map(|&(.., why)| why);
        assert_eq!(outcome, expected, "{stock} {unit_type}");
    };
    check("stock = 100", "house", |_| (), None);
    check("stock = 99", "house", |_| (), Some(EndOfTask::NotAffordable));
    check("stock = 10", "keep", |_| (), None);
    let one_lost: fn(&mut Stage) = |stage| stage.tell(&attack(2, 1)).unwrap();
    let both_lost: fn(&mut Stage) = |stage| {
        stage.tell(&attack(2, 1)).unwrap();
        stage.step(2);
        stage.tell(&attack(2, 3)).unwrap();
    };
    check("stock = 10", "keep", one_lost, None);
    check("stock = 10", "keep", both_lost, Some(EndOfTask::Missing));
}

#[test]
fn a_site_is_no_building_that_others_require() {
    let mut stage = stage(&[own(0, "mason", 7.0, 6.0), own(0, "mason", 7.0, 9.5)]);
    found(&mut stage, 0, "house", (10.0, 6.0));
    assert_eq!(found(&mut stage, 1, "keep", (10.0, 9.5)), Some(EndOfTask::Missing));
    stage.step(16);
    assert_eq!(found(&mut stage, 1, "keep", (10.0, 9.5)), None);
}

#[test]
fn of_several_for_one_place_the_first_there_founds_and_at_once_one_by_chance() {
    let founder = |first: f64, second: f64, seed: u64| {
        let plan = Plan { tables: TABLES, seats: &["stock = 500", "stock = 500"], seed, ..Plan::default() };
        let mut stage =
            plan.stage(&[own(0, "mason", 12.0 - first, 6.0), own(1, "mason", 12.0 + second, 6.0)]);
        for builder in [0, 1] {
            stage.tell(&build(builder, stage.unit_type("house"), 12.0, 6.0)).unwrap();
        }
        stage.step(10);
        let site = stage.see(2).unwrap();
        let loser = 1 - u32::from(site.owner.unwrap().0);
        assert_eq!(
            stage.ended.iter().map(|&(_, id, _, why)| (id, why)).collect::<Vec<_>>(),
            [(loser, EndOfTask::NoRoom)]
        );
        let paid = [0, 1].map(|seat| 500 - stage.stock(seat));
        assert_eq!((paid[0] + paid[1], paid[loser as usize]), (100, 0));
        loser
    };
    for seed in 0..8 {
        assert_eq!(founder(5.0, 5.001, seed), 1);
        assert_eq!(founder(5.001, 5.0, seed), 0);
        assert_eq!(founder(5.0, 5.6, seed), 1);
    }
    let won: u32 = (0..300).map(|seed| founder(5.0, 5.0, seed)).sum();
    assert!((115..=185).contains(&won), "the first seat got {won} of 300");
}

#[test]
fn a_site_stops_everybody_at_once_and_sees() {
    let tables = format!("[vision]\n{TABLES}");
    let mut stage = Plan { tables: &tables, seats: &["stock = 500", ""], ..Plan::default() }.stage(&[
        own(0, "mason", 8.0, 6.0),
        own(1, "gun", 18.0, 6.0),
        own(1, "jet", 18.0, 2.0),
    ]);
    stage.tell(&build(0, stage.unit_type("house"), 11.0, 6.0)).unwrap();
    stage.tell(&go(1, 9.5, 6.0)).unwrap();
    stage.tell(&go(2, 9.5, 6.0)).unwrap();
    let sees =
        |stage: &Stage| stage.world.sightings(Seat(0)).iter().any(|sighting| sighting.object == ObjectId(1));
    assert!(!sees(&stage));
    stage.step(4);
    assert!(works(&stage, 0));
    assert!(sees(&stage), "the site is nearer than the builder");
    stage.step_until(|stage| !stage.is_moving(1));
    assert_eq!(stage.see(1).unwrap().stop, Some(Stop::Segment));
    stage.step_until(|stage| !stage.is_moving(2));
    assert_eq!(stage.see(2).unwrap().stop, Some(Stop::Arrived));
}

#[test]
fn a_builder_whose_way_is_blocked_is_told() {
    let mut stage = stage(&[own(0, "mason", 2.0, 6.0), own(0, "gun", 5.0, 6.0)]);
    assert_eq!(found(&mut stage, 0, "house", (12.0, 6.0)), Some(EndOfTask::Blocked));
    stage.step(10);
    assert_eq!((stage.stock(0), stage.task(0)), (500, Task::None));
}

#[test]
fn without_a_table_production_nothing_is_made() {
    let tables = TABLES.replace("[production]", "");
    let mut stage = Plan { tables: &tables, ..Plan::default() }
        .stage(&[own(0, "mason", 2.0, 6.0), own(0, "house", 6.0, 9.0)]);
    let (house, mason) = (stage.unit_type("house"), stage.unit_type("mason"));
    let commands: [Command; 2] = [build(0, house, 12.0, 6.0), train(1, mason)];
    for command in commands {
        assert_eq!(stage.tell(&command), Err(Refusal::UnknownAction));
    }
}

#[test]
fn under_fog_a_builder_has_to_see_across_what_it_builds() {
    let check = |vision: &str, sight: f64, expected: Option<&str>| {
        let text = format!(
            "name = 'x'\nmap = 'x.map'\nlength_seconds = 1\n{vision}\n[production]\n\
             [objective]\nkind = 'last_standing'\n\
             [unit.hall]\nwidth = 6\nheight = 8\nspeed = 0\n\
             [unit.mason]\nradius = 0.25\nspeed = 1\nsight = {sight}\nbuilds = ['hall']\n\
             [[seat]]\ngroups = [{{ unit = 'mason', count = 1 }}]\n"
        );
        let error = crate::Scenario::read("x.toml", &text).err().map(|error| error.to_string());
        assert_eq!(error.is_some(), expected.is_some(), "{vision} {sight} {error:?}");
        assert!(expected.is_none_or(|expected| error.unwrap().contains(expected)));
    };
    check("[vision]", 10.078_125, None);
    check("[vision]", 10.078, Some("\"mason\" builds what is larger than it sees"));
    check("", 1.0, None);
}
