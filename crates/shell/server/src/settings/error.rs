//! What can be wrong with a configuration.

use std::path::PathBuf;

use thiserror::Error;

use super::Origin;

/// Why a configuration cannot be used.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum SettingsError {
    /// The file is not TOML.
    #[error("{file}, line {line}: {problem}; the file has to be TOML", file = .file.display())]
    Syntax {
        /// The file.
        file: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What is wrong there.
        problem: String,
    },
    /// There is no such section.
    #[error("{origin}: there is no section [{section}]; the sections are {}", .known.join(", "))]
    UnknownSection {
        /// Where it is.
        origin: Origin,
        /// Its name.
        section: String,
        /// Those that there are.
        known: Vec<&'static str>,
    },
    /// There is a value where a section should be.
    #[error("{origin}: {key} stands in no section; write it below one of {}, as in [limits]", .known.join(", "))]
    NoSection {
        /// Where it is.
        origin: Origin,
        /// The key.
        key: String,
        /// The sections that there are.
        known: Vec<&'static str>,
    },
    /// The section has no such key.
    #[error("{origin}: [{section}] has no key {key}; it has {}", .known.join(", "))]
    UnknownKey {
        /// Where it is.
        origin: Origin,
        /// The section.
        section: String,
        /// The key.
        key: String,
        /// Those that the section has.
        known: Vec<&'static str>,
    },
    /// A value that the key may not have.
    #[error("{origin}: {key} = {found}: it has to be {limit}")]
    BadValue {
        /// Where it is.
        origin: Origin,
        /// Section and key.
        key: String,
        /// What is there.
        found: String,
        /// What may be there.
        limit: String,
    },
    /// A flag that sets nothing.
    #[error("--set {text}: write it as --set limits.connections=100")]
    BadFlag {
        /// What is there.
        text: String,
    },
    /// A key that means nothing without another.
    #[error("{origin}: {key} needs {missing}, which is not given; give it, or leave both away")]
    Alone {
        /// Where it is.
        origin: Origin,
        /// Section and key.
        key: String,
        /// Section and key of the other.
        missing: String,
    },
}

impl SettingsError {
    /// Returns where the mistake is; `None`: in a text that is no configuration at all.
    #[must_use]
    pub fn origin(&self) -> Option<&Origin> {
        match self {
            Self::UnknownSection { origin, .. }
            | Self::NoSection { origin, .. }
            | Self::UnknownKey { origin, .. }
            | Self::BadValue { origin, .. }
            | Self::Alone { origin, .. } => Some(origin),
            Self::Syntax { .. } | Self::BadFlag { .. } => None,
        }
    }
}
