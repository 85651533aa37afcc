//! One leads and the others go after it: the yardstick `follow`.

use glam::DVec2;

use super::Progress;
use super::scene::{GRACE, Order, Scene, is_there};
use crate::ground::Ground;
use crate::planner::Planner;
use crate::release::by_distance;

/// Leads a column: each goes to where the one before it is, until that one has arrived.
#[derive(Clone, Debug)]
pub(crate) struct Following {
    goals: Vec<DVec2>,
    /// The units, the leader first; empty before the first cycle.
    column: Vec<usize>,
    /// The place of the goal of each unit.
    places: Vec<usize>,
    patience: Vec<u32>,
    progress: Vec<Progress>,
}

impl Following {
    pub(crate) fn new(goals: Vec<DVec2>) -> Self {
        Self { goals, column: Vec::new(), places: Vec::new(), patience: Vec::new(), progress: Vec::new() }
    }

    pub(crate) fn advance(&mut self, ground: &Ground, scene: &Scene<'_>) -> Vec<Order> {
        if self.column.is_empty() {
            self.begin(scene);
        }
        let mut planner = Planner::new(ground);
        let mut orders = Vec::new();
        for rank in 0..self.column.len() {
            let unit = self.column[rank];
            let (seen, goal) = (scene.units[unit], self.goals[self.places[unit]]);
            if seen.is_moving || is_there(seen.position, goal) {
                self.progress[unit] = if seen.is_moving { Progress::Going } else { Progress::Arrived };
                continue;
            }
            if scene.cycle < self.patience[unit] || self.progress[unit] == Progress::Unreachable {
                continue;
            }
            self.progress[unit] = Progress::Waiting;
            let ahead = rank.checked_sub(1).map(|rank| self.column[rank]);
            let ahead = ahead.filter(|&ahead| self.progress[ahead] != Progress::Arrived);
            let target = ahead.map_or(goal, |ahead| scene.units[ahead].position);
            match planner.path(seen.position, target) {
                Ok(legs) => {
                    orders.push(Order { unit, legs: legs.to_vec(), start: None });
                    self.patience[unit] = scene.cycle + GRACE;
                }
                // Somebody may stand where there is no margin; a goal of one's own has to have room.
                Err(_) if ahead.is_some() => self.patience[unit] = scene.cycle + GRACE,
                Err(_) => self.progress[unit] = Progress::Unreachable,
            }
        }
        orders
    }

    /// Lines up by the distance from the middle of the goals.
    fn begin(&mut self, scene: &Scene<'_>) {
        let count = scene.units.len().min(self.goals.len());
        let starts: Vec<DVec2> = scene.units.iter().map(|unit| unit.position).take(count).collect();
        self.places = by_distance(&starts, &self.goals[..count]);
        let middle = self.goals.iter().sum::<DVec2>() / self.goals.len() as f64;
        self.column = (0..count).collect();
        let distance = |unit: usize| starts[unit].distance_squared(middle);
        self.column.sort_by(|&a, &b| distance(a).total_cmp(&distance(b)).then(a.cmp(&b)));
        self.patience = vec![0; count];
        self.progress = vec![Progress::Waiting; count];
    }

    pub(crate) fn progress(&self, unit: usize) -> Progress {
        self.progress.get(unit).copied().unwrap_or(Progress::Waiting)
    }
}
