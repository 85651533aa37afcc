//! Boards, instances, distances, names, and what is refused.

use glam::DVec2;

use super::{RADIUS, board, boards, instance};
use crate::in_step::{
    Algorithm, Board, BoardError, Distances, Instance, InstanceError, JOINT_AGENTS_MAX, RADIUS_IN_STEP_MAX,
    TooManyAgents,
};
use crate::tests::{Dice, drawn, slanted};
use crate::{Field, Ground};

#[test]
fn circles_too_large_to_follow_each_other_around_a_corner_have_no_board() {
    let map = drawn(&["..", ".."]);
    let of_radius = |radius| Board::new(&Ground::new(&map, radius).unwrap());
    const { assert!(RADIUS_IN_STEP_MAX * RADIUS_IN_STEP_MAX * 8.0 < 1.0) };
    assert_eq!(of_radius(RADIUS_IN_STEP_MAX).unwrap().len(), 4);
    for radius in [0.3536, 0.36, 0.49, 1.0] {
        let error = of_radius(radius).unwrap_err();
        assert_eq!(error, BoardError::Radius { radius });
        assert!(error.to_string().contains("0.35355 at most"), "{error}");
    }
}

/// On maps with half-blocked tiles and free walls, too.
#[test]
fn places_have_room_and_steps_are_clear_both_ways() {
    let mut dice = Dice(1);
    for _ in 0..20 {
        let map = slanted(&mut dice, 16);
        let ground = Ground::new(&map, RADIUS).unwrap();
        let board = Board::new(&ground).unwrap();
        let mut steps = 0;
        for y in 0..map.height() {
            for x in 0..map.width() {
                let middle = DVec2::new(f64::from(x), f64::from(y)) + 0.5;
                let place = board.place(x, y);
                assert_eq!(place.is_some(), ground.holds(middle));
                let Some(place) = place else { continue };
                assert_eq!((board.tile(place), board.point(place)), ((x, y), middle));
                for &next in board.neighbours(place) {
                    assert!(ground.is_clear(middle, board.point(next)));
                    assert!(board.neighbours(next).contains(&place));
                    steps += 1;
                }
            }
        }
        assert!(steps > 2 * board.len());
        assert_eq!(board.place(map.width(), 0), None);
    }
}

#[test]
fn distances_are_those_of_a_field_that_may_not_go_diagonally() {
    for (name, board) in boards() {
        let goals: Vec<_> = board.places().step_by(7).chain(board.places().step_by(7)).collect();
        let distances = Distances::new(&board, &goals);
        assert_eq!(distances.tables(), goals.len() / 2, "agents with the same goal share a table");
        for (agent, &goal) in goals.iter().enumerate() {
            for place in board.places() {
                let around = board.neighbours(place).iter();
                let nearest = around.filter_map(|&next| distances.steps(agent, next)).min();
                let expected = if place == goal { Some(0) } else { nearest.map(|steps| steps + 1) };
                assert_eq!(distances.steps(agent, place), expected, "{name}");
            }
        }
    }
}

/// A way in eight directions is never longer than one in four, and at least 1/√2 of it.
#[test]
fn distances_agree_with_fields() {
    let map = drawn(&["......", ".@@@..", "...@..", "@..@.@", "......"]);
    let ground = Ground::new(&map, RADIUS).unwrap();
    let board = Board::new(&ground).unwrap();
    let goal = board.place(5, 4).unwrap();
    let field = Field::new(&ground, board.point(goal)).unwrap();
    let distances = Distances::new(&board, &[goal]);
    for place in board.places() {
        let steps = f64::from(distances.steps(0, place).unwrap());
        let length = field.distance(&ground, board.point(place)).unwrap();
        assert!(length <= steps + 1e-9 && steps <= length * 1.4143 + 1e-9, "{steps} {length}");
    }
}

#[test]
fn every_mistake_of_an_instance_is_named() {
    let board = board(&["..@.", "..@."]);
    let at = |x, y| board.place(x, y).unwrap();
    let (a, b, c, apart) = (at(0, 0), at(1, 0), at(0, 1), at(3, 0));
    let cases = [
        (vec![a, b], vec![c], InstanceError::Count { starts: 2, goals: 1 }),
        (vec![a, b, a], vec![a, b, c], InstanceError::SameStart { first: 0, second: 2 }),
        (vec![a, b, c], vec![c, a, a], InstanceError::SameGoal { first: 1, second: 2 }),
        (vec![a, b], vec![b, apart], InstanceError::Unreachable { agent: 1 }),
    ];
    for (starts, goals, expected) in cases {
        assert_eq!(Instance::new(&board, starts, goals).unwrap_err(), expected);
    }
    let empty = Instance::new(&board, Vec::new(), Vec::new()).unwrap();
    assert_eq!((empty.sum_of_costs_min(), empty.makespan_min()), (0, 0));
}

#[test]
fn planners_have_names_and_say_them_where_one_is_unknown() {
    for algorithm in Algorithm::ALL {
        assert_eq!(algorithm.name().parse(), Ok(algorithm));
    }
    let error = "lakam".parse::<Algorithm>().unwrap_err().to_string();
    assert_eq!(error, "`lakam` is no planner; choose one of pibt, lacam, spacetime, joint, conflict");
}

#[test]
fn joint_moves_of_too_many_are_refused() {
    let board = board(&["....."; 5]);
    let instance = instance(&board, 9, 1);
    let error = Algorithm::Joint.begin(&instance, 1).err().unwrap();
    assert_eq!(error, TooManyAgents { algorithm: Algorithm::Joint, agents: 9, limit: JOINT_AGENTS_MAX });
    assert!(error.to_string().starts_with("9 agents; joint takes 8 at most"), "{error}");
}

/// Nobody to plan for is solved at once by all.
#[test]
fn nobody_has_a_plan_of_no_step() {
    let board = board(&["..."]);
    let instance = Instance::new(&board, Vec::new(), Vec::new()).unwrap();
    for algorithm in Algorithm::ALL {
        assert_eq!(super::plan(algorithm, &instance, 1, 10).makespan(), 0);
    }
}
