//! What a player may know and say: the wall between the world and the wire.

mod base;
mod command;
mod delta;
mod identity;
mod outcome;
mod profile;
mod rules;
mod tracker;
mod view;

pub use base::{Base, DEVIATION_MAX, DEVIATION_SKINS_MAX};
pub use command::{COMMANDS_A_CYCLE_MAX, Command, Sequenced, Start, WAYPOINTS_MAX, Waypoint};
pub use delta::{Appeared, Changed, Delta, Moved, Stopped};
pub use identity::{Digest, Handle, Seat, UnitTypeId};
pub use outcome::{CommandResult, EndReason, MatchResult, Outcome, Refusal, Score, StopReason};
pub use profile::{
    GRID_BITS_MAX, GRID_FRACTIONS, Positions, Profile, SKIN_MAX, SUBSTEPS_MAX, Scalar, Solver, VELOCITY_BITS,
};
pub use rules::{ClockMode, Objective, Rules, Stops, Terrain, UnitType, Zone};
pub use tracker::{Sighting, Stop, Tracker};
pub use view::{MismatchError, Seen, View};
