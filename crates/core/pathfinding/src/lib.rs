//! Ways for circles on tile maps: straight legs that keep clear of every wall, and distances to a goal.
//!
//! The server does not plan. This is a library for those who do, bots and clients: the same input gives the same
//! bits, and nothing here reads a clock or a file. What it promises and what it costs: `docs/PATHFINDING.md`.

mod around;
mod bits;
mod controller;
mod corners;
mod crowd;
mod error;
mod field;
mod formation;
mod ground;
pub mod in_step;
mod jump;
mod lattice;
mod obstacles;
mod planner;
mod pull;
mod release;
mod taut;
#[cfg(test)]
mod tests;
mod tighten;
mod turns;
mod walls;
mod work;

pub use around::Detours;
pub use controller::{Controller, Delivery, Order, Progress, Scene, Seen, StepError, Tactic, UnknownTactic};
pub use crowd::Crowd;
pub use error::{GroundError, ObstacleError, PlanError, Which};
pub use field::Field;
pub use formation::{Formation, FormationError};
pub use ground::{Ground, MARGIN, RADIUS_MAX};
pub use obstacles::{Obstacle, Obstacles};
pub use planner::{Planner, length};
pub use release::{
    Goals, Group, Moving, ReleaseError, Releasing, Request, Schedule, Walk, bound, bound_of_groups, release,
    release_some, throughput_max,
};
