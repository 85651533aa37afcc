//! Plans made cheaper, ways around reservations, and windows.

use std::collections::BTreeSet;

use super::{boards, instance, plan, solve};
use crate::in_step::distances::FAR;
use crate::in_step::reservations::{FOREVER, Reservations};
use crate::in_step::way::{Surroundings, WayFinder};
use crate::in_step::{Algorithm, Board, Outcome, Place, Refinement};
use crate::tests::Dice;

#[test]
fn refining_never_makes_a_plan_dearer_and_keeps_it_valid() {
    let mut won = 0;
    for (name, board) in boards() {
        for share in [16, 6, 3] {
            let instance = instance(&board, board.len() / share, 7);
            let first = plan(Algorithm::Lacam, &instance, 1, 20_000);
            let mut refinement = Refinement::new(&instance, &first, 1);
            let mut cost = first.sum_of_costs();
            for _ in 0..20 {
                refinement.improve(10);
                let plan = refinement.plan();
                plan.check(&instance).unwrap_or_else(|fault| panic!("{name}: {fault}"));
                assert_eq!(plan.sum_of_costs(), refinement.sum_of_costs(), "{name}");
                assert!(plan.sum_of_costs() <= cost, "{name}");
                cost = plan.sum_of_costs();
            }
            won += first.sum_of_costs() - cost;
        }
    }
    println!("{won} steps won");
    assert!(won > 2_000, "only {won}");
}

#[test]
fn refining_by_parts_is_refining_at_once() {
    let (_, board) = boards().swap_remove(3);
    let instance = instance(&board, 60, 3);
    let first = plan(Algorithm::Lacam, &instance, 1, 20_000);
    let mut at_once = Refinement::new(&instance, &first, 5);
    at_once.improve(150);
    let mut by_ones = Refinement::new(&instance, &first, 5);
    (0..150).for_each(|_| by_ones.improve(1));
    assert_eq!(at_once.plan(), by_ones.plan());
}

/// A way among random others costs what a flood step by step says.
#[test]
fn ways_around_reservations_are_shortest() {
    let mut dice = Dice(41);
    let (mut compared, mut blocked) = (0, 0);
    for (name, board) in boards() {
        for _ in 0..12 {
            let instance = instance(&board, board.len() / 4, dice.roll());
            let Some(Outcome::Solved(plan)) = solve(Algorithm::Lacam, &instance, 1, 20_000) else { continue };
            let mut reservations = Reservations::new(board.len());
            for (agent, way) in (1..).zip(&plan.ways()[1..]) {
                reservations.add(agent, way, FOREVER);
            }
            let distances = instance.distances().of(0);
            let (start, goal) = (instance.starts()[0], instance.goals()[0]);
            let end = reservations.free_from(goal);
            let salt = dice.roll();
            let surroundings = Surroundings {
                board: &board,
                reservations: &reservations,
                distances,
                end,
                horizon: FOREVER,
                salt,
            };
            let mut finder = WayFinder::new(&board);
            let way = finder.find(&surroundings, start, FOREVER).expect("the plan has one");
            let expected = flood(&board, &reservations, (start, goal), plan.steps() + board.len());
            assert_eq!(Some(way.len() - 1), expected, "{name}");
            let cost = u32::try_from(way.len() - 1).unwrap();
            assert!(finder.find(&surroundings, start, cost).is_none());
            assert_eq!(finder.find(&surroundings, start, cost + 1).map(|way| way.len()), Some(way.len()));
            reservations.add(0, &way, FOREVER);
            compared += 1;
            blocked += u32::from(cost > distances[start.index()]);
        }
    }
    assert!(compared > 80 && blocked > 40, "{compared} {blocked}");
}

/// After how many steps one can be at the goal for good.
fn flood(
    board: &Board,
    reservations: &Reservations,
    (start, goal): (Place, Place),
    steps: usize,
) -> Option<usize> {
    let occupied = |place: Place, step: usize| reservations.at(place, u32::try_from(step).unwrap());
    let mut now = BTreeSet::from([start]);
    for step in 0..=steps {
        if now.contains(&goal) && (step..=steps).all(|later| occupied(goal, later).is_none()) {
            return Some(step);
        }
        let mut next = BTreeSet::new();
        for &place in &now {
            for &to in board.neighbours(place).iter().chain([&place]) {
                let comes = occupied(place, step + 1);
                let swaps = comes.is_some() && comes == occupied(to, step);
                if occupied(to, step + 1).is_none() && !swaps {
                    next.insert(to);
                }
            }
        }
        now = next;
    }
    None
}

#[test]
fn windows_of_reservations_give_valid_plans_where_there_is_room() {
    let mut solved = 0;
    for (name, board) in boards() {
        for seed in 0..3 {
            let instance = instance(&board, board.len() / 12, seed);
            let outcome = solve(Algorithm::Spacetime, &instance, seed, 400);
            println!(
                "{name} {}: {}",
                instance.agents(),
                outcome.as_ref().is_some_and(|found| found.plan().is_some())
            );
            solved += u32::from(outcome.is_some_and(|found| found.plan().is_some()));
        }
    }
    assert!(solved >= 25, "only {solved}");
}

#[test]
fn far_is_no_distance() {
    let board = super::board(&[".@."]);
    let distances = crate::in_step::Distances::new(&board, &[board.place(0, 0).unwrap()]);
    assert_eq!(distances.of(0)[1], FAR);
    assert_eq!(distances.steps(0, board.place(2, 0).unwrap()), None);
}
