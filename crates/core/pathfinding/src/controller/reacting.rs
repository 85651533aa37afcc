//! Each on its own path; stopped, it takes another: the yardsticks `alone` and `replan`.

use glam::DVec2;

use super::Progress;
use super::scene::{GRACE, Order, Scene, is_there};
use crate::around::Detours;
use crate::crowd::Crowd;
use crate::ground::{Ground, MARGIN};
use crate::planner::Planner;
use crate::release::by_distance;

/// Paths that are planned in one cycle at most; who is left over comes first in the next.
const PATHS_A_CYCLE_MAX: usize = 64;

/// Leads each unit by itself.
#[derive(Clone, Debug)]
pub(crate) struct Reacting {
    goals: Vec<DVec2>,
    goes_around: bool,
    /// The place of the goal of each unit; empty before the first cycle.
    places: Vec<usize>,
    /// The cycle before which each unit is let be.
    patience: Vec<u32>,
    progress: Vec<Progress>,
    /// Who is looked at first.
    cursor: usize,
}

impl Reacting {
    /// Returns the mind that looks at walls alone.
    pub(crate) fn alone(goals: Vec<DVec2>) -> Self {
        Self {
            goals,
            goes_around: false,
            places: Vec::new(),
            patience: Vec::new(),
            progress: Vec::new(),
            cursor: 0,
        }
    }

    /// Returns the mind that goes around those who rest.
    pub(crate) fn around(goals: Vec<DVec2>) -> Self {
        Self { goes_around: true, ..Self::alone(goals) }
    }

    pub(crate) fn advance(&mut self, ground: &Ground, scene: &Scene<'_>) -> Vec<Order> {
        let count = scene.units.len().min(self.goals.len());
        if self.places.is_empty() {
            let starts: Vec<DVec2> = scene.units.iter().map(|unit| unit.position).take(count).collect();
            self.places = by_distance(&starts, &self.goals[..count]);
            self.patience = vec![0; count];
            self.progress = vec![Progress::Waiting; count];
        }
        let crowd = if self.goes_around { crowd(ground, scene) } else { Crowd::new() };
        let (mut planner, mut detours) = (Planner::new(ground), Detours::new(ground));
        let mut orders = Vec::new();
        let mut planned = 0;
        for unit in (self.cursor..count).chain(0..self.cursor) {
            let seen = scene.units[unit];
            let goal = self.goals[self.places[unit]];
            if seen.is_moving || is_there(seen.position, goal) {
                self.progress[unit] = if seen.is_moving { Progress::Going } else { Progress::Arrived };
                continue;
            }
            if scene.cycle < self.patience[unit] || self.progress[unit] == Progress::Unreachable {
                continue;
            }
            self.progress[unit] = Progress::Waiting;
            if planned == PATHS_A_CYCLE_MAX {
                self.cursor = unit;
                break;
            }
            planned += 1;
            let path = if self.goes_around {
                detours.path(&crowd, seen.position, goal)
            } else {
                planner.path(seen.position, goal).map(|legs| Some(legs.to_vec()))
            };
            match path {
                Ok(Some(legs)) => {
                    orders.push(Order { unit, legs, start: None });
                    self.patience[unit] = scene.cycle + GRACE;
                }
                Ok(None) if planner.connects(seen.position, goal) => {
                    self.patience[unit] = scene.cycle + GRACE;
                }
                Ok(None) | Err(_) => self.progress[unit] = Progress::Unreachable,
            }
        }
        orders
    }

    pub(crate) fn progress(&self, unit: usize) -> Progress {
        self.progress.get(unit).copied().unwrap_or(Progress::Waiting)
    }
}

/// All who rest. Whoever is asked for is among them, and the crowd lets each move away from where it is.
fn crowd(ground: &Ground, scene: &Scene<'_>) -> Crowd {
    let mut crowd = Crowd::new();
    let resting = scene.units.iter().filter(|unit| !unit.is_moving);
    let resting = resting.map(|unit| (unit.position, ground.radius()));
    let others = scene.others.iter().map(|circle| (circle.center, circle.radius));
    for (number, (center, radius)) in resting.chain(others).enumerate() {
        crowd.insert(number, center, ground.radius() + radius + MARGIN);
    }
    crowd
}
