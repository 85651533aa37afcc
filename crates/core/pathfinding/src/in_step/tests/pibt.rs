//! Priority inheritance: what holds at every step, whatever the goals.

use super::{boards, instance, plan, puzzle};
use crate::in_step::{Algorithm, Distances, Instance, Pibt, Plan};
use crate::tests::Dice;

/// Goals change, and several share one: still nobody meets.
#[test]
fn no_two_ever_meet_or_change_places() {
    let mut dice = Dice(11);
    let mut steps = 0;
    for (name, board) in boards() {
        for share in [10, 3, 1] {
            let first = instance(&board, board.len() / share, dice.roll());
            let mut pibt = Pibt::new(&board, first.distances(), first.starts(), dice.roll());
            let mut walked = Plan::standing(first.starts());
            for _ in 0..4 {
                let all: Vec<_> = board.places().collect();
                let choose = |_| all[(dice.roll() % 5) as usize * (all.len() / 5)];
                let goals: Vec<_> = (0..first.agents()).map(choose).collect();
                let distances = Distances::new(&board, &goals);
                for _ in 0..20 {
                    walked.push(pibt.step(&distances));
                    steps += 1;
                }
            }
            let ended = Instance::new(&board, first.starts().to_vec(), pibt.places().to_vec());
            // Places in a cut-off region cannot be left, so all are reachable.
            walked.check(&ended.unwrap()).unwrap_or_else(|fault| panic!("{name}: {fault}"));
        }
    }
    assert!(steps > 2000);
}

/// Okumura 2022, theorem 1: where every place lies on a ring, who has the highest priority gets there.
#[test]
fn everybody_arrives_at_least_once_where_all_places_lie_on_rings() {
    let board = super::board(&["......"; 6]);
    for seed in 0..20 {
        let instance = instance(&board, 30, seed);
        let mut pibt = Pibt::new(&board, instance.distances(), instance.starts(), seed);
        let mut has_arrived = vec![false; instance.agents()];
        for _ in 0..1000 {
            let places = pibt.step(instance.distances());
            for (arrived, (place, goal)) in has_arrived.iter_mut().zip(places.iter().zip(instance.goals())) {
                *arrived |= place == goal;
            }
        }
        assert!(has_arrived.iter().all(|&arrived| arrived), "seed {seed}");
    }
}

#[test]
fn one_alone_goes_a_shortest_way() {
    for (name, board) in boards() {
        for seed in 0..10 {
            let instance = instance(&board, 1, seed);
            let plan = plan(Algorithm::Pibt, &instance, seed, 10_000);
            assert_eq!(plan.sum_of_costs(), instance.sum_of_costs_min(), "{name}");
        }
    }
}

/// Two in a corridor with one bay have to back off for each other.
#[test]
fn two_change_places_in_a_corridor_with_a_bay() {
    let board = super::board(&["@@@@.@@@", "........"]);
    let instance = puzzle(&board, &["........", "a.b....."], &["........", ".....b.a"]);
    assert!(plan(Algorithm::Pibt, &instance, 1, 100).makespan() < 30);
    let instance = puzzle(&board, &["........", "ab......"], &["........", "ba......"]);
    assert!(plan(Algorithm::Pibt, &instance, 1, 100).makespan() < 30);
}

#[test]
fn a_step_follows_from_the_seed() {
    let board = super::board(&[".........."; 10]);
    let instance = instance(&board, 60, 2);
    let planned = |seed| super::solve(Algorithm::Pibt, &instance, seed, 40);
    assert_eq!(planned(1), planned(1));
    assert_ne!(planned(1), planned(2));
}
