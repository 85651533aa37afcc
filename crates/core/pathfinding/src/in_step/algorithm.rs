//! The planners by their names.

use std::str::FromStr;

use thiserror::Error;

use crate::in_step::instance::Instance;
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
    /// Windowed cooperative A*: one after the other around reservations; can get stuck. A state is a place and a time of one.
    Spacetime,
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
    pub const ALL: [Self; 3] = [Self::Pibt, Self::Lacam, Self::Spacetime];

    /// Returns the name, as it is parsed.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Pibt => "pibt",
            Self::Lacam => "lacam",
            Self::Spacetime => "spacetime",
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
            Self::Lacam => Box::new(Lacam::new(instance, seed)),
            Self::Spacetime => Box::new(Spacetime::new(instance, seed)),
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
