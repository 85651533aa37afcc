//! The check of plans: every fault is found.

use super::{board, instance, puzzle};
use crate::in_step::{Fault, Plan};

#[test]
fn the_check_finds_every_fault() {
    let board = board(&["...", "..."]);
    let at = |x, y| board.place(x, y).unwrap();
    let instance = puzzle(&board, &["ab.", "..."], &["ba.", "..."]);
    let check = |a: &[(u32, u32)], b: &[(u32, u32)]| {
        let way = |places: &[(u32, u32)]| places.iter().map(|&(x, y)| at(x, y)).collect();
        Plan::of_ways(&[way(a), way(b)]).check(&instance)
    };
    let (first, second) = (0, 1);
    let around = [(0, 0), (0, 1), (1, 1), (1, 0)];
    assert_eq!(check(&around, &[(1, 0), (1, 0), (0, 0)]), Ok(()));
    let cases = [
        (&around[1..], &[(1, 0), (0, 0)][..], Fault::Start { agent: 0 }),
        (&around[..3], &[(1, 0), (0, 0)], Fault::Goal { agent: 0 }),
        (&around[..1], &[(1, 0), (0, 0)], Fault::Goal { agent: 0 }),
        (&[(0, 0), (1, 1), (1, 0)], &[(1, 0), (0, 0)], Fault::Leap { agent: 0, step: 1 }),
        (&[(0, 0), (1, 0)], &[(1, 0), (0, 0)], Fault::Swap { first, second, step: 1 }),
        (&around, &[(1, 0), (1, 1), (1, 1), (0, 1), (0, 0)], Fault::Meeting { first, second, step: 2 }),
    ];
    for (a, b, expected) in cases {
        assert_eq!(check(a, b), Err(expected));
    }
    let alone = Plan::standing(&instance.starts()[..1]);
    assert_eq!(alone.check(&instance), Err(Fault::Agents { planned: 1, agents: 2 }));
}

#[test]
fn costs_count_until_an_agent_stays_for_good() {
    let board = board(&["...", "..."]);
    let at = |x, y| board.place(x, y).unwrap();
    let stays = vec![at(0, 0)];
    let leaves_again = vec![at(2, 0), at(2, 1), at(2, 1), at(2, 0)];
    let mut plan = Plan::of_ways(&[stays.clone(), leaves_again.clone()]);
    plan.push(&[at(0, 0), at(2, 0)]);
    assert_eq!((plan.steps(), plan.makespan(), plan.sum_of_costs()), (4, 3, 3));
    assert_eq!(plan.ways(), [stays, leaves_again]);
}

#[test]
fn bounds_are_those_of_everybody_alone() {
    let board = board(&["....", ".@@."]);
    let instance = puzzle(&board, &["a..b", "...."], &["...a", "b..."]);
    assert_eq!((instance.sum_of_costs_min(), instance.makespan_min()), (3 + 4, 4));
    let _ = super::instance(&board, 2, 1);
    let full = instance_of_all(&board);
    assert_eq!(full, board.len());
}

fn instance_of_all(board: &crate::in_step::Board) -> usize {
    instance(board, 100, 3).agents()
}
