//! One step after the other, each made for all and without looking back.

use crate::in_step::board::{Board, Place};
use crate::in_step::distances::Distances;
use crate::in_step::generator::{Generator, Rings, Scene};
use crate::in_step::instance::Instance;
use crate::in_step::plan::Plan;
use crate::in_step::priorities::{Priorities, ranks};
use crate::in_step::search::{Outcome, Search};

/// Moves agents step by step, for a loop that looks at the world in between. No two ever meet or change places; whoever has been
/// away from its goal for longest goes first. Where passages have no second way it can shuffle for ever.
#[doc(alias = "priority_inheritance_with_backtracking")]
#[derive(Clone, Debug)]
pub struct Pibt<'a> {
    board: &'a Board,
    seed: u64,
    step: u64,
    generator: Generator,
    priorities: Priorities,
    ranks: Vec<u32>,
    now: Vec<Place>,
}

impl<'a> Pibt<'a> {
    /// Returns what moves agents from their places; the seed decides ties.
    #[must_use]
    pub fn new(board: &'a Board, distances: &Distances, places: &[Place], seed: u64) -> Self {
        Self::with_rings((board, Rings::Allowed), distances, places, seed)
    }

    /// Returns the same, with or without rings of agents that follow each other.
    pub(crate) fn with_rings(
        (board, rings): (&'a Board, Rings),
        distances: &Distances,
        places: &[Place],
        seed: u64,
    ) -> Self {
        let ranks = ranks(distances, places);
        Self {
            board,
            seed,
            step: 0,
            generator: Generator::new(board, places.len(), rings),
            priorities: Priorities::new(&ranks),
            ranks,
            now: places.to_vec(),
        }
    }

    /// Moves everybody by one step and returns where they are then. The goals are those of the distances, which may be others than
    /// before, and which agents may share.
    ///
    /// # Panics
    /// With distances for fewer agents, or of another board.
    pub fn step(&mut self, distances: &Distances) -> &[Place] {
        let Self { board, seed, step, generator, priorities, ranks, now } = self;
        priorities.count(distances, now, ranks);
        let before = std::mem::take(now);
        let scene = Scene { board, distances, now: &before, seed: *seed, step: *step };
        generator.begin(&scene);
        for &agent in &priorities.order {
            generator.choose(&scene, agent);
        }
        *now = generator.finish(&before);
        *step += 1;
        &self.now
    }

    /// Returns where the agents are.
    #[must_use]
    pub fn places(&self) -> &[Place] {
        &self.now
    }
}

/// Plans by such steps.
pub(crate) struct Steps<'a> {
    instance: &'a Instance<'a>,
    pibt: Pibt<'a>,
    plan: Plan,
}

impl<'a> Steps<'a> {
    pub(crate) fn new(instance: &'a Instance<'a>, seed: u64) -> Self {
        let pibt = Pibt::new(instance.board(), instance.distances(), instance.starts(), seed);
        Self { instance, pibt, plan: Plan::standing(instance.starts()) }
    }
}

impl Search for Steps<'_> {
    fn advance(&mut self, budget: u64) -> Option<Outcome> {
        for _ in 0..budget {
            if self.pibt.places() == self.instance.goals() {
                break;
            }
            self.plan.push(self.pibt.step(self.instance.distances()));
        }
        (self.pibt.places() == self.instance.goals()).then(|| Outcome::Solved(self.plan.clone()))
    }

    fn expanded(&self) -> u64 {
        self.pibt.step
    }
}
