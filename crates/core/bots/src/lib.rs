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
mod player;
mod post;
mod random;
mod rush;
mod seeing;
mod straight;
#[cfg(test)]
mod test_items;

pub use bot::{Bot, NAMES, UnknownBot, make, random};
pub use keyed::bot_seed;
