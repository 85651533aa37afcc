//! The planners by their names.

use std::str::FromStr;

use thiserror::Error;

use crate::in_step::conflict::Conflict;
use crate::in_step::instance::Instance;
use crate::in_step::joint::{JOINT_AGENTS_MAX, Joint};
use crate::in_step::lacam::Lacam;
use crate::in_step::pibt::Steps;
use crate::in_step::search::Search;
use crate::in_step::spacetime::Spacetime;

/// A planner for agents that go in step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Algorithm {
    /// Priority inheritance with backtracking, step by step: quick, can shuffle for ever. A state is a step of all.
    Pibt,
    /// Lazy constraints addition search: finds a plan if there is one, quick and not short. A state is a step of all that is tried.
    Lacam,
    /// Windowed cooperative A*: one after the other around reservations; can get stuck. A state is a window of all.
    #[doc(alias = "cooperative_a_star")]
    Spacetime,
    /// A* over the moves of all at once: the least sum of costs, for a handful. A state is the places of all.
    #[doc(alias = "joint_action_space")]
    Joint,
    /// Conflict-based search: the least sum of costs, for some more where they hardly meet. A state is a set of ways.
    #[doc(alias = "conflict_based_search")]
    Conflict,
}

/// A name that no planner has.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("`{found}` is no planner; choose one of {}", Algorithm::names())]
pub struct UnknownAlgorithm {
    /// The name.
    pub found: String,
}

/// More agents than a planner takes.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[error("{agents} agents; {} takes {limit} at most: plan for fewer, or choose another of {}", algorithm.name(), Algorithm::names())]
pub struct TooManyAgents {
    /// The planner.
    pub algorithm: Algorithm,
    /// How many.
    pub agents: usize,
    /// The most.
    pub limit: usize,
}

impl Algorithm {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Pibt, Self::Lacam, Self::Spacetime, Self::Joint, Self::Conflict];

    /// Returns the name, as it is parsed.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Pibt => "pibt",
            Self::Lacam => "lacam",
            Self::Spacetime => "spacetime",
            Self::Joint => "joint",
            Self::Conflict => "conflict",
        }
    }

    /// Returns all names, with commas between them.
    #[must_use]
    pub fn names() -> String {
        Self::ALL.map(Self::name).join(", ")
    }

    /// Begins to plan. The seed decides ties; exact planners have none to decide.
    ///
    /// # Errors
    /// More than [`JOINT_AGENTS_MAX`] agents for [`Self::Joint`].
    pub fn begin<'a>(
        self,
        instance: &'a Instance<'a>,
        seed: u64,
    ) -> Result<Box<dyn Search + 'a>, TooManyAgents> {
        Ok(match self {
            Self::Pibt => Box::new(Steps::new(instance, seed)),
            Self::Lacam => Box::new(Lacam::new(instance, seed)),
            Self::Spacetime => Box::new(Spacetime::new(instance, seed)),
            Self::Joint => {
                let (agents, limit) = (instance.agents(), JOINT_AGENTS_MAX);
                if agents > limit {
                    return Err(TooManyAgents { algorithm: self, agents, limit });
                }
                Box::new(Joint::new(instance))
            }
            Self::Conflict => Box::new(Conflict::new(instance)),
        })
    }
}

impl FromStr for Algorithm {
    type Err = UnknownAlgorithm;

    fn from_str(name: &str) -> Result<Self, UnknownAlgorithm> {
        let found = Self::ALL.into_iter().find(|algorithm| algorithm.name() == name);
        found.ok_or_else(|| UnknownAlgorithm { found: name.to_owned() })
    }
}
