//! Work: who gathers where, what is built, and what is trained.

mod berths;
mod miners;
mod sites;
mod town;
mod worth;

pub(crate) use miners::Miners;
pub(crate) use town::{Plans, Town};
