//! Distances from everywhere to one goal, for many who go there.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::DVec2;

use crate::error::{PlanError, Which};
use crate::ground::Ground;
use crate::lattice::{DIAGONAL, Lattice, STRAIGHT};
use crate::planner::check_goal;

/// The cost of a node from which the goal cannot be reached.
const FAR: u32 = u32::MAX;

/// The eight steps to neighbours, in the order in which ties are decided, with their costs.
const STEPS: [((i32, i32), u32); 8] = [
    ((1, 0), STRAIGHT),
    ((0, 1), STRAIGHT),
    ((-1, 0), STRAIGHT),
    ((0, -1), STRAIGHT),
    ((1, 1), DIAGONAL),
    ((-1, 1), DIAGONAL),
    ((-1, -1), DIAGONAL),
    ((1, -1), DIAGONAL),
];

/// The distance of every node of a ground to one goal. Who keeps it saves a search for each path there:
/// [`crate::Planner::path_by`].
#[doc(alias = "flow_field")]
#[derive(Clone, Debug)]
pub struct Field {
    goal: DVec2,
    costs: Vec<u32>,
}

impl Field {
    /// Returns the distances to a goal, by the algorithm of Dijkstra (1959).
    ///
    /// # Errors
    /// A goal that is not on the map, has no room, or is in a nook.
    pub fn new(ground: &Ground, goal: DVec2) -> Result<Self, PlanError> {
        check_goal(ground, goal)?;
        let mut first = Vec::new();
        let lattice = &ground.lattice;
        lattice.access(&ground.walls, goal, &mut first);
        if first.is_empty() {
            return Err(PlanError::Enclosed { which: Which::Goal, point: goal });
        }
        let mut costs = vec![FAR; lattice.nodes()];
        let mut queue = BinaryHeap::new();
        for node in first {
            let cost = lattice.cost_of(lattice.point(node).distance(goal));
            costs[node as usize] = cost;
            queue.push(Reverse((cost, node)));
        }
        while let Some(Reverse((cost, node))) = queue.pop() {
            if cost != costs[node as usize] {
                continue;
            }
            for (next, step) in neighbours(lattice, node) {
                let cost = cost + step;
                if cost < costs[next as usize] {
                    costs[next as usize] = cost;
                    queue.push(Reverse((cost, next)));
                }
            }
        }
        Ok(Self { goal, costs })
    }

    /// Returns the goal.
    #[must_use]
    pub fn goal(&self) -> DVec2 {
        self.goal
    }

    /// Returns about how far the goal is from a point, in world units, on steps of eight directions: up to 8 % more than
    /// the shortest way. `None` where it cannot be reached.
    #[must_use]
    pub fn distance(&self, ground: &Ground, from: DVec2) -> Option<f64> {
        let node = self.nearest(ground, from)?;
        Some(ground.lattice.point(node).distance(from) + ground.lattice.length_of(self.costs[node as usize]))
    }

    /// Returns the next point on the way to the goal, to which a circle can go straight from a point with room; the goal itself
    /// where it is straight ahead. `None` where it cannot be reached.
    #[must_use]
    pub fn next(&self, ground: &Ground, from: DVec2) -> Option<DVec2> {
        if ground.is_clear(from, self.goal) {
            return Some(self.goal);
        }
        let node = self.nearest(ground, from)?;
        let point = ground.lattice.point(node);
        let onward = self.step(&ground.lattice, node).map(|next| ground.lattice.point(next));
        Some(onward.filter(|&next| ground.is_clear(from, next)).unwrap_or(point))
    }

    /// Puts the nodes of the way from a node to the goal behind `way`, the node first.
    pub(crate) fn follow(&self, lattice: &Lattice, from: u32, way: &mut Vec<u32>) {
        assert_eq!(self.costs.len(), lattice.nodes(), "the field is of this ground");
        let mut node = from;
        way.push(node);
        while let Some(next) = self.step(lattice, node) {
            way.push(next);
            node = next;
        }
    }

    /// The neighbour through which a shortest way leads; `None` at a node that sees the goal and has no better neighbour.
    fn step(&self, lattice: &Lattice, node: u32) -> Option<u32> {
        let cost = self.costs[node as usize];
        let leads = |&(next, step): &(u32, u32)| self.costs[next as usize].checked_add(step) == Some(cost);
        neighbours(lattice, node).find(leads).map(|(next, _)| next)
    }

    /// The node near a point from which the goal is nearest.
    fn nearest(&self, ground: &Ground, from: DVec2) -> Option<u32> {
        if !ground.holds(from) {
            return None;
        }
        let mut nodes = Vec::new();
        ground.lattice.access(&ground.walls, from, &mut nodes);
        let whole = |node: u32| {
            let first = ground.lattice.cost_of(ground.lattice.point(node).distance(from));
            self.costs[node as usize].saturating_add(first)
        };
        let reached = nodes.into_iter().filter(|&node| self.costs[node as usize] != FAR);
        reached.min_by_key(|&node| (whole(node), node))
    }
}

/// The nodes to which a step leads from a node, and the costs of the steps.
fn neighbours(lattice: &Lattice, node: u32) -> impl Iterator<Item = (u32, u32)> {
    let from = lattice.place(node);
    STEPS.into_iter().filter_map(move |((dx, dy), cost)| {
        let to = (from.0 + dx, from.1 + dy);
        // Along an axis one of the two nodes beside is the start itself, the other the end.
        let is_free = lattice.is_diagonal_free(from, to);
        is_free.then(|| (lattice.node(to.0.cast_unsigned(), to.1.cast_unsigned()), cost))
    })
}
