//! What each unit was told last, so that nothing is said twice.

use std::collections::BTreeMap;

use glam::DVec2;
use maniple_view::{Command, Handle, Task};

use crate::seeing::{Item, Scene};

/// The last command to each unit of the seat.
#[derive(Clone, Debug, Default)]
pub(crate) struct Orders {
    told: BTreeMap<Handle, Command>,
}

impl Orders {
    /// Forgets who is gone.
    pub(crate) fn refresh(&mut self, scene: &Scene<'_>) {
        self.told.retain(|object, _| scene.own(*object).is_some());
    }

    /// Returns the command, if the unit does not obey just this one already.
    pub(crate) fn give(&mut self, item: &Item<'_>, command: Command) -> Option<Command> {
        if self.told.get(&item.object) == Some(&command) && is_at_it(item, &command) {
            return None;
        }
        self.told.insert(item.object, command.clone());
        Some(command)
    }

    /// Returns where the path ends that a unit was told last to go along; `None` where it was told something else.
    pub(crate) fn goal(&self, item: &Item<'_>) -> Option<DVec2> {
        match self.told(item) {
            Some(Command::Path { points, .. }) => points.last().map(|&(x, y, _)| DVec2::new(x, y)),
            Some(_) | None => None,
        }
    }

    /// Returns what a unit was told last; `None`: nothing yet.
    pub(crate) fn told(&self, item: &Item<'_>) -> Option<&Command> {
        self.told.get(&item.object)
    }
}

/// Returns whether a unit that was told so still does it.
fn is_at_it(item: &Item<'_>, command: &Command) -> bool {
    let has = |task| item.seen.own.is_some_and(|own| own.task == task);
    match command {
        Command::Move { .. } | Command::Path { .. } => item.seen.base.is_moving(),
        Command::Attack { .. } => has(Task::Attack),
        Command::AttackAt { .. } => has(Task::AttackAt),
        Command::AttackMove { .. } => has(Task::AttackMove),
        Command::Hold { .. } => has(Task::Hold),
        Command::Gather { .. } => has(Task::Gather),
        Command::ReturnLoad { .. } => has(Task::ReturnLoad),
        Command::Build { .. } => has(Task::Build),
        Command::Stop { .. } => !item.seen.base.is_moving() && has(Task::None),
        Command::Resign | Command::Train { .. } | Command::Cancel { .. } | Command::Switch { .. } => false,
    }
}
