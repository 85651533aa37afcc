//! A group on its way, led by a controller.

use std::sync::Arc;

use glam::DVec2;
use maniple_geometry::{Circle, Cycle};
use maniple_pathfinding::{Controller, Ground, Order, Progress, Seen, Tactic};
use maniple_view::{Command, Handle};

use crate::seeing::{Item, Scene};

/// Cycles after an order in which the controller gives a unit no other one, at most.
const GRACE: u32 = 5;

/// Units of one radius on their way to as many goals.
#[derive(Clone, Debug)]
pub(crate) struct March {
    ground: Arc<Ground>,
    controller: Controller,
    /// By handle.
    units: Vec<Handle>,
    /// Where each was seen last.
    seen: Vec<Seen>,
    /// The cycle of the last order to each.
    ordered: Vec<u32>,
}

impl March {
    /// Returns the march of units to goals; they go at `speed`, in world units a cycle, which must not be more than any of them can.
    pub(crate) fn new(
        (tactic, ground): (Tactic, Arc<Ground>),
        units: &[&Item<'_>],
        goals: Vec<DVec2>,
        speed: f64,
    ) -> Self {
        let mut items = units.to_vec();
        items.sort_by_key(|item| item.object);
        Self {
            ground,
            controller: Controller::new(tactic, goals, speed),
            units: items.iter().map(|item| item.object).collect(),
            seen: items.iter().map(|item| seen(item)).collect(),
            ordered: vec![0; items.len()],
        }
    }

    /// Returns the orders of a cycle to those who are free to march.
    ///
    /// Who is not, or is no more, counts as being under way, so that no way is planned for it; the others go around it where it rests.
    pub(crate) fn advance(
        &mut self,
        cycle: Cycle,
        scene: &Scene<'_>,
        is_free: impl Fn(Handle) -> bool,
    ) -> Vec<Command> {
        for (&object, last) in self.units.iter().zip(&mut self.seen) {
            *last = match scene.own(object) {
                Some(item) if is_free(object) => seen(item),
                Some(_) | None => Seen { is_moving: true, ..*last },
            };
        }
        let stands = |item: &&Item<'_>| {
            let is_other = self.units.binary_search(&item.object).is_err() || !is_free(item.object);
            is_other && item.is_in_the_way()
        };
        let circle = |item: &Item<'_>| Circle::new(item.center, item.kind.shape.radius());
        let others: Vec<Circle> = scene.all().filter(stands).map(circle).collect();
        let seen = maniple_pathfinding::Scene { cycle: cycle.0, units: &self.seen, others: &others };
        let orders = self.controller.advance(&self.ground, &seen);
        for order in &orders {
            self.ordered[order.unit] = cycle.0;
        }
        orders.into_iter().map(|order| command(self.units[order.unit], order)).collect()
    }

    /// Returns those who were free in the last cycle and wait, although it is some time since their last order: the controller knows
    /// no way for them.
    pub(crate) fn stuck(&self, cycle: Cycle) -> impl Iterator<Item = Handle> {
        let is_stuck = move |&unit: &usize| {
            let waits = self.controller.progress(unit) == Progress::Waiting;
            waits && !self.seen[unit].is_moving && cycle.0 > self.ordered[unit] + GRACE
        };
        (0..self.units.len()).filter(is_stuck).map(|unit| self.units[unit])
    }
}

fn seen(item: &Item<'_>) -> Seen {
    Seen { position: item.center, is_moving: item.seen.base.is_moving() }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a moment of a schedule is not negative, and a match is shorter than 2^32 cycles"
)]
fn command(object: Handle, order: Order) -> Command {
    if order.legs.is_empty() {
        return Command::Stop { object };
    }
    let points = order.legs.iter().map(|leg| (leg.x, leg.y, None)).collect();
    let start = order.start.map(|start| (Cycle(start as u32), start - start.floor()));
    Command::Path { object, points, start }
}
