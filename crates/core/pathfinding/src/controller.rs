//! Groups led to their goals while they are watched: by each of several tactics, and with as few orders as it takes.
//!
//! A [`Controller`] is told once a cycle where its units are, and answers with orders. It knows no view and no command: whoever
//! plays translates ([`Scene`], [`Order`]).

mod following;
mod reacting;
mod scene;
mod scheduled;
mod tactic;

pub use scene::{Order, Scene, Seen};
pub use tactic::{Tactic, UnknownTactic};

use glam::DVec2;

use crate::ground::Ground;
use following::Following;
use reacting::Reacting;
use scheduled::Scheduled;

/// What has become of a unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// It rests and has not arrived.
    Waiting,
    /// It is on its way.
    Going,
    /// It rests at a goal.
    Arrived,
    /// No way leads from where it is to any goal that is left.
    Unreachable,
}

/// Leads a group of units of one radius to as many goals.
#[derive(Clone, Debug)]
pub struct Controller {
    mind: Mind,
}

#[derive(Clone, Debug)]
enum Mind {
    Reacting(Reacting),
    Following(Following),
    Scheduled(Scheduled),
}

impl Controller {
    /// Returns a controller that leads units to goals; which to which it chooses itself. Speeds are in world units a cycle.
    #[must_use]
    pub fn new(tactic: Tactic, goals: Vec<DVec2>, speed: f64) -> Self {
        let mind = match tactic {
            Tactic::Alone => Mind::Reacting(Reacting::alone(goals)),
            Tactic::Replan => Mind::Reacting(Reacting::around(goals)),
            Tactic::Follow => Mind::Following(Following::new(goals)),
            Tactic::Auto => Mind::Scheduled(Scheduled::new(goals, speed)),
        };
        Self { mind }
    }

    /// Returns the orders for a cycle; at most one for each unit.
    ///
    /// The number of units must not change from one call to the next.
    pub fn advance(&mut self, ground: &Ground, scene: &Scene<'_>) -> Vec<Order> {
        match &mut self.mind {
            Mind::Reacting(mind) => mind.advance(ground, scene),
            Mind::Following(mind) => mind.advance(ground, scene),
            Mind::Scheduled(mind) => mind.advance(ground, scene),
        }
    }

    /// Returns what has become of a unit, as of the last call of [`Self::advance`].
    #[must_use]
    pub fn progress(&self, unit: usize) -> Progress {
        match &self.mind {
            Mind::Reacting(mind) => mind.progress(unit),
            Mind::Following(mind) => mind.progress(unit),
            Mind::Scheduled(mind) => mind.progress(unit),
        }
    }
}
