//! The search beside plain ones, and that answers do not depend on what was asked before.

use std::collections::BTreeSet;

use glam::DVec2;
use maniple_tilemap::{Kind, TileMap};

use super::{Dice, generated, scattered, slanted};
use crate::jump::{Search, octile};
use crate::{Field, Ground, PlanError, Planner, length};

/// Queries for each map.
const QUERIES: usize = 60;

fn maps(dice: &mut Dice) -> Vec<(TileMap, f64)> {
    let mut maps = Vec::new();
    for radius in [0.2, 0.45, 0.8, 1.4] {
        maps.push((scattered(dice, 30, 0.25), radius));
        maps.push((slanted(dice, 30), radius));
        for kind in [Kind::Maze, Kind::Obstacles] {
            maps.push((generated(kind, 40, radius, dice.roll()), radius));
        }
    }
    // Rows of more than one word of bits.
    maps.push((scattered(dice, 150, 0.2), 0.35));
    maps
}

/// Jump point search finds ways as short as the algorithm of Dijkstra does, of steps between free nodes.
#[test]
fn ways_are_as_short_as_those_of_a_plain_search() {
    let mut dice = Dice(21);
    let mut found = 0;
    for (map, radius) in maps(&mut dice) {
        let ground = Ground::new(&map, radius).unwrap();
        let lattice = &ground.lattice;
        let mut search = Search::default();
        for _ in 0..QUERIES / 4 {
            let Some(goal) = free_node(&ground, &mut dice) else { break };
            let field = Field::new(&ground, lattice.point(goal)).unwrap();
            for _ in 0..4 {
                let start = free_node(&ground, &mut dice).unwrap();
                if lattice.region(start) != lattice.region(goal) {
                    continue;
                }
                let (mut way, mut plain) = (Vec::new(), Vec::new());
                search.find(lattice, start, goal, &mut way);
                field.follow(lattice, start, &mut plain);
                // The field may end in another node that sees the goal.
                let end = plain[plain.len() - 1];
                if end != goal {
                    plain.clear();
                    search.find(lattice, start, end, &mut way);
                }
                if !plain.is_empty() {
                    assert_eq!(cost(&ground, &way), cost(&ground, &plain), "{radius}");
                    found += 1;
                }
            }
        }
    }
    assert!(found > 300, "only {found} ways");
}

fn free_node(ground: &Ground, dice: &mut Dice) -> Option<u32> {
    let nodes = u32::try_from(ground.lattice.nodes()).unwrap();
    let mut nodes = (0..10_000).map(|_| u32::try_from(dice.roll() % u64::from(nodes)).unwrap());
    nodes.find(|&node| {
        let (x, y) = ground.lattice.place(node);
        ground.lattice.is_free(x, y)
    })
}

fn cost(ground: &Ground, way: &[u32]) -> u32 {
    let step = |pair: &[u32]| {
        let (from, to) = (ground.lattice.place(pair[0]), ground.lattice.place(pair[1]));
        assert!(from.0.abs_diff(to.0) <= 1 && from.1.abs_diff(to.1) <= 1, "{from:?} {to:?}");
        assert!(ground.lattice.is_diagonal_free(from, to), "{from:?} {to:?}");
        octile(from, to)
    };
    way.windows(2).map(step).sum()
}

/// A flood over points a quarter apart, with every step tested against all walls, reaches what the planner says it does.
#[test]
fn what_is_unreachable_a_flood_does_not_reach() {
    let mut dice = Dice(22);
    let (mut reached, mut unreached) = (0, 0);
    for _ in 0..12 {
        let map = scattered(&mut dice, 16, 0.35);
        let ground = Ground::new(&map, 0.3).unwrap();
        let mut planner = Planner::new(&ground);
        for _ in 0..3 {
            let from = tile_middle(&map, dice.place(&map, &ground));
            let flood = flood(&ground, from);
            for _ in 0..QUERIES {
                let to = tile_middle(&map, dice.place(&map, &ground));
                let is_reached = flood.contains(&key(to));
                match planner.path(from, to) {
                    Ok(_) => assert!(is_reached, "{from} {to}"),
                    Err(error) => {
                        assert_eq!(error, PlanError::Unreachable { radius: 0.3 });
                        assert!(!is_reached, "{from} {to}");
                    }
                }
                *if is_reached { &mut reached } else { &mut unreached } += 1;
            }
        }
    }
    assert!(reached > 100 && unreached > 100, "{reached} {unreached}");
}

fn tile_middle(map: &TileMap, point: DVec2) -> DVec2 {
    let (x, y) = map.tile_at(point);
    DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)
}

fn key(point: DVec2) -> (i64, i64) {
    let whole = |coordinate: f64| format!("{}", coordinate * 4.0).parse().unwrap();
    (whole(point.x), whole(point.y))
}

fn flood(ground: &Ground, from: DVec2) -> BTreeSet<(i64, i64)> {
    let mut reached = BTreeSet::from([key(from)]);
    let mut waiting = vec![from];
    while let Some(point) = waiting.pop() {
        for step in [DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y] {
            let next = point + step * 0.25;
            if ground.is_clear(point, next) && reached.insert(key(next)) {
                waiting.push(next);
            }
        }
    }
    reached
}

/// The same question has the same answer, to the bit, whatever was asked before.
#[test]
fn a_warm_planner_says_what_a_new_one_says() {
    let mut dice = Dice(23);
    for (map, radius) in maps(&mut dice) {
        let ground = Ground::new(&map, radius).unwrap();
        let again = Ground::new(&map, radius).unwrap();
        let mut warm = Planner::new(&ground);
        for _ in 0..QUERIES {
            let (from, to) = (dice.place(&map, &ground), dice.place(&map, &ground));
            let expected = Planner::new(&again).path(from, to).map(<[DVec2]>::to_vec);
            assert_eq!(warm.path(from, to).map(<[DVec2]>::to_vec), expected);
        }
    }
}

/// A path by a field is clear, ends in its goal, and is about as long as one by a search.
#[test]
fn a_field_leads_to_its_goal_as_a_search_does() {
    let mut dice = Dice(24);
    let (mut by_field, mut by_search) = (0.0, 0.0);
    for (map, radius) in maps(&mut dice) {
        let ground = Ground::new(&map, radius).unwrap();
        let mut planner = Planner::new(&ground);
        let goal = dice.place(&map, &ground);
        let Ok(field) = Field::new(&ground, goal) else { continue };
        for _ in 0..QUERIES {
            let from = dice.place(&map, &ground);
            let legs = planner.path_by(&field, from).map(<[DVec2]>::to_vec);
            assert_eq!(legs.is_ok(), planner.path(from, goal).is_ok(), "{from} {goal} {radius}");
            let Ok(legs) = legs else { continue };
            check_legs(&ground, from, &legs, goal);
            check_next(&ground, &field, from);
            by_field += length(from, &legs);
            by_search += length(from, planner.path(from, goal).unwrap());
        }
    }
    println!("length by fields over that by searches: {}", by_field / by_search);
    assert!((by_field / by_search - 1.0).abs() < 0.01);
}

fn check_legs(ground: &Ground, from: DVec2, legs: &[DVec2], goal: DVec2) {
    let starts = std::iter::once(&from).chain(legs);
    assert!(starts.zip(legs).all(|(start, end)| ground.is_clear(*start, *end)));
    assert_eq!(legs.last().copied().unwrap_or(from), goal);
}

/// Whoever follows the next points arrives, and is never farther away than was said.
fn check_next(ground: &Ground, field: &Field, from: DVec2) {
    let (mut point, mut walked) = (from, 0.0);
    let said = field.distance(ground, from).unwrap_or(0.0);
    for _ in 0..10_000 {
        if point == field.goal() {
            assert!(walked <= said + 3.0, "{walked} {said}");
            return;
        }
        let next = field.next(ground, point).unwrap();
        assert!(ground.is_clear(point, next));
        walked += point.distance(next);
        point = next;
    }
    panic!("{from} never arrives");
}
