//! Many circles on fixed ways at full speed, of which only the departures are planned.
//!
//! Where whoever touches something stops, a crowd gets through a narrow place best if nobody ever waits on the way: all
//! walk at full speed, and each departs in time to find its gap. Departures are exact: of two trajectories made of straight
//! pieces it is computed which delays would bring them too near to each other ([`conflict`]), and each circle takes the
//! earliest moment that none of those before it forbids ([`traffic`]).

mod assign;
mod beats;
mod bound;
mod bundle;
mod conflict;
mod ends;
mod error;
mod fan;
mod lanes;
mod order;
mod releasing;
mod schedule;
mod streets;
mod stretch;
mod traffic;
mod trajectory;
mod trunk;

pub(crate) use assign::{Assignment, by_distance};
pub(crate) use lanes::last_narrow_place;

pub use bound::{bound, bound_of_groups, throughput_max};
pub use error::ReleaseError;
pub use releasing::Releasing;
pub use schedule::{Goals, Group, Moving, Request, Schedule, Walk, release, release_some};
