//! What a player may know and say: the wall between the world and the wire.

mod base;
mod command;
mod delta;
mod fnv;
mod ground;
mod identity;
mod merge;
mod outcome;
mod profile;
mod rules;
mod snapshot;
mod status;
mod tile_set;
mod tracker;
mod unit_type;
mod vantage;
mod view;

pub use base::{Base, DEVIATION_MAX, DEVIATION_SKINS_MAX};
pub use command::{COMMANDS_A_CYCLE_MAX, Command, Sequenced, Start, WAYPOINTS_MAX, Waypoint};
pub use delta::{Appeared, Changed, Delta, Ended, Moved, Shot, Stopped};
pub use identity::{Digest, Handle, Seat, UnitTypeId};
pub use merge::Merge;
pub use outcome::{CommandResult, EndReason, MatchResult, Outcome, Refusal, Score, StopReason, Tally};
pub use profile::{
    GRID_BITS_MAX, GRID_FRACTIONS, Positions, Profile, SKIN_MAX, SUBSTEPS_MAX, Scalar, Solver, VELOCITY_BITS,
};
pub use rules::{
    ClockMode, Identity, Objective, Rules, Stops, Terrain, TerrainKnowledge, UNKNOWN_TILE, Zone,
};
pub use snapshot::{Present, RestoreError, TrackerSnapshot};
pub use status::{Action, EndOfTask, Mode, Own, Status, Task};
pub use tile_set::TileSet;
pub use tracker::{Observation, Sighting, Stop, Tracker};
pub use unit_type::{
    Alternate, Falloff, Harvest, Layer, Making, Shape, Splash, UnitType, Weapon, hull_distance,
};
pub use vantage::Vantage;
pub use view::{MismatchError, Seen, View};
