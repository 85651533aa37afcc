//! Fixed ways at full speed, of which only the departures are planned.

use glam::DVec2;
use maniple_geometry::{Circle, Scalar};

use super::assign::{by_distance, by_passage};
use super::error::ReleaseError;
use super::order::Order;
use super::traffic::{Planned, Traffic};
use super::trajectory::Trajectory;
use super::trunk::Trunk;
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

/// Returns a schedule under which no circle ever comes nearer to another than touching and [`MARGIN`], nor to a wall.
///
/// # Errors
/// A group with fewer or more goals than circles, goals too near to each other, an end without a path, or nobody left whose way is
/// ever free: then another planner has to help.
pub fn release(ground: &Ground, request: &Request<'_>) -> Result<Schedule, ReleaseError> {
    let mut planner = Planner::new(ground);
    let units = units(&mut planner, request)?;
    let mut traffic = Traffic::default();
    for circle in request.still {
        let trajectory = Trajectory::still(circle.center);
        traffic.push(Planned { trajectory, departure: 0.0, radius: circle.radius });
    }
    let mut order = Order::new(&units, 2.0 * ground.radius() + MARGIN);
    let mut walks: Vec<Vec<Option<Walk>>> =
        request.groups.iter().map(|group| vec![None; group.starts.len()]).collect();
    let mut makespan = 0.0;
    while let Some((number, ways)) = order.next(&units) {
        let unit = &units[number];
        let reach = ground.radius() + MARGIN;
        let mut best: Option<(f64, f64, &Trajectory)> = None;
        for way in ways.iter().map(|&way| &unit.ways[way]) {
            let Some(departure) = traffic.earliest(way, reach, 0.0) else { continue };
            let arrival = departure + way.duration();
            if best.is_none_or(|(_, earliest, _)| arrival < earliest) {
                best = Some((departure, arrival, way));
            }
        }
        let (departure, arrival, way) = best.ok_or(ReleaseError::NoDeparture {
            group: unit.group,
            circle: unit.index,
            from: way_start(unit),
            to: unit.goal,
        })?;
        let legs = way.legs().iter().map(|leg| leg.position(leg.until)).collect();
        walks[unit.group][unit.index] = Some(Walk { goal: unit.place, departure, arrival, legs });
        traffic.push(Planned { trajectory: way.clone(), departure, radius: ground.radius() });
        order.leave(&units, number);
        makespan = arrival.greater(makespan);
    }
    let all = |walks: Vec<Option<Walk>>| walks.into_iter().map(|walk| walk.expect("all left")).collect();
    Ok(Schedule { walks: walks.into_iter().map(all).collect(), makespan })
}

fn way_start(unit: &Unit) -> DVec2 {
    unit.ways[0].start()
}

/// A circle and its ways.
#[derive(Clone, Debug)]
pub(crate) struct Unit {
    pub(crate) group: usize,
    /// Its place among the circles of its group.
    pub(crate) index: usize,
    /// The place of its goal.
    pub(crate) place: usize,
    pub(crate) goal: DVec2,
    /// At least one.
    pub(crate) ways: Vec<Trajectory>,
    /// Who is nearer to where all have to pass goes first, in world units.
    pub(crate) distance: f64,
}

/// Returns all circles with their ways, by group, and within it by who goes first.
fn units(planner: &mut Planner<'_>, request: &Request<'_>) -> Result<Vec<Unit>, ReleaseError> {
    let mut units = Vec::new();
    for (number, group) in request.groups.iter().enumerate() {
        if group.starts.len() != group.goals.len() {
            return Err(ReleaseError::Goals {
                group: number,
                circles: group.starts.len(),
                goals: group.goals.len(),
            });
        }
        if !group.starts.is_empty() {
            let first = units.len();
            add_group(planner, (number, group), request.speed, &mut units)?;
            units[first..].sort_by(|a, b| a.distance.total_cmp(&b.distance).then(a.index.cmp(&b.index)));
        }
    }
    Ok(units)
}

fn add_group(
    planner: &mut Planner<'_>,
    (number, group): (usize, &Group),
    speed: f64,
    units: &mut Vec<Unit>,
) -> Result<(), ReleaseError> {
    let ground = planner.ground();
    let ends = (middle_of(&group.starts), middle_of(&group.goals));
    let trunk = Trunk::new(ground, planner, ends, 2.0 * ground.radius() + MARGIN)?;
    let to_cut = distances(&group.starts, |start| trunk.distance_to_cut(planner, start))?;
    let places = match group.whose {
        Goals::Own => (0..group.starts.len()).collect(),
        Goals::Interchangeable if trunk.is_straight() => by_distance(&group.starts, &group.goals),
        Goals::Interchangeable => {
            let from_cut = distances(&group.goals, |goal| trunk.distance_from_cut(planner, goal))?;
            by_passage(&to_cut, &from_cut)
        }
    };
    for (index, &start) in group.starts.iter().enumerate() {
        let goal = group.goals[places[index]];
        let way = |lane| {
            let legs = trunk.way(planner, lane, (start, goal))?;
            Ok(Trajectory::new(start, &legs, speed))
        };
        let ways = (0..trunk.lanes.count).map(way).collect::<Result<Vec<_>, ReleaseError>>()?;
        units.push(Unit { group: number, index, place: places[index], goal, ways, distance: to_cut[index] });
    }
    Ok(())
}

fn distances(
    points: &[DVec2],
    distance: impl FnMut(DVec2) -> Result<f64, crate::PlanError>,
) -> Result<Vec<f64>, crate::PlanError> {
    points.iter().copied().map(distance).collect()
}

/// The point that is nearest to the middle of all.
fn middle_of(points: &[DVec2]) -> DVec2 {
    let middle = points.iter().sum::<DVec2>() / points.len() as f64;
    let distance = |point: &&DVec2| point.distance_squared(middle);
    *points.iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).expect("a group has circles")
}
