//! How a group can be led.

use thiserror::Error;

/// How a group is led.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tactic {
    /// Each takes its own path, and again whenever it was stopped.
    Alone,
    /// One leads, and each other goes to where the one before it is.
    Follow,
    /// Each takes its own path, and whenever it was stopped another one around all who rest: local repair, *LRA\**.
    #[doc(alias = "lra")]
    Replan,
    /// All by one schedule of departures; who is stopped all the same is scheduled anew, with those in whose way it stands. In step where
    /// there is no schedule.
    Auto,
}

/// A name that no tactic has.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("no tactic is called {name:?}; there are {}", Tactic::ALL.map(Tactic::name).join(", "))]
pub struct UnknownTactic {
    /// The name.
    pub name: String,
}

impl Tactic {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Alone, Self::Follow, Self::Replan, Self::Auto];

    /// Returns the name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Alone => "alone",
            Self::Follow => "follow",
            Self::Replan => "replan",
            Self::Auto => "auto",
        }
    }

    /// Returns the tactic of a name.
    ///
    /// # Errors
    /// A name that none has.
    pub fn parse(name: &str) -> Result<Self, UnknownTactic> {
        let found = Self::ALL.into_iter().find(|tactic| tactic.name() == name);
        found.ok_or_else(|| UnknownTactic { name: name.to_owned() })
    }
}
