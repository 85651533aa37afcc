//! How a command fails, and with which exit code.

use std::fmt;
use std::path::Path;
use std::process::ExitCode;

/// The exit code of an interrupted command, as shells have it: 128 + SIGINT.
pub(crate) const INTERRUPTED: i32 = 130;

/// Why a command failed.
#[derive(Debug)]
pub(crate) enum Failure {
    /// A check did not hold, or a peer went away: exit code 1.
    Failed(anyhow::Error),
    /// The command line cannot be meant: exit code 2, as for what `clap` refuses.
    Usage(anyhow::Error),
    /// A file or a scene is wrong: exit code 3.
    BadInput(anyhow::Error),
    /// The user stopped it: exit code 130.
    Interrupted,
}

impl Failure {
    /// Returns a failed check, or another failure that is not of the input.
    pub(crate) fn failed(error: impl Into<anyhow::Error>) -> Self {
        Self::Failed(error.into())
    }

    /// Returns a mistake on the command line.
    pub(crate) fn usage(text: String) -> Self {
        Self::Usage(anyhow::Error::msg(text))
    }

    /// Returns a mistake in a file or scene.
    pub(crate) fn bad_input(error: impl Into<anyhow::Error>) -> Self {
        Self::BadInput(error.into())
    }

    /// Returns the failure with the file in which its cause lies.
    pub(crate) fn within(self, path: &Path) -> Self {
        let path = path.display().to_string();
        match self {
            Self::Failed(error) => Self::Failed(error.context(path)),
            Self::Usage(error) => Self::Usage(error.context(path)),
            Self::BadInput(error) => Self::BadInput(error.context(path)),
            Self::Interrupted => Self::Interrupted,
        }
    }

    /// Returns what went wrong, without what the program puts before it.
    pub(crate) fn cause(&self) -> String {
        match self {
            Self::Failed(error) | Self::Usage(error) | Self::BadInput(error) => format!("{error:#}"),
            Self::Interrupted => "interrupted".to_owned(),
        }
    }

    /// Returns the exit code.
    pub(crate) fn exit_code(&self) -> ExitCode {
        ExitCode::from(match self {
            Self::Failed(_) => 1,
            Self::Usage(_) => 2,
            Self::BadInput(_) => 3,
            Self::Interrupted => 130,
        })
    }
}

/// The whole chain in one line.
impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Failed(_) | Self::Usage(_) | Self::BadInput(_) => write!(f, "error: {}", self.cause()),
            Self::Interrupted => f.write_str(&self.cause()),
        }
    }
}
