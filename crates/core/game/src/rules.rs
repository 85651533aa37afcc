//! What a scenario can ask for besides motion; one file a rule. A rule that it does not ask for does nothing and costs nothing.

pub(crate) mod approach;
pub(crate) mod combat;
mod crowd;
pub(crate) mod harvest;
pub(crate) mod modes;
pub(crate) mod neutral;
pub(crate) mod objective;
pub(crate) mod production;
mod race;

pub use objective::Ending;
pub(crate) use race::Race;
