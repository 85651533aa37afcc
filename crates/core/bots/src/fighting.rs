//! Fights: who is in range of whom, who fires at whom, and how a force goes to it.

mod aim;
mod force;
mod melee;
mod retreat;
mod siege;
mod volley;

pub(crate) use aim::{is_fighter, is_in_range, weapon};
pub(crate) use force::{Battle, Force};
pub(crate) use melee::melee;
pub(crate) use siege::{Siege, Sieges, deploy};
