//! Kinds of generated maps.

use std::fmt;
use std::str::FromStr;

use super::GenerateError;

/// What kind of ground a generated map has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Kind {
    /// Open everywhere.
    Plain,
    /// Mostly open, with small irregular blocks of rock and trees.
    Obstacles,
    /// Corridors with walls between them, and more than one way.
    Maze,
    /// Land in the water, joined by fords.
    Islands,
    /// Long ridges with ramps through them.
    Cliffs,
    /// Large areas with few narrow passages between them.
    Choke,
}

impl Kind {
    /// Every kind.
    pub const ALL: [Self; 6] =
        [Self::Plain, Self::Obstacles, Self::Maze, Self::Islands, Self::Cliffs, Self::Choke];

    /// The names of the kinds, in the order of [`Kind::ALL`].
    pub const NAMES: [&'static str; 6] = ["plain", "obstacles", "maze", "islands", "cliffs", "choke"];

    /// Returns the name, in lower case.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Plain => "plain",
            Self::Obstacles => "obstacles",
            Self::Maze => "maze",
            Self::Islands => "islands",
            Self::Cliffs => "cliffs",
            Self::Choke => "choke",
        }
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Kind {
    type Err = GenerateError;

    fn from_str(name: &str) -> Result<Self, GenerateError> {
        let found = Self::ALL.into_iter().find(|kind| kind.name() == name);
        found.ok_or_else(|| GenerateError::Kind { name: name.to_owned(), known: Self::NAMES.join(", ") })
    }
}
