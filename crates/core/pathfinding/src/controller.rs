//! Groups led to their goals while they are watched: by each of several tactics, and with as few orders as it takes.
//!
//! A [`Controller`] is told once a cycle where its units are, and answers with orders. It knows no view and no command: whoever
//! plays translates ([`Scene`], [`Order`]).

mod auto;
mod boarding;
mod following;
mod passage;
mod plan;
mod reacting;
mod roster;
mod scene;
mod scheduled;
mod squads;
mod stepping;
mod tactic;
mod walkers;

pub use boarding::StepError;
pub use scene::{Delivery, Order, Scene, Seen};
pub use tactic::{Tactic, UnknownTactic};

use std::ops::Range;

use glam::DVec2;
use maniple_geometry::Circle;

use crate::ground::Ground;
use crate::release::Group;
use crate::work::Work;
use auto::Auto;
use following::Following;
use reacting::Reacting;
use squads::Squads;

/// Looks a cycle, unless another budget is given: some ten milliseconds.
const LOOKS_A_CYCLE: u64 = 1 << 20;

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

/// Leads units of one radius to their goals.
#[derive(Clone, Debug)]
pub struct Controller {
    /// Who leads which units.
    minds: Vec<(Range<usize>, Mind)>,
    /// The stages behind the one that is under way.
    later: Vec<Vec<(Range<usize>, Mind)>>,
    /// Looks a cycle.
    budget: u64,
    /// Looks in the last cycle.
    looks: u64,
}

#[derive(Clone, Debug)]
enum Mind {
    Reacting(Reacting),
    Following(Following),
    Auto(Box<Auto>),
}

impl Controller {
    /// Returns a controller that leads units to goals; which to which it chooses itself. Speeds are in world units a cycle.
    #[must_use]
    pub fn new(tactic: Tactic, goals: Vec<DVec2>, speed: f64) -> Self {
        let mind = Mind::single(tactic, goals, speed);
        Self::of_minds(vec![(0..usize::MAX, mind)])
    }

    /// Returns a controller that leads several groups that may be in each other's way, at a speed in world units a cycle. The units
    /// of the first group come first, then those of the second, and so on. Under [`Tactic::Auto`] they are led together; under the
    /// others each group by itself, and goals are interchangeable within it.
    #[must_use]
    pub fn of_groups(tactic: Tactic, groups: &[Group], speed: f64) -> Self {
        if tactic == Tactic::Auto {
            let auto = Auto::new(Squads::of_groups(groups), speed);
            return Self::of_minds(vec![(0..usize::MAX, Mind::Auto(Box::new(auto)))]);
        }
        let mut first = 0;
        let mind = |group: &Group| {
            let units = first..first + group.starts.len();
            first = units.end;
            (units, Mind::single(tactic, group.goals.clone(), speed))
        };
        Self::of_minds(groups.iter().map(mind).collect())
    }

    fn of_minds(minds: Vec<(Range<usize>, Mind)>) -> Self {
        Self { minds, later: Vec::new(), budget: LOOKS_A_CYCLE, looks: 0 }
    }

    /// Returns a controller that leads units to the goals of one stage after the other: to those of the next when all have arrived, or
    /// cannot.
    ///
    /// # Panics
    /// Without a stage.
    #[must_use]
    pub fn by_stages(tactic: Tactic, stages: Vec<Vec<DVec2>>, speed: f64) -> Self {
        let all = stages.into_iter().map(|goals| Self::new(tactic, goals, speed));
        let mut minds: Vec<_> = all.map(|controller| controller.minds).collect();
        let first = minds.remove(0);
        minds.reverse();
        Self { later: minds, ..Self::of_minds(first) }
    }

    /// Returns how many stages lie behind the one that is under way.
    #[must_use]
    pub fn stages_left(&self) -> usize {
        self.later.len()
    }

    /// Returns the same that does other than 2^20 looks a cycle when it plans: what that leaves undone is done in the cycles after it. A
    /// look is a pair of straight pieces that are compared, a point of a lattice that is visited, or an agent that is moved by a step. A
    /// part that has begun is ended whatever it takes. Only [`Tactic::Auto`] plans by parts.
    #[must_use]
    pub fn with_budget(self, looks: u64) -> Self {
        Self { budget: looks.max(1), ..self }
    }

    /// Returns the same where other becomes of orders than [`Delivery::Sure`]. To be called before the first cycle.
    #[must_use]
    pub fn with_delivery(self, delivery: Delivery) -> Self {
        let with_delivery = |(units, mind)| match mind {
            Mind::Auto(auto) => (units, Mind::Auto(Box::new(auto.with_delivery(delivery)))),
            Mind::Reacting(_) | Mind::Following(_) => (units, mind),
        };
        let all = |minds: Vec<_>| -> Vec<_> { minds.into_iter().map(with_delivery).collect() };
        Self { minds: all(self.minds), later: self.later.into_iter().map(all).collect(), ..self }
    }

    /// Returns the same that leads in step, as where there is no schedule.
    #[cfg(test)]
    pub(crate) fn in_step(self) -> Self {
        let in_step = |(units, mind)| match mind {
            Mind::Auto(auto) => (units, Mind::Auto(Box::new(auto.in_step()))),
            Mind::Reacting(_) | Mind::Following(_) => (units, mind),
        };
        Self { minds: self.minds.into_iter().map(in_step).collect(), ..self }
    }

    /// Returns the orders for a cycle; at most one for each unit.
    ///
    /// The number of units must not change from one call to the next.
    pub fn advance(&mut self, ground: &Ground, scene: &Scene<'_>) -> Vec<Order> {
        let is_done = |unit| matches!(self.progress(unit), Progress::Arrived | Progress::Unreachable);
        if !self.later.is_empty() && (0..scene.units.len()).all(is_done) {
            self.minds = self.later.pop().unwrap_or_default();
        }
        let mut work = Work::new(self.budget);
        let orders = self.lead(ground, scene, &mut work);
        self.looks = work.done();
        orders
    }

    /// Returns how many looks the last cycle took.
    #[must_use]
    pub fn looks(&self) -> u64 {
        self.looks
    }

    fn lead(&mut self, ground: &Ground, scene: &Scene<'_>, work: &mut Work) -> Vec<Order> {
        if let [(_, mind)] = &mut self.minds[..] {
            return mind.advance(ground, scene, work);
        }
        let mut orders = Vec::new();
        for (units, mind) in &mut self.minds {
            let own = units.start.min(scene.units.len())..units.end.min(scene.units.len());
            let is_resting_other = |(unit, seen): &(usize, &Seen)| !own.contains(unit) && !seen.is_moving;
            let resting = scene.units.iter().enumerate().filter(is_resting_other);
            let resting = resting.map(|(_, seen)| Circle::new(seen.position, ground.radius()));
            let others: Vec<Circle> = scene.others.iter().copied().chain(resting).collect();
            let part = Scene { units: &scene.units[own.clone()], others: &others, ..*scene };
            let given = mind.advance(ground, &part, work).into_iter();
            orders.extend(given.map(|order| Order { unit: order.unit + own.start, ..order }));
        }
        orders
    }

    /// Returns what has become of a unit, as of the last call of [`Self::advance`].
    #[must_use]
    pub fn progress(&self, unit: usize) -> Progress {
        let found = self.minds.iter().find(|(units, _)| units.contains(&unit));
        let Some((units, mind)) = found else { return Progress::Waiting };
        let unit = unit - units.start;
        match mind {
            Mind::Reacting(mind) => mind.progress(unit),
            Mind::Following(mind) => mind.progress(unit),
            Mind::Auto(mind) => mind.progress(unit),
        }
    }

    /// Returns why units that cannot be scheduled could not be led in step either when that was tried last; `None` where it was not
    /// tried, or where it could be done.
    #[must_use]
    pub fn step_error(&self) -> Option<StepError> {
        self.minds.iter().find_map(|(_, mind)| match mind {
            Mind::Reacting(_) | Mind::Following(_) => None,
            Mind::Auto(mind) => mind.error(),
        })
    }
}

impl Mind {
    /// The mind of a tactic for one group that knows of no other.
    fn single(tactic: Tactic, goals: Vec<DVec2>, speed: f64) -> Self {
        match tactic {
            Tactic::Alone => Self::Reacting(Reacting::alone(goals)),
            Tactic::Replan => Self::Reacting(Reacting::around(goals)),
            Tactic::Follow => Self::Following(Following::new(goals)),
            Tactic::Auto => Self::Auto(Box::new(Auto::new(Squads::one(goals), speed))),
        }
    }

    fn advance(&mut self, ground: &Ground, scene: &Scene<'_>, work: &mut Work) -> Vec<Order> {
        match self {
            Self::Reacting(mind) => mind.advance(ground, scene),
            Self::Following(mind) => mind.advance(ground, scene),
            Self::Auto(mind) => mind.advance(ground, scene, work),
        }
    }
}
