//! What is to be scheduled, and what comes of it.

use glam::DVec2;
use maniple_geometry::Circle;

use super::error::ReleaseError;
use super::releasing::Releasing;
use crate::ground::Ground;
use crate::work::Work;

/// Whose goals are whose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Goals {
    /// Any circle of the group may go to any of its goals.
    Interchangeable,
    /// Each circle has the goal with its number.
    Own,
}

/// Circles at rest that go somewhere together.
#[derive(Clone, Debug, PartialEq)]
pub struct Group {
    /// Where they rest, in world units.
    pub starts: Vec<DVec2>,
    /// As many points to go to, in world units.
    pub goals: Vec<DVec2>,
    /// Whose goals these are.
    pub whose: Goals,
}

/// What is to be scheduled.
#[derive(Clone, Copy, Debug)]
pub struct Request<'a> {
    /// The groups; where their ways cross, earlier ones go first.
    pub groups: &'a [Group],
    /// The speed of all, in world units a cycle.
    pub speed: f64,
    /// Who stays where it is.
    pub still: &'a [Circle],
    /// Who is on its way already, and keeps to it.
    pub moving: &'a [Moving],
}

/// A circle that is on its way, or is going to be.
#[derive(Clone, Debug, PartialEq)]
pub struct Moving {
    /// Where it starts, in world units.
    pub from: DVec2,
    /// The goals of its legs.
    pub legs: Vec<DVec2>,
    /// When it departs, in cycles since the beginning of the schedule; may be negative.
    pub departure: f64,
    /// In world units a cycle.
    pub speed: f64,
    /// In world units.
    pub radius: f64,
}

/// When and how one circle goes.
#[derive(Clone, Debug, PartialEq)]
pub struct Walk {
    /// The place of its goal among those of its group.
    pub goal: usize,
    /// When it departs, in cycles since the beginning of the schedule.
    pub departure: f64,
    /// When it arrives.
    pub arrival: f64,
    /// The goals of its legs, one after the other; none where it is there.
    pub legs: Vec<DVec2>,
}

/// A plan for all circles of a request.
#[derive(Clone, Debug, PartialEq)]
pub struct Schedule {
    /// By group, then by circle.
    pub walks: Vec<Vec<Walk>>,
    /// When the last one arrives, in cycles.
    pub makespan: f64,
}

/// Returns a schedule under which no circle ever comes nearer to another than touching and [`MARGIN`](crate::MARGIN), nor to a wall;
/// of those that are tried, the one that ends first. Part by part: [`Releasing`].
///
/// # Errors
/// A group with fewer or more goals than circles, an end without a path, or nobody left whose way is ever free: then another
/// planner has to help.
pub fn release(ground: &Ground, request: &Request<'_>) -> Result<Schedule, ReleaseError> {
    let ended = Releasing::new(request).advance(ground, u64::MAX);
    ended.expect("so much work ends")
}

/// Returns a schedule for as many as can go even if all others stay where they are; `None` for each of those.
///
/// # Errors
/// A group with fewer or more goals than circles, or an end without a path.
pub fn release_some(ground: &Ground, request: &Request<'_>) -> Result<Vec<Vec<Option<Walk>>>, ReleaseError> {
    let mut work = Work::new(u64::MAX);
    let ended = Releasing::of_some(request).go_on(ground, &mut work);
    ended.expect("so much work ends").map(|attempt| attempt.walks)
}
