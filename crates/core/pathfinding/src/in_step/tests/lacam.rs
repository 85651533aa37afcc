//! Lazy constraints: everything that can be solved is solved, and what cannot be is said.

use std::collections::BTreeSet;

use super::{board, boards, instance, plan, puzzle, solve};
use crate::in_step::{Algorithm, Board, Instance, Outcome, Place};

#[test]
fn crowds_on_maps_of_all_kinds_have_valid_plans() {
    for (name, board) in boards() {
        for share in [20, 8, 3] {
            for seed in 0..3 {
                let instance = instance(&board, board.len() / share, seed);
                let outcome = solve(Algorithm::Lacam, &instance, seed, 20_000);
                assert!(
                    matches!(outcome, Some(Outcome::Solved(_))),
                    "{name}, a {share}th, seed {seed}: {outcome:?}"
                );
            }
        }
    }
}

/// Everybody one after the other at every goal there is: what a flood over all configurations reaches is solved, and of the rest
/// it is said that it cannot be.
#[test]
fn small_puzzles_are_solved_or_said_to_be_unsolvable() {
    let cases: [(&[&str], usize); 6] = [
        (&["...."], 2),
        (&["..", ".."], 3),
        (&["..", ".."], 4),
        (&["@.@", "..."], 3),
        (&["@.@@", "...."], 3),
        (&["...", ".@."], 4),
    ];
    let (mut solvable, mut unsolvable) = (0, 0);
    for (rows, agents) in cases {
        let board = board(rows);
        let starts: Vec<Place> = board.places().take(agents).collect();
        let reachable = flood(&board, &starts);
        for goals in arrangements(&board, agents) {
            let instance = Instance::new(&board, starts.clone(), goals.clone()).unwrap();
            let expected = reachable.contains(&goals);
            let outcome = solve(Algorithm::Lacam, &instance, 1, 1_000_000);
            let joint = solve(Algorithm::Joint, &instance, 1, 1_000_000);
            for found in [outcome, joint] {
                let is_right = match found {
                    Some(Outcome::Solved(_)) => expected,
                    Some(Outcome::Unsolvable) => !expected,
                    Some(Outcome::Stuck) | None => false,
                };
                assert!(is_right, "{rows:?} {goals:?}");
            }
            *(if expected { &mut solvable } else { &mut unsolvable }) += 1;
        }
    }
    println!("{solvable} solvable, {unsolvable} not");
    assert!(solvable >= 50 && unsolvable >= 200, "{solvable} {unsolvable}");
}

/// The worst case: a room that is full but for one place.
#[test]
fn a_room_that_is_full_but_for_one_place_is_solved() {
    let board = board(&["..."; 3]);
    let instance = puzzle(&board, &["abc", "def", "gh."], &["hgf", "edc", "ba."]);
    let exact = plan(Algorithm::Joint, &instance, 1, 400_000);
    let found = plan(Algorithm::Lacam, &instance, 1, 1_000_000);
    println!("{} {}", exact.sum_of_costs(), found.sum_of_costs());
    assert!(found.sum_of_costs() >= exact.sum_of_costs());
}

#[test]
fn a_search_can_be_spread_over_cycles() {
    let board = board(&["........", "..@@@@..", "........"]);
    let instance = instance(&board, 14, 4);
    for algorithm in Algorithm::ALL {
        if algorithm == Algorithm::Joint {
            continue;
        }
        let at_once = algorithm.begin(&instance, 9).unwrap().advance(3_000);
        let mut search = algorithm.begin(&instance, 9).unwrap();
        let by_ones = (0..3_000).find_map(|_| search.advance(1));
        assert_eq!(at_once, by_ones, "{}", algorithm.name());
        assert!(search.expanded() <= 3_000, "{}", search.expanded());
    }
}

/// All places of agents that a flood of joint moves reaches: slow and obvious.
fn flood(board: &Board, starts: &[Place]) -> BTreeSet<Vec<Place>> {
    let mut known = BTreeSet::from([starts.to_vec()]);
    let mut waiting = vec![starts.to_vec()];
    while let Some(now) = waiting.pop() {
        let mut moves = vec![Vec::new()];
        for &place in &now {
            let choices: Vec<Place> = board.neighbours(place).iter().copied().chain([place]).collect();
            moves = moves
                .into_iter()
                .flat_map(|begun: Vec<Place>| {
                    choices.iter().map(move |&choice| begun.iter().copied().chain([choice]).collect())
                })
                .collect();
        }
        let is_fine = |next: &Vec<Place>| {
            (0..next.len())
                .all(|a| (0..a).all(|b| next[a] != next[b] && !(next[a] == now[b] && next[b] == now[a])))
        };
        for next in moves.into_iter().filter(is_fine) {
            if known.insert(next.clone()) {
                waiting.push(next);
            }
        }
    }
    known
}

/// All ways to put agents into places.
fn arrangements(board: &Board, agents: usize) -> Vec<Vec<Place>> {
    let mut all = vec![Vec::new()];
    for _ in 0..agents {
        all = all
            .into_iter()
            .flat_map(|begun: Vec<Place>| {
                let free: Vec<Place> = board.places().filter(|place| !begun.contains(place)).collect();
                free.into_iter().map(move |place| begun.iter().copied().chain([place]).collect())
            })
            .collect();
    }
    all
}
