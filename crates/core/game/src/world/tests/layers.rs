//! What flies, and over what.

use glam::DVec2;
use maniple_geometry::ObjectId;
use maniple_view::{Refusal, Stop};

use super::stage::{Plan, attack, go, hold, own};

const TABLES: &str = "
[combat]
[unit.jet]
radius = 0.25
speed = 4
layer = 'air'
hit_points = 30
weapon = { range = 4, cooldown_seconds = 1, damage_min = 10, damage_max = 10, targets = ['ground'] }
[unit.tank]
radius = 0.25
speed = 4
hit_points = 30
weapon = { range = 4, cooldown_seconds = 1, damage_min = 10, damage_max = 10, targets = ['ground'] }
[unit.flak]
width = 2
height = 2
speed = 0
hit_points = 30
weapon = { range = 4, cooldown_seconds = 1, damage_min = 10, damage_max = 10, targets = ['air'] }
";

#[test]
fn who_flies_passes_over_walls_and_units_but_not_over_the_edge_nor_through_who_flies() {
    let rows = "........................\n".repeat(3)
        + &"........@@@.............\n".repeat(6)
        + &"........................\n".repeat(3);
    let check = |unit: &str, goal: (f64, f64), expected: Stop| {
        let mut stage = Plan { tables: TABLES, rows: &rows, ..Plan::default() }.stage(&[
            own(0, unit, 3.0, 6.0),
            own(0, "tank", 5.0, 6.0),
            own(1, "flak", 14.0, 6.0),
            own(1, "jet", 20.0, 6.0),
        ]);
        stage.tell(&go(0, goal.0, goal.1)).unwrap();
        stage.step_until(|stage| !stage.is_moving(0) && stage.world.cycle().0 > 0);
        assert_eq!(stage.see(0).unwrap().stop, Some(expected), "{unit} {goal:?} {}", stage.place(0));
        if expected == Stop::Arrived {
            assert_eq!(stage.place(0), DVec2::from(goal));
        }
    };
    check("jet", (18.0, 6.0), Stop::Arrived);
    check("jet", (9.5, 6.0), Stop::Arrived);
    check("jet", (5.0, 6.0), Stop::Arrived);
    check("jet", (14.0, 6.0), Stop::Arrived);
    check("jet", (23.0, 6.0), Stop::Object(Some(ObjectId(3))));
    check("jet", (3.0, 12.0), Stop::Edge);
    check("jet", (0.0, 6.0), Stop::Edge);
    check("tank", (18.0, 6.0), Stop::Object(Some(ObjectId(1))));
    check("tank", (9.5, 8.0), Stop::Segment);
}

#[test]
fn a_weapon_hits_only_in_its_layers() {
    let check = |shooter: &str, target: &str, expected: bool| {
        let mut stage = Plan { tables: TABLES, ..Plan::default() }
            .stage(&[own(0, shooter, 6.0, 6.0), own(1, target, 9.0, 6.0)]);
        let refusal = if expected { Ok(()) } else { Err(Refusal::BadTarget) };
        assert_eq!(stage.tell(&attack(0, 1)), refusal, "{shooter} {target}");
        stage.tell(&hold(0)).unwrap();
        stage.step(2);
        assert_eq!(stage.hit_points(1), if expected { 20 } else { 30 }, "{shooter} {target}");
    };
    check("tank", "jet", false);
    check("tank", "tank", true);
    check("flak", "jet", true);
    check("flak", "tank", false);
    check("jet", "flak", true);
    check("jet", "jet", false);
}

#[test]
fn who_flies_over_its_target_is_in_range() {
    let mut stage = Plan { tables: TABLES, ..Plan::default() }.stage(&[
        own(0, "jet", 6.0, 6.0),
        own(1, "flak", 6.0, 6.0),
        own(1, "tank", 6.0, 8.0),
    ]);
    stage.tell(&attack(0, 1)).unwrap();
    stage.step(1);
    assert_eq!(stage.hit_points(1), 20);
    stage.tell(&hold(1)).unwrap();
    stage.step(1);
    assert_eq!(stage.hit_points(0), 20);
}
