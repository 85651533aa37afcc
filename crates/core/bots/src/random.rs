//! The bot that walks anywhere.

use maniple_view::{Command, Delta, View};

use crate::keyed::{Purpose, fraction, keyed};
use crate::player::{Play, Start};
use crate::seeing::size;

/// Sends each of its units that rests to a random point of the map.
#[derive(Clone, Debug)]
pub(crate) struct Random;

impl Random {
    pub(crate) const NAME: &str = "random";

    pub(crate) fn begin(_start: &Start, _view: &View) -> Self {
        Self
    }
}

impl Play for Random {
    fn play(&mut self, start: &Start, view: &View, _delta: &Delta) -> Vec<Command> {
        let size = size(view.terrain());
        let random = |index, purpose| fraction(keyed(start.seed, view.cycle().0, index, purpose));
        view.objects_of(start.seat)
            .filter(|(_, seen)| !seen.base.is_moving() && start.kind(seen.unit_type).speed > 0.0)
            .map(|(object, _)| Command::Move {
                object,
                x: size.x * random(object.0, Purpose::GoalX),
                y: size.y * random(object.0, Purpose::GoalY),
                s: None,
                queue: false,
                start: None,
            })
            .collect()
    }
}
