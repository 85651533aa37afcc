//! By a schedule where there is one, else in step: the tactic `auto`.

use super::Progress;
use super::boarding::StepError;
use super::scene::{Delivery, Order, Scene};
use super::scheduled::Scheduled;
use super::squads::Squads;
use super::stepping::{Stepping, Verdict};
use crate::ground::Ground;
use crate::work::Work;

/// Cycles from one attempt in step that came to nothing to the next, at first and at most: each doubles them.
const RETRY_MIN: u32 = 16;
const RETRY_MAX: u32 = 256;

/// Leads by schedules, and in step where there is none.
#[derive(Clone, Debug)]
pub(crate) struct Auto {
    squads: Squads,
    speed: f64,
    delivery: Delivery,
    scheduled: Scheduled,
    /// While units are led in step.
    stepping: Option<Box<Stepping>>,
    /// Why the last attempt in step came to nothing.
    error: Option<StepError>,
    /// The cycle of the next attempt in step, and the cycles to the one after it.
    next: u32,
    retry: u32,
}

impl Auto {
    pub(crate) fn new(squads: Squads, speed: f64) -> Self {
        Self {
            scheduled: Scheduled::new(squads.clone(), speed, Delivery::Sure),
            squads,
            speed,
            delivery: Delivery::Sure,
            stepping: None,
            error: None,
            next: 0,
            retry: RETRY_MIN,
        }
    }

    /// Returns the same where this becomes of orders.
    pub(crate) fn with_delivery(self, delivery: Delivery) -> Self {
        let scheduled = Scheduled::new(self.squads.clone(), self.speed, delivery);
        Self { scheduled, delivery, ..self }
    }

    /// Returns the same that leads in step, as where there is no schedule.
    #[cfg(test)]
    pub(crate) fn in_step(self) -> Self {
        Self { scheduled: self.scheduled.without_schedules(), ..self }
    }

    pub(crate) fn advance(&mut self, ground: &Ground, scene: &Scene<'_>, work: &mut Work) -> Vec<Order> {
        if self.stepping.is_none() {
            let orders = self.scheduled.advance(ground, scene, work);
            if !self.scheduled.is_stuck() || scene.cycle < self.next {
                return orders;
            }
            self.stepping = Some(Box::new(Stepping::new(self.squads.clone(), self.speed, self.delivery)));
        }
        let Some(stepping) = &mut self.stepping else { return Vec::new() };
        match stepping.advance(ground, scene, work) {
            Verdict::Going(orders) => orders,
            Verdict::Done(goals) => {
                self.scheduled.take_over(scene.cycle, &goals);
                (self.stepping, self.error) = (None, None);
                (self.next, self.retry) = (scene.cycle, RETRY_MIN);
                Vec::new()
            }
            Verdict::Failed(error) => {
                self.error = Some(error);
                self.stepping = None;
                self.next = scene.cycle + self.retry;
                self.retry = (2 * self.retry).min(RETRY_MAX);
                self.scheduled.go_partly(scene);
                self.scheduled.advance(ground, scene, work)
            }
        }
    }

    pub(crate) fn error(&self) -> Option<StepError> {
        self.error
    }

    pub(crate) fn progress(&self, unit: usize) -> Progress {
        match &self.stepping {
            None => self.scheduled.progress(unit),
            Some(_) => Progress::Going,
        }
    }
}
