//! What a bot is, and which there are.

use maniple_pathfinding::Tactic;
use maniple_view::{Command, Delta, Rules, Seat, Terrain, View};
use thiserror::Error;

use crate::commander::Commander;
use crate::focus::Focus;
use crate::gather::Gather;
use crate::idle::Idle;
use crate::led::Led;
use crate::r#macro::Macro;
use crate::player::{Player, Start};
use crate::random::Random;
use crate::rush::Rush;
use crate::straight::Straight;

/// The names of all bots, sorted.
pub const NAMES: [&str; 12] = [
    Tactic::Alone.name(),
    Tactic::Auto.name(),
    Commander::NAME,
    Focus::NAME,
    Tactic::Follow.name(),
    Gather::NAME,
    Idle::NAME,
    Macro::NAME,
    Random::NAME,
    Tactic::Replan.name(),
    Rush::NAME,
    Straight::NAME,
];

/// A player that is a program.
///
/// Its commands depend on nothing but what it is given: no clock, no randomness but from its seed.
pub trait Bot {
    /// Returns the name by which [`make`] knows it.
    fn name(&self) -> &'static str;

    /// Takes what is known before the first cycle.
    fn on_start(&mut self, seat: Seat, rules: &Rules, terrain: &Terrain);

    /// Returns the commands for the cycle of `view`, which `delta` has just been applied to.
    fn on_cycle(&mut self, view: &View, delta: &Delta) -> Vec<Command>;
}

impl<B: Bot + ?Sized> Bot for Box<B> {
    fn name(&self) -> &'static str {
        (**self).name()
    }

    fn on_start(&mut self, seat: Seat, rules: &Rules, terrain: &Terrain) {
        (**self).on_start(seat, rules, terrain);
    }

    fn on_cycle(&mut self, view: &View, delta: &Delta) -> Vec<Command> {
        (**self).on_cycle(view, delta)
    }
}

/// A name that no bot has.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("no bot is called {name:?}; there are {}", NAMES.join(", "))]
pub struct UnknownBot {
    /// The name.
    pub name: String,
}

/// Returns the bot with this name; `seed` is where its randomness starts, see [`crate::bot_seed`].
///
/// # Errors
/// A name that is not one of [`NAMES`].
pub fn make(name: &str, seed: u64) -> Result<Box<dyn Bot + Send>, UnknownBot> {
    let bot: Box<dyn Bot + Send> = match name {
        Commander::NAME => Box::new(Player::new(Commander::NAME, seed, Commander::begin)),
        Focus::NAME => Box::new(Player::new(Focus::NAME, seed, Focus::begin)),
        Gather::NAME => Box::new(Player::new(Gather::NAME, seed, Gather::begin)),
        Idle::NAME => Box::new(Idle),
        Macro::NAME => Box::new(Player::new(Macro::NAME, seed, Macro::begin)),
        Random::NAME => Box::new(random(seed)),
        Rush::NAME => Box::new(Player::new(Rush::NAME, seed, Rush::begin)),
        Straight::NAME => Box::new(Player::new(Straight::NAME, seed, Straight::begin)),
        _ => match Tactic::parse(name) {
            Ok(tactic) => Box::new(Player::new(tactic.name(), seed, move |start: &Start, view: &View| {
                Led::begin(tactic, start, view)
            })),
            Err(_) => return Err(UnknownBot { name: name.to_owned() }),
        },
    };
    Ok(bot)
}

/// Returns the bot `random`, which sends each of its units that rests to a random point of the map.
#[must_use]
pub fn random(seed: u64) -> impl Bot + Send {
    Player::new(Random::NAME, seed, Random::begin)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_makes_the_bot_of_that_name() {
        assert!(NAMES.is_sorted());
        for name in NAMES {
            assert_eq!(make(name, 1).map(|bot| bot.name()), Ok(name));
        }
        let error = make("strait", 1).err().map(|error| error.to_string());
        assert_eq!(
            error.as_deref(),
            Some(
                "no bot is called \"strait\"; there are alone, auto, commander, focus, follow, gather, idle, macro, random, replan, rush, straight"
            )
        );
    }
}
