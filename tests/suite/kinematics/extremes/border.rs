//! What no world accepts, in every field that takes a number: refused by name.

use glam::DVec2;
use maniple_geometry::limits::{COORDINATE_MAX, RADIUS_MAX, RADIUS_MIN, SPEED_MAX, SPEED_MIN, TINY};
use maniple_geometry::{Circle, Cycle, Limits, Moment, NumberError, ObjectId, Segment};
use maniple_kinematics::{
    InsertError, Layers, Leg, OrderError, Placement, Stops, Wall, WallError, WallKind, World,
};

/// What is refused in every field: the name of the problem follows from the number.
const NEVER: [f64; 11] = [
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    -0.0,
    5e-324,
    -5e-324,
    f64::MIN_POSITIVE,
    1e-310,
    1e-30,
    1e308,
    f64::MAX,
];

/// Puts a number into a field and returns the field and the problem that the world names, if it refuses.
type Field = (&'static str, fn(&mut World, f64) -> Option<(&'static str, NumberError)>);

const FIELDS: [Field; 10] = [
    ("x", |world, x| inserted(world, DVec2::new(x, 9.0), 1.0)),
    ("y", |world, y| inserted(world, DVec2::new(9.0, y), 1.0)),
    ("r", |world, r| inserted(world, DVec2::new(9.0, 9.0), r)),
    ("x", |world, x| teleported(world, DVec2::new(x, 9.0))),
    ("x", |world, x| ordered(world, DVec2::new(x, 9.0), (1.0, 0.0))),
    ("y", |world, y| ordered(world, DVec2::new(9.0, y), (1.0, 0.0))),
    ("s", |world, s| ordered(world, DVec2::new(9.0, 9.0), (s, 0.0))),
    ("start", |world, start| ordered(world, DVec2::new(9.0, 9.0), (1.0, start))),
    ("x1", |world, x| walled(world, DVec2::new(x, 30.0), DVec2::new(30.0, 40.0))),
    ("y2", |world, y| walled(world, DVec2::new(30.0, 30.0), DVec2::new(40.0, y))),
];

#[test]
fn numbers_that_no_world_accepts_are_refused_by_name_in_every_field() {
    let mut refusals = 0;
    for (field, put) in FIELDS {
        for number in NEVER {
            let mut world = world();
            let (named, problem) =
                put(&mut world, number).unwrap_or_else(|| panic!("{field} = {number:e} was accepted"));
            assert_eq!(named, field, "{number:e}");
            let is_named = match problem {
                NumberError::NotANumber => number.is_nan(),
                NumberError::Infinite => number.is_infinite(),
                NumberError::NegativeZero => number.to_bits() == (-0.0f64).to_bits(),
                NumberError::Tiny(value) => value == number && number.abs() < TINY,
                NumberError::TooLarge { value, .. } => value == number && number >= 1e308,
                NumberError::Negative(_) | NumberError::NotPositive(_) | NumberError::TooSmall { .. } => {
                    false
                }
            };
            assert!(is_named, "{field} = {number:e}: {problem:?}");
            assert!(!problem.to_string().is_empty());
            assert_eq!(world.len(), 1, "nothing changed");
            refusals += 1;
        }
    }
    println!("class border: {refusals} numbers refused by name");
}

#[test]
fn the_border_of_each_range_is_inside_and_the_next_number_is_not() {
    let too_large = |value: f64, limit: f64| Some(NumberError::TooLarge { value, limit });
    let check = |field: usize, number: f64, expected: Option<NumberError>| {
        let found = FIELDS[field].1(&mut world(), number).map(|(_, problem)| problem);
        assert_eq!(found, expected, "{} = {number:e}", FIELDS[field].0);
    };
    for field in [0, 1, 3, 4, 5] {
        for (sign, limit) in [(1.0, 1e6), (-1.0, 1e6)] {
            check(field, sign * limit, None);
            check(field, sign * 1e6f64.next_up(), too_large(sign * 1e6f64.next_up(), limit));
        }
        check(field, TINY, None);
        check(field, -TINY, None);
        check(field, 0.0, None);
    }
    check(2, RADIUS_MIN, None);
    check(
        2,
        RADIUS_MIN.next_down(),
        Some(NumberError::TooSmall { value: RADIUS_MIN.next_down(), limit: RADIUS_MIN }),
    );
    check(2, 1e3f64.next_up(), too_large(1e3f64.next_up(), 1e3));
    check(6, SPEED_MIN, None);
    check(
        6,
        SPEED_MIN.next_down(),
        Some(NumberError::TooSmall { value: SPEED_MIN.next_down(), limit: SPEED_MIN }),
    );
    check(6, 1e4, None);
    check(6, 1e4f64.next_up(), too_large(1e4f64.next_up(), 1e4));
    check(7, 1.0, None);
    check(7, 1f64.next_up(), too_large(1f64.next_up(), 1.0));
}

#[test]
fn limits_are_taken_up_to_their_own_limits() {
    assert!(Limits::new(1e6, 1e3, 1e4).is_ok(), "what is promised");
    assert!(Limits::new(COORDINATE_MAX, RADIUS_MAX, SPEED_MAX).is_ok(), "the largest");
    let check = |numbers: [f64; 3], named: &str| {
        let refused = Limits::new(numbers[0], numbers[1], numbers[2]).map_err(|(name, _)| name);
        assert_eq!(refused, Err(named), "{numbers:?}");
    };
    for number in NEVER.into_iter().chain([0.0, -1.0, COORDINATE_MAX.next_up()]) {
        check([number, 1.0, 1.0], "coordinate limit");
        check([1.0, number, 1.0], "radius limit");
        check([1.0, 1.0, number], "speed limit");
    }
}

fn world() -> World {
    let limits = Limits::new(1e6, 1e3, 1e4).expect("good limits");
    let mut world = World::new(limits, Stops::Both, &[]).expect("no walls");
    world.insert(ObjectId(1), Circle::new(DVec2::splat(100.0), 0.5), Layers::GROUND).expect("free");
    world
}

fn inserted(world: &mut World, center: DVec2, radius: f64) -> Option<(&'static str, NumberError)> {
    named(world.insert(ObjectId(2), Circle::new(center, radius), Layers::GROUND))
}

fn teleported(world: &mut World, center: DVec2) -> Option<(&'static str, NumberError)> {
    named(world.teleport(ObjectId(1), center))
}

fn named(result: Result<(), InsertError>) -> Option<(&'static str, NumberError)> {
    match result {
        Err(InsertError::BadNumber { field, problem }) => Some((field, problem)),
        other => {
            assert_eq!(other, Ok(()));
            None
        }
    }
}

fn ordered(
    world: &mut World,
    goal: DVec2,
    (speed, fraction): (f64, f64),
) -> Option<(&'static str, NumberError)> {
    let start = Some(Moment { cycle: Cycle(0), fraction });
    match world.go(ObjectId(1), &[Leg { goal, speed }], Placement::Replace, start) {
        Err(OrderError::BadNumber { field, problem }) => Some((field, problem)),
        other => {
            assert_eq!(other, Ok(()));
            None
        }
    }
}

fn walled(world: &mut World, start: DVec2, end: DVec2) -> Option<(&'static str, NumberError)> {
    let wall = Wall { segment: Segment::new(start, end), kind: WallKind::Segment, layers: Layers::GROUND };
    match world.insert_wall(wall) {
        Err(WallError::BadNumber { field, problem, .. }) => Some((field, problem)),
        other => {
            assert!(other.is_ok(), "{other:?}");
            None
        }
    }
}
