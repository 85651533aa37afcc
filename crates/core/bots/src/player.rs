//! How a bot begins: what it knows from the start, and a match from its first view on.

use maniple_view::{Command, Delta, Rules, Seat, Terrain, UnitType, UnitTypeId, View};

use crate::bot::Bot;
use crate::seeing::Scene;

/// What a bot knows from the start.
#[derive(Clone, Debug)]
pub(crate) struct Start {
    /// Where the bot's randomness starts.
    pub(crate) seed: u64,
    pub(crate) seat: Seat,
    pub(crate) rules: Rules,
}

impl Start {
    /// Returns a view sorted by whose things are.
    pub(crate) fn scene<'a>(&'a self, view: &'a View) -> Scene<'a> {
        Scene::of(view, &self.rules, self.seat)
    }

    /// Returns a unit type of the rules.
    pub(crate) fn kind(&self, unit_type: UnitTypeId) -> &UnitType {
        &self.rules.unit_types[usize::from(unit_type.0)]
    }

    /// Returns whether units can be trained in the match.
    pub(crate) fn can_train(&self) -> bool {
        self.rules.unit_types.iter().any(|kind| !kind.trains.is_empty())
    }
}

/// A bot in a match.
pub(crate) trait Play {
    /// Returns the commands for the cycle of `view`, which `delta` has just been applied to.
    fn play(&mut self, start: &Start, view: &View, delta: &Delta) -> Vec<Command>;
}

/// A bot that begins anew with the first view after each start. It gives no commands before it is started.
#[derive(Clone, Debug)]
pub(crate) struct Player<P, B> {
    name: &'static str,
    seed: u64,
    begin: B,
    start: Option<Start>,
    /// From the first view on.
    game: Option<P>,
}

impl<P: Play, B: Fn(&Start, &View) -> P> Player<P, B> {
    /// Returns the bot of a name, with what it begins to play with.
    pub(crate) fn new(name: &'static str, seed: u64, begin: B) -> Self {
        Self { name, seed, begin, start: None, game: None }
    }
}

impl<P: Play, B: Fn(&Start, &View) -> P> Bot for Player<P, B> {
    fn name(&self) -> &'static str {
        self.name
    }

    fn on_start(&mut self, seat: Seat, rules: &Rules, _terrain: &Terrain) {
        self.start = Some(Start { seed: self.seed, seat, rules: rules.clone() });
        self.game = None;
    }

    fn on_cycle(&mut self, view: &View, delta: &Delta) -> Vec<Command> {
        let Some(start) = &self.start else { return Vec::new() };
        let game = self.game.get_or_insert_with(|| (self.begin)(start, view));
        game.play(start, view, delta)
    }
}
