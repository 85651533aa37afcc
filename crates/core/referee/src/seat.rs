//! What the referee keeps for a seat.

use maniple_geometry::Cycle;
use maniple_view::{COMMANDS_A_CYCLE_MAX, Delta, Sequenced, Tracker};
use thiserror::Error;

/// Longest name of a player, in bytes: it has to fit on one line.
pub const NAME_BYTES_MAX: usize = 64;

/// Most commands of a seat that wait for a cycle: as many as a cycle takes, and as many again that are told so.
pub const QUEUED_MAX: usize = 2 * COMMANDS_A_CYCLE_MAX;

/// A player who cannot join.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum JoinError {
    /// A name that is empty, too long, or has characters that do not print.
    #[error("a name must have 1 to {NAME_BYTES_MAX} bytes that print; found {name:?}")]
    BadName {
        /// The name.
        name: String,
    },
}

/// More commands than may wait for a cycle: the batch was dropped, none of it has a result.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[error("more than {QUEUED_MAX} commands wait for cycle {cycle}; the batch was dropped")]
pub struct FloodError {
    /// The cycle for which they wait.
    pub cycle: Cycle,
}

/// Commands that came together.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Batch {
    pub(crate) seen_cycle: Cycle,
    pub(crate) commands: Vec<Sequenced>,
}

/// A seat of the match.
#[derive(Debug)]
pub(crate) struct SeatState {
    /// Empty until a player has come.
    pub(crate) name: String,
    pub(crate) is_connected: bool,
    pub(crate) tracker: Tracker,
    /// What is to be sent; of a seat without a connection nothing is kept.
    pub(crate) delta: Option<Delta>,
    batches: Vec<Batch>,
    queued: usize,
}

impl SeatState {
    /// Returns the seat before anybody has come.
    pub(crate) fn new(tracker: Tracker) -> Self {
        Self {
            name: String::new(),
            is_connected: false,
            tracker,
            delta: None,
            batches: Vec::new(),
            queued: 0,
        }
    }

    pub(crate) fn has_joined(&self) -> bool {
        !self.name.is_empty()
    }

    /// Lets commands wait for `cycle`.
    pub(crate) fn queue(&mut self, cycle: Cycle, batch: Batch) -> Result<(), FloodError> {
        if batch.commands.is_empty() {
            return Ok(());
        }
        if batch.commands.len() > QUEUED_MAX - self.queued {
            return Err(FloodError { cycle });
        }
        self.queued += batch.commands.len();
        self.batches.push(batch);
        Ok(())
    }

    /// Returns the commands that wait, in the order in which they came.
    pub(crate) fn take_batches(&mut self) -> Vec<Batch> {
        self.queued = 0;
        std::mem::take(&mut self.batches)
    }
}

/// Checks the name of a player.
pub(crate) fn check_name(name: &str) -> Result<(), JoinError> {
    if name.is_empty() || name.len() > NAME_BYTES_MAX || name.chars().any(char::is_control) {
        return Err(JoinError::BadName { name: name.to_owned() });
    }
    Ok(())
}
