//! What is refused, and how.

use glam::DVec2;
use maniple_geometry::{Circle, NumberError};
use maniple_tilemap::Area;

use super::drawn;
use crate::{Field, Ground, GroundError, MARGIN, Obstacle, Obstacles, PlanError, Planner, RADIUS_MAX, Which};

const RADIUS: f64 = 0.4;

fn point(x: f64, y: f64) -> DVec2 {
    DVec2::new(x, y)
}

#[test]
fn what_is_no_radius_or_no_margin_is_refused() {
    let map = drawn(&["..."]);
    let cases = [
        (f64::NAN, NumberError::NotANumber),
        (0.0, NumberError::NotPositive(0.0)),
        (-1.0, NumberError::NotPositive(-1.0)),
        (4.5, NumberError::TooLarge { value: 4.5, limit: RADIUS_MAX }),
    ];
    for (radius, problem) in cases {
        let error = Ground::new(&map, radius).unwrap_err();
        if radius.is_nan() {
            assert!(error.to_string().contains("not a number"), "{error}");
        } else {
            assert_eq!(error, GroundError::Radius(problem));
        }
    }
    for margin in [-0.1, 1.1] {
        assert_eq!(Ground::with_margin(&map, RADIUS, margin).unwrap_err(), GroundError::Margin(margin));
    }
}

#[test]
fn every_error_names_the_end_and_what_it_needs() {
    let map = drawn(&["..@..", ".@@..", "..@.."]);
    let ground = Ground::new(&map, RADIUS).unwrap();
    let mut planner = Planner::new(&ground);
    let inside = point(0.5, 0.5);
    let outside =
        |which, at| PlanError::Outside { which, point: at, width: map.width(), height: map.height() };
    let blocked = |which, at, room| PlanError::Blocked { which, point: at, room };
    let room = RADIUS + MARGIN;
    let cases = [
        (point(-0.5, 0.5), inside, outside(Which::Start, point(-0.5, 0.5))),
        (inside, point(0.5, 3.5), outside(Which::Goal, point(0.5, 3.5))),
        (inside, point(2.5, 0.5), blocked(Which::Goal, point(2.5, 0.5), room)),
        (inside, point(0.5, RADIUS), blocked(Which::Goal, point(0.5, RADIUS), room)),
        (point(0.3, 0.5), inside, blocked(Which::Start, point(0.3, 0.5), RADIUS)),
        (point(2.5, 1.5), inside, blocked(Which::Start, point(2.5, 1.5), RADIUS)),
        (inside, point(4.5, 0.5), PlanError::Unreachable { radius: RADIUS }),
    ];
    for (from, to, expected) in cases {
        assert_eq!(planner.path(from, to), Err(expected), "{from} {to}");
    }
    let not_a_number = planner.path(point(f64::NAN, 0.5), inside).unwrap_err();
    assert!(not_a_number.to_string().contains("not on the map"), "{not_a_number}");
    assert_eq!(planner.path(inside, inside), Ok(&[][..]));
    assert!(Field::new(&ground, point(2.5, 0.5)).is_err());
}

/// In a corridor that is as wide as the circle nobody can keep the margin.
#[test]
fn a_circle_that_is_wedged_in_is_told_so() {
    let map = drawn(&["..."]);
    let ground = Ground::new(&map, 0.5).unwrap();
    let start = point(0.5, 0.5);
    let error = Planner::new(&ground).path(start, point(2.5, 0.5)).unwrap_err();
    assert!(matches!(error, PlanError::Blocked { which: Which::Goal, .. }), "{error}");
}

#[test]
fn what_is_no_obstacle_on_the_map_is_refused() {
    let map = drawn(&["....", "...."]);
    let ground = Ground::new(&map, 0.25).unwrap();
    let mut obstacles = Obstacles::new(&ground);
    let circle = |x, radius| Obstacle::Circle(Circle::new(DVec2::new(x, 1.0), radius));
    let rectangle =
        |x: f64, to: f64| Obstacle::Rectangle(Area { min: DVec2::new(x, 0.5), max: DVec2::new(to, 1.5) });
    for good in [circle(0.0, 0.1), circle(4.0, 4.0), rectangle(0.0, 4.0)] {
        assert!(obstacles.insert(1, good).is_ok(), "{good:?}");
    }
    for bad in [
        circle(4.1, 0.1),
        circle(f64::NAN, 0.1),
        circle(1.0, 0.0),
        circle(1.0, 4.1),
        circle(1.0, f64::NAN),
        rectangle(1.0, 1.0),
        rectangle(2.0, 1.0),
        rectangle(1.0, 1e300),
        rectangle(f64::NAN, 1.0),
    ] {
        let error = obstacles.insert(1, bad).unwrap_err();
        assert!(error.to_string().contains("on a map of 4 x 2 tiles"), "{error}");
    }
    assert_eq!(obstacles.remove(1), Some(rectangle(0.0, 4.0)), "what was there stays");
}
