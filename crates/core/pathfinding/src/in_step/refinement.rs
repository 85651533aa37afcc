//! A plan made better, as long as there is time.

use crate::in_step::board::Place;
use crate::in_step::instance::Instance;
use crate::in_step::keyed::keyed;
use crate::in_step::plan::Plan;
use crate::in_step::prioritized::{Prioritized, Standing};
use crate::in_step::reservations::{FOREVER, Reservations};
use crate::in_step::way::{Surroundings, WayFinder};

/// How many agents a round plans anew at most.
const NEIGHBOURHOOD_MAX: usize = 8;

/// Of so many agents, taken by chance, the one that loses most is looked at.
const CONTESTANTS: u64 = 4;

/// What a random number is for.
#[derive(Clone, Copy, Debug)]
enum Purpose {
    Contestant,
    Place,
    Order,
    Tie,
}

/// Makes a plan cheaper by large-neighbourhood search (Li, Chen, Harabor, Stuckey and Koenig, *Anytime Multi-Agent Path Finding via
/// Large Neighborhood Search*, 2021): a round takes the ways of a few agents back and plans them one after the other around all
/// others; what is not worse is kept. So the plan can be walked at any time.
#[derive(Clone, Debug)]
pub struct Refinement<'a> {
    instance: &'a Instance<'a>,
    seed: u64,
    round: u64,
    ways: Vec<Vec<Place>>,
    reservations: Reservations,
    finder: WayFinder,
    /// Another plan, from nothing, while it is made.
    fresh: Option<Prioritized>,
    /// The agents of this round.
    chosen: Vec<u32>,
    cost: u64,
}

impl<'a> Refinement<'a> {
    /// Returns the refinement of a plan; the seed decides whom a round takes.
    ///
    /// # Panics
    /// With a plan that does not solve the instance.
    #[must_use]
    pub fn new(instance: &'a Instance<'a>, plan: &Plan, seed: u64) -> Self {
        let ways: Vec<Vec<Place>> = plan.ways();
        let mut reservations = Reservations::new(instance.board().len());
        for (agent, way) in (0..).zip(&ways) {
            reservations.add(agent, way, FOREVER);
        }
        let cost = ways.iter().map(|way| u64::from(cost(way))).sum();
        let finder = WayFinder::new(instance.board());
        let fresh = Some(Prioritized::new(instance));
        Self { instance, seed, round: 0, ways, reservations, finder, fresh, chosen: Vec::new(), cost }
    }

    /// Goes on by so many rounds.
    pub fn improve(&mut self, rounds: u64) {
        for _ in 0..rounds {
            if self.cost == self.instance.sum_of_costs_min() {
                return;
            }
            if let Some(fresh) = &mut self.fresh {
                match fresh.go_on(self.instance, &mut self.finder, self.seed) {
                    Standing::Goes => {}
                    Standing::Done => self.compare(),
                    Standing::GaveUp => self.fresh = None,
                }
            } else {
                self.choose();
                self.plan_anew();
            }
            self.round += 1;
        }
    }

    /// Returns the sum of costs of the plan as it is.
    #[must_use]
    pub fn sum_of_costs(&self) -> u64 {
        self.cost
    }

    /// Returns how many ways were looked for: states of the searches that were expanded.
    #[must_use]
    pub fn expanded(&self) -> u64 {
        self.finder.expanded
    }

    /// Returns the plan as it is.
    #[must_use]
    pub fn plan(&self) -> Plan {
        Plan::of_ways(&self.ways)
    }

    /// Takes the plan that was made from nothing, if it is cheaper.
    fn compare(&mut self) {
        let (ways, reservations) = self.fresh.take().expect("there is one").finish();
        let cost = ways.iter().map(|way| u64::from(cost(way))).sum();
        if cost < self.cost {
            (self.ways, self.reservations, self.cost) = (ways, reservations, cost);
        }
    }

    /// Draws a number below `end` for this round.
    fn draw(&self, purpose: Purpose, index: u64, end: usize) -> usize {
        let bits = keyed(self.seed ^ (purpose as u64) << 60, self.round, index);
        usize::try_from(bits % end as u64).expect("it is below a length")
    }

    /// How much longer the way of an agent is than if it were alone.
    fn loss(&self, agent: u32) -> u32 {
        let way = &self.ways[agent as usize];
        cost(way) - self.instance.distances().of(agent as usize)[way[0].index()]
    }

    /// Chooses who plans anew: every other round one that loses much and those who are in its way, else one alone.
    fn choose(&mut self) {
        let agents = self.instance.agents();
        let contestants = (0..CONTESTANTS).map(|index| self.draw(Purpose::Contestant, index, agents));
        let contestants = contestants.map(|agent| u32::try_from(agent).expect("agents are few"));
        let loser =
            contestants.max_by_key(|&agent| (self.loss(agent), agent)).expect("there are contestants");
        self.chosen.clear();
        self.chosen.push(loser);
        self.add_blockers(loser);
        self.add_visitors(loser);
    }

    /// Adds those who are where an agent had better be.
    fn add_blockers(&mut self, agent: u32) {
        let distances = self.instance.distances().of(agent as usize);
        let way = &self.ways[agent as usize];
        for (step, places) in (1..).zip(way.windows(2)) {
            if distances[places[1].index()] < distances[places[0].index()] {
                continue;
            }
            for &better in self.instance.board().neighbours(places[0]) {
                if distances[better.index()] >= distances[places[0].index()] {
                    continue;
                }
                let blockers = [self.reservations.at(better, step), self.reservations.at(better, step - 1)];
                for other in blockers.into_iter().flatten() {
                    if self.chosen.len() < NEIGHBOURHOOD_MAX && !self.chosen.contains(&other) {
                        self.chosen.push(other);
                    }
                }
            }
        }
    }

    /// Adds some who are ever in places of an agent's way.
    fn add_visitors(&mut self, agent: u32) {
        let way = &self.ways[agent as usize];
        for index in 0..NEIGHBOURHOOD_MAX as u64 {
            let place = way[self.draw(Purpose::Place, index, way.len())];
            for other in self.reservations.visitors(place) {
                if self.chosen.len() < NEIGHBOURHOOD_MAX && !self.chosen.contains(&other) {
                    self.chosen.push(other);
                }
            }
        }
    }

    /// Plans the chosen ones anew, and keeps what is not worse.
    fn plan_anew(&mut self) {
        let mut chosen = std::mem::take(&mut self.chosen);
        chosen.sort_by_key(|&agent| {
            (keyed(self.seed ^ (Purpose::Order as u64) << 60, self.round, agent.into()), agent)
        });
        for &agent in &chosen {
            self.reservations.remove(agent, &self.ways[agent as usize], FOREVER);
        }
        let old: u64 = chosen.iter().map(|&agent| u64::from(cost(&self.ways[agent as usize]))).sum();
        let least = |agent: u32| u64::from(cost(&self.ways[agent as usize]) - self.loss(agent));
        // What may still be lost by all together.
        let mut slack = old - chosen.iter().map(|&agent| least(agent)).sum::<u64>();
        let mut found: Vec<Vec<Place>> = Vec::with_capacity(chosen.len());
        for &agent in &chosen {
            let surroundings = Surroundings {
                board: self.instance.board(),
                reservations: &self.reservations,
                end: self.reservations.free_from(self.instance.goals()[agent as usize]),
                distances: self.instance.distances().of(agent as usize),
                horizon: FOREVER,
                salt: keyed(self.seed ^ (Purpose::Tie as u64) << 60, self.round, agent.into()),
            };
            let start = self.ways[agent as usize][0];
            let least = u64::from(surroundings.distances[start.index()]);
            let bound = u32::try_from(least + slack + 1).unwrap_or(FOREVER);
            let Some(way) = self.finder.find(&surroundings, start, bound) else { break };
            slack -= u64::from(cost(&way)) - least;
            self.reservations.add(agent, &way, FOREVER);
            found.push(way);
        }
        self.keep(&chosen, found, old);
        self.chosen = chosen;
    }

    /// Keeps the new ways, if all were found; else puts the old ones back.
    fn keep(&mut self, chosen: &[u32], found: Vec<Vec<Place>>, old: u64) {
        if found.len() < chosen.len() {
            for (&agent, way) in chosen.iter().zip(&found) {
                self.reservations.remove(agent, way, FOREVER);
            }
            for &agent in chosen {
                self.reservations.add(agent, &self.ways[agent as usize], FOREVER);
            }
            return;
        }
        let new: u64 = found.iter().map(|way| u64::from(cost(way))).sum();
        assert!(new <= old, "ways that cost more are not found");
        self.cost -= old - new;
        for (&agent, way) in chosen.iter().zip(found) {
            self.ways[agent as usize] = way;
        }
    }
}

/// What a way costs: its steps.
fn cost(way: &[Place]) -> u32 {
    u32::try_from(way.len() - 1).expect("ways are shorter than 2^32 steps")
}
