//! The bot that walks anywhere.

use maniple_view::{Command, Delta, Rules, Seat, Terrain, View};

use crate::bot::Bot;
use crate::keyed::{Purpose, fraction, keyed};

/// Sends each of its units that rests to a random point of the map.
#[derive(Clone, Debug)]
pub struct Random {
    seed: u64,
    seat: Seat,
    can_move: Vec<bool>,
    width: f64,
    height: f64,
}

impl Random {
    pub(crate) const NAME: &str = "random";

    /// Returns the bot; it has to be started.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self { seed, seat: Seat(0), can_move: Vec::new(), width: 0.0, height: 0.0 }
    }
}

impl Bot for Random {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn on_start(&mut self, seat: Seat, rules: &Rules, terrain: &Terrain) {
        self.seat = seat;
        self.can_move = rules.unit_types.iter().map(|unit_type| unit_type.speed > 0.0).collect();
        self.width = f64::from(terrain.width);
        self.height = f64::from(terrain.height);
    }

    fn on_cycle(&mut self, view: &View, _delta: &Delta) -> Vec<Command> {
        let random = |index, purpose| fraction(keyed(self.seed, view.cycle().0, index, purpose));
        view.objects_of(self.seat)
            .filter(|(_, seen)| !seen.base.is_moving() && self.can_move[usize::from(seen.unit_type.0)])
            .map(|(object, _)| Command::Move {
                object,
                x: self.width * random(object.0, Purpose::GoalX),
                y: self.height * random(object.0, Purpose::GoalY),
                s: None,
                queue: false,
                start: None,
            })
            .collect()
    }
}
