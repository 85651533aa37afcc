//! Each on its own path; stopped, it takes another: the yardsticks `alone` and `replan`.

use glam::DVec2;

use super::Progress;
use super::roster::Roster;
use super::scene::{Order, Scene};
use crate::around::Detours;
use crate::crowd::Crowd;
use crate::ground::{Ground, MARGIN};
use crate::planner::Planner;

/// Paths that are planned in one cycle at most; who is left over comes first in the next.
const PATHS_A_CYCLE_MAX: usize = 64;

/// Leads each unit by itself.
#[derive(Clone, Debug)]
pub(crate) struct Reacting {
    roster: Roster,
    goes_around: bool,
    /// Who is looked at first.
    cursor: usize,
}

impl Reacting {
    /// Returns the mind that looks at walls alone.
    pub(crate) fn alone(goals: Vec<DVec2>) -> Self {
        Self { roster: Roster::new(goals), goes_around: false, cursor: 0 }
    }

    /// Returns the mind that goes around those who rest.
    pub(crate) fn around(goals: Vec<DVec2>) -> Self {
        Self { goes_around: true, ..Self::alone(goals) }
    }

    pub(crate) fn advance(&mut self, ground: &Ground, scene: &Scene<'_>) -> Vec<Order> {
        let roster = &mut self.roster;
        roster.begin(scene);
        let crowd = if self.goes_around { crowd(ground, scene) } else { Crowd::new() };
        let (mut planner, mut detours) = (Planner::new(ground), Detours::new(ground));
        let mut orders = Vec::new();
        let mut planned = 0;
        for unit in (self.cursor..roster.count()).chain(0..self.cursor) {
            let Some(goal) = roster.due(unit, scene) else { continue };
            if planned == PATHS_A_CYCLE_MAX {
                self.cursor = unit;
                break;
            }
            planned += 1;
            let from = scene.units[unit].position;
            let path = if self.goes_around {
                detours.path(&crowd, from, goal)
            } else {
                planner.path(from, goal).map(|legs| Some(legs.to_vec()))
            };
            match path {
                Ok(Some(legs)) => {
                    orders.push(Order { unit, legs, start: None });
                    roster.let_be(unit, scene);
                }
                Ok(None) if planner.connects(from, goal) => roster.let_be(unit, scene),
                Ok(None) | Err(_) => roster.give_up(unit),
            }
        }
        orders
    }

    pub(crate) fn progress(&self, unit: usize) -> Progress {
        self.roster.progress(unit)
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
