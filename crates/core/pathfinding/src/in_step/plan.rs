//! A plan: where everybody is at every step.

use thiserror::Error;

use crate::in_step::board::Place;
use crate::in_step::instance::Instance;

/// Where every agent is at every step, from the starts on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plan {
    agents: usize,
    /// Step by step, one place for each agent.
    places: Vec<Place>,
}

/// What is wrong with a plan. Steps are numbered from 0, where all are at their starts.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum Fault {
    /// It is for another number of agents.
    #[error("the plan is for {planned} agents, and there are {agents}")]
    Agents {
        /// Of the plan.
        planned: usize,
        /// Of the instance.
        agents: usize,
    },
    /// Somebody does not begin at its start.
    #[error("agent {agent} does not begin at its start")]
    Start {
        /// Who.
        agent: usize,
    },
    /// Somebody goes to a place that is no neighbour.
    #[error("agent {agent} leaps at step {step}")]
    Leap {
        /// Who.
        agent: usize,
        /// The step at whose end it is there.
        step: usize,
    },
    /// Two are in the same place: a vertex conflict.
    #[error("agents {first} and {second} are in the same place after step {step}")]
    Meeting {
        /// The one.
        first: usize,
        /// The other.
        second: usize,
        /// The step at whose end they are.
        step: usize,
    },
    /// Two change places: an edge conflict.
    #[error("agents {first} and {second} change places in step {step}")]
    Swap {
        /// The one.
        first: usize,
        /// The other.
        second: usize,
        /// The step.
        step: usize,
    },
    /// Somebody does not end at its goal.
    #[error("agent {agent} does not end at its goal")]
    Goal {
        /// Who.
        agent: usize,
    },
}

impl Plan {
    /// Returns the plan in which all stay where they are.
    #[must_use]
    pub fn standing(starts: &[Place]) -> Self {
        Self { agents: starts.len(), places: starts.to_vec() }
    }

    /// Returns the plan of ways, one for each agent, place by place from its start on; who is at the end stays there.
    ///
    /// # Panics
    /// With a way of no place.
    #[must_use]
    pub fn of_ways(ways: &[Vec<Place>]) -> Self {
        let length = ways.iter().map(Vec::len).max().unwrap_or(1);
        let at = |way: &Vec<Place>, step: usize| way.get(step).or(way.last()).copied();
        let places = (0..length)
            .flat_map(|step| ways.iter().map(move |way| at(way, step).expect("a way has a start")))
            .collect();
        Self { agents: ways.len(), places }
    }

    /// Adds a step after the last one.
    ///
    /// # Panics
    /// With another number of agents.
    pub fn push(&mut self, places: &[Place]) {
        assert_eq!(places.len(), self.agents, "a place for each agent");
        self.places.extend_from_slice(places);
    }

    /// Returns how many agents it is for.
    #[must_use]
    pub fn agents(&self) -> usize {
        self.agents
    }

    /// Returns how many steps there are; the starts are none.
    #[must_use]
    pub fn steps(&self) -> usize {
        self.places.len().checked_div(self.agents).map_or(0, |rows| rows - 1)
    }

    /// Returns where the agents are after a step; their starts for 0.
    ///
    /// # Panics
    /// For a step that is not of the plan.
    #[must_use]
    pub fn at(&self, step: usize) -> &[Place] {
        &self.places[step * self.agents..(step + 1) * self.agents]
    }

    /// Returns the way of an agent, place by place from its start on, up to where it stays for good.
    #[must_use]
    pub fn way(&self, agent: usize) -> Vec<Place> {
        (0..=self.cost(agent) as usize).map(|step| self.at(step)[agent]).collect()
    }

    /// Returns the ways of all agents.
    #[must_use]
    pub fn ways(&self) -> Vec<Vec<Place>> {
        (0..self.agents).map(|agent| self.way(agent)).collect()
    }

    /// Returns the cost of an agent: after how many steps it stays for good where it ends.
    #[must_use]
    pub fn cost(&self, agent: usize) -> u32 {
        let end = self.at(self.steps())[agent];
        let last = (0..self.steps()).rev().find(|&step| self.at(step)[agent] != end);
        last.map_or(0, |step| u32::try_from(step + 1).expect("plans are shorter than 2^32 steps"))
    }

    /// Returns the sum of the costs of all agents.
    #[must_use]
    pub fn sum_of_costs(&self) -> u64 {
        (0..self.agents).map(|agent| u64::from(self.cost(agent))).sum()
    }

    /// Returns the makespan: after how many steps all stay for good.
    #[must_use]
    pub fn makespan(&self) -> u32 {
        (0..self.agents).map(|agent| self.cost(agent)).max().unwrap_or(0)
    }

    /// Checks that the plan solves an instance; looks at every pair at every step, so it is slow and obvious.
    ///
    /// # Errors
    /// The first fault.
    pub fn check(&self, instance: &Instance<'_>) -> Result<(), Fault> {
        let agents = instance.agents();
        if self.agents != agents {
            return Err(Fault::Agents { planned: self.agents, agents });
        }
        for agent in 0..agents {
            if self.at(0)[agent] != instance.starts()[agent] {
                return Err(Fault::Start { agent });
            }
            if self.at(self.steps())[agent] != instance.goals()[agent] {
                return Err(Fault::Goal { agent });
            }
        }
        for step in 1..=self.steps() {
            self.check_step(instance, step)?;
        }
        Ok(())
    }

    fn check_step(&self, instance: &Instance<'_>, step: usize) -> Result<(), Fault> {
        let (before, after) = (self.at(step - 1), self.at(step));
        for first in 0..self.agents {
            let is_step = instance.board().neighbours(before[first]).contains(&after[first]);
            if !is_step && before[first] != after[first] {
                return Err(Fault::Leap { agent: first, step });
            }
            for second in first + 1..self.agents {
                if after[first] == after[second] {
                    return Err(Fault::Meeting { first, second, step });
                }
                if after[first] == before[second] && after[second] == before[first] {
                    return Err(Fault::Swap { first, second, step });
                }
            }
        }
        Ok(())
    }
}
