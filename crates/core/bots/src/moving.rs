//! Getting there: ways with exact clearance for one, controllers for groups.

mod advance;
mod around;
mod march;
mod roads;
mod slots;

pub(crate) use advance::Advance;
pub(crate) use around::{around, straight_on};
pub(crate) use march::March;
pub(crate) use roads::Roads;
pub(crate) use slots::{AROUND, slots_around};
