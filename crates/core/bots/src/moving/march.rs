//! A group on its way, led by a controller.

use std::sync::Arc;

use glam::DVec2;
use maniple_geometry::{Circle, Cycle};
use maniple_pathfinding::{Controller, Ground, Order, Progress, Seen, Tactic};
use maniple_view::{Command, Handle, Layer};

use crate::seeing::{Item, Scene};

/// Units of one radius on their way to as many goals.
#[derive(Clone, Debug)]
pub(crate) struct March {
    ground: Arc<Ground>,
    controller: Controller,
    /// By handle.
    units: Vec<Handle>,
    /// Where each was seen last.
    seen: Vec<Seen>,
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
        }
    }

    /// Returns the orders of a cycle.
    ///
    /// Who is no more counts as being under way, so that it gets no orders and stands in nobody's way.
    pub(crate) fn advance(&mut self, cycle: Cycle, scene: &Scene<'_>) -> Vec<Command> {
        for (&object, last) in self.units.iter().zip(&mut self.seen) {
            *last = scene.own(object).map_or(Seen { is_moving: true, ..*last }, seen);
        }
        let stands = |item: &&Item<'_>| {
            let is_other = self.units.binary_search(&item.object).is_err();
            let is_round = item.kind.shape.rounding() > 0.0;
            is_round && is_other && item.kind.layer == Layer::Ground && !item.seen.base.is_moving()
        };
        let circle = |item: &Item<'_>| Circle::new(item.center, item.kind.shape.radius());
        let others: Vec<Circle> = scene.all().filter(stands).map(circle).collect();
        let seen = maniple_pathfinding::Scene { cycle: cycle.0, units: &self.seen, others: &others };
        let orders = self.controller.advance(&self.ground, &seen);
        orders.into_iter().map(|order| command(self.units[order.unit], order)).collect()
    }

    /// Returns how many rest at a goal, as of the last cycle.
    pub(crate) fn arrived(&self) -> usize {
        (0..self.units.len()).filter(|&unit| self.controller.progress(unit) == Progress::Arrived).count()
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
