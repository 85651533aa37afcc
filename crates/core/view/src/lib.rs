//! What a player may know and say: the wall between the world and the wire.

mod base;
mod command;
mod delta;
mod identity;
mod outcome;
mod rules;
mod tracker;
mod view;

pub use base::{Base, DEVIATION_SKINS_MAX};
pub use command::{COMMANDS_A_CYCLE_MAX, Command, Sequenced, Start, WAYPOINTS_MAX, Waypoint};
pub use delta::{Appeared, Changed, Delta, Moved, Stopped};
pub use identity::{Digest, Handle, Seat, UnitTypeId};
pub use outcome::{CommandResult, EndReason, MatchResult, Outcome, Refusal, Score, StopReason};
pub use rules::{ClockMode, Objective, Rules, Stops, Terrain, UnitType, Zone};
pub use tracker::{Sighting, Stop, Tracker};
pub use view::{MismatchError, Seen, View};
