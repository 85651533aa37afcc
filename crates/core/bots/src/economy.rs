//! Work: who gathers where, what is built and where, and what is trained.

mod bases;
mod berths;
mod miners;
mod projects;
mod sites;
mod town;
mod training;
mod worth;

pub(crate) use miners::Miners;
pub(crate) use projects::Projects;
pub(crate) use town::{Plans, Town};
pub(crate) use training::{Means, train};
