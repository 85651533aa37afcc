//! The bot that does nothing.

use maniple_view::{Command, Delta, Rules, Seat, Terrain, View};

use crate::bot::Bot;

/// Gives no command: an opponent that stands in the way, and the least that a bot can be.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Idle;

impl Idle {
    pub(crate) const NAME: &str = "idle";
}

impl Bot for Idle {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn on_start(&mut self, _seat: Seat, _rules: &Rules, _terrain: &Terrain) {}

    fn on_cycle(&mut self, _view: &View, _delta: &Delta) -> Vec<Command> {
        Vec::new()
    }
}
