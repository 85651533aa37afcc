//! Work: who gathers where.

mod berths;
mod miners;

pub(crate) use miners::Miners;
