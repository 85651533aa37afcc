//! Random starts and goals, for tests and figures.

use crate::in_step::board::{Board, Place};
use crate::in_step::keyed::keyed;

/// Returns starts and goals for `agents`, all in the largest region of the board, no two starts and no two goals the same; fewer
/// where it has fewer places. They follow from the seed.
#[must_use]
pub fn scattered(board: &Board, agents: usize, seed: u64) -> (Vec<Place>, Vec<Place>) {
    let region = largest_region(board);
    let drawn = |purpose: u64| {
        let mut places = region.clone();
        places.sort_by_key(|place| (keyed(seed, place.index() as u64, purpose), *place));
        places.truncate(agents);
        places
    };
    (drawn(1), drawn(2))
}

/// The places of the region that has most of them; of several the one with the first place.
fn largest_region(board: &Board) -> Vec<Place> {
    let mut is_known = vec![false; board.len()];
    let mut largest = Vec::new();
    for first in board.places() {
        if is_known[first.index()] {
            continue;
        }
        is_known[first.index()] = true;
        let mut region = vec![first];
        let mut done = 0;
        while done < region.len() {
            for &next in board.neighbours(region[done]) {
                if !is_known[next.index()] {
                    is_known[next.index()] = true;
                    region.push(next);
                }
            }
            done += 1;
        }
        if region.len() > largest.len() {
            largest = region;
        }
    }
    largest
}
