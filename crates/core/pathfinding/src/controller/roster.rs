//! Who goes to which goal, and how far each has got: what those keep who give each unit its order by itself.

use glam::DVec2;

use super::Progress;
use super::scene::{GRACE, Scene, is_there};
use crate::release::by_distance;

/// The units and their goals.
#[derive(Clone, Debug)]
pub(crate) struct Roster {
    goals: Vec<DVec2>,
    /// The place of the goal of each unit; empty before the first cycle.
    places: Vec<usize>,
    /// The cycle before which each unit is let be.
    patience: Vec<u32>,
    progress: Vec<Progress>,
}

impl Roster {
    /// Returns the roster of units that are not known yet.
    pub(crate) fn new(goals: Vec<DVec2>) -> Self {
        Self { goals, places: Vec::new(), patience: Vec::new(), progress: Vec::new() }
    }

    /// Shares out the goals by distance, the first time that it is called with units and goals.
    pub(crate) fn begin(&mut self, scene: &Scene<'_>) {
        if !self.places.is_empty() {
            return;
        }
        let count = scene.units.len().min(self.goals.len());
        let starts: Vec<DVec2> = scene.units.iter().map(|unit| unit.position).take(count).collect();
        self.places = by_distance(&starts, &self.goals[..count]);
        self.patience = vec![0; count];
        self.progress = vec![Progress::Waiting; count];
    }

    /// Takes in where a unit is, and returns its goal if it is to be given an order.
    pub(crate) fn due(&mut self, unit: usize, scene: &Scene<'_>) -> Option<DVec2> {
        let (seen, goal) = (scene.units[unit], self.goals[self.places[unit]]);
        if seen.is_moving || is_there(seen.position, goal) {
            self.progress[unit] = if seen.is_moving { Progress::Going } else { Progress::Arrived };
            return None;
        }
        if scene.cycle < self.patience[unit] || self.progress[unit] == Progress::Unreachable {
            return None;
        }
        self.progress[unit] = Progress::Waiting;
        Some(goal)
    }

    /// Lets a unit be for a while.
    pub(crate) fn let_be(&mut self, unit: usize, scene: &Scene<'_>) {
        self.patience[unit] = scene.cycle + GRACE;
    }

    /// Gives a unit up: no way leads to its goal.
    pub(crate) fn give_up(&mut self, unit: usize) {
        self.progress[unit] = Progress::Unreachable;
    }

    /// Returns the goals, of which as many are shared out as there are units.
    pub(crate) fn goals(&self) -> &[DVec2] {
        &self.goals
    }

    /// Returns how many units have a goal.
    pub(crate) fn count(&self) -> usize {
        self.places.len()
    }

    /// Returns what has become of a unit.
    pub(crate) fn progress(&self, unit: usize) -> Progress {
        self.progress.get(unit).copied().unwrap_or(Progress::Waiting)
    }
}
