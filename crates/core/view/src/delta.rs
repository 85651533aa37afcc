//! The change of a view over one cycle.

use glam::DVec2;
use maniple_geometry::{Cycle, Moment};
use serde::{Deserialize, Serialize};

use crate::base::Base;
use crate::identity::{Digest, Handle, Seat, UnitTypeId};
use crate::outcome::{CommandResult, StopReason};
use crate::status::{EndOfTask, Own, Status, Task};

/// The change of a view from the cycle before to `cycle`, or over several cycles: see [`crate::Merge`].
///
/// A view without objects, changed by a delta that has everything in `appeared`, is a *keyframe*: that is the
/// first delta of every connection.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Delta {
    /// The cycle at whose start the view is like this.
    pub cycle: Cycle,
    /// Answers to the seat's commands of this cycle, in the order in which they came.
    pub results: Vec<CommandResult>,
    /// Tiles that became visible or ceased to be, as (skip, count): from the end of the run before, or else from the first tile,
    /// `skip` tiles row by row are as before and the next `count` are the other way round. Nothing without fog.
    pub sight: Vec<(u32, u32)>,
    /// Tiles that became known, as (x, y, tiles): (x, y) and those to the right of it, in the characters of [`crate::Terrain`]. Each tile
    /// once, and none where all terrain is known from the start.
    pub revealed: Vec<(u32, u32, String)>,
    /// Walls that became known, as (x1, y1, x2, y2), the blocked side to the right; each at most as long as its tile. Each once, and
    /// none where all terrain is known from the start.
    pub walls: Vec<(f64, f64, f64, f64)>,
    /// Objects that came into sight, by handle.
    pub appeared: Vec<Appeared>,
    /// Objects whose motion changed, by handle.
    pub moved: Vec<Moved>,
    /// Objects that stopped, by handle.
    pub stopped: Vec<Stopped>,
    /// Objects that went out of sight, by handle.
    pub vanished: Vec<Handle>,
    /// Objects that died in sight, by handle.
    pub died: Vec<Handle>,
    /// Other changes, by handle.
    pub changed: Vec<Changed>,
    /// Shots in the cycle of objects that were in sight when they fired and still are, by the handle of who fired.
    pub shots: Vec<Shot>,
    /// Tasks of objects of the seat that ended in the cycle, by handle.
    pub ended: Vec<Ended>,
    /// Resources of the seat; `None` where they are as before.
    pub stock: Option<u32>,
    /// The hash of the view after this delta; see [`crate::View::check`].
    pub check: Digest,
}

/// The lists of a delta that holds nothing, in entries.
const ENTRIES_OF_NOTHING: usize = 6;

/// Tiles in a row that count as one entry.
const TILES_OF_AN_ENTRY: usize = 64;

impl Delta {
    /// Returns how many entries it has in its lists, as a measure of the memory that it takes: 60 bytes each, seldom up to 150.
    #[must_use]
    pub fn entries(&self) -> usize {
        let tiles: usize = self.revealed.iter().map(|(.., tiles)| 1 + tiles.len() / TILES_OF_AN_ENTRY).sum();
        ENTRIES_OF_NOTHING
            + self.results.len()
            + self.sight.len()
            + tiles
            + self.walls.len()
            + self.appeared.len()
            + self.moved.len()
            + self.stopped.len()
            + self.vanished.len()
            + self.died.len()
            + self.changed.len()
            + self.shots.len()
            + self.ended.len()
    }
}

/// An object that came into sight.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Appeared {
    /// Its handle from now on.
    pub object: Handle,
    /// Its type.
    pub unit_type: UnitTypeId,
    /// Whose it is; `None`: nobody's.
    pub owner: Option<Seat>,
    /// Where it is, evaluated at this cycle.
    pub base: Base,
    /// What is to be seen of it.
    pub status: Status,
    /// What only its owner knows; `None` for objects of others.
    pub own: Option<Own>,
}

/// An object in sight that took up another motion: of others, one that is seen to be another; see [`Base::predicts`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Moved {
    /// The object.
    pub object: Handle,
    /// Its motion from its start, or, where that is not to be seen, from this cycle.
    pub base: Base,
}

/// An object in sight that came to rest.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stopped {
    /// The object.
    pub object: Handle,
    /// Where it rests.
    pub point: DVec2,
    /// The cycle in which it stopped.
    pub cycle: Cycle,
    /// The fraction of that cycle.
    pub fraction: f64,
    /// Why; `None` for objects of others.
    pub reason: Option<StopReason>,
}

impl Stopped {
    /// Returns the base of the object from now on.
    #[must_use]
    pub fn base(&self) -> Base {
        Base::at_rest(self.point, Moment { cycle: self.cycle, fraction: self.fraction })
    }
}

/// Another change of an object in sight.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Changed {
    /// The object.
    pub object: Handle,
    /// What is to be seen of it; `None` where it is as before.
    pub status: Option<Status>,
    /// What only its owner knows; `None` where it is as before, and for objects of others.
    pub own: Option<Own>,
}

/// A shot.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shot {
    /// Who fired.
    pub object: Handle,
    /// At whom, where the view holds it; `None` too for a shot at a point.
    pub target: Option<Handle>,
}

/// A task that ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ended {
    /// The object of the seat.
    pub object: Handle,
    /// What it had been told to do.
    pub task: Task,
    /// Why it does so no more.
    pub why: EndOfTask,
}
