//! What the rules do for a seat says nothing of what it does not see.

use maniple_geometry::ObjectId;
use maniple_view::{Command, EndOfTask, Own, Refusal, Seat, Sighting, Status, Stop, Task};

use super::play::{Dice, TABLES};
use super::stage::{
    Plan, Stage, Stand, attack, cancel, gather, go, hold, nobodys, own, return_load, switch, train,
};

/// All that a seat is told of a cycle, without the numbers of objects, which it never learns.
type Told = (Vec<((f64, f64), Status, Own)>, usize, u32, Vec<(Task, EndOfTask)>);

fn told(stage: &Stage) -> Told {
    let now = stage.world.cycle();
    let seen = stage.world.sightings(Seat(0));
    let of = |it: &Sighting| (it.base.position(now).into(), it.status, it.own);
    let is_own = |id: &ObjectId| seen.iter().any(|it| it.object == *id && it.owner == Some(Seat(0)));
    let ended =
        stage.world.ended().iter().filter(|(id, ..)| is_own(id)).map(|&(_, task, why)| (task, why)).collect();
    (seen.iter().map(of).collect(), stage.world.died(Seat(0)).len(), stage.stock(0), ended)
}

#[test]
fn a_seat_is_told_the_same_whatever_goes_on_out_of_its_sight() {
    let rows = "................................................................\n".repeat(12);
    let tables = format!("[vision]\n{TABLES}");
    let plan =
        |seed: u64| Plan { tables: &tables, rows: &rows, seats: &["stock = 300", "stock = 300"], seed };
    let base = |seat: u16, x: f64| -> Vec<Stand<'_>> {
        let mut stands =
            vec![own(seat, "house", x, 2.0), own(seat, "hut", x, 9.0), nobodys("ore", x, 6.0, 20)];
        stands.extend((0..4).map(|place| own(seat, "worker", x - 1.5 + f64::from(place), 4.0)));
        stands.extend([own(seat, "tank", x, 7.5), own(seat, "jet", x, 5.0)]);
        stands
    };
    let stands = [base(0, 8.0), base(1, 56.0)].concat();
    /// Commands to the objects of a base, which begin with this number, of a seat whose base is at x.
    fn command(dice: &mut Dice, stage: &Stage, first: u32, x: f64) -> Command {
        let worker = first + 3 + dice.below(4);
        let (x, y) = (x - 4.0 + dice.coordinate(8), dice.coordinate(12));
        match dice.below(9) {
            0 => go(first + 3 + dice.below(6), x, y),
            1 | 2 => gather(worker, first + 2),
            3 => return_load(worker),
            4 => super::stage::build(worker, stage.unit_type("house"), x, y),
            5 => train(first, stage.unit_type(dice.one(&["worker", "tank", "jet"]))),
            6 => dice.one(&[cancel as fn(u32) -> Command, hold])(first),
            7 => switch(first + 7),
            _ => attack(first + 7, first + dice.below(9)),
        }
    }
    for seed in 0..12 {
        println!("with seed {seed}");
        let mut stages = [plan(seed).stage(&stands), plan(seed).stage(&stands)];
        let (mut dice, mut hidden) = (Dice::new(seed), Dice::new(seed + 1000));
        for cycle in 0..300 {
            let orders: Vec<Command> =
                (0..dice.below(3)).map(|_| command(&mut dice, &stages[0], 0, 8.0)).collect();
            let secret: Vec<Command> =
                (0..hidden.below(3)).map(|_| command(&mut hidden, &stages[0], 9, 56.0)).collect();
            let answers: Vec<Vec<Result<(), Refusal>>> = stages
                .iter_mut()
                .map(|stage| orders.iter().map(|order| stage.tell_as(0, order)).collect())
                .collect();
            assert_eq!(answers[0], answers[1], "cycle {cycle}: {orders:?}");
            for order in &secret {
                // Most are refused for one reason or another.
                let _ = stages[1].tell_as(1, order);
            }
            stages.iter_mut().for_each(|stage| stage.step(1));
            let [one, other] = [&stages[0], &stages[1]].map(told);
            assert_eq!(one, other, "cycle {cycle}");
        }
        assert_ne!(stages[0].world.hash(), stages[1].world.hash(), "the worlds differ");
        assert!(stages[0].world.sightings(Seat(0)).iter().all(|it| it.owner != Some(Seat(1))));
    }
}

#[test]
fn who_is_not_seen_does_not_decide_where_a_unit_appears() {
    let check = |sight: f64, is_made: bool| {
        let tables = format!(
            "[vision]\n[production]\n[unit.hall]\nwidth = 2\nheight = 2\nspeed = 0\nsight = {sight}\n\
             trains = ['pawn']\n[unit.pawn]\nradius = 0.25\nspeed = 1\nmake_seconds = 1\n"
        );
        let appeared = |others: &[Stand<'_>]| {
            let stands = [&[own(0, "hall", 6.0, 6.0)], others].concat();
            let mut stage = Plan { tables: &tables, ..Plan::default() }.stage(&stands);
            assert_eq!(stage.world.sightings(Seat(0)).len(), 1, "nobody is in sight");
            stage.tell(&train(0, stage.unit_type("pawn"))).unwrap();
            stage.step(8);
            let of_seat = stage.world.sightings(Seat(0)).into_owned();
            of_seat.iter().filter(|it| it.owner == Some(Seat(0))).map(|it| it.base.point).next_back()
        };
        // The nearest place above the hall is 0.4375 from it; its neighbour stands just out of sight.
        let y = 4.75 - sight - 1e-9;
        let alone = appeared(&[]);
        assert_eq!(alone, appeared(&[own(1, "pawn", 6.0, y)]), "{sight}");
        assert_eq!(alone != Some(glam::DVec2::new(6.0, 6.0)), is_made, "{sight}");
    };
    check(0.9, false);
    check(0.95, false);
    check(0.999, false);
    check(1.0, true);
    check(1.1, true);
}

#[test]
fn the_luck_of_a_unit_does_not_depend_on_what_others_make() {
    let tables = "[combat]\n[production]\n[unit.hall]\nwidth = 2\nheight = 2\nspeed = 0\ntrains = ['gun']\n\
         [unit.gun]\nradius = 0.25\nspeed = 1\nmake_seconds = 1\n\
         weapon = { range = 12, cooldown_seconds = 0, damage_min = 0, damage_max = 99 }\n\
         [unit.butt]\nradius = 0.5\nspeed = 0\nhit_points = 100000\n";
    let hit_points = |others_make: bool| {
        let mut stage = Plan { tables, ..Plan::default() }.stage(&[
            own(0, "hall", 6.0, 6.0),
            own(1, "hall", 20.0, 6.0),
            nobodys("butt", 6.0, 2.0, 0),
        ]);
        if others_make {
            stage.tell(&train(1, stage.unit_type("gun"))).unwrap();
        }
        stage.step(2);
        stage.tell(&train(0, stage.unit_type("gun"))).unwrap();
        stage.step(8);
        let all = stage.all();
        let is_own_gun = |it: &&Sighting| it.owner == Some(Seat(0)) && it.object != ObjectId(0);
        let gun = all.values().find(is_own_gun).unwrap().object.0;
        stage.tell(&attack(gun, 2)).unwrap();
        let hit_points: Vec<u32> = (0..20)
            .map(|_| {
                stage.step(1);
                stage.hit_points(2)
            })
            .collect();
        (gun, hit_points)
    };
    let ((one, alone), (other, beside)) = (hit_points(false), hit_points(true));
    assert_ne!(one, other, "it has another number");
    assert_eq!(alone, beside);
}

#[test]
fn where_what_is_nobodys_wanders_does_not_depend_on_how_many_others_there_are() {
    let tables = "[neutral]\ngroups = [{ unit = 'sheep', count = 1 }]\nwander = 2\npause_seconds = 1\n\
                  [unit.sheep]\nradius = 0.25\nspeed = 2\n";
    let sheep = [nobodys("sheep", 6.0, 6.0, 0), nobodys("sheep", 12.0, 6.0, 0)];
    let places = |others: &[Stand<'_>]| {
        let stands = [others, &sheep].concat();
        let mut stage = Plan { tables, ..Plan::default() }.stage(&stands);
        stage.step(40);
        let objects = stage.world.objects().iter();
        objects.filter(|it| it.owner.is_none()).map(|it| it.base.point).collect::<Vec<_>>()
    };
    let alone = places(&[]);
    assert_eq!(alone.len(), 2);
    assert_eq!(alone, places(&[own(1, "post", 22.0, 1.0), own(1, "post", 22.0, 11.0)]));
}

#[test]
fn who_runs_into_two_at_the_same_moment_is_told_of_neither() {
    let tables = "[unit.pawn]\nradius = 0.25\nspeed = 4\n";
    for (others, expected) in [
        (&[own(1, "pawn", 9.0, 5.625), own(1, "pawn", 9.0, 6.375)][..], None),
        (&[own(1, "pawn", 9.0, 5.625), own(1, "pawn", 9.25, 6.375)][..], Some(ObjectId(1))),
    ] {
        let mut stage =
            Plan { tables, ..Plan::default() }.stage(&[&[own(0, "pawn", 6.0, 6.0)], others].concat());
        stage.tell(&go(0, 12.0, 6.0)).unwrap();
        stage.step_until(|stage| !stage.is_moving(0) && stage.world.cycle().0 > 0);
        assert_eq!(stage.see(0).unwrap().stop, Some(Stop::Object(expected)), "{others:?}");
    }
}

#[test]
fn a_shot_is_told_to_those_who_saw_who_fired_and_the_target_when_it_was_fired() {
    let tables = "[vision]\n[combat]\n[unit.scout]\nradius = 0.25\nspeed = 4\nsight = 3\nhit_points = 1000\n\
                  [unit.gun]\nradius = 0.25\nspeed = 1\nsight = 15\nhit_points = 10\n\
                  weapon = { range = 14, cooldown_seconds = 0.125, damage_min = 1, damage_max = 1 }\n";
    let stands = [own(0, "scout", 6.0, 6.0), own(1, "gun", 14.0, 6.0)];
    let mut stage = Plan { tables, ..Plan::default() }.stage(&stands);
    stage.tell(&go(0, 13.0, 6.0)).unwrap();
    stage.tell(&hold(1)).unwrap();
    let gun = ObjectId(1);
    let sees = |stage: &Stage| stage.world.sightings(Seat(0)).iter().any(|it| it.object == gun);
    let (mut unseen, mut came, mut seen) = (0, 0, 0);
    for _ in 0..20 {
        let saw = sees(&stage);
        stage.step(1);
        let shot = (gun, Some(ObjectId(0)));
        assert_eq!(stage.world.shots(Seat(1)), stage.world.fired(), "it is its own");
        if !stage.world.fired().contains(&shot) {
            continue;
        }
        assert_eq!(stage.world.shots(Seat(0)).contains(&shot), saw, "cycle {}", stage.world.cycle());
        match (saw, sees(&stage)) {
            (false, false) => unseen += 1,
            (false, true) => came += 1,
            (true, _) => seen += 1,
        }
    }
    assert!(unseen > 0 && came == 1 && seen > 0, "{unseen} {came} {seen}");
}
