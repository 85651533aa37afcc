//! A search through configurations that never asks for all that follow one at once.

use hashbrown::HashTable;

use crate::in_step::board::Place;
use crate::in_step::generator::{Generator, Rings, Scene};
use crate::in_step::instance::{Instance, Problem};
use crate::in_step::keyed::keyed;
use crate::in_step::plan::Plan;
use crate::in_step::priorities::{Priorities, ranks};
use crate::in_step::search::{Outcome, Search, hash_of};

/// Most places that are remembered, one for each agent and configuration: with their priorities 1.5 GiB.
const PLACES_MAX: usize = 1 << 27;

/// No configuration, or no constraint.
const NONE: u32 = u32::MAX;

/// A configuration that was reached: where everybody is.
#[derive(Clone, Copy, Debug)]
struct Node {
    /// The configuration from which it was reached first.
    parent: u32,
    /// The constraints that wait, in the order in which they are tried.
    first: u32,
    last: u32,
}

/// An agent has to go to a place, and so have others before it.
#[derive(Clone, Copy, Debug)]
struct Constraint {
    /// The constraint that holds, too; [`NONE`] for the first, which says nothing.
    parent: u32,
    agent: u32,
    place: Place,
    depth: u32,
    /// The constraint of the same configuration that is tried after it.
    next: u32,
}

/// Lazy constraints addition search (Okumura, *LaCAM: Search-Based Algorithm for Quick Multi-Agent Pathfinding*, 2023, algorithm 1):
/// depth first through configurations; what follows one is made by priority inheritance under ever more constraints, each of
/// which sends one agent more to a place. All successors come in the end, so a plan is found if there is one.
pub(crate) struct Lacam<'a> {
    problem: Problem<'a>,
    tree: Tree,
}

impl<'a> Lacam<'a> {
    pub(crate) fn new(instance: &'a Instance<'a>, seed: u64) -> Self {
        let problem = instance.problem();
        Self { problem, tree: Tree::new(problem, Rings::Allowed, seed) }
    }
}

/// What the search knows, without the problem: it is given again whenever the search goes on.
#[derive(Clone, Debug)]
pub(crate) struct Tree {
    seed: u64,
    generator: Generator,
    ranks: Vec<u32>,
    nodes: Vec<Node>,
    constraints: Vec<Constraint>,
    /// Where everybody is in each configuration; for how long everybody was away from the goal; who chooses first.
    places: Vec<Place>,
    waited: Vec<u32>,
    order: Vec<u32>,
    /// Configurations by their places. It is only ever asked for one, so that its order cannot be seen.
    known: HashTable<u32>,
    open: Vec<u32>,
    expanded: u64,
}

impl Tree {
    pub(crate) fn new(problem: Problem<'_>, rings: Rings, seed: u64) -> Self {
        let ranks = ranks(problem.distances, problem.starts);
        let mut search = Self {
            seed,
            generator: Generator::new(problem.board, problem.starts.len(), rings),
            ranks,
            nodes: Vec::new(),
            constraints: Vec::new(),
            places: Vec::new(),
            waited: Vec::new(),
            order: Vec::new(),
            known: HashTable::new(),
            open: Vec::new(),
            expanded: 0,
        };
        let mut priorities = Priorities::new(&search.ranks);
        priorities.count(problem.distances, problem.starts, &search.ranks);
        search.add(NONE, problem.starts, &priorities);
        search
    }

    /// Makes one configuration that may follow the last one, under the next constraint.
    fn expand(&mut self, problem: Problem<'_>, node: u32) {
        let Some(constraint) = self.next_constraint(node) else {
            self.open.pop();
            return;
        };
        self.expanded += 1;
        self.refine(problem, node, constraint);
        let Some(places) = self.successor(problem, node, constraint) else { return };
        if let Some(known) = self.find(&places) {
            self.open.push(known);
            return;
        }
        let range = self.range(node);
        let mut priorities =
            Priorities { waited: self.waited[range.clone()].to_vec(), order: self.order[range].to_vec() };
        priorities.count(problem.distances, &places, &self.ranks);
        self.add(node, &places, &priorities);
    }

    /// Where the data of a configuration are.
    fn range(&self, node: u32) -> std::ops::Range<usize> {
        let agents = self.ranks.len();
        node as usize * agents..(node as usize + 1) * agents
    }

    fn add(&mut self, parent: u32, places: &[Place], priorities: &Priorities) {
        let node = u32::try_from(self.nodes.len()).expect("there are fewer configurations than places");
        self.nodes.push(Node { parent, first: NONE, last: NONE });
        self.places.extend_from_slice(places);
        self.waited.extend_from_slice(&priorities.waited);
        self.order.extend_from_slice(&priorities.order);
        self.constrain(
            node,
            Constraint { parent: NONE, agent: 0, place: Place::NOWHERE, depth: 0, next: NONE },
        );
        let Self { known, places: all, ranks, .. } = self;
        let agents = ranks.len();
        let places_of = |node: u32| &all[node as usize * agents..(node as usize + 1) * agents];
        known.insert_unique(hash_of(places), node, |&node| hash_of(places_of(node)));
        self.open.push(node);
    }

    fn find(&self, places: &[Place]) -> Option<u32> {
        self.known.find(hash_of(places), |&node| self.places[self.range(node)] == *places).copied()
    }

    /// Puts a constraint behind those of a configuration.
    fn constrain(&mut self, node: u32, constraint: Constraint) {
        let number = u32::try_from(self.constraints.len()).expect("constraints are counted in 32 bits");
        self.constraints.push(constraint);
        let node = &mut self.nodes[node as usize];
        if node.last == NONE {
            node.first = number;
        } else {
            self.constraints[node.last as usize].next = number;
        }
        node.last = number;
    }

    fn next_constraint(&mut self, node: u32) -> Option<u32> {
        let node = &mut self.nodes[node as usize];
        let first = node.first;
        if first == NONE {
            return None;
        }
        node.first = self.constraints[first as usize].next;
        if node.first == NONE {
            node.last = NONE;
        }
        Some(first)
    }

    /// Adds the constraints that follow one: the next agent, and each place to which it can go.
    fn refine(&mut self, problem: Problem<'_>, node: u32, parent: u32) {
        let depth = self.constraints[parent as usize].depth;
        if depth as usize == self.ranks.len() {
            return;
        }
        let agent = self.order[self.range(node)][depth as usize];
        let now = self.places[self.range(node)][agent as usize];
        let mut choices: Vec<Place> = problem.board.neighbours(now).to_vec();
        choices.push(now);
        choices.sort_by_key(|place| keyed(self.seed, u64::from(place.0), self.expanded));
        for place in choices {
            self.constrain(node, Constraint { parent, agent, place, depth: depth + 1, next: NONE });
        }
    }

    /// Returns a configuration that follows a node and keeps to a constraint; `None` where none was found.
    fn successor(&mut self, problem: Problem<'_>, node: u32, constraint: u32) -> Option<Vec<Place>> {
        let range = self.range(node);
        let now = &self.places[range.clone()];
        let scene = Scene {
            board: problem.board,
            distances: problem.distances,
            now,
            seed: self.seed,
            step: self.expanded,
        };
        self.generator.begin(&scene);
        let mut is_fit = true;
        let mut next = constraint;
        while is_fit && next != NONE {
            let Constraint { parent, agent, place, depth, .. } = self.constraints[next as usize];
            is_fit = depth == 0 || self.generator.fix(&scene, agent, place);
            next = parent;
        }
        is_fit = is_fit && self.order[range].iter().all(|&agent| self.generator.choose(&scene, agent));
        if is_fit {
            return Some(self.generator.finish(now));
        }
        self.generator.reset(now);
        None
    }

    /// The plan from the starts to a configuration.
    fn plan(&self, problem: Problem<'_>, node: u32) -> Plan {
        let mut nodes = vec![node];
        while let Some(&last) = nodes.last().filter(|&&last| self.nodes[last as usize].parent != NONE) {
            nodes.push(self.nodes[last as usize].parent);
        }
        let mut plan = Plan::standing(problem.starts);
        for &node in nodes.iter().rev().skip(1) {
            plan.push(&self.places[self.range(node)]);
        }
        plan
    }

    /// Expands at most so many states more, and returns how the search ended; `None` where it goes on.
    pub(crate) fn advance(&mut self, problem: Problem<'_>, budget: u64) -> Option<Outcome> {
        let end = self.expanded.saturating_add(budget);
        while let Some(&node) = self.open.last() {
            if self.places[self.range(node)] == *problem.goals {
                return Some(Outcome::Solved(self.plan(problem, node)));
            }
            if self.places.len() + self.ranks.len() > PLACES_MAX {
                return Some(Outcome::Stuck);
            }
            if self.expanded == end {
                return None;
            }
            self.expand(problem, node);
        }
        Some(Outcome::Unsolvable)
    }

    pub(crate) fn expanded(&self) -> u64 {
        self.expanded
    }
}

impl Search for Lacam<'_> {
    fn advance(&mut self, budget: u64) -> Option<Outcome> {
        self.tree.advance(self.problem, budget)
    }

    fn expanded(&self) -> u64 {
        self.tree.expanded()
    }
}
