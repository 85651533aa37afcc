//! Bots: view in, commands out.
//!
//! A bot knows what a player knows: this crate depends on `maniple-view`, and on `maniple-pathfinding`, which knows maps and no world.

mod bot;
mod commander;
mod economy;
mod fighting;
mod focus;
mod gather;
mod idle;
mod keyed;
mod led;
mod r#macro;
mod moving;
mod orders;
mod post;
mod random;
mod rush;
mod seeing;
mod straight;

pub use bot::{Bot, NAMES, UnknownBot, make};
pub use commander::Commander;
pub use focus::Focus;
pub use gather::Gather;
pub use idle::Idle;
pub use keyed::bot_seed;
pub use led::Led;
pub use r#macro::Macro;
pub use random::Random;
pub use rush::Rush;
pub use straight::Straight;
