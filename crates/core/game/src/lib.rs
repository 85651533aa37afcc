//! Scenarios, unit types, rules, vision, and the world of a match.
//!
//! [`load`] turns files into a [`Loaded`] start; [`World`] plays it, one cycle after the other. What a scenario does
//! not ask for is not computed.

mod keyed;
mod load;
mod placement;
mod room;
mod rules;
pub mod scenario;
mod vision;
mod world;

pub use keyed::{Purpose, keyed};
pub use load::{FILES_MAX, Files, LoadError, Loaded, LoadedFile, load};
pub use placement::{PlaceError, START_GAP, Setup, StartUnit};
pub use rules::Ending;
pub use scenario::{Overrides, Scenario, ScenarioError, Stall};
pub use world::{Part, RestoreError, World, WorldError, WorldSnapshot};
