//! Tests of planning in step: every plan goes through a slow obvious check, and fast planners are compared with exact ones.

mod exact;
mod lacam;
mod parts;
mod pibt;
mod plans;
mod real;
mod refinement;
mod walk;

use maniple_tilemap::{Kind, TileMap};

use crate::Ground;
use crate::in_step::{Algorithm, Board, Instance, Outcome, Place, Plan, scattered};
use crate::tests::{Dice, drawn, generated, scattered as blocked_at_random};

/// The radius of the agents.
const RADIUS: f64 = 0.35;

/// A board of a map as MovingAI writes it.
fn board(rows: &[&str]) -> Board {
    board_of(&drawn(rows))
}

fn board_of(map: &TileMap) -> Board {
    Board::new(&Ground::new(map, RADIUS).unwrap()).unwrap()
}

/// Boards of all kinds of maps, small and larger ones.
fn boards() -> Vec<(String, Board)> {
    let mut dice = Dice(5);
    let mut boards = vec![
        ("open".to_owned(), board(&["......"; 5])),
        ("gap".to_owned(), board(&["...@...", "...@...", ".......", "...@..."])),
    ];
    for kind in Kind::ALL {
        boards.push((format!("{kind:?}"), board_of(&generated(kind, 24, RADIUS, dice.roll()))));
    }
    for blocked in [0.1, 0.2, 0.3] {
        let map = blocked_at_random(&mut dice, 16, blocked);
        boards.push((format!("{blocked} blocked"), board_of(&map)));
    }
    boards
}

/// An instance of random ends.
fn instance(board: &Board, agents: usize, seed: u64) -> Instance<'_> {
    let (starts, goals) = scattered(board, agents, seed);
    Instance::new(board, starts, goals).unwrap()
}

/// An instance of the places of letters: small ones start, and go where the same capital is; `*` is both ends of one that stays.
fn puzzle<'a>(board: &'a Board, starts: &[&str], goals: &[&str]) -> Instance<'a> {
    let find = |rows: &[&str], letter: char| -> Place {
        let mut all =
            (0..).zip(rows).flat_map(|(y, row)| (0..).zip(row.chars()).map(move |(x, found)| (x, y, found)));
        let (x, y, _) = all.find(|&(_, _, found)| found == letter).unwrap();
        board.place(x, y).unwrap()
    };
    let mut letters: Vec<char> =
        starts.iter().flat_map(|row| row.chars()).filter(char::is_ascii_lowercase).collect();
    letters.sort_unstable();
    let ends = |rows| letters.iter().map(|&letter| find(rows, letter)).collect();
    Instance::new(board, ends(starts), ends(goals)).unwrap()
}

/// What a planner says within a budget; `None` where it goes on.
fn solve(algorithm: Algorithm, instance: &Instance<'_>, seed: u64, budget: u64) -> Option<Outcome> {
    let outcome = algorithm.begin(instance, seed).unwrap().advance(budget);
    if let Some(plan) = outcome.as_ref().and_then(Outcome::plan) {
        plan.check(instance).unwrap_or_else(|fault| panic!("{}: {fault}", algorithm.name()));
        assert!(plan.sum_of_costs() >= instance.sum_of_costs_min());
        assert!(plan.makespan() >= instance.makespan_min());
    }
    outcome
}

/// The plan of a planner that has to find one.
fn plan(algorithm: Algorithm, instance: &Instance<'_>, seed: u64, budget: u64) -> Plan {
    match solve(algorithm, instance, seed, budget) {
        Some(Outcome::Solved(plan)) => plan,
        other => panic!("{} of {} agents, seed {seed}: {other:?}", algorithm.name(), instance.agents()),
    }
}
