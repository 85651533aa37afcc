//! Units that buildings train.

use maniple_view::{EndOfTask, Refusal, Seat, UnitTypeId};

use super::stage::{Plan, Stage, Stand, attack, build, cancel, gather, go, nobodys, own, switch, train};

/// A `barracks` trains pawns in a second and knights in two.
const TABLES: &str = "
[combat]
[production]
[unit.barracks]
width = 2
height = 2
speed = 0
sight = 3
hit_points = 100
trains = ['pawn', 'knight']
[unit.pawn]
radius = 0.25
speed = 4
hit_points = 10
cost = 20
make_seconds = 1
[unit.knight]
radius = 0.5
speed = 4
hit_points = 10
cost = 50
make_seconds = 2
requires = ['stable']
[unit.stable]
radius = 0.5
speed = 0
hit_points = 10
cost = 1
[unit.mason]
radius = 0.25
speed = 4
builds = ['stable']
[unit.gun]
radius = 0.25
speed = 4
weapon = { range = 22, cooldown_seconds = 0, damage_min = 100, damage_max = 100 }
";

fn stage(stock: &str, stands: &[Stand<'_>]) -> Stage {
    Plan { tables: TABLES, seats: &[stock, ""], ..Plan::default() }.stage(stands)
}

/// Returns the type of what is in training, and how many wait behind it.
fn line(stage: &Stage, building: u32) -> (Option<UnitTypeId>, u32) {
    let own = stage.see(building).unwrap().own;
    (own.training, own.waiting)
}

#[test]
fn units_are_paid_at_once_and_finished_one_after_the_other() {
    let mut stage = stage("stock = 200", &[own(0, "barracks", 6.0, 6.0), own(0, "stable", 12.0, 6.0)]);
    let (pawn, knight) = (stage.unit_type("pawn"), stage.unit_type("knight"));
    for unit_type in [pawn, knight, pawn] {
        stage.tell(&train(0, unit_type)).unwrap();
    }
    assert_eq!(stage.stock(0), 110);
    let mut made = Vec::new();
    for cycle in 1..=40 {
        stage.step(1);
        let newest = stage.all().values().last().copied().unwrap();
        if newest.object.0 as usize == 2 + made.len() {
            made.push((cycle, newest.unit_type));
        }
    }
    assert_eq!(made, [(8, pawn), (24, knight), (32, pawn)]);
    assert_eq!((stage.stock(0), stage.world.tally(Seat(0)).made), (110, 3));
    assert_eq!(line(&stage, 0), (None, 0));
}

#[test]
fn what_cannot_be_trained_is_refused_with_the_reason_and_costs_nothing() {
    let check = |stock: &str, stands: &[Stand<'_>], unit_type: &str, expected: Result<(), Refusal>| {
        let mut stage = stage(stock, &[&[own(0, "barracks", 6.0, 6.0)], stands].concat());
        let before = stage.stock(0);
        let unit_type = stage.unit_type(unit_type);
        assert_eq!(stage.tell(&train(0, unit_type)), expected);
        assert_eq!(stage.stock(0) == before, expected.is_err());
        assert_eq!(line(&stage, 0).0, None, "told from the next cycle on");
        assert_eq!(stage.tell_as(1, &train(0, unit_type)), Err(Refusal::UnknownHandle));
    };
    let stable = own(0, "stable", 12.0, 6.0);
    let unit_type = |name| stage("", &[]).unit_type(name);
    check("stock = 20", &[], "pawn", Ok(()));
    check("stock = 19", &[], "pawn", Err(Refusal::NotAffordable { cost: 20, stock: 19 }));
    check("stock = 50", &[stable], "knight", Ok(()));
    let missing = || Err(Refusal::Missing { unit_type: unit_type("stable") });
    check("stock = 50", &[], "knight", missing());
    check("stock = 0", &[], "knight", missing());
    check("stock = 50", &[own(1, "stable", 12.0, 6.0)], "knight", missing());
    check("stock = 50", &[], "mason", Err(Refusal::UnknownAction));
    let mut stage = stage("stock = 50", &[own(0, "mason", 6.0, 6.0)]);
    assert_eq!(stage.tell(&train(0, stage.unit_type("pawn"))), Err(Refusal::UnknownAction));
}

#[test]
fn a_site_of_what_is_required_is_not_enough() {
    let mut stage = stage("stock = 99", &[own(0, "barracks", 6.0, 6.0), own(0, "mason", 10.0, 6.0)]);
    let (knight, stable) = (stage.unit_type("knight"), stage.unit_type("stable"));
    stage.tell(&build(1, stable, 11.0, 6.0)).unwrap();
    stage.step(40);
    assert_eq!(stage.tell(&train(0, knight)), Err(Refusal::Missing { unit_type: stable }));
    assert_eq!(stage.outcome(1), EndOfTask::Done);
    assert_eq!(stage.tell(&train(0, knight)), Ok(()));
}

#[test]
fn five_are_in_training_or_wait_and_no_more() {
    let mut stage = stage("stock = 200", &[own(0, "barracks", 6.0, 6.0)]);
    let pawn = stage.unit_type("pawn");
    for _ in 0..5 {
        stage.tell(&train(0, pawn)).unwrap();
    }
    assert_eq!(stage.tell(&train(0, pawn)), Err(Refusal::TrainingFull { max: 5 }));
    assert_eq!(stage.stock(0), 100);
    stage.step(7);
    assert_eq!(line(&stage, 0), (Some(pawn), 4));
    assert_eq!(stage.tell(&train(0, pawn)), Err(Refusal::TrainingFull { max: 5 }));
    stage.step(1);
    assert_eq!(stage.tell(&train(0, pawn)), Ok(()));
}

#[test]
fn the_last_of_a_line_is_given_up_first_and_paid_back() {
    let mut stage = stage("stock = 200", &[own(0, "barracks", 6.0, 6.0), own(0, "stable", 12.0, 6.0)]);
    let (pawn, knight) = (stage.unit_type("pawn"), stage.unit_type("knight"));
    stage.tell(&train(0, pawn)).unwrap();
    stage.tell(&train(0, knight)).unwrap();
    stage.step(4);
    assert_eq!(stage.stock(0), 130);
    assert_eq!(stage.tell_as(1, &cancel(0)), Err(Refusal::UnknownHandle));
    stage.tell(&cancel(0)).unwrap();
    assert_eq!(stage.stock(0), 180);
    stage.step(3);
    assert_eq!(line(&stage, 0), (Some(pawn), 0));
    stage.tell(&cancel(0)).unwrap();
    assert_eq!(stage.stock(0), 200);
    assert_eq!(stage.tell(&cancel(0)), Err(Refusal::NothingToCancel));
    stage.step(4);
    assert_eq!(stage.all().len(), 2, "nothing is made any more");
    stage.tell(&train(0, pawn)).unwrap();
    stage.step(7);
    assert_eq!(stage.all().len(), 2, "what was given up does not help the next one");
    stage.step(1);
    assert_eq!(stage.all().len(), 3);
}

#[test]
fn a_unit_without_room_waits_for_some() {
    // A yard of 3 by 3 with the barracks in its midst: no place but the doorway, and somebody stands there.
    let rows = "........................\n........................\n...@@@@@................\n...@...@................\n\
                ...@...@................\n...@...@................\n...@@.@@................\n...@@.@@................\n\
                ........................\n........................\n........................\n........................\n";
    let tables = TABLES
        .replace("width = 2\nheight = 2", "width = 2.8\nheight = 2.8")
        .replace("sight = 3", "sight = 1.2");
    let mut stage = Plan { tables: &tables, rows, seats: &["stock = 200", ""], ..Plan::default() }.stage(&[
        own(0, "barracks", 5.5, 4.5),
        own(1, "pawn", 5.5, 7.0),
        own(1, "pawn", 5.5, 8.0),
    ]);
    let pawn = stage.unit_type("pawn");
    stage.tell(&train(0, pawn)).unwrap();
    stage.tell(&train(0, pawn)).unwrap();
    stage.step(40);
    assert_eq!(stage.all().len(), 3, "nobody gets out");
    assert_eq!((line(&stage, 0), stage.stock(0)), ((Some(pawn), 1), 160));
    stage.tell(&go(2, 12.0, 9.0)).unwrap();
    stage.step(4);
    stage.tell(&go(1, 5.5, 11.0)).unwrap();
    let waited = stage.step_until(|stage| stage.see(3).is_some());
    assert!(waited < 8, "as soon as there is room: {waited}");
    assert_eq!(line(&stage, 0), (Some(pawn), 0));
    assert_eq!(stage.world.tally(Seat(0)).made, 1);
    assert_eq!(
        stage.step_until(|stage| line(stage, 0).0.is_none() || stage.world.cycle().0 > 120),
        120 - 44 - waited + 1
    );
}

#[test]
fn a_unit_appears_beside_its_building_within_sight_of_it_and_touches_nobody() {
    let crowd: Vec<Stand<'_>> =
        (0..8).map(|place| own(1, "pawn", 3.7 + 0.6 * f64::from(place), 4.2)).collect();
    let mut stage = stage("stock = 500", &[&[own(0, "barracks", 6.0, 6.0)], &crowd[..]].concat());
    let pawn = stage.unit_type("pawn");
    for _ in 0..20 {
        stage.tell(&train(0, pawn)).unwrap();
        stage.step(8);
        let newest = *stage.all().keys().last().unwrap();
        let (offset, pawn, house) = (stage.place(newest.0) - stage.place(0), newest.0, 0);
        let shape = |object| stage.kind(&stage.see(object).unwrap()).shape;
        let distance = maniple_view::hull_distance(offset, &shape(pawn), &shape(house));
        assert!((0.0625..=3.0).contains(&distance), "{distance}");
    }
    assert_eq!(stage.all().len(), 29);
}

#[test]
fn a_unit_does_not_appear_behind_a_wall() {
    let rows = "........................\n@@@@@@@@@@@@@@@@@@@@@@@@\n....@...................\n....@...................\n\
                ....@...................\n@@@@@@@@@@@@@@@@@@@@@@@@\n".to_owned()
        + &"........................\n".repeat(6);
    let tables = TABLES.replace("sight = 3", "sight = 20");
    let mut stage = Plan { tables: &tables, rows: &rows, seats: &["stock = 500", ""], ..Plan::default() }
        .stage(&[own(0, "barracks", 1.75, 3.5)]);
    let pawn = stage.unit_type("pawn");
    for _ in 0..7 {
        stage.tell(&train(0, pawn)).unwrap();
        stage.step(8);
    }
    assert_eq!(stage.all().len(), 6, "the yard has room for five");
    assert_eq!(line(&stage, 0), (Some(pawn), 1));
    for pawn in 1..6 {
        let place = stage.place(pawn);
        assert!((0.0..4.0).contains(&place.x) && (2.0..5.0).contains(&place.y), "{place}");
    }
}

#[test]
fn what_is_in_training_dies_with_its_building() {
    let mut stage = stage("stock = 200", &[own(0, "barracks", 6.0, 6.0), own(1, "gun", 20.0, 6.0)]);
    stage.tell(&train(0, stage.unit_type("pawn"))).unwrap();
    stage.step(3);
    stage.tell(&attack(1, 0)).unwrap();
    stage.step(20);
    assert_eq!((stage.all().len(), stage.stock(0)), (1, 180));
}

#[test]
fn a_seat_has_4096_objects_and_those_in_training_are_among_them() {
    let rows = "................................................................\n".repeat(64);
    let pawns = |count: u32| {
        (0..count).map(|place| {
            own(0, "mason", 1.0 + 0.6 * f64::from(place % 100), 1.0 + 0.6 * f64::from(place / 100))
        })
    };
    let stands: Vec<Stand<'_>> = std::iter::once(own(0, "barracks", 61.5, 61.5)).chain(pawns(4094)).collect();
    let mut stage =
        Plan { tables: TABLES, rows: &rows, seats: &["stock = 200", ""], ..Plan::default() }.stage(&stands);
    let (pawn, full) = (stage.unit_type("pawn"), Err(Refusal::TooManyObjects { max: 4096 }));
    assert_eq!(stage.tell(&train(0, pawn)), Ok(()));
    assert_eq!(stage.tell(&train(0, pawn)), full);
    assert_eq!(stage.stock(0), 180);
    stage.tell(&cancel(0)).unwrap();
    assert_eq!(stage.tell(&train(0, pawn)), Ok(()));
    let builder = 4094;
    let place = stage.place(builder);
    stage.tell(&build(builder, stage.unit_type("stable"), place.x + 2.0, place.y + 1.5)).unwrap();
    for _ in 0..10 {
        stage.world.step();
        if !stage.world.ended().is_empty() {
            break;
        }
    }
    assert_eq!(stage.world.ended().iter().map(|&(.., why)| why).collect::<Vec<_>>(), [EndOfTask::TooMany]);
    assert_eq!(
        (stage.tell(&train(0, pawn)), stage.stock(0)),
        (full, 180),
        "it is made, or still in training"
    );
}

#[test]
fn who_switches_its_mode_does_not_train_meanwhile() {
    let tables = format!(
        "[modes]\n{TABLES}[unit.hall]\nwidth = 2\nheight = 2\nspeed = 0\nhit_points = 9\ntrains = ['pawn']\n\
         [unit.hall.alternate]\nname = 'shut'\nswitch_seconds = 2\nspeed = 0\n"
    );
    let mut stage = Plan { tables: &tables, seats: &["stock = 200", ""], ..Plan::default() }
        .stage(&[own(0, "hall", 6.0, 6.0)]);
    let due = |stage: &Stage| stage.see(0).unwrap().own.due.map(|due| due.0);
    stage.tell(&train(0, stage.unit_type("pawn"))).unwrap();
    stage.step(3);
    assert_eq!(due(&stage), Some(8));
    stage.tell(&switch(0)).unwrap();
    stage.step(15);
    assert_eq!((due(&stage), stage.all().len()), (None, 1));
    stage.step(1);
    assert_eq!(due(&stage), Some(24));
    stage.step(5);
    assert_eq!((due(&stage), stage.all().len()), (None, 2));
}

#[test]
fn of_two_who_are_ready_for_the_same_room_chance_decides() {
    // Two walled yards share the only doorway in which a unit has room.
    let rows = "........................\n..@@@@@@@@@.............\n..@...@...@.............\n..@.......@.............\n\
                ..@...@...@.............\n..@@@@@@@@@.............\n........................\n........................\n\
                ........................\n........................\n........................\n........................\n";
    let tables = TABLES
        .replace("width = 2\nheight = 2", "width = 2.8\nheight = 2.8")
        .replace("sight = 3", "sight = 1.2");
    let won: u32 = (0..200)
        .map(|seed| {
            let plan = Plan { tables: &tables, rows, seats: &["stock = 20", "stock = 20"], seed };
            let mut stage = plan.stage(&[own(0, "barracks", 4.5, 3.5), own(1, "barracks", 8.5, 3.5)]);
            let pawn = stage.unit_type("pawn");
            stage.tell(&train(0, pawn)).unwrap();
            stage.tell(&train(1, pawn)).unwrap();
            stage.step(8);
            assert_eq!(stage.all().len(), 3, "room for one");
            u32::from(stage.see(2).unwrap().owner == Some(Seat(0)))
        })
        .sum();
    assert!((70..=130).contains(&won), "the first seat got {won} of 200");
}

#[test]
fn who_trains_and_gathers_does_each_in_its_own_time() {
    let tables = format!(
        "{TABLES}[harvest]\npatch = 'mine'\n[unit.mine]\nradius = 0.5\nspeed = 0\npatch = {{ places = 1 }}\n\
         [unit.ship]\nradius = 0.25\nspeed = 4\nharvest = {{ load_max = 50, seconds_each = 0.5 }}\ntrains = ['pawn']\n"
    );
    let mut stage = Plan { tables: &tables, seats: &["stock = 200", ""], ..Plan::default() }
        .stage(&[own(0, "ship", 5.2, 6.0), nobodys("mine", 6.0, 6.0, 99)]);
    let pawn = stage.unit_type("pawn");
    stage.tell(&gather(0, 1)).unwrap();
    stage.step(2);
    stage.tell(&train(0, pawn)).unwrap();
    stage.tell(&train(0, pawn)).unwrap();
    let load = stage.load(0);
    stage.step(16);
    assert_eq!(stage.all().len(), 4, "two pawns in two seconds");
    assert_eq!(stage.load(0) - load, 4, "and four resources");
}
