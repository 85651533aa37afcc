//! Each agent alone, and where two conflict, one of them elsewhere.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, BinaryHeap};

use crate::in_step::board::Place;
use crate::in_step::instance::Instance;
use crate::in_step::plan::Plan;
use crate::in_step::search::{Outcome, Search};

/// Most steps in all ways that are remembered: some gigabytes.
const STEPS_MAX: usize = 1 << 28;

/// No node.
const NONE: u32 = u32::MAX;

/// What an agent must not do: be in `place` after `step`; or, with `from`, come there from it in that step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Ban {
    agent: usize,
    step: usize,
    place: Place,
    from: Option<Place>,
}

/// Ways of all that keep to some bans.
struct Node {
    parent: u32,
    /// The ban that its parent does not have.
    ban: Option<Ban>,
    ways: Vec<Vec<Place>>,
}

/// Conflict-based search (Sharon, Stern, Felner and Sturtevant, *Conflict-Based Search for Optimal Multi-Agent Pathfinding*, 2015): the
/// least sum of costs. Everybody has a shortest way alone; for the first conflict of two there are two ways on: one of the two
/// is banned from it, or the other. Without a plan it goes on for ever, so its budget has to end it.
pub(crate) struct Conflict<'a> {
    instance: &'a Instance<'a>,
    nodes: Vec<Node>,
    /// By the sum of costs, then by how many pairs conflict.
    open: BinaryHeap<Reverse<(usize, usize, u32)>>,
    /// Steps in all ways.
    steps: usize,
    expanded: u64,
}

impl<'a> Conflict<'a> {
    pub(crate) fn new(instance: &'a Instance<'a>) -> Self {
        let mut search = Self { instance, nodes: Vec::new(), open: BinaryHeap::new(), steps: 0, expanded: 0 };
        let way = |agent| search.way(agent, &BTreeSet::new()).expect("everybody can reach the goal alone");
        let ways = (0..instance.agents()).map(way).collect();
        search.add(Node { parent: NONE, ban: None, ways });
        search
    }

    fn add(&mut self, node: Node) {
        let number = u32::try_from(self.nodes.len()).expect("nodes are limited by their steps");
        let cost = node.ways.iter().map(|way| way.len() - 1).sum();
        let (_, conflicts) = conflicts(&node.ways);
        self.open.push(Reverse((cost, conflicts, number)));
        self.steps += cost + node.ways.len();
        self.nodes.push(node);
    }

    /// Adds a node with one ban more, if the agent has a way then.
    fn branch(&mut self, parent: u32, ban: Ban) {
        let mut bans = BTreeSet::from([ban]);
        let mut number = parent;
        while number != NONE {
            let node = &self.nodes[number as usize];
            bans.extend(node.ban.filter(|other| other.agent == ban.agent));
            number = node.parent;
        }
        if let Some(way) = self.way(ban.agent, &bans) {
            let mut ways = self.nodes[parent as usize].ways.clone();
            ways[ban.agent] = way;
            self.add(Node { parent, ban: Some(ban), ways });
        }
    }

    /// Returns a shortest way of an agent that keeps to bans, by A* in space and time; `None` where there is none.
    fn way(&self, agent: usize, bans: &BTreeSet<Ban>) -> Option<Vec<Place>> {
        let (start, goal) = (self.instance.starts()[agent], self.instance.goals()[agent]);
        let distances = self.instance.distances().of(agent);
        // Behind the last ban one step is like another.
        let last = bans.iter().map(|ban| ban.step).max().unwrap_or(0);
        let stays_from =
            bans.iter().filter(|ban| ban.place == goal && ban.from.is_none()).map(|ban| ban.step + 1);
        let stays_from = stays_from.max().unwrap_or(0);
        let is_banned = |step: usize, place: Place, from: Place| {
            let ban = |from| Ban { agent, step, place, from };
            bans.contains(&ban(None)) || bans.contains(&ban(Some(from)))
        };
        let mut parents = BTreeMap::from([((start, 0), None)]);
        let mut open = BinaryHeap::from([Reverse((distances[start.index()], Reverse(0), start))]);
        while let Some(Reverse((_, Reverse(step), place))) = open.pop() {
            if place == goal && step >= stays_from {
                return Some(traced(&parents, (place, step)));
            }
            let next = step + 1;
            for &to in self.instance.board().neighbours(place).iter().chain(std::iter::once(&place)) {
                let is_known = next > last + 1 && parents.contains_key(&(to, last + 1));
                if is_known || parents.contains_key(&(to, next)) || is_banned(next, to, place) {
                    continue;
                }
                parents.insert((to, next), Some((place, step)));
                let cost =
                    u32::try_from(next).expect("ways are shorter than 2^32 steps") + distances[to.index()];
                open.push(Reverse((cost, Reverse(next), to)));
            }
        }
        None
    }
}

impl Search for Conflict<'_> {
    fn advance(&mut self, budget: u64) -> Option<Outcome> {
        let end = self.expanded.saturating_add(budget);
        while let Some(&Reverse((_, _, number))) = self.open.peek() {
            let (first, _) = conflicts(&self.nodes[number as usize].ways);
            let Some(bans) = first else {
                return Some(Outcome::Solved(Plan::of_ways(&self.nodes[number as usize].ways)));
            };
            if self.steps > STEPS_MAX {
                return Some(Outcome::Stuck);
            }
            if self.expanded == end {
                return None;
            }
            self.open.pop();
            self.expanded += 1;
            for ban in bans {
                self.branch(number, ban);
            }
        }
        Some(Outcome::Unsolvable)
    }

    fn expanded(&self) -> u64 {
        self.expanded
    }
}

/// The way to a place and step, from the start on.
fn traced(parents: &BTreeMap<(Place, usize), Option<(Place, usize)>>, last: (Place, usize)) -> Vec<Place> {
    let mut way = vec![last.0];
    let mut at = last;
    while let Some(Some(parent)) = parents.get(&at) {
        way.push(parent.0);
        at = *parent;
    }
    way.reverse();
    way
}

/// The bans that end the first conflict, one for either agent, and how many pairs conflict.
fn conflicts(ways: &[Vec<Place>]) -> (Option<[Ban; 2]>, usize) {
    let mut first: Option<[Ban; 2]> = None;
    let mut count = 0;
    for one in 0..ways.len() {
        for other in one + 1..ways.len() {
            if let Some(bans) = conflict(ways, one, other) {
                count += 1;
                if first.is_none_or(|first| bans[0].step < first[0].step) {
                    first = Some(bans);
                }
            }
        }
    }
    (first, count)
}

/// The bans that end the first conflict of two.
fn conflict(ways: &[Vec<Place>], one: usize, other: usize) -> Option<[Ban; 2]> {
    let at = |agent: usize, step: usize| ways[agent][step.min(ways[agent].len() - 1)];
    let steps = ways[one].len().max(ways[other].len());
    (1..steps).find_map(|step| {
        let (place, second) = (at(one, step), at(other, step));
        if place == second {
            let ban = |agent| Ban { agent, step, place, from: None };
            return Some([ban(one), ban(other)]);
        }
        let (from, before) = (at(one, step - 1), at(other, step - 1));
        let ban = |agent, place, from| Ban { agent, step, place, from: Some(from) };
        (place == before && second == from).then(|| [ban(one, place, from), ban(other, second, before)])
    })
}
