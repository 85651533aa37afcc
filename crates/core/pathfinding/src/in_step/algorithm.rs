//! The planners by their names.

use std::str::FromStr;

use thiserror::Error;

use crate::in_step::instance::Instance;
use crate::in_step::pibt::Steps;
use crate::in_step::search::Search;

/// A planner for agents that go in step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Algorithm {
    /// Priority inheritance with backtracking, step by step: quick, can shuffle for ever. A state is a step of all.
    Pibt,
}

/// A name that no planner has.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("`{found}` is no planner; choose one of {}", Algorithm::names())]
pub struct UnknownAlgorithm {
    /// The name.
    pub found: String,
}

impl Algorithm {
    /// All of them.
    pub const ALL: [Self; 1] = [Self::Pibt];

    /// Returns the name, as it is parsed.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Pibt => "pibt",
        }
    }

    /// Returns all names, with commas between them.
    #[must_use]
    pub fn names() -> String {
        Self::ALL.map(Self::name).join(", ")
    }

    /// Begins to plan. The seed decides ties.
    #[must_use]
    pub fn begin<'a>(self, instance: &'a Instance<'a>, seed: u64) -> Box<dyn Search + 'a> {
        match self {
            Self::Pibt => Box::new(Steps::new(instance, seed)),
        }
    }
}

impl FromStr for Algorithm {
    type Err = UnknownAlgorithm;

    fn from_str(name: &str) -> Result<Self, UnknownAlgorithm> {
        let found = Self::ALL.into_iter().find(|algorithm| algorithm.name() == name);
        found.ok_or_else(|| UnknownAlgorithm { found: name.to_owned() })
    }
}
