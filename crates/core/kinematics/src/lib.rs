//! One cycle of circles that go straight and stop when they would overlap something, exactly.

mod certificate;
mod components;
mod cycle;
mod digest;
mod error;
mod event;
mod plan;
mod runner;
mod sectors;
mod solve;
mod sphere;
mod track;
mod wall;
mod world;

pub use digest::chained;
pub use error::{InsertError, OrderError, Overlap, WallError};
pub use event::{Event, EventKind};
pub use plan::{Leg, Placement, WAYPOINTS_MAX};
pub use solve::Stops;
pub use wall::{Layers, Wall, WallKind};
pub use world::{Activity, World};
