//! Who chooses first.

use crate::in_step::board::Place;
use crate::in_step::distances::Distances;

/// Who chooses first: who has been away from its goal for longest; among those the one that had farthest to go.
#[derive(Clone, Debug)]
pub(crate) struct Priorities {
    /// For how many steps each agent has been away from its goal.
    pub(crate) waited: Vec<u32>,
    /// The agents, first of all first.
    pub(crate) order: Vec<u32>,
}

/// The rank of each agent among those who have waited as long: 0 for who is farthest from its goal.
pub(crate) fn ranks(distances: &Distances, now: &[Place]) -> Vec<u32> {
    let mut order: Vec<usize> = (0..now.len()).collect();
    order.sort_by_key(|&agent| (std::cmp::Reverse(distances.of(agent)[now[agent].index()]), agent));
    let mut ranks = vec![0; now.len()];
    for (rank, agent) in (0..).zip(order) {
        ranks[agent] = rank;
    }
    ranks
}

impl Priorities {
    pub(crate) fn new(ranks: &[u32]) -> Self {
        let mut order: Vec<u32> = (0..).zip(ranks).map(|(agent, _)| agent).collect();
        order.sort_unstable_by_key(|&agent| ranks[agent as usize]);
        Self { waited: vec![0; ranks.len()], order }
    }

    /// Counts a step after which the agents are at `now`.
    pub(crate) fn count(&mut self, distances: &Distances, now: &[Place], ranks: &[u32]) {
        for (agent, (waited, place)) in self.waited.iter_mut().zip(now).enumerate() {
            *waited = if distances.of(agent)[place.index()] == 0 { 0 } else { *waited + 1 };
        }
        let waited = &self.waited;
        // The order hardly changes from step to step, and this sort is quick on what is nearly sorted.
        self.order.sort_by_key(|&agent| (std::cmp::Reverse(waited[agent as usize]), ranks[agent as usize]));
    }
}
