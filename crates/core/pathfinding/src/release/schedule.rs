//! Fixed ways at full speed, of which only the departures are planned.

use glam::DVec2;
use maniple_geometry::{Circle, Scalar};

use super::ends::Ends;
use super::error::ReleaseError;
use super::order::Order;
use super::traffic::{Planned, Traffic};
use super::trajectory::Trajectory;
use crate::ground::{Ground, MARGIN};
use crate::planner::Planner;

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

/// Lanes that are tried: as many as let most circles through side by side, and one fewer, since circles that come from aside need
/// more room where they turn.
const FEWER_LANES_MAX: usize = 1;

/// Returns a schedule under which no circle ever comes nearer to another than touching and [`MARGIN`], nor to a wall; of those that
/// are tried, the one that ends first.
///
/// # Errors
/// A group with fewer or more goals than circles, an end without a path, or nobody left whose way is ever free: then another
/// planner has to help.
pub fn release(ground: &Ground, request: &Request<'_>) -> Result<Schedule, ReleaseError> {
    let mut best: Result<Schedule, ReleaseError> = attempt(ground, request, 0);
    if let Err(error @ (ReleaseError::Goals { .. } | ReleaseError::Path(_))) = best {
        return Err(error);
    }
    for fewer_lanes in 1..=FEWER_LANES_MAX {
        if let Ok(schedule) = attempt(ground, request, fewer_lanes)
            && best.as_ref().map_or(true, |best| schedule.makespan < best.makespan)
        {
            best = Ok(schedule);
        }
    }
    best
}

fn attempt(ground: &Ground, request: &Request<'_>, fewer_lanes: usize) -> Result<Schedule, ReleaseError> {
    let mut planner = Planner::new(ground);
    let mut ends = Ends::new(fewer_lanes);
    for (number, group) in request.groups.iter().enumerate() {
        ends.add(&mut planner, number, group)?;
    }
    let mut traffic = Traffic::default();
    for circle in request.still {
        let trajectory = Trajectory::still(circle.center);
        traffic.push(Planned { trajectory, departure: 0.0, radius: circle.radius });
    }
    let mut order = Order::new(&ends, 2.0 * ground.radius() + MARGIN);
    let mut walks: Vec<Vec<Option<Walk>>> =
        request.groups.iter().map(|group| vec![None; group.starts.len()]).collect();
    let mut makespan = 0.0;
    while let Some((start_number, goal_number)) = order.next(&ends) {
        let (start, goal) = (&ends.starts[start_number], &ends.goals[goal_number]);
        let legs = [&start.legs[..], &goal.legs].concat();
        let trajectory = Trajectory::new(start.point, &legs, request.speed);
        let departure = traffic.earliest(&trajectory, ground.radius() + MARGIN, 0.0);
        let departure = departure.ok_or(ReleaseError::NoDeparture {
            group: start.group,
            circle: start.index,
            from: start.point,
            to: goal.point,
        })?;
        let arrival = departure + trajectory.duration();
        walks[start.group][start.index] = Some(Walk { goal: goal.index, departure, arrival, legs });
        traffic.push(Planned { trajectory, departure, radius: ground.radius() });
        order.leave(&ends, (start_number, goal_number));
        makespan = arrival.greater(makespan);
    }
    let all = |walks: Vec<Option<Walk>>| walks.into_iter().map(|walk| walk.expect("all left")).collect();
    Ok(Schedule { walks: walks.into_iter().map(all).collect(), makespan })
}
