//! The shortest way from node to node: jump point search.
//!
//! Harabor and Grastien, *Online Graph Pruning for Pathfinding on Grid Maps*, AAAI 2011, without cutting corners; runs along
//! the axes look at 64 nodes at a time, as in their *Improving Jump Point Search*, ICAPS 2014. Only nodes at which a
//! shortest way may have to turn are queued: of ways that are as long, it is enough to know the one with its diagonal
//! steps first.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::lattice::{DIAGONAL, Lattice, STRAIGHT};

/// No node.
const NONE: u32 = u32::MAX;

/// The eight steps, those along the axes first.
const STEPS: [(i32, i32); 8] = [(1, 0), (0, 1), (-1, 0), (0, -1), (1, 1), (-1, 1), (-1, -1), (1, -1)];

/// What the search knows of a node.
#[derive(Clone, Copy, Debug, Default)]
struct Known {
    /// The search that knew it last: what earlier ones knew need not be cleared.
    search: u32,
    /// The cost from the start.
    cost: u32,
    /// The node before it.
    before: u32,
}

/// The memory of searches, kept from one to the next.
#[derive(Clone, Debug, Default)]
pub(crate) struct Search {
    number: u32,
    known: Vec<Known>,
    /// By the cost of the whole way, then the rest of it, then the node: a total order, and of equal ways those near
    /// the goal first.
    queue: BinaryHeap<Reverse<(u32, u32, u32)>>,
}

impl Search {
    /// Puts every node of a shortest way from start to goal, both free and in one region, behind `way`.
    ///
    /// # Panics
    /// Where there is no way.
    pub(crate) fn find(&mut self, lattice: &Lattice, start: u32, goal: u32, way: &mut Vec<u32>) {
        self.begin(lattice);
        self.known[start as usize] = Known { search: self.number, cost: 0, before: NONE };
        let target = lattice.place(goal);
        let rest = octile(lattice.place(start), target);
        self.queue.push(Reverse((rest, rest, start)));
        while let Some(Reverse((whole, rest, node))) = self.queue.pop() {
            if node == goal {
                self.trace(lattice, goal, way);
                return;
            }
            // An entry that was overtaken by a cheaper one is out of date.
            if whole - rest == self.known[node as usize].cost {
                self.expand(lattice, node, target);
            }
        }
        panic!("nodes of one region are connected");
    }

    fn begin(&mut self, lattice: &Lattice) {
        self.known.resize(lattice.nodes(), Known::default());
        self.queue.clear();
        self.number = self.number.wrapping_add(1);
        if self.number == 0 {
            self.known.fill(Known::default());
            self.number = 1;
        }
    }

    /// Queues what a shortest way through a node, from the one before it, may lead to.
    fn expand(&mut self, lattice: &Lattice, node: u32, goal: (i32, i32)) {
        let from = lattice.place(node);
        let Known { cost, before, .. } = self.known[node as usize];
        if before == NONE {
            for step in STEPS {
                self.advance(lattice, (node, cost), step, goal);
            }
            return;
        }
        let last = lattice.place(before);
        let (dx, dy) = ((from.0 - last.0).signum(), (from.1 - last.1).signum());
        self.advance(lattice, (node, cost), (dx, dy), goal);
        if dx != 0 && dy != 0 {
            self.advance(lattice, (node, cost), (dx, 0), goal);
            self.advance(lattice, (node, cost), (0, dy), goal);
            return;
        }
        for side in [-1, 1] {
            let (side_x, side_y) = (dy * side, dx * side);
            // To a side that was open already one step before, a way with the diagonal step first is shorter or as long.
            let is_new = !lattice.is_free(from.0 - dx + side_x, from.1 - dy + side_y);
            if is_new && lattice.is_free(from.0 + side_x, from.1 + side_y) {
                self.advance(lattice, (node, cost), (side_x, side_y), goal);
                self.advance(lattice, (node, cost), (dx + side_x, dy + side_y), goal);
            }
        }
    }

    fn advance(&mut self, lattice: &Lattice, (node, cost): (u32, u32), step: (i32, i32), goal: (i32, i32)) {
        let from = lattice.place(node);
        let found = if step.0 != 0 && step.1 != 0 {
            jump_diagonally(lattice, from, step, goal)
        } else {
            lattice.jump(from, step, goal)
        };
        let Some(place) = found else { return };
        let next = lattice.node(place.0.cast_unsigned(), place.1.cast_unsigned());
        let cost = cost + octile(from, place);
        let known = &mut self.known[next as usize];
        if known.search != self.number || cost < known.cost {
            *known = Known { search: self.number, cost, before: node };
            let rest = octile(place, goal);
            self.queue.push(Reverse((cost + rest, rest, next)));
        }
    }

    /// Follows the nodes back from the goal, and puts in those between them.
    fn trace(&self, lattice: &Lattice, goal: u32, way: &mut Vec<u32>) {
        let first = way.len();
        let mut node = goal;
        while node != NONE {
            let before = self.known[node as usize].before;
            way.push(node);
            if before != NONE {
                let (mut place, end) = (lattice.place(node), lattice.place(before));
                let step = ((end.0 - place.0).signum(), (end.1 - place.1).signum());
                loop {
                    place = (place.0 + step.0, place.1 + step.1);
                    if place == end {
                        break;
                    }
                    way.push(lattice.node(place.0.cast_unsigned(), place.1.cast_unsigned()));
                }
            }
            node = before;
        }
        way[first..].reverse();
    }
}

/// Returns the first node of a diagonal run from which a run along an axis leads to something, or the goal.
fn jump_diagonally(
    lattice: &Lattice,
    from: (i32, i32),
    step: (i32, i32),
    goal: (i32, i32),
) -> Option<(i32, i32)> {
    let mut place = from;
    loop {
        let next = (place.0 + step.0, place.1 + step.1);
        if !lattice.is_diagonal_free(place, next) {
            return None;
        }
        place = next;
        let leads = |step| lattice.jump(place, step, goal).is_some();
        if place == goal || leads((step.0, 0)) || leads((0, step.1)) {
            return Some(place);
        }
    }
}

/// Returns the cost between two nodes where nothing is in the way.
pub(crate) fn octile(a: (i32, i32), b: (i32, i32)) -> u32 {
    let (dx, dy) = (a.0.abs_diff(b.0), a.1.abs_diff(b.1));
    let (short, long) = (dx.min(dy), dx.max(dy));
    short * DIAGONAL + (long - short) * STRAIGHT
}
