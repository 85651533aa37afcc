//! One cycle of circles that go straight and stop when they would overlap something, exactly.

mod agenda;
mod audit;
mod bands;
mod batch;
mod broad_phase;
mod certificate;
mod components;
mod cycle;
mod digest;
mod error;
mod event;
mod graph;
mod lanes;
mod objects;
mod orders;
mod outcome;
mod plan;
mod resting;
mod room;
mod runner;
mod solve;
mod sphere;
mod squares;
mod state;
mod track;
mod wall;
mod walls;
mod world;

pub use broad_phase::{BroadPhase, NearPairs};
pub use digest::chained;
pub use error::{InsertError, OrderError, Overlap, WallError};
pub use event::{Event, EventKind};
pub use plan::{Leg, Placement, WAYPOINTS_MAX};
pub use solve::Stops;
pub use wall::{Layers, Wall, WallId, WallKind};
pub use world::{Activity, World};
