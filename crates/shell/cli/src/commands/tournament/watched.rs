//! A bot that is watched: what became of its commands, and whether it panics.

use std::mem;

use maniple_bots::Bot;
use maniple_view::{Command, Delta, Outcome, Rules, Seat, Terrain, View};
use serde::Serialize;

use crate::commands::tournament::caught::caught;

/// A panic of a bot.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub(super) struct Crash {
    /// The cycle for which it was to give commands; 0 also for what it does before the first.
    pub(super) cycle: u32,
    /// What the panic said, and where it was.
    pub(super) message: String,
}

/// A bot whose panics do not get out: it resigns instead, once, and is not asked any more.
pub(super) struct Watched {
    name: &'static str,
    state: State,
    /// Commands that were applied later than in the cycle that the bot had seen.
    pub(super) late: u64,
    /// Commands that were refused.
    pub(super) refused: u64,
    pub(super) crash: Option<Crash>,
}

enum State {
    Plays(Box<dyn Bot + Send>),
    Resigns,
    Out,
}

impl Watched {
    pub(super) fn new(bot: Box<dyn Bot + Send>) -> Self {
        Self { name: bot.name(), state: State::Plays(bot), late: 0, refused: 0, crash: None }
    }

    /// Returns what the bot answers; `None` if it panics, or is not asked any more.
    fn ask<T>(&mut self, cycle: u32, question: impl FnOnce(&mut dyn Bot) -> T) -> Option<T> {
        let State::Plays(bot) = &mut self.state else { return None };
        match caught(|| question(&mut **bot)) {
            Ok(answer) => Some(answer),
            Err(message) => {
                self.crash = Some(Crash { cycle, message });
                self.state = State::Resigns;
                None
            }
        }
    }
}

impl Bot for Watched {
    fn name(&self) -> &'static str {
        self.name
    }

    fn on_start(&mut self, seat: Seat, rules: &Rules, terrain: &Terrain) {
        self.ask(0, |bot| bot.on_start(seat, rules, terrain));
    }

    fn on_cycle(&mut self, view: &View, delta: &Delta) -> Vec<Command> {
        for result in &delta.results {
            match result.outcome {
                Outcome::Applied { late, .. } => self.late += u64::from(late > 0),
                Outcome::Refused { .. } => self.refused += 1,
            }
        }
        if let Some(commands) = self.ask(view.cycle().0, |bot| bot.on_cycle(view, delta)) {
            return commands;
        }
        match mem::replace(&mut self.state, State::Out) {
            State::Resigns => vec![Command::Resign],
            State::Plays(_) | State::Out => Vec::new(),
        }
    }
}
