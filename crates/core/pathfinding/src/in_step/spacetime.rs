//! One after the other, each around those before it, as far as a window reaches.

use crate::in_step::board::Place;
use crate::in_step::instance::Instance;
use crate::in_step::keyed::keyed;
use crate::in_step::plan::Plan;
use crate::in_step::reservations::Reservations;
use crate::in_step::search::{Outcome, Search};
use crate::in_step::way::{Surroundings, WayFinder};

/// Steps that a plan of a window looks ahead.
const WINDOW: u32 = 16;

/// Steps that are gone before the next window.
const STRIDE: usize = 8;

/// How often a window is planned in another order before it is given up.
const ATTEMPTS_MAX: u64 = 32;

/// Windowed hierarchical cooperative A* (Silver, *Cooperative Pathfinding*, 2005): agents plan one after the other in space and time,
/// each around the reservations of those before it, all for a window of some steps, of which they go half. The distances to the
/// goals guide them, as if nobody else were there beyond the window. Who finds no way is first in the next attempt.
pub(crate) struct Spacetime<'a> {
    instance: &'a Instance<'a>,
    seed: u64,
    window: u64,
    /// Of this window, those that failed.
    attempts: u64,
    order: Vec<u32>,
    reservations: Reservations,
    finder: WayFinder,
    plan: Plan,
    expanded: u64,
}

impl<'a> Spacetime<'a> {
    pub(crate) fn new(instance: &'a Instance<'a>, seed: u64) -> Self {
        Self {
            instance,
            seed,
            window: 0,
            attempts: 0,
            order: (0..).zip(instance.starts()).map(|(agent, _)| agent).collect(),
            reservations: Reservations::new(instance.board().len()),
            finder: WayFinder::new(instance.board()),
            plan: Plan::standing(instance.starts()),
            expanded: 0,
        }
    }

    fn now(&self) -> &[Place] {
        self.plan.at(self.plan.steps())
    }

    /// Plans a window, and goes half of it where there was a way for everybody. Returns whether to go on.
    fn go_on(&mut self) -> bool {
        if self.attempts == 0 {
            let (seed, window) = (self.seed, self.window);
            self.order.sort_by_key(|&agent| (keyed(seed, window, agent.into()), agent));
        }
        self.expanded += 1;
        match self.attempt() {
            Ok(ways) => {
                for step in 1..=STRIDE {
                    let at = |way: &Vec<Place>| way[step.min(way.len() - 1)];
                    let places: Vec<Place> = ways.iter().map(at).collect();
                    self.plan.push(&places);
                }
                self.window += 1;
                self.attempts = 0;
            }
            Err(stuck) => {
                self.order[..=stuck].rotate_right(1);
                self.attempts += 1;
            }
        }
        self.attempts < ATTEMPTS_MAX
    }

    /// The ways of all in this window.
    ///
    /// # Errors
    /// The place in the order of who has none.
    fn attempt(&mut self) -> Result<Vec<Vec<Place>>, usize> {
        self.reservations.clear();
        let mut ways = vec![Vec::new(); self.order.len()];
        for (index, &agent) in self.order.iter().enumerate() {
            let surroundings = Surroundings {
                board: self.instance.board(),
                reservations: &self.reservations,
                end: 0,
                distances: self.instance.distances().of(agent as usize),
                horizon: WINDOW,
                salt: keyed(self.seed, self.window, u64::from(agent) << 32),
            };
            let start = self.plan.at(self.plan.steps())[agent as usize];
            let way = self.finder.find(&surroundings, start, u32::MAX);
            let mut way = way.ok_or(index)?;
            way.truncate(WINDOW as usize + 1);
            self.reservations.add(agent, &way, WINDOW);
            ways[agent as usize] = way;
        }
        Ok(ways)
    }
}

impl Search for Spacetime<'_> {
    fn advance(&mut self, budget: u64) -> Option<Outcome> {
        let end = self.expanded.saturating_add(budget);
        loop {
            if self.now() == self.instance.goals() {
                return Some(Outcome::Solved(self.plan.clone()));
            }
            if self.expanded == end {
                return None;
            }
            if !self.go_on() {
                return Some(Outcome::Stuck);
            }
        }
    }

    fn expanded(&self) -> u64 {
        self.expanded
    }
}
