//! Orders to objects.

use maniple_geometry::{Moment, NumberError, ObjectId, Planar, Scalar};

use crate::error::OrderError;
use crate::plan::{Leg, Placement, Planned, WAYPOINTS_MAX};
use crate::track::departure;
use crate::world::World;

impl<S: Scalar> World<S> {
    /// Lets an object go along legs, one after the other; taken as a whole or refused as a whole.
    ///
    /// With [`Placement::Replace`], what runs goes on until `start`, or ends now where there is none. With
    /// [`Placement::Queue`], the first leg begins at the later of `start` and the end of what is before it.
    ///
    /// # Errors
    /// An unknown object, a number out of the limits, a start before the present cycle, no leg, or more than
    /// [`WAYPOINTS_MAX`] waiting.
    pub fn go(
        &mut self,
        id: ObjectId,
        legs: &[Leg<S>],
        placement: Placement,
        start: Option<Moment>,
    ) -> Result<(), OrderError> {
        let slot = self.objects.slot(id).ok_or(OrderError::UnknownObject)?;
        let (&first, rest) = legs.split_first().ok_or(OrderError::EmptyPath)?;
        for leg in legs {
            self.check_leg(leg)?;
        }
        self.check_start(start)?;
        let now = Moment::start_of(self.cycle);
        let start = match placement {
            Placement::Replace => Some(start.unwrap_or(now)),
            Placement::Queue => start,
        };
        let kept = self.kept(slot, placement, start)?;
        if kept + legs.len() > WAYPOINTS_MAX {
            return Err(OrderError::TooManyWaypoints { max: WAYPOINTS_MAX });
        }
        let behind =
            rest.iter().map(|&leg| Planned { leg: Some(leg), placement: Placement::Queue, start: None });
        let state = &self.objects.states[slot as usize];
        let (point, rested) = (state.position(self.cycle), state.rested_until(now));
        if placement == Placement::Replace && start <= Some(now) && first.goal != point {
            // What begins at once need not wait for the cycle to begin.
            let (motion, _) = departure(point, first, now);
            self.objects.set_out(slot, &motion, first);
            self.objects.states[slot as usize].rested_before = rested;
            self.objects.extend_queue(slot, 0, behind);
        } else {
            let planned = std::iter::once(Planned { leg: Some(first), placement, start }).chain(behind);
            self.objects.extend_queue(slot, kept, planned);
        }
        self.objects.settle(slot, self.cycle);
        self.activate(slot);
        Ok(())
    }

    /// Lets an object stop and forget what waits, at `start` or now; what runs goes on until then.
    ///
    /// # Errors
    /// An unknown object, a start that is no moment or lies before the present cycle, or a full queue.
    pub fn halt(&mut self, id: ObjectId, start: Option<Moment>) -> Result<(), OrderError> {
        let slot = self.objects.slot(id).ok_or(OrderError::UnknownObject)?;
        self.check_start(start)?;
        let now = Moment::start_of(self.cycle);
        let state = &self.objects.states[slot as usize];
        if start.is_none_or(|start| start <= now) && state.rested_until(now) {
            // It has not moved, so there is no stop to tell of.
            if state.is_moving() {
                self.objects.set_at_rest(slot, state.start, now);
            }
            self.objects.clear_queue(slot);
            self.objects.settle(slot, self.cycle);
            return Ok(());
        }
        let start = Some(start.unwrap_or(now));
        let kept = self.kept(slot, Placement::Replace, start)?;
        if kept + 1 > WAYPOINTS_MAX {
            return Err(OrderError::TooManyWaypoints { max: WAYPOINTS_MAX });
        }
        let halt = Planned { leg: None, placement: Placement::Replace, start };
        self.objects.extend_queue(slot, kept, std::iter::once(halt));
        self.objects.settle(slot, self.cycle);
        self.activate(slot);
        Ok(())
    }

    /// How many of the waiting legs an order leaves.
    fn kept(&self, slot: u32, placement: Placement, start: Option<Moment>) -> Result<usize, OrderError> {
        let plan = self.objects.plan(slot);
        Ok(match (placement, start) {
            (Placement::Replace, Some(start)) => plan.kept_by(start, Moment::start_of(self.cycle)),
            (Placement::Replace, None) => 0,
            (Placement::Queue, _) => plan.queue.len(),
        })
    }

    fn check_leg(&self, leg: &Leg<S>) -> Result<(), OrderError> {
        let bad = |(field, problem)| OrderError::BadNumber { field, problem };
        self.limits.check_point(leg.goal.to_dvec2()).map_err(bad)?;
        let speed = leg.speed.to_f64();
        self.limits.check_speed(speed).map_err(|problem| bad(("s", problem)))?;
        if speed == 0.0 {
            return Err(bad(("s", NumberError::NotPositive(speed))));
        }
        Ok(())
    }

    fn check_start(&self, start: Option<Moment>) -> Result<(), OrderError> {
        let Some(start) = start else { return Ok(()) };
        let bad = |problem| OrderError::BadNumber { field: "start", problem };
        self.limits.check_fraction(start.fraction).map_err(bad)?;
        if start.cycle < self.cycle {
            return Err(OrderError::StartInPast { now: self.cycle });
        }
        Ok(())
    }
}
