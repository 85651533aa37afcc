//! Plans for many who go in step: each with a goal of its own, all from middle to middle of tiles, one step at a time.
//!
//! A *board* is the middles of tiles between which a circle has room, four neighbours each. In a step every agent goes to a
//! neighbour or stays; no two may come to the same place, and no two may change places. Such plans are walked without a
//! collision by circles whose radius is at most [`RADIUS_IN_STEP_MAX`], all stepping at once and as long. (Stern et al.,
//! *Multi-Agent Pathfinding: Definitions, Variants, and Benchmarks*, 2019, name this the classical problem.)
//!
//! Budgets are counts of what is looked at, never a time: the same question has the same answer on every machine.

mod algorithm;
mod board;
mod conflict;
mod distances;
mod generator;
mod instance;
mod joint;
mod keyed;
mod lacam;
mod pibt;
mod plan;
mod priorities;
mod prioritized;
mod refinement;
mod reservations;
mod scatter;
mod search;
mod spacetime;
mod swap;
#[cfg(test)]
mod tests;
mod way;

pub(crate) use board::Raster;
pub(crate) use distances::FAR;
pub(crate) use generator::Rings;
pub(crate) use instance::Problem;
pub(crate) use lacam::Tree;

pub use algorithm::{Algorithm, TooManyAgents, UnknownAlgorithm};
pub use board::{Board, BoardError, Place, RADIUS_IN_STEP_MAX};
pub use distances::Distances;
pub use instance::{AGENTS_MAX, DISTANCES_MAX, Instance, InstanceError};
pub use joint::JOINT_AGENTS_MAX;
pub use pibt::Pibt;
pub use plan::{Fault, Plan};
pub use refinement::Refinement;
pub use scatter::scattered;
pub use search::{Outcome, Search};
