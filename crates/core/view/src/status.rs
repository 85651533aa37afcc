//! What an object is like besides where it is.

use maniple_geometry::Cycle;
use serde::{Deserialize, Serialize};

use crate::identity::UnitTypeId;

/// What is to be seen of an object besides its motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Status {
    /// What it can still take; `None`: it cannot be hurt.
    pub hit_points: Option<u32>,
    /// Resources that are left; `None`: it is no resource patch.
    pub amount: Option<u32>,
    /// Its mode.
    pub mode: Mode,
    /// What it is doing.
    pub action: Action,
}

/// The mode of an object.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mode {
    /// The first one.
    #[default]
    Normal,
    /// Going over to the other one.
    Switching,
    /// The other one.
    Alternate,
    /// Going back to the first one.
    SwitchingBack,
    /// A building that is not finished; it can do nothing.
    Site,
}

/// What an object is seen to be doing while it stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Action {
    /// Nothing that shows.
    #[default]
    None,
    /// It takes resources from a patch.
    Gather,
    /// It works on a building site.
    Build,
}

/// What only the owner of an object knows of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Own {
    /// Motions that wait behind its present one.
    pub queued: u32,
    /// What it has been told to do.
    pub task: Task,
    /// Resources that it carries.
    pub load: u32,
    /// The first cycle in which it can fire again.
    pub ready: Cycle,
    /// What it trains; `None`: nothing.
    pub training: Option<UnitTypeId>,
    /// How many wait behind what it trains.
    pub waiting: u32,
    /// The cycle at whose start what it trains, or the site itself, will be finished if nothing comes between; `None`
    /// where nothing is being made, or nobody works on the site.
    pub due: Option<Cycle>,
}

/// What an object has been told to do, other than to move.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Task {
    /// Nothing but motions.
    #[default]
    None,
    /// To attack an object.
    Attack,
    /// To fire at a point.
    AttackAt,
    /// To go somewhere, and to fight whoever is in range on the way.
    AttackMove,
    /// To stand, and to fight whoever is in range.
    Hold,
    /// To gather.
    Gather,
    /// To bring its load home.
    ReturnLoad,
    /// To build.
    Build,
}

/// Why a task ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EndOfTask {
    /// It is done: the target is dead, the load is full or delivered, the building is finished, the place is reached.
    Done,
    /// Something stands in the straight way.
    Blocked,
    /// The target is no longer in sight, or what was worked at is gone.
    Lost,
    /// The patch is empty.
    Empty,
    /// Something stands where the building was to be.
    NoRoom,
    /// The seat lacks resources for it.
    NotAffordable,
    /// The seat lacks a building that it requires.
    Missing,
    /// The seat has as many objects as it may have.
    TooMany,
}
