//! Deltas on binary connections: of motions only what the receiver cannot tell itself, everything else as in [`Delta`].
//!
//! A receiver knows where each object is, and how fast its type goes. So a turn takes the place in the list, the moment and one
//! component of the velocity: about ten bytes, where [`Delta`] takes sixty. `docs/PROTOCOL.md` has the layout, `docs/packed.py`
//! a second reader.

mod bits;
mod motion;
mod numbers;
mod pack;
mod unpack;

use maniple_geometry::Cycle;
use maniple_view::{
    Appeared, Changed, CommandResult, Delta, Digest, Ended, Handle, Own, Seat, Shot, Status, UnitTypeId,
};
use serde::{Deserialize, Serialize};
use thiserror::Error;

pub use pack::Packer;

/// An object that came into sight: what [`Appeared`] says, but for its base.
pub type PackedAppeared = (Handle, UnitTypeId, Option<Seat>, Status, Option<Own>);

/// A delta in few bytes. Only who holds the view before it can read it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PackedDelta {
    /// See [`Delta::cycle`].
    pub cycle: Cycle,
    /// All but motions; `None`: nothing.
    pub rest: Option<Box<Rest>>,
    /// The bases of [`Rest::appeared`], then what [`Delta::moved`] and [`Delta::stopped`] say, in the layout of `docs/PROTOCOL.md`.
    pub motions: Vec<u8>,
    /// See [`Delta::check`].
    pub check: Digest,
}

/// What a delta says besides motions.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rest {
    /// See [`Delta::results`].
    pub results: Vec<CommandResult>,
    /// See [`Delta::sight`].
    pub sight: Vec<(u32, u32)>,
    /// See [`Delta::revealed`].
    pub revealed: Vec<(u32, u32, String)>,
    /// See [`Delta::walls`].
    pub walls: Vec<(f64, f64, f64, f64)>,
    /// See [`Delta::appeared`].
    pub appeared: Vec<PackedAppeared>,
    /// See [`Delta::vanished`].
    pub vanished: Vec<Handle>,
    /// See [`Delta::died`].
    pub died: Vec<Handle>,
    /// See [`Delta::changed`].
    pub changed: Vec<Changed>,
    /// See [`Delta::shots`].
    pub shots: Vec<Shot>,
    /// See [`Delta::ended`].
    pub ended: Vec<Ended>,
    /// See [`Delta::stock`].
    pub stock: Option<u32>,
}

impl Rest {
    fn of(delta: &Delta) -> Self {
        let appeared = |new: &Appeared| (new.object, new.unit_type, new.owner, new.status, new.own);
        Self {
            results: delta.results.clone(),
            sight: delta.sight.clone(),
            revealed: delta.revealed.clone(),
            walls: delta.walls.clone(),
            appeared: delta.appeared.iter().map(appeared).collect(),
            vanished: delta.vanished.clone(),
            died: delta.died.clone(),
            changed: delta.changed.clone(),
            shots: delta.shots.clone(),
            ended: delta.ended.clone(),
            stock: delta.stock,
        }
    }
}

/// A packed delta that cannot be read. The view it was meant for is of no use any more.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[error("the packed delta of cycle {cycle}, byte {offset} of its motions: {problem}")]
pub struct PackedError {
    /// The cycle of the delta.
    pub cycle: Cycle,
    /// How many bytes of its motions had been read.
    pub offset: usize,
    /// What is wrong there.
    pub problem: PackedProblem,
}

/// What is wrong with the motions of a packed delta.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum PackedProblem {
    /// They end within a motion.
    #[error("they end too early")]
    End,
    /// A number that does not fit its type.
    #[error("a number is too large")]
    TooLarge,
    /// Flags that mean nothing.
    #[error("flags {flags:#04x} mean nothing here")]
    Flags {
        /// The flags.
        flags: u8,
    },
    /// A motion of an object that the view does not hold.
    #[error("object {object} is none of the view")]
    UnknownObject {
        /// The object.
        object: Handle,
    },
    /// A unit type that the rules do not have, or that has no other mode.
    #[error("object {object} has no such speed by the rules")]
    UnknownSpeed {
        /// The object.
        object: Handle,
    },
    /// A moment before the first cycle.
    #[error("a moment {ago} cycles ago is before the match")]
    BeforeStart {
        /// How many cycles ago.
        ago: u32,
    },
}

#[cfg(test)]
mod tests;
