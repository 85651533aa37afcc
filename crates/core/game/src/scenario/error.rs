//! What can be wrong with a scenario.

use maniple_geometry::NumberError;
use thiserror::Error;

/// Why a scenario was refused, and where.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{file}:{line}:{column}: {problem}")]
pub struct ScenarioError {
    /// The name of the file.
    pub file: String,
    /// The line, from 1.
    pub line: usize,
    /// The column in characters, from 1.
    pub column: usize,
    /// What is wrong there.
    pub problem: Problem,
}

/// What is wrong with a scenario.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum Problem {
    /// Not TOML, an unknown or missing key, or a value of another type.
    #[error("{message}{}", hint(.nearest.as_deref()))]
    Shape {
        /// What the parser says.
        message: String,
        /// The known name that is most like the unknown one.
        nearest: Option<String>,
    },
    /// A kind of map that there is not.
    #[error("no kind of map is called {name:?}{}; known are {known}", hint(.nearest.as_deref()))]
    UnknownKind {
        /// The name.
        name: String,
        /// The names of all kinds.
        known: String,
        /// The kind whose name is most like it.
        nearest: Option<String>,
    },
    /// A number that no world accepts.
    #[error("{field} {problem}")]
    BadNumber {
        /// The key.
        field: &'static str,
        /// What is wrong with it.
        problem: NumberError,
    },
    /// A number below or above its range.
    #[error("{field} is {value}; it must be from {min} to {max}")]
    OutOfRange {
        /// The key, or what is counted.
        field: &'static str,
        /// The number.
        value: f64,
        /// The smallest allowed.
        min: f64,
        /// The largest allowed.
        max: f64,
    },
    /// A choice without the number that belongs to it.
    #[error("{choice} needs {field}, from {min} to {max}; add it")]
    Incomplete {
        /// What was chosen.
        choice: &'static str,
        /// The key of the number.
        field: &'static str,
        /// The smallest allowed.
        min: u32,
        /// The largest allowed.
        max: u32,
    },
    /// A number that means nothing without a choice.
    #[error("{field} means nothing without {choice}; leave it out, or choose that")]
    Pointless {
        /// The key of the number.
        field: &'static str,
        /// What would have to be chosen.
        choice: &'static str,
    },
    /// Two things of which only one can be.
    #[error("{one} and {other} cannot both be; leave one out")]
    Conflict {
        /// The one that is written here.
        one: &'static str,
        /// The other.
        other: &'static str,
    },
    /// Something that is missing where something else is written.
    #[error("{wanted} is missing; {why}")]
    Missing {
        /// The key, or what is meant by it.
        wanted: &'static str,
        /// Why it is needed, and the remedy.
        why: &'static str,
    },
    /// A unit type that cannot be what it is named for.
    #[error("{name:?} {problem}")]
    Unfit {
        /// The unit type.
        name: String,
        /// Why it cannot, and the remedy.
        problem: &'static str,
    },
    /// A unit type of a name that another file has too.
    #[error("the unit type {name:?} is in {other}, too; rename one, or leave it out")]
    Twice {
        /// The name.
        name: String,
        /// The other file.
        other: String,
    },
    /// A group of a unit type that the scenario does not have.
    #[error("no unit type is called {name:?}{}", hint(.nearest.as_deref()))]
    UnknownUnit {
        /// The name in the group.
        name: String,
        /// The name of a unit type that is most like it.
        nearest: Option<String>,
    },
    /// A name that is empty, too long, or has characters that do not print.
    #[error("{field} must have 1 to {max} bytes that print; found {name:?}")]
    BadName {
        /// The key.
        field: &'static str,
        /// The name.
        name: String,
        /// The largest number of bytes.
        max: usize,
    },
    /// More text than any scenario needs.
    #[error("the text has {found} bytes; at most {max} are allowed")]
    TooLong {
        /// How many it has.
        found: usize,
        /// How many it may have.
        max: usize,
    },
}

fn hint(nearest: Option<&str>) -> String {
    nearest.map(|name| format!("; did you mean `{name}`?")).unwrap_or_default()
}
