//! The way that an object would go through one cycle if nothing were in it.

use maniple_geometry::limits::TINY;
use maniple_geometry::{Cycle, Moment, Motion, Piece, Planar, Scalar};

use crate::event::EventKind;
use crate::plan::{Course, Leg, Placement, Plan, Planned};

/// A piece of a track, and what the object's plan is while it lasts.
#[derive(Clone, Debug)]
pub(crate) struct Stage<S: Scalar> {
    pub(crate) piece: Piece<S>,
    pub(crate) motion: Motion<S>,
    pub(crate) course: Option<Course<S>>,
    /// How many of the waiting legs were taken or dropped when the stage begins.
    pub(crate) consumed: usize,
    /// What happens when the stage begins.
    pub(crate) opening: Option<EventKind>,
}

/// Adds the stages of a plan in a cycle to a list: they follow each other without a gap from 0 to 1, so that time left
/// over at a waypoint goes into the next leg.
///
/// Each round takes or drops a waiting leg, ends one, or ends the cycle, so there are at most two for each leg of
/// the plan and one more.
pub(crate) fn add_stages<S: Scalar>(plan: &Plan<'_, S>, cycle: Cycle, stages: &mut Vec<Stage<S>>) {
    let mut walk = Walk {
        plan,
        cycle,
        time: S::ZERO,
        point: plan.motion.position(cycle).flushed(),
        motion: plan.motion,
        course: plan.course,
        consumed: 0,
        opening: None,
        stages,
    };
    while walk.advance() {}
}

/// A walk along a plan through one cycle.
struct Walk<'a, S: Scalar> {
    plan: &'a Plan<'a, S>,
    cycle: Cycle,
    time: S,
    point: S::Vector,
    motion: Motion<S>,
    course: Option<Course<S>>,
    consumed: usize,
    opening: Option<EventKind>,
    stages: &'a mut Vec<Stage<S>>,
}

impl<S: Scalar> Walk<'_, S> {
    /// Goes on to the next change; returns whether the cycle goes on after it.
    fn advance(&mut self) -> bool {
        match self.course {
            Some(course) => self.run(course),
            None => self.rest(),
        }
    }

    fn run(&mut self, course: Course<S>) -> bool {
        let left = S::from_f64(course.duration - self.motion.from.until(self.cycle));
        // At the start of a cycle the way to the goal is never without time, so that what lies on it is asked.
        let arrival = left.greater(self.time).greater(S::from_f64(TINY));
        if let Some((index, cut)) = self.next_replacement()
            && cut < arrival
        {
            self.push(cut, None);
            self.point = self.last_position(cut);
            self.begin(index, cut);
            return true;
        }
        if arrival > S::ONE {
            self.push(S::ONE, None);
            return false;
        }
        self.push(arrival, Some(course.leg.goal));
        self.point = course.leg.goal;
        self.time = arrival;
        self.settle(EventKind::Arrived);
        true
    }

    fn rest(&mut self) -> bool {
        let front = self.plan.queue.get(self.consumed).and_then(|planned| self.time_of(planned));
        let next = match (front.map(|time| (self.consumed, time)), self.next_replacement()) {
            (Some(front), Some(cut)) if cut.1 <= front.1 => Some(cut),
            (Some(front), _) => Some(front),
            (None, cut) => cut,
        };
        let Some((index, time)) = next else {
            self.push(S::ONE, None);
            return false;
        };
        if time > self.time {
            self.push(time, None);
        }
        self.begin(index, time);
        true
    }

    /// The first waiting leg that replaces what comes before it, and when, if that is in this cycle.
    fn next_replacement(&self) -> Option<(usize, S)> {
        let waiting = self.plan.queue.iter().enumerate().skip(self.consumed);
        let (index, planned) =
            waiting.into_iter().find(|(_, planned)| planned.placement == Placement::Replace)?;
        self.time_of(planned).map(|time| (index, time))
    }

    /// When a waiting leg may begin: now or later; `None` where that is not in this cycle.
    fn time_of(&self, planned: &Planned<S>) -> Option<S> {
        match planned.start {
            None => Some(self.time),
            Some(start) if start.cycle < self.cycle => Some(self.time),
            Some(start) if start.cycle == self.cycle => Some(S::from_f64(start.fraction).greater(self.time)),
            Some(_) => None,
        }
    }

    fn begin(&mut self, index: usize, time: S) {
        let was_moving = self.course.is_some();
        self.time = time;
        self.consumed = index + 1;
        match self.plan.queue[index].leg {
            None if was_moving => self.settle(EventKind::Ordered),
            None => {}
            Some(leg) if leg.goal == self.point => self.settle(EventKind::Arrived),
            Some(leg) => self.set_out(leg),
        }
    }

    fn settle(&mut self, event: EventKind) {
        if self.opening.is_some() {
            self.push(self.time, None);
        }
        self.opening = Some(event);
        self.motion = Motion::at_rest(self.point, self.moment());
        self.course = None;
    }

    fn set_out(&mut self, leg: Leg<S>) {
        let (motion, course) = departure(self.point, leg, self.moment());
        self.motion = motion;
        self.course = Some(course);
    }

    fn push(&mut self, until: S, goal: Option<S::Vector>) {
        let piece =
            Piece { point: self.point, velocity: self.motion.velocity, since: self.time, until, goal };
        self.stages.push(Stage {
            piece,
            motion: self.motion,
            course: self.course,
            consumed: self.consumed,
            opening: self.opening.take(),
        });
    }

    fn last_position(&self, time: S) -> S::Vector {
        self.stages.last().map_or(self.point, |stage| stage.piece.position(time))
    }

    fn moment(&self) -> Moment {
        Moment { cycle: self.cycle, fraction: self.time.to_f64() }
    }
}

/// Returns the motion from a point along a leg, and its course.
///
/// The velocity is `(goal - point) * (speed / length)`; the goal differs from the point.
pub(crate) fn departure<S: Scalar>(point: S::Vector, leg: Leg<S>, from: Moment) -> (Motion<S>, Course<S>) {
    let way = leg.goal - point;
    let velocity = (way * (leg.speed / way.length())).flushed();
    (Motion { start: point, velocity, from }, Course::along(leg, point))
}
