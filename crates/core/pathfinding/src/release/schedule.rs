//! Fixed ways at full speed, of which only the departures are planned.

use glam::DVec2;
use maniple_geometry::{Circle, Scalar};

use super::ends::Ends;
use super::error::ReleaseError;
use super::order::{Care, Order};
use super::traffic::{Planned, Traffic};
use super::trajectory::{Piece, Trajectory};
use crate::around::{Crowd, Detours};
use crate::ground::{Ground, MARGIN};
use crate::planner::Planner;

/// Circles, and goals for each, for which a way around others is looked for before somebody departs who relies on others to have left.
const DETOURS_MAX: usize = 4;

/// The same where nobody relies on others.
const DETOURS_OF_SOME_MAX: usize = 16;

/// From where on goals are numbered in a crowd, and from where those who stay, and the goals of those on their way.
const GOALS: usize = 1 << 24;
const STILL: usize = 1 << 25;
const MOVING: usize = 1 << 26;

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

/// Lanes that are tried: as many as let most circles through side by side, and one fewer, since circles that come from aside need
/// more room where they turn; and, as long as there is no schedule, so many fewer.
const FEWER_LANES_MAX: usize = 3;

/// Returns a schedule under which no circle ever comes nearer to another than touching and [`MARGIN`], nor to a wall; of those that
/// are tried, the one that ends first.
///
/// # Errors
/// A group with fewer or more goals than circles, an end without a path, or nobody left whose way is ever free: then another
/// planner has to help.
pub fn release(ground: &Ground, request: &Request<'_>) -> Result<Schedule, ReleaseError> {
    let mut best = attempt(ground, request, (Reliance::OnAll, 0))?;
    for fewer_lanes in 1..=FEWER_LANES_MAX {
        let is_enough = best.stuck.is_none();
        let another = attempt(ground, request, (Reliance::OnAll, fewer_lanes))?;
        if another.stuck.is_none() && (!is_enough || another.makespan < best.makespan) {
            best = another;
        }
        if is_enough {
            break;
        }
    }
    if let Some(error) = best.stuck {
        return Err(error);
    }
    let all = |walks: Vec<Option<Walk>>| walks.into_iter().map(|walk| walk.expect("all left")).collect();
    Ok(Schedule { walks: best.walks.into_iter().map(all).collect(), makespan: best.makespan })
}

/// Returns a schedule for as many as can go even if all others stay where they are; `None` for each of those.
///
/// # Errors
/// A group with fewer or more goals than circles, or an end without a path.
pub fn release_some(ground: &Ground, request: &Request<'_>) -> Result<Vec<Vec<Option<Walk>>>, ReleaseError> {
    Ok(attempt(ground, request, (Reliance::OnNobody, 0))?.walks)
}

/// Whether somebody may depart who relies on others to leave in time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Reliance {
    OnAll,
    OnNobody,
}

/// What came of one try.
struct Attempt {
    walks: Vec<Vec<Option<Walk>>>,
    makespan: f64,
    /// Why not all have a walk.
    stuck: Option<ReleaseError>,
}

/// One try to find a schedule.
fn attempt(
    ground: &Ground,
    request: &Request<'_>,
    (reliance, fewer_lanes): (Reliance, usize),
) -> Result<Attempt, ReleaseError> {
    let mut planner = Planner::new(ground);
    let mut ends = Ends::new(fewer_lanes);
    for (number, group) in request.groups.iter().enumerate() {
        ends.add(&mut planner, number, group)?;
    }
    let mut board = Board::new(ground, request, &ends);
    let mut order = Order::new(&ends, 2.0 * ground.radius() + MARGIN);
    let walks = request.groups.iter().map(|group| vec![None; group.starts.len()]).collect();
    let mut attempt = Attempt { walks, makespan: 0.0, stuck: None };
    while !order.is_empty() {
        let Some(departing) = board.next(&ends, &mut order, reliance)? else {
            let start = &ends.starts[order.first(1)[0]];
            let (group, circle, from) = (start.group, start.index, start.point);
            attempt.stuck = Some(ReleaseError::NoDeparture { group, circle, from });
            break;
        };
        let Departing { start: number, goal: goal_number, departure, trajectory } = departing;
        let (start, goal) = (&ends.starts[number], &ends.goals[goal_number]);
        let arrival = departure + trajectory.duration();
        let legs = trajectory.legs().iter().map(Piece::end).collect();
        attempt.walks[start.group][start.index] = Some(Walk { goal: goal.index, departure, arrival, legs });
        attempt.makespan = arrival.greater(attempt.makespan);
        board.leave((number, start.point), (goal_number, goal.point));
        board.traffic.push(Planned { trajectory, departure, radius: ground.radius() });
        order.leave(&ends, (number, goal_number));
    }
    Ok(attempt)
}

/// A circle that has been found a departure.
struct Departing {
    start: usize,
    goal: usize,
    departure: f64,
    trajectory: Trajectory,
}

/// Where everybody is: on the way, or at rest.
struct Board<'a> {
    ground: &'a Ground,
    speed: f64,
    traffic: Traffic,
    /// Who stays, who waits, and those who have arrived, as somebody sees them who goes when all others rest.
    crowd: Crowd,
    detours: Detours<'a>,
}

impl<'a> Board<'a> {
    fn new(ground: &'a Ground, request: &Request<'_>, ends: &Ends) -> Self {
        let mut board = Self {
            ground,
            speed: request.speed,
            traffic: Traffic::default(),
            crowd: Crowd::new(),
            detours: Detours::new(ground),
        };
        for (number, circle) in request.still.iter().enumerate() {
            let trajectory = Trajectory::still(circle.center);
            board.traffic.push(Planned { trajectory, departure: 0.0, radius: circle.radius });
            board.crowd.insert(STILL + number, circle.center, ground.radius() + circle.radius + MARGIN);
        }
        for (number, moving) in request.moving.iter().enumerate() {
            let trajectory = Trajectory::new(moving.from, &moving.legs, moving.speed);
            let reach = ground.radius() + moving.radius + MARGIN;
            board.crowd.insert(MOVING + number, trajectory.goal(), reach);
            let (departure, radius) = (moving.departure, moving.radius);
            board.traffic.push(Planned { trajectory, departure, radius });
        }
        for (number, start) in ends.starts.iter().enumerate() {
            board.crowd.insert(number, start.point, board.reach());
        }
        board
    }

    /// How far the middles of two circles keep from each other.
    fn reach(&self) -> f64 {
        2.0 * self.ground.radius() + MARGIN
    }

    /// Returns who departs next, when and how; `None` where nobody can.
    fn next(
        &mut self,
        ends: &Ends,
        order: &mut Order,
        reliance: Reliance,
    ) -> Result<Option<Departing>, ReleaseError> {
        let mut has_tried_detours = false;
        while let Some((choice, care)) = order.next(ends) {
            if care > Care::Open {
                let count = if reliance == Reliance::OnAll { DETOURS_MAX } else { DETOURS_OF_SOME_MAX };
                for number in if has_tried_detours { Vec::new() } else { order.first(count) } {
                    let departing = self.detour(ends, order, number)?;
                    if departing.is_some() {
                        return Ok(departing);
                    }
                }
                has_tried_detours = true;
                if reliance == Reliance::OnNobody {
                    return Ok(None);
                }
            }
            let (start, goal) = (&ends.starts[choice.0], &ends.goals[choice.1]);
            let legs = [&start.legs[..], &goal.legs].concat();
            let trajectory = Trajectory::new(start.point, &legs, self.speed);
            let mut departing = self.departing(choice, trajectory);
            if departing.is_none() {
                departing = self.detour(ends, order, choice.0)?;
            }
            if departing.is_some() {
                return Ok(departing);
            }
            order.put_off(choice.0);
        }
        Ok(None)
    }

    fn departing(&mut self, (start, goal): (usize, usize), trajectory: Trajectory) -> Option<Departing> {
        let departure = self.traffic.earliest(&trajectory, self.ground.radius() + MARGIN, 0.0)?;
        Some(Departing { start, goal, departure, trajectory })
    }

    /// A way around all who rest, to the first goal of the stream to which there is one.
    fn detour(
        &mut self,
        ends: &Ends,
        order: &Order,
        number: usize,
    ) -> Result<Option<Departing>, ReleaseError> {
        let start = &ends.starts[number];
        self.crowd.remove(number, start.point, self.reach());
        let mut found = None;
        for &goal in order.goals(start.stream).iter().take(DETOURS_MAX) {
            let legs = self.detours.path(&self.crowd, start.point, ends.goals[goal].point)?;
            let Some(legs) = legs else { continue };
            let trajectory = Trajectory::new(start.point, &legs, self.speed);
            found = self.departing((number, goal), trajectory);
            if found.is_some() {
                break;
            }
        }
        self.crowd.insert(number, start.point, self.reach());
        Ok(found)
    }

    fn leave(&mut self, start: (usize, DVec2), goal: (usize, DVec2)) {
        let reach = self.reach();
        self.crowd.remove(start.0, start.1, reach);
        self.crowd.insert(GOALS + goal.0, goal.1, reach);
    }
}
