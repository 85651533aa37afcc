//! One leads and the others go after it: the yardstick `follow`.

use glam::DVec2;

use super::Progress;
use super::roster::Roster;
use super::scene::{Order, Scene};
use crate::ground::Ground;
use crate::planner::Planner;

/// Leads a column: each goes to where the one before it is, until that one has arrived.
#[derive(Clone, Debug)]
pub(crate) struct Following {
    roster: Roster,
    /// The units, the leader first; empty before the first cycle.
    column: Vec<usize>,
}

impl Following {
    pub(crate) fn new(goals: Vec<DVec2>) -> Self {
        Self { roster: Roster::new(goals), column: Vec::new() }
    }

    pub(crate) fn advance(&mut self, ground: &Ground, scene: &Scene<'_>) -> Vec<Order> {
        let Self { roster, column } = self;
        if column.is_empty() {
            roster.begin(scene);
            *column = line_up(roster, scene);
        }
        let mut planner = Planner::new(ground);
        let mut orders = Vec::new();
        for rank in 0..column.len() {
            let unit = column[rank];
            let Some(goal) = roster.due(unit, scene) else { continue };
            let ahead = rank.checked_sub(1).map(|rank| column[rank]);
            let ahead = ahead.filter(|&ahead| roster.progress(ahead) != Progress::Arrived);
            let target = ahead.map_or(goal, |ahead| scene.units[ahead].position);
            match planner.path(scene.units[unit].position, target) {
                Ok(legs) => {
                    orders.push(Order { unit, legs: legs.to_vec(), start: None });
                    roster.let_be(unit, scene);
                }
                // Somebody may stand where there is no margin; a goal of one's own has to have room.
                Err(_) if ahead.is_some() => roster.let_be(unit, scene),
                Err(_) => roster.give_up(unit),
            }
        }
        orders
    }

    pub(crate) fn progress(&self, unit: usize) -> Progress {
        self.roster.progress(unit)
    }
}

/// Returns the units by the distance from the middle of the goals.
fn line_up(roster: &Roster, scene: &Scene<'_>) -> Vec<usize> {
    let middle = roster.goals().iter().sum::<DVec2>() / roster.goals().len() as f64;
    let mut column: Vec<usize> = (0..roster.count()).collect();
    let distance = |unit: usize| scene.units[unit].position.distance_squared(middle);
    column.sort_by(|&a, &b| distance(a).total_cmp(&distance(b)).then(a.cmp(&b)));
    column
}
