//! Going straight to where something is in reach.

use glam::DVec2;
use maniple_geometry::ObjectId;
use maniple_view::{Shape, Stop, hull_distance};

use crate::room::nearest_within;
use crate::world::State;

/// Hull to hull, in world units: so near is who works at something. One ORTS point.
pub(crate) const TOUCH: f64 = 1.0 / 16.0;

/// Part of a reach at which a way to it ends, so that no rounding leaves the end out of reach.
const WITHIN: f64 = 1.0 - 1.0 / 1024.0;

/// What somebody goes to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Goal {
    /// World units.
    pub(crate) center: DVec2,
    pub(crate) shape: Shape,
    /// Hull to hull, in world units; the end belongs to it.
    pub(crate) reach: f64,
}

/// How far an approach is at the start of a cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Approach {
    /// In reach; the object stands.
    There,
    /// Under way, or, if it cannot go, waiting.
    Coming,
    /// Something stopped it in the last cycle.
    Blocked,
}

impl Goal {
    /// Returns what has to be reached so that an object is within `reach` of another one.
    pub(crate) fn object(state: &State, object: ObjectId, reach: f64) -> Self {
        Self { center: state.center(object), shape: state.kind(object).shape, reach }
    }

    /// Returns whether an object is in reach.
    pub(crate) fn is_in_reach(&self, state: &State, object: ObjectId) -> bool {
        let offset = self.center - state.center(object);
        hull_distance(offset, &state.kind(object).shape, &self.shape) <= self.reach
    }
}

/// Lets an object go on to its goal: straight to the nearest point from which it is in reach, never around anything.
pub(crate) fn approach(state: &mut State, object: ObjectId, goal: &Goal) -> Approach {
    if goal.is_in_reach(state, object) {
        state.halt(object);
        return Approach::There;
    }
    if is_blocked(state, object) {
        return Approach::Blocked;
    }
    let here = state.center(object);
    let half = goal.shape.half();
    let nearest = nearest_within(here, goal.center - half, goal.center + half);
    let away = here - nearest;
    let apart = state.kind(object).shape.rounding() + goal.shape.rounding() + goal.reach * WITHIN;
    let end = nearest + away * (apart / away.length());
    state.send(object, end);
    Approach::Coming
}

/// Returns whether something stopped an object on its way in the last cycle.
pub(crate) fn is_blocked(state: &State, object: ObjectId) -> bool {
    if state.units.at(object).aim.is_none() {
        return false;
    }
    match state.stops.get(&object) {
        Some((_, Stop::Object(_) | Stop::Segment | Stop::Edge)) => true,
        Some((_, Stop::Arrived | Stop::Ordered)) | None => false,
    }
}
