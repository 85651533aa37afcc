//! All ways from nothing, one after the other.

use std::collections::VecDeque;

use crate::in_step::board::Place;
use crate::in_step::instance::Instance;
use crate::in_step::keyed::keyed;
use crate::in_step::reservations::{FOREVER, Reservations};
use crate::in_step::way::{Surroundings, WayFinder};

/// How many ways are taken back for each agent, in the mean, before all is given up.
const EVICTIONS_AN_AGENT: usize = 4;

/// How planning one after the other stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Standing {
    /// Some have no way yet.
    Goes,
    /// All have a way.
    Done,
    /// Too many ways were taken back.
    GaveUp,
}

/// Plans all agents one after the other around those that have their ways (Erdmann and Lozano-Pérez, *On Multiple Moving Objects*,
/// 1987). Who finds no way takes a shortest one as if it were alone, and whoever is in that plans anew.
#[derive(Clone, Debug)]
pub(crate) struct Prioritized {
    /// Empty for who has none.
    ways: Vec<Vec<Place>>,
    reservations: Reservations,
    waiting: VecDeque<u32>,
    evictions: usize,
    rounds: u64,
}

impl Prioritized {
    /// Begins with those who have least far to go: they are where they stay before the others come, who go around them. The other
    /// way round they would have to wait until the last one has come past.
    pub(crate) fn new(instance: &Instance<'_>) -> Self {
        let mut order: Vec<u32> = (0..).zip(instance.starts()).map(|(agent, _)| agent).collect();
        let distance = |agent: u32| {
            let agent = agent as usize;
            instance.distances().of(agent)[instance.starts()[agent].index()]
        };
        order.sort_by_key(|&agent| (distance(agent), agent));
        Self {
            ways: vec![Vec::new(); instance.agents()],
            reservations: Reservations::new(instance.board().len()),
            waiting: order.into(),
            evictions: 0,
            rounds: 0,
        }
    }

    /// Plans for one agent.
    pub(crate) fn go_on(&mut self, instance: &Instance<'_>, finder: &mut WayFinder, seed: u64) -> Standing {
        let Some(agent) = self.waiting.pop_front() else { return Standing::Done };
        self.rounds += 1;
        let start = instance.starts()[agent as usize];
        let surroundings = Surroundings {
            board: instance.board(),
            reservations: &self.reservations,
            end: self.reservations.free_from(instance.goals()[agent as usize]),
            distances: instance.distances().of(agent as usize),
            horizon: FOREVER,
            salt: keyed(seed, self.rounds, agent.into()),
        };
        let way = match finder.find(&surroundings, start, FOREVER) {
            Some(way) => way,
            None => {
                let way = alone(&surroundings, start);
                self.evict(&way);
                way
            }
        };
        self.reservations.add(agent, &way, FOREVER);
        self.ways[agent as usize] = way;
        if self.evictions > EVICTIONS_AN_AGENT * self.ways.len() {
            return Standing::GaveUp;
        }
        if self.waiting.is_empty() { Standing::Done } else { Standing::Goes }
    }

    /// Returns the ways and their reservations.
    pub(crate) fn finish(self) -> (Vec<Vec<Place>>, Reservations) {
        assert!(self.waiting.is_empty(), "all have a way");
        (self.ways, self.reservations)
    }

    /// Takes back the ways of all who are in a way.
    fn evict(&mut self, way: &[Place]) {
        for agent in self.reservations.conflicts(way) {
            self.reservations.remove(agent, &self.ways[agent as usize], FOREVER);
            self.ways[agent as usize].clear();
            self.waiting.push_front(agent);
            self.evictions += 1;
        }
    }
}

/// A shortest way of one alone.
fn alone(surroundings: &Surroundings<'_>, start: Place) -> Vec<Place> {
    let mut way = vec![start];
    let mut place = start;
    while surroundings.distances[place.index()] > 0 {
        let distance = surroundings.distances[place.index()];
        let nearer = |next: &Place| surroundings.distances[next.index()] < distance;
        place =
            surroundings.around(place).find(nearer).expect("a place with a distance has a nearer neighbour");
        way.push(place);
    }
    way
}
