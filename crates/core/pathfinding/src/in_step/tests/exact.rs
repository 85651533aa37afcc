//! The exact planners: the least sum of costs, by two ways and by brute force.

use std::collections::BTreeMap;

use super::{board, board_of, instance, plan, puzzle, solve};
use crate::in_step::{Algorithm, Board, Instance, Outcome, Place};
use crate::tests::{Dice, scattered as blocked_at_random};

/// The least sum of costs, by trying every sequence of moves that is not longer than `steps`: step by step, the least costs with which
/// places are reached, for every choice of when everybody is at the goal for good.
fn brute_force(instance: &Instance<'_>, steps: usize) -> Option<u64> {
    let agents = instance.agents();
    // For each agent the step from which on it has to be at its goal; all combinations.
    let mut best: Option<u64> = None;
    let combinations = (steps + 1).pow(u32::try_from(agents).unwrap());
    for combination in 0..combinations {
        let ends: Vec<usize> = (0..agents)
            .map(|agent| combination / (steps + 1).pow(u32::try_from(agent).unwrap()) % (steps + 1))
            .collect();
        let sum = ends.iter().sum::<usize>() as u64;
        if best.is_none_or(|best| sum < best) && can_end(instance, &ends) {
            best = Some(sum);
        }
    }
    best
}

/// Whether everybody can be at the goal for good from its step on.
fn can_end(instance: &Instance<'_>, ends: &[usize]) -> bool {
    let board = instance.board();
    let fits = |places: &[Place], step: usize| {
        (0..places.len()).all(|agent| step < ends[agent] || places[agent] == instance.goals()[agent])
    };
    if !fits(instance.starts(), 0) {
        return false;
    }
    let mut now = BTreeMap::from([(instance.starts().to_vec(), ())]);
    for step in 1..=ends.iter().copied().max().unwrap_or(0) {
        let mut next = BTreeMap::new();
        for places in now.keys() {
            for moved in moves(board, places) {
                if fits(&moved, step) {
                    next.insert(moved, ());
                }
            }
        }
        now = next;
    }
    !now.is_empty()
}

fn moves(board: &Board, now: &[Place]) -> Vec<Vec<Place>> {
    let mut all: Vec<Vec<Place>> = vec![Vec::new()];
    for (agent, &place) in now.iter().enumerate() {
        let mut longer = Vec::new();
        for begun in &all {
            for &to in board.neighbours(place).iter().chain([&place]) {
                let conflicts =
                    (0..agent).any(|other| begun[other] == to || (begun[other] == place && now[other] == to));
                if !conflicts {
                    longer.push(begun.iter().copied().chain([to]).collect());
                }
            }
        }
        all = longer;
    }
    all
}

#[test]
fn joint_moves_cost_as_little_as_by_brute_force() {
    let mut dice = Dice(21);
    let mut compared = 0;
    for round in 0..60 {
        let map = blocked_at_random(&mut dice, 3, 0.2);
        let board = board_of(&map);
        let agents = 1 + (dice.roll() % 3) as usize;
        if board.len() < agents {
            continue;
        }
        let instance = instance(&board, agents, dice.roll());
        let steps = if instance.agents() == 3 { 7 } else { 9 };
        let expected = brute_force(&instance, steps);
        let found = solve(Algorithm::Joint, &instance, 1, 100_000).expect("the space is small");
        let cost = found.plan().map(crate::in_step::Plan::sum_of_costs);
        match expected {
            Some(expected) => assert_eq!(cost, Some(expected), "round {round}"),
            // What takes more steps than were tried costs more than they.
            None => assert!(cost.is_none_or(|cost| cost > steps as u64), "round {round}"),
        }
        compared += usize::from(expected.is_some());
    }
    assert!(compared > 30, "only {compared}");
}

/// An agent at its goal has to let another one past, and to come back.
#[test]
fn who_is_at_the_goal_makes_way_where_it_must() {
    let board = board(&["@.@@", "...."]);
    let instance = puzzle(&board, &["....", "a.b."], &["....", "..ba"]);
    for algorithm in [Algorithm::Joint, Algorithm::Conflict] {
        assert_eq!(plan(algorithm, &instance, 1, 10_000).sum_of_costs(), brute_force(&instance, 8).unwrap());
    }
}

#[test]
fn conflicts_and_joint_moves_cost_the_same() {
    let mut dice = Dice(31);
    let mut compared = 0;
    for round in 0..40 {
        let board = board_of(&blocked_at_random(&mut dice, 6, 0.2));
        let agents = 2 + (dice.roll() % 3) as usize;
        let instance = instance(&board, agents, dice.roll());
        let joint = solve(Algorithm::Joint, &instance, 1, 200_000);
        let conflict = solve(Algorithm::Conflict, &instance, 1, 3_000);
        if let (Some(Outcome::Solved(joint)), Some(Outcome::Solved(conflict))) = (joint, conflict) {
            assert_eq!(joint.sum_of_costs(), conflict.sum_of_costs(), "round {round}, {agents} agents");
            compared += 1;
        }
    }
    assert!(compared > 25, "only {compared}");
}

#[test]
fn eight_who_hardly_meet_are_planned_by_their_conflicts() {
    let board = board(&["................"; 16]);
    let mut solved = 0;
    for seed in 0..10 {
        let instance = instance(&board, 8, seed);
        let exact = solve(Algorithm::Conflict, &instance, 1, 2_000);
        let Some(Outcome::Solved(exact)) = exact else { continue };
        let quick = plan(Algorithm::Lacam, &instance, seed, 10_000);
        assert!(exact.sum_of_costs() <= quick.sum_of_costs());
        solved += 1;
    }
    assert!(solved >= 8, "only {solved}");
}

#[test]
fn what_joint_moves_expand_grows_with_each_agent() {
    let board = board(&["....", "....", "....", "...."]);
    let rows: Vec<&str> = vec!["abc.", "d...", "e...", "...."];
    let goals = ["..ba", "..dc", "...e", "...."];
    let mut before = 0;
    for agents in 1..=5 {
        let starts: Vec<String> = rows.iter().map(|row| keep(row, agents)).collect();
        let starts: Vec<&str> = starts.iter().map(String::as_str).collect();
        let instance = puzzle(&board, &starts, &goals);
        let mut search = Algorithm::Joint.begin(&instance, 1).unwrap();
        assert!(matches!(search.advance(1_000_000), Some(Outcome::Solved(_))));
        println!("{agents} agents: {} states", search.expanded());
        assert!(search.expanded() >= before);
        before = search.expanded();
    }
}

/// A row without the letters behind the first ones.
fn keep(row: &str, agents: usize) -> String {
    row.chars().map(|letter| if "abcde"[..agents].contains(letter) { letter } else { '.' }).collect()
}

/// Conflicts never run out where there is no plan: the budget ends it.
#[test]
fn an_unsolvable_instance_ends_in_bounded_time() {
    let board = board(&["...."]);
    let instance = puzzle(&board, &["ab.."], &["ba.."]);
    assert_eq!(solve(Algorithm::Joint, &instance, 1, 1_000), Some(Outcome::Unsolvable));
    assert_eq!(solve(Algorithm::Lacam, &instance, 1, 1_000), Some(Outcome::Unsolvable));
    assert_eq!(solve(Algorithm::Conflict, &instance, 1, 300), None);
    assert_eq!(solve(Algorithm::Pibt, &instance, 1, 300), None);
    let spacetime = solve(Algorithm::Spacetime, &instance, 1, 300);
    assert!(spacetime.is_none_or(|outcome| outcome == Outcome::Stuck));
}
