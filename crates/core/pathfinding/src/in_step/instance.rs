//! Who has to get where.

use thiserror::Error;

use crate::in_step::board::{Board, Place};
use crate::in_step::distances::{Distances, FAR};

/// Most agents of an instance: each step looks at all of them, and a plan holds a place for each and step.
pub const AGENTS_MAX: usize = 1 << 14;

/// Most distances of an instance, one for each place and different goal: 2 GiB.
pub const DISTANCES_MAX: usize = 1 << 29;

/// Why starts and goals are no instance. Agents are numbered from 0 on.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum InstanceError {
    /// Not as many goals as starts.
    #[error("{starts} starts and {goals} goals; give each agent one of both")]
    Count {
        /// How many starts.
        starts: usize,
        /// How many goals.
        goals: usize,
    },
    /// More agents than are planned for.
    #[error("{agents} agents; {AGENTS_MAX} are the most")]
    Agents {
        /// How many.
        agents: usize,
    },
    /// The distances would take too much memory.
    #[error(
        "{goals} goals on {places} places need {} distances; {DISTANCES_MAX} are the most: plan for fewer agents, or on a \
         smaller map",
        goals * places
    )]
    Distances {
        /// How many different goals.
        goals: usize,
        /// How many places.
        places: usize,
    },
    /// Two begin in the same place.
    #[error("agents {first} and {second} start at the same place; move one of them")]
    SameStart {
        /// The one.
        first: usize,
        /// The other.
        second: usize,
    },
    /// Two end in the same place.
    #[error("agents {first} and {second} have the same goal; give one of them another")]
    SameGoal {
        /// The one.
        first: usize,
        /// The other.
        second: usize,
    },
    /// There is no way from start to goal, even for one alone.
    #[error(
        "no way leads from the start of agent {agent} to its goal; choose a goal in the region of the start"
    )]
    Unreachable {
        /// Whose.
        agent: usize,
    },
}

/// What a search looks at: see [`Instance`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Problem<'a> {
    pub(crate) board: &'a Board,
    pub(crate) starts: &'a [Place],
    pub(crate) goals: &'a [Place],
    pub(crate) distances: &'a Distances,
}

/// Agents on a board, each with a start and a goal of its own that it can reach, and the distances to the goals.
#[derive(Clone, Debug)]
pub struct Instance<'a> {
    board: &'a Board,
    starts: Vec<Place>,
    goals: Vec<Place>,
    distances: Distances,
}

impl<'a> Instance<'a> {
    /// Returns the instance of starts and goals, one of both for each agent.
    ///
    /// # Errors
    /// Too many, or places that two share or that no way connects.
    ///
    /// # Panics
    /// With a place of another board.
    pub fn new(board: &'a Board, starts: Vec<Place>, goals: Vec<Place>) -> Result<Self, InstanceError> {
        if starts.len() != goals.len() {
            return Err(InstanceError::Count { starts: starts.len(), goals: goals.len() });
        }
        if starts.len() > AGENTS_MAX {
            return Err(InstanceError::Agents { agents: starts.len() });
        }
        if goals.len() * board.len() > DISTANCES_MAX {
            return Err(InstanceError::Distances { goals: goals.len(), places: board.len() });
        }
        if let Some((first, second)) = sharing(&starts) {
            return Err(InstanceError::SameStart { first, second });
        }
        if let Some((first, second)) = sharing(&goals) {
            return Err(InstanceError::SameGoal { first, second });
        }
        let distances = Distances::new(board, &goals);
        let is_cut_off = |&agent: &usize| distances.of(agent)[starts[agent].index()] == FAR;
        if let Some(agent) = (0..starts.len()).find(is_cut_off) {
            return Err(InstanceError::Unreachable { agent });
        }
        Ok(Self { board, starts, goals, distances })
    }

    /// Returns the board.
    #[must_use]
    pub fn board(&self) -> &'a Board {
        self.board
    }

    /// Returns how many agents there are.
    #[must_use]
    pub fn agents(&self) -> usize {
        self.starts.len()
    }

    /// Returns where the agents start.
    #[must_use]
    pub fn starts(&self) -> &[Place] {
        &self.starts
    }

    /// Returns where the agents have to be at last.
    #[must_use]
    pub fn goals(&self) -> &[Place] {
        &self.goals
    }

    /// Returns the distances to the goals.
    #[must_use]
    pub fn distances(&self) -> &Distances {
        &self.distances
    }

    pub(crate) fn problem(&self) -> Problem<'_> {
        Problem { board: self.board, starts: &self.starts, goals: &self.goals, distances: &self.distances }
    }

    /// Returns a lower bound of the sum of costs of any plan: the sum of all distances.
    #[must_use]
    pub fn sum_of_costs_min(&self) -> u64 {
        self.lengths().map(u64::from).sum()
    }

    /// Returns a lower bound of the makespan of any plan, in steps: the largest distance; 0 without agents.
    #[must_use]
    pub fn makespan_min(&self) -> u32 {
        self.lengths().max().unwrap_or(0)
    }

    fn lengths(&self) -> impl Iterator<Item = u32> {
        self.starts.iter().enumerate().map(|(agent, start)| self.distances.of(agent)[start.index()])
    }
}

/// The first two agents, by their place, that share one.
fn sharing(places: &[Place]) -> Option<(usize, usize)> {
    let mut order: Vec<usize> = (0..places.len()).collect();
    order.sort_by_key(|&agent| (places[agent], agent));
    order.windows(2).find(|pair| places[pair[0]] == places[pair[1]]).map(|pair| (pair[0], pair[1]))
}
