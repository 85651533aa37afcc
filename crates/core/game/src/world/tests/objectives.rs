//! What ends a match, and who has won; teams, and who leaves.

use maniple_geometry::ObjectId;
use maniple_view::{Command, EndOfTask, EndReason, Refusal, Seat, Task};

use super::stage::{Plan, Stage, Stand, attack, go, own};

const TABLES: &str = "
[combat]
[unit.gun]
radius = 0.25
speed = 4
sight = 4
hit_points = 10
weapon = { range = 20, cooldown_seconds = 0, damage_min = 10, damage_max = 10 }
[unit.flag]
radius = 0.25
speed = 4
hit_points = 10
[unit.house]
width = 2
height = 2
speed = 0
hit_points = 10
";

/// Plays to the end; in cycle 1, 2 and so on the shooters fire at the targets of these lists.
fn played(objective: &str, seats: &[&str], stands: &[Stand<'_>], shots: &[&[(u32, u32)]]) -> Stage {
    let tables = format!("{TABLES}\n[objective]\n{objective}\n");
    let mut stage = Plan { tables: &tables, seats, ..Plan::default() }.stage(stands);
    for shots in shots {
        stage.step(1);
        for &(shooter, target) in *shots {
            assert_eq!(stage.tell(&attack(shooter, target)), Ok(()), "{shooter} {target}");
        }
    }
    stage.step(1000);
    stage
}

#[test]
fn each_objective_is_decided_drawn_or_goes_on_to_the_length() {
    /// A gun, a flag and a house a seat: 0 to 2, 3 to 5, 6 to 8.
    fn stands(seats: u16) -> Vec<Stand<'static>> {
        let of = |seat: u16| {
            let y = 2.0 + 3.5 * f64::from(seat);
            [own(seat, "gun", 4.0, y), own(seat, "flag", 8.0, y), own(seat, "house", 12.0, y)]
        };
        (0..seats).flat_map(of).collect()
    }
    let check =
        |objective: &str, shots: &[&[(u32, u32)]], reason: EndReason, cycles: u32, winners: &[u16]| {
            let stage = played(objective, &["", ""], &stands(2), shots);
            assert_eq!(stage.ending(), Some((reason, winners.to_vec())), "{objective} {shots:?}");
            assert_eq!(stage.world.ending().unwrap().cycles.0, cycles, "{objective} {shots:?}");
        };
    let (objective, length) = (EndReason::Objective, EndReason::Length);

    let kills = "kind = 'kills'";
    check(kills, &[], length, 480, &[]);
    check(kills, &[&[(0, 4)]], length, 480, &[0]);
    check(kills, &[&[(0, 4), (3, 1)]], length, 480, &[]);
    check(kills, &[&[(0, 5)]], length, 480, &[]);
    check(kills, &[&[(0, 4)], &[(0, 3)]], objective, 3, &[0]);
    check(kills, &[&[(3, 1)], &[(3, 0)]], objective, 3, &[1]);
    check(kills, &[&[(0, 4), (3, 1)], &[(0, 3), (3, 0)]], objective, 3, &[]);

    let buildings = "kind = 'buildings'";
    check(buildings, &[], length, 480, &[]);
    check(buildings, &[&[(0, 4)], &[(0, 3)]], length, 480, &[]);
    check(buildings, &[&[(0, 5)]], objective, 2, &[0]);
    check(buildings, &[&[], &[(3, 2)]], objective, 3, &[1]);
    check(buildings, &[&[(0, 5), (3, 2)]], objective, 2, &[]);

    let last = "kind = 'last_standing'";
    check(last, &[], length, 480, &[]);
    check(last, &[&[(0, 4)]], length, 480, &[]);
    check(last, &[&[(0, 4)], &[(0, 3)]], length, 480, &[]);
    check(last, &[&[(0, 4)], &[(0, 3)], &[(0, 5)]], objective, 4, &[0]);

    let survive = "kind = 'survive'\nteam = 1";
    check(survive, &[], length, 480, &[1]);
    check(survive, &[&[(0, 4)], &[(0, 5)]], length, 480, &[1]);
    check(survive, &[&[(0, 4)], &[(0, 5)], &[(0, 3)]], objective, 4, &[0]);
    check(survive, &[&[(3, 1)], &[(3, 2)], &[(3, 0)]], length, 480, &[1]);

    let check = |objective_text: &str, shots: &[&[(u32, u32)]], reason: EndReason, winners: &[u16]| {
        let stage = played(objective_text, &["", "", ""], &stands(3), shots);
        assert_eq!(stage.ending(), Some((reason, winners.to_vec())), "{objective_text} {shots:?}");
    };
    check(buildings, &[&[(0, 5)]], length, &[0]);
    check(buildings, &[&[(0, 5)], &[(6, 2)]], objective, &[2]);
    // Of as many buildings the one that was destroyed sooner counts.
    check(buildings, &[&[(3, 8)], &[(6, 5)]], objective, &[0]);
    check(survive, &[&[(0, 4)], &[(0, 5)], &[(0, 3)]], objective, &[]);
    check(survive, &[&[(0, 4), (3, 1)], &[(0, 5)], &[(0, 3)]], objective, &[2]);
}

#[test]
fn at_the_length_more_buildings_win_and_among_equals_the_sooner() {
    let stands = [
        own(0, "gun", 2.0, 2.0),
        own(1, "gun", 2.0, 10.0),
        own(0, "house", 6.0, 2.0),
        own(0, "house", 9.0, 2.0),
        own(1, "house", 6.0, 10.0),
        own(1, "house", 9.0, 10.0),
    ];
    let check = |shots: &[&[(u32, u32)]], winners: &[u16]| {
        let stage = played("kind = 'buildings'", &["", ""], &stands, shots);
        assert_eq!(stage.ending(), Some((EndReason::Length, winners.to_vec())), "{shots:?}");
    };
    check(&[&[(0, 4)]], &[0]);
    check(&[&[(1, 2)]], &[1]);
    check(&[&[(0, 4)], &[(1, 2)]], &[0]);
    check(&[&[(1, 2)], &[(0, 4)]], &[1]);
    check(&[&[(1, 2), (0, 4)]], &[]);
}

#[test]
fn a_team_wins_together_and_shares_what_it_sees() {
    let stands = [
        own(0, "flag", 2.0, 2.0),
        own(2, "gun", 20.0, 10.0),
        own(1, "flag", 22.0, 8.0),
        own(1, "gun", 22.0, 10.0),
    ];
    let tables = format!("[vision]\n{TABLES}\n[objective]\nkind = 'last_standing'\n");
    let plan = Plan { tables: &tables, seats: &["team = 5", "", "team = 5"], ..Plan::default() };
    let mut stage = plan.stage(&stands);
    let seen = |stage: &Stage, seat: u16| -> Vec<u32> {
        stage.world.sightings(Seat(seat)).iter().map(|sighting| sighting.object.0).collect()
    };
    assert_eq!([0, 1, 2].map(|seat| seen(&stage, seat)), [vec![0, 1, 2, 3], vec![1, 2, 3], vec![0, 1, 2, 3]]);
    assert_eq!(stage.tell_as(0, &go(1, 3.0, 3.0)), Err(Refusal::UnknownHandle), "seen, and not commanded");
    stage.tell(&attack(1, 2)).unwrap();
    stage.step(1);
    assert_eq!([0, 1].map(|seat| stage.world.died(Seat(seat))), [[ObjectId(2)], [ObjectId(2)]]);
    stage.tell(&attack(1, 3)).unwrap();
    stage.step(1);
    assert_eq!(stage.ending(), Some((EndReason::Objective, vec![0, 2])));
    let team_one = |stage: &Stage| [0, 1, 2].map(|seat| stage.world.team(Seat(seat)));
    assert_eq!(team_one(&stage), [5, 1, 5]);
}

#[test]
fn the_eyes_of_who_has_resigned_are_gone_but_not_those_of_its_team() {
    let stands = [own(0, "flag", 2.0, 2.0), own(2, "gun", 20.0, 10.0), own(1, "flag", 22.0, 8.0)];
    let tables = format!("[vision]\n{TABLES}");
    let plan = Plan { tables: &tables, seats: &["team = 5", "", "team = 5"], ..Plan::default() };
    let mut stage = plan.stage(&stands);
    stage.tell_as(2, &Command::Resign).unwrap();
    stage.step(1);
    assert_eq!(stage.world.sightings(Seat(0)).len(), 1, "its units were the eyes of the team");
    assert_eq!(stage.world.sightings(Seat(2)).len(), 1, "and it still sees what its team sees");
    assert_eq!(stage.ending(), None);
}

#[test]
fn who_resigns_has_still_fought_in_the_cycle_and_counts_for_nobody() {
    let tables = format!("{TABLES}\n[objective]\nkind = 'kills'\n");
    let plan = Plan { tables: &tables, seats: &["", "", ""], ..Plan::default() };
    let mut stage = plan.stage(&[
        own(0, "gun", 2.0, 2.0),
        own(1, "gun", 2.0, 6.0),
        own(1, "house", 6.0, 6.0),
        own(2, "gun", 2.0, 10.0),
        own(2, "flag", 6.0, 10.0),
        own(0, "gun", 4.0, 2.0),
    ]);
    stage.tell(&attack(1, 4)).unwrap();
    stage.tell(&attack(0, 2)).unwrap();
    stage.tell(&attack(5, 1)).unwrap();
    assert_eq!(stage.tell_as(1, &Command::Resign), Ok(()));
    assert_eq!(stage.tell_as(1, &go(1, 3.0, 3.0)), Err(Refusal::Out));
    assert_eq!(stage.tell_as(1, &Command::Resign), Err(Refusal::Out));
    stage.step(1);
    assert_eq!(stage.all().keys().map(|id| id.0).collect::<Vec<_>>(), [0, 3, 5]);
    assert_eq!(stage.shots.len(), 3);
    assert_eq!(stage.ended, [(0, 0, Task::Attack, EndOfTask::Done), (0, 5, Task::Attack, EndOfTask::Done)]);
    let tallies = [0, 1, 2].map(|seat| stage.world.tally(Seat(seat)));
    assert_eq!([tallies[0].units_destroyed, tallies[0].buildings_destroyed], [1, 1], "shot before it left");
    assert_eq!([tallies[1].units_lost, tallies[1].buildings_lost, tallies[1].units_destroyed], [1, 1, 1]);
    assert!(stage.world.is_out(Seat(1)));
    assert_eq!(stage.ending(), None);
}

#[test]
fn who_is_out_cannot_win_and_resigning_counts_before_the_objective() {
    let stands = [own(0, "gun", 2.0, 2.0), own(1, "gun", 2.0, 6.0)];
    let check = |resign: &[u16], winners: &[u16]| {
        let tables = format!("{TABLES}\n[objective]\nkind = 'last_standing'\n");
        let mut stage = Plan { tables: &tables, ..Plan::default() }.stage(&stands);
        stage.tell(&attack(0, 1)).unwrap();
        for &seat in resign {
            stage.tell_as(seat, &Command::Resign).unwrap();
        }
        stage.step(1);
        let reason = if resign.is_empty() { EndReason::Objective } else { EndReason::Resigned };
        assert_eq!(stage.ending(), Some((reason, winners.to_vec())), "{resign:?}");
        assert_eq!(stage.tell_as(0, &Command::Resign), Err(Refusal::Out));
    };
    check(&[], &[0]);
    check(&[1], &[0]);
    check(&[0], &[1]);
    check(&[0, 1], &[]);
}

#[test]
fn a_race_counts_whose_centre_is_in_the_zone_border_included_and_once() {
    let tables = format!("{TABLES}\n[objective]\nkind = 'race'\nzone_size = 2\n");
    let stands = [own(0, "flag", 12.0, 6.0), own(0, "flag", 12.0, 8.0), own(1, "flag", 12.0, 3.0)];
    let mut stage = Plan { tables: &tables, ..Plan::default() }.stage(&stands);
    let rules = stage.world.rules(Vec::new());
    let maniple_view::Objective::Race { zones } = rules.objective else { panic!("a race has zones") };
    let zone = zones[0];
    assert_eq!(stage.world.points(), [0, 0]);
    let inner = if zone.min.x > 12.0 { zone.min.x } else { zone.max.x };
    let y = (zone.min.y + zone.max.y) / 2.0;
    stage.tell(&go(0, inner, y)).unwrap();
    let arrived = stage.step_until(|stage| stage.world.tally(Seat(0)).arrived == 1);
    assert_eq!(stage.place(0).x, inner);
    assert_eq!(stage.world.tally(Seat(0)).arrival_sum, u64::from(arrived - 1));
    stage.tell(&go(0, 12.0, 6.0)).unwrap();
    stage.step(20);
    stage.tell(&go(0, inner, y)).unwrap();
    stage.step(40);
    assert_eq!(stage.world.points(), [1, 0], "once");
    assert_eq!(stage.ending(), None);
}

#[test]
fn an_objective_of_fights_where_nobody_fights_is_refused() {
    let check = |kind: &str, combat: &str, expected: bool| {
        let text = format!(
            "name = 'x'\nmap = 'x.map'\nlength_seconds = 1\n{combat}\n[objective]\nkind = '{kind}'\n\
             [unit.a]\nradius = 0.25\nspeed = 1\n[[seat]]\ngroups = [{{ unit = 'a', count = 1 }}]\n"
        );
        let error = crate::Scenario::read("x.toml", &text).err().map(|error| error.to_string());
        assert_eq!(error.is_none(), expected, "{kind} {combat} {error:?}");
        assert!(error.is_none_or(|error| error.contains("means nothing without a table [combat]")));
    };
    for kind in ["kills", "buildings"] {
        check(kind, "", false);
        check(kind, "[combat]", true);
    }
    for kind in ["last_standing", "resources"] {
        check(kind, "", true);
    }
}
