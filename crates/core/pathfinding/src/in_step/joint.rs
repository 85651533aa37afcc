//! All agents as one, in the space of all their places together.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use hashbrown::HashTable;

use crate::in_step::board::Place;
use crate::in_step::instance::Instance;
use crate::in_step::plan::Plan;
use crate::in_step::search::{Outcome, Search, hash_of};

/// Most agents: one expansion has up to 5^8 = 390,625 successors.
pub const JOINT_AGENTS_MAX: usize = 8;

/// Most states that are remembered: some gigabytes.
const STATES_MAX: usize = 1 << 25;

/// No state.
const NONE: u32 = u32::MAX;

/// Where all are, and who stays there for good.
#[derive(Clone, Copy, Debug)]
struct State {
    parent: u32,
    /// The costs of all up to here.
    cost: u32,
    /// A bit for each agent that is at its goal and stays.
    rests: u32,
    is_done: bool,
}

/// A* over joint moves: the least sum of costs, in the space of the places of all agents. A move costs a step for each agent that
/// does not rest yet, and to rest is a choice of its own at the goal, never taken back: so the costs of a plan add up move by move.
pub(crate) struct Joint<'a> {
    instance: &'a Instance<'a>,
    states: Vec<State>,
    /// The places of all agents in each state.
    places: Vec<Place>,
    /// States by their places and who rests. It is only ever asked for one, so that its order cannot be seen.
    known: HashTable<u32>,
    /// By the least cost of a plan through the state, then by the steps that are missing.
    open: BinaryHeap<Reverse<(u32, u32, u32)>>,
    expanded: u64,
}

impl<'a> Joint<'a> {
    /// # Panics
    /// With more than [`JOINT_AGENTS_MAX`] agents.
    pub(crate) fn new(instance: &'a Instance<'a>) -> Self {
        assert!(instance.agents() <= JOINT_AGENTS_MAX, "the planner was asked for its limit");
        let mut search = Self {
            instance,
            states: Vec::new(),
            places: Vec::new(),
            known: HashTable::new(),
            open: BinaryHeap::new(),
            expanded: 0,
        };
        search.reach_resting(NONE, 0, 0, instance.starts());
        search
    }

    fn places_of(&self, state: u32) -> &[Place] {
        let agents = self.instance.agents();
        &self.places[state as usize * agents..(state as usize + 1) * agents]
    }

    /// Reaches places with every choice of who rests from now on, of those who are at their goals.
    fn reach_resting(&mut self, parent: u32, cost: u32, rests: u32, places: &[Place]) {
        let is_there = |agent: &usize| places[*agent] == self.instance.goals()[*agent];
        let may = (0..places.len()).filter(is_there).fold(0, |bits, agent| bits | 1 << agent) & !rests;
        let mut more = may;
        loop {
            self.reach(State { parent, cost, rests: rests | more, is_done: false }, places);
            if more == 0 {
                return;
            }
            // The next smaller choice.
            more = (more - 1) & may;
        }
    }

    fn reach(&mut self, state: State, places: &[Place]) {
        let key =
            |rests: u32, places: &[Place]| hash_of(places).wrapping_add(u64::from(rests).rotate_left(40));
        let hash = key(state.rests, places);
        let is_it = |&other: &u32| {
            self.states[other as usize].rests == state.rests && self.places_of(other) == places
        };
        let number = if let Some(&number) = self.known.find(hash, is_it) {
            let known = &mut self.states[number as usize];
            if known.cost <= state.cost {
                return;
            }
            *known = state;
            number
        } else {
            let number = u32::try_from(self.states.len()).expect("states are limited");
            self.states.push(state);
            self.places.extend_from_slice(places);
            let Self { known, states, places, instance, .. } = self;
            let agents = instance.agents();
            known.insert_unique(hash, number, |&other| {
                let at = other as usize;
                key(states[at].rests, &places[at * agents..(at + 1) * agents])
            });
            number
        };
        let missing: u32 = (0..places.len())
            .filter(|agent| state.rests >> agent & 1 == 0)
            .map(|agent| self.instance.distances().of(agent)[places[agent].index()])
            .sum();
        self.open.push(Reverse((state.cost + missing, missing, number)));
    }

    fn expand(&mut self, number: u32) {
        let state = self.states[number as usize];
        let now = self.places_of(number).to_vec();
        let moving = u32::try_from(now.len()).expect("agents are few") - state.rests.count_ones();
        let mut next = Vec::with_capacity(now.len());
        let mut found = Vec::new();
        self.moves(&now, state.rests, &mut next, &mut found);
        for places in found.chunks(now.len()) {
            self.reach_resting(number, state.cost + moving, state.rests, places);
        }
    }

    /// Puts all moves of the agents from `next.len()` on behind `found`.
    fn moves(&self, now: &[Place], rests: u32, next: &mut Vec<Place>, found: &mut Vec<Place>) {
        let agent = next.len();
        let Some(&from) = now.get(agent) else {
            found.extend_from_slice(next);
            return;
        };
        let around = if rests >> agent & 1 == 0 { self.instance.board().neighbours(from) } else { &[] };
        for &to in around.iter().chain(std::iter::once(&from)) {
            let is_taken =
                (0..agent).any(|other| next[other] == to || (next[other] == from && now[other] == to));
            if !is_taken {
                next.push(to);
                self.moves(now, rests, next, found);
                next.pop();
            }
        }
    }

    fn plan(&self, last: u32) -> Plan {
        let mut numbers = vec![last];
        let mut number = last;
        while self.states[number as usize].parent != NONE {
            number = self.states[number as usize].parent;
            numbers.push(number);
        }
        let mut plan = Plan::standing(self.instance.starts());
        for &number in numbers.iter().rev().skip(1) {
            plan.push(self.places_of(number));
        }
        plan
    }
}

impl Search for Joint<'_> {
    fn advance(&mut self, budget: u64) -> Option<Outcome> {
        let end = self.expanded.saturating_add(budget);
        let all_rest = (1 << self.instance.agents()) - 1;
        loop {
            if self.states.len() > STATES_MAX {
                return Some(Outcome::Stuck);
            }
            if self.expanded == end {
                return None;
            }
            let Some(&Reverse((_, _, number))) = self.open.peek() else { return Some(Outcome::Unsolvable) };
            let state = self.states[number as usize];
            if state.rests == all_rest {
                return Some(Outcome::Solved(self.plan(number)));
            }
            self.open.pop();
            if !state.is_done {
                self.states[number as usize].is_done = true;
                self.expanded += 1;
                self.expand(number);
            }
        }
    }

    fn expanded(&self) -> u64 {
        self.expanded
    }
}
