mod combat;
mod damage;
mod harvest;
mod layers;
mod modes;
mod neutral;
mod objectives;
mod play;
mod production;
mod secrets;
pub(crate) mod stage;
mod training;

use std::sync::Arc;

use glam::DVec2;
use maniple_geometry::{Cycle, ObjectId};
use maniple_view::{Command, EndReason, Handle, Refusal, Seat, Shape, Stop, WAYPOINTS_MAX};

use super::World;
use crate::{Files, Loaded, LoadedFile, Overrides, load};

/// A map 24 wide and 6 high without a wall.
const PLAIN: &str = "........................\n........................\n........................\n\
                     ........................\n........................\n........................\n";

const ONE: &str = "groups = [{ unit = 'a', count = 1 }]";

/// Returns the files of a scenario `s/tiny.toml` on a map of `rows`. Its unit types are `a`, which goes half a world
/// unit a cycle, and `b`, which cannot move. `tables` goes before the seats, `seat` is the content of the first.
pub(crate) fn files(tables: &str, rows: &str, seat: &str) -> Files {
    let scenario = format!(
        "name = 'tiny'\nmap = '../m/tiny.map'\nrate = 8\nlength_seconds = 30\n{tables}\n\
         [objective]\nkind = 'race'\nzone_size = 2\n\
         [unit.a]\nradius = 0.25\nspeed = 4\nsight = 3\n\
         [unit.b]\nradius = 0.5\nspeed = 0\nsight = 3\n\
         [[seat]]\n{seat}\n"
    );
    let width = rows.lines().next().map_or(0, str::len);
    let map = format!("type octile\nheight {}\nwidth {width}\nmap\n{rows}", rows.lines().count());
    let file = |path: &str, text: String| LoadedFile { path: path.to_owned(), bytes: text.into_bytes() };
    Files(vec![file("s/tiny.toml", scenario), file("m/tiny.map", map)])
}

#[test]
fn every_command_is_taken_or_refused_with_its_reason() {
    let check = |command: Command, expected: Result<(), Refusal>| {
        let mut world = world(
            "",
            &format!(
                "{}\n[[seat]]\n{ONE}",
                "groups = [{ unit = 'a', count = 1 }, { unit = 'b', count = 1 }]"
            ),
        );
        world.step();
        assert_eq!(world.command(Seat(0), ObjectId(0), &command, None), expected, "{command:?}");
    };
    let go = |x, y, s| Command::Move { object: Handle(0), x, y, s, queue: false, start: None };
    let out = || Err(Refusal::OutOfWorld { width: 24, height: 6 });
    let bad = |field: &str, problem: &str| {
        Err(Refusal::BadNumber { field: field.to_owned(), problem: problem.to_owned() })
    };
    check(go(3.0, 3.0, None), Ok(()));
    check(go(3.0, 3.0, Some(0.5)), Ok(()));
    check(go(0.0, 6.0, Some(0.0)), Ok(()));
    check(go(3.0, 6.1, None), out());
    check(go(-0.1, 3.0, None), out());
    check(go(1e300, 3.0, None), out());
    check(go(f64::NAN, 3.0, None), bad("x", "is not a number"));
    check(go(3.0, f64::INFINITY, None), bad("y", "is infinite"));
    check(go(3.0, -0.0, None), bad("y", "is -0; write 0"));
    check(go(3.0, 3.0, Some(0.6)), Err(Refusal::TooFast { max: 0.5 }));
    check(go(3.0, 3.0, Some(1e9)), Err(Refusal::TooFast { max: 0.5 }));
    check(go(3.0, 3.0, Some(-1.0)), bad("s", "is -1; it must not be negative"));
    check(Command::Stop { object: Handle(0) }, Ok(()));
    check(Command::Resign, Ok(()));

    let start = |cycle, fraction| Command::Move {
        object: Handle(0),
        x: 3.0,
        y: 3.0,
        s: None,
        queue: false,
        start: Some((Cycle(cycle), fraction)),
    };
    check(start(1, 0.0), Ok(()));
    check(start(9, 0.5), Ok(()));
    check(start(0, 0.5), Err(Refusal::StartInPast { now: Cycle(1) }));
    check(start(2, 1.5), bad("start", "is 1.5; the largest allowed is 1"));
    check(start(2, f64::NAN), bad("start", "is not a number"));

    let queued = |s| Command::Move { object: Handle(0), x: 3.0, y: 3.0, s, queue: true, start: None };
    check(queued(None), Ok(()));
    check(queued(Some(0.0)), bad("s", "is 0, which stops at once; a stop cannot be queued"));

    let path = |points: Vec<_>| Command::Path { object: Handle(0), points, start: None };
    check(path(vec![(3.0, 3.0, None), (4.0, 3.0, Some(0.1))]), Ok(()));
    check(path(vec![(3.0, 3.0, None); WAYPOINTS_MAX]), Ok(()));
    check(path(vec![]), Err(Refusal::EmptyPath));
    check(path(vec![(3.0, 3.0, None); WAYPOINTS_MAX + 1]), Err(Refusal::TooManyWaypoints { max: 64 }));
    check(path(vec![(3.0, 3.0, None), (3.0, 7.0, None)]), out());
    check(path(vec![(3.0, 3.0, Some(0.0))]), bad("s", "is 0; a waypoint needs a speed"));
}

#[test]
fn only_own_living_objects_that_can_move_obey() {
    let mut world = world(
        "",
        &format!("groups = [{{ unit = 'a', count = 1 }}, {{ unit = 'b', count = 1 }}]\n[[seat]]\n{ONE}"),
    );
    let stop = Command::Stop { object: Handle(0) };
    assert_eq!(world.command(Seat(0), ObjectId(0), &stop, None), Ok(()));
    assert_eq!(world.command(Seat(0), ObjectId(1), &stop, None), Err(Refusal::UnknownAction));
    assert_eq!(world.command(Seat(0), ObjectId(2), &stop, None), Err(Refusal::UnknownHandle));
    assert_eq!(world.command(Seat(0), ObjectId(9), &stop, None), Err(Refusal::UnknownHandle));
    world.resign(Seat(0));
    assert_eq!(world.command(Seat(0), ObjectId(0), &stop, None), Err(Refusal::Out));
    world.step();
    assert_eq!(world.command(Seat(1), ObjectId(2), &stop, None), Err(Refusal::Out), "the match has ended");
}

#[test]
fn too_many_queued_moves_are_refused_and_change_nothing() {
    let mut world = world("", ONE);
    let queued = Command::Move { object: Handle(0), x: 3.0, y: 3.0, s: None, queue: true, start: None };
    let refused = (0..=WAYPOINTS_MAX + 1)
        .find_map(|_| world.command(Seat(0), ObjectId(0), &queued, None).err())
        .expect("a queue has an end");
    assert!(matches!(refused, Refusal::TooManyWaypoints { .. }), "{refused:?}");
}

#[test]
fn a_unit_goes_to_its_goal_at_the_speed_of_its_type_and_says_so() {
    let mut world = world("", ONE);
    let from = world.sightings(Seat(0))[0].base.point;
    let x = if from.x < 12.0 { from.x + 2.0 } else { from.x - 2.0 };
    let go = Command::Move { object: Handle(0), x, y: from.y, s: None, queue: false, start: None };
    world.command(Seat(0), ObjectId(0), &go, None).unwrap();
    world.step();
    assert_eq!(world.sightings(Seat(0))[0].base.velocity.length(), 0.5);
    for _ in 0..4 {
        world.step();
    }
    let unit = world.sightings(Seat(0))[0];
    assert!(!unit.base.is_moving());
    assert_eq!(unit.base.point, DVec2::new(x, from.y));
}

#[test]
fn walls_and_the_edge_of_the_map_are_told_apart() {
    let rows = format!("{}....@...................\n", "........................\n".repeat(5));
    let check = |toward: DVec2, expected: Stop| {
        let loaded = load(&files("", &rows, ONE), "s/tiny.toml", &Overrides::default()).unwrap();
        let mut world = World::new(&loaded).unwrap();
        let mut approach = |x: f64, y: f64| {
            let go = Command::Move { object: Handle(0), x, y, s: None, queue: false, start: None };
            world.command(Seat(0), ObjectId(0), &go, None).unwrap();
            (0..80).find_map(|_| {
                world.step();
                world.sightings(Seat(0))[0].stop
            })
        };
        assert_eq!(approach(0.5, 0.75), Some(Stop::Arrived));
        assert_eq!(approach(0.5, 5.5), Some(Stop::Arrived));
        assert_eq!(approach(toward.x, toward.y), Some(expected));
    };
    check(DVec2::new(8.0, 5.5), Stop::Segment);
    check(DVec2::new(0.5, 0.0), Stop::Edge);
    check(DVec2::new(0.5, 6.0), Stop::Edge);
    check(DVec2::new(0.0, 3.0), Stop::Edge);
}

#[test]
fn the_objects_of_who_resigns_die_at_the_end_of_the_cycle_before_those_who_saw_them() {
    let two = format!("{ONE}\n[[seat]]\n{ONE}\n[[seat]]\n{ONE}");
    let mut world = world("", &two);
    world.resign(Seat(1));
    world.resign(Seat(1));
    assert_eq!(world.sightings(Seat(0)).len(), 3);
    world.step();
    assert_eq!(world.died(Seat(0)), [ObjectId(1)]);
    assert_eq!(world.sightings(Seat(0)).len(), 2);
    assert_eq!(world.ending(), None);
    world.step();
    assert_eq!(world.died(Seat(0)), []);

    let mut world = super::tests::world("[vision]", &two);
    world.resign(Seat(1));
    world.step();
    assert_eq!(world.died(Seat(0)), [], "it was far away");
    assert_eq!(world.died(Seat(1)), [ObjectId(1)]);
    world.resign(Seat(0));
    world.step();
    assert_eq!(
        world.ending().map(|ending| (ending.reason, ending.winners.clone())),
        Some((EndReason::Resigned, vec![Seat(2)]))
    );
}

#[test]
fn the_hash_differs_as_soon_as_anything_differs() {
    let hash = |act: fn(&mut World)| {
        let mut world = world("", &format!("{ONE}\n[[seat]]\n{ONE}\n[[seat]]\n{ONE}"));
        act(&mut world);
        world.step();
        world.hash().0
    };
    let stop = |world: &mut World| {
        let go = Command::Move { object: Handle(0), x: 12.0, y: 3.0, s: None, queue: false, start: None };
        world.command(Seat(0), ObjectId(0), &go, None).unwrap();
    };
    let mut hashes = vec![
        hash(|_| ()),
        hash(stop),
        hash(|world| world.resign(Seat(0))),
        hash(|world| world.resign(Seat(1))),
        hash(World::step),
    ];
    assert_eq!(hash(stop), hashes[1]);
    hashes.sort_unstable();
    hashes.dedup();
    assert_eq!(hashes.len(), 5);
}

#[test]
fn the_match_ends_at_its_length() {
    let mut world = world("", &format!("{ONE}\n[[seat]]\n{ONE}"));
    while world.ending().is_none() {
        world.step();
    }
    let ending = world.ending().unwrap();
    assert_eq!((ending.reason, ending.cycles, &ending.winners[..]), (EndReason::Length, Cycle(240), &[][..]));
}

fn world(tables: &str, seats: &str) -> World {
    let loaded = load(&files(tables, PLAIN, seats), "s/tiny.toml", &Overrides::default()).unwrap();
    World::new(&loaded).unwrap()
}

#[test]
fn a_start_that_is_no_world_is_an_error_with_a_remedy() {
    let check = |alter: fn(&mut Loaded), named: &[&str]| {
        let mut loaded = load(&files("", PLAIN, ONE), "s/tiny.toml", &Overrides::default()).unwrap();
        alter(&mut loaded);
        let error = World::new(&loaded).err().map(|error| error.to_string()).unwrap();
        assert!(named.iter().all(|name| error.contains(name)), "{error} does not name {named:?}");
    };
    check(
        |loaded| Arc::make_mut(&mut loaded.scenario).unit_types[0].shape = Shape::Circle { radius: 1e9 },
        &["radius", "unit types"],
    );
    check(|loaded| loaded.setup.units[0].position = DVec2::ZERO, &["unit 0", "wall", "move the spawn"]);
}
