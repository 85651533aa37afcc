//! Where circles start and where they go, and the legs at both ends.

use glam::DVec2;

use super::assign::{Sight, by_distance, lanes};
use super::error::ReleaseError;
use super::lanes::Lanes;
use super::schedule::{Goals, Group};
use super::trajectory::Trajectory;
use super::trunk::Trunk;
use crate::error::PlanError;
use crate::ground::MARGIN;
use crate::planner::Planner;

/// A circle that is to go.
#[derive(Clone, Debug)]
pub(crate) struct Start {
    pub(crate) group: usize,
    /// Its place among the circles of its group.
    pub(crate) index: usize,
    pub(crate) point: DVec2,
    /// Which goals it may have: those of the same stream.
    pub(crate) stream: usize,
    /// Who is nearer to where all have to pass goes first, in world units.
    pub(crate) distance: f64,
    /// As far as the way does not depend on the goal.
    pub(crate) legs: Vec<DVec2>,
    /// The same with times; only its places matter.
    pub(crate) trajectory: Trajectory,
}

/// A place to go to.
#[derive(Clone, Debug)]
pub(crate) struct Goal {
    /// Its place among the goals of its group.
    pub(crate) index: usize,
    pub(crate) point: DVec2,
    /// The legs from where the way depends on the goal.
    pub(crate) legs: Vec<DVec2>,
    /// The same with times; only its places matter.
    pub(crate) trajectory: Trajectory,
}

/// All starts and goals. Circles of one stream take its goals in turn.
#[derive(Clone, Debug, Default)]
pub(crate) struct Ends {
    /// By group, and within it by who goes first.
    pub(crate) starts: Vec<Start>,
    pub(crate) goals: Vec<Goal>,
    /// The goals of each stream, those that are to be taken first before the others.
    pub(crate) streams: Vec<Vec<usize>>,
    /// How many lanes fewer than fit are taken.
    fewer_lanes: usize,
}

impl Ends {
    /// Returns no ends yet; through narrow places lead so many lanes fewer than let most circles through, but at least one.
    pub(crate) fn new(fewer_lanes: usize) -> Self {
        Self { fewer_lanes, ..Self::default() }
    }

    /// Takes in a group.
    pub(crate) fn add(
        &mut self,
        planner: &mut Planner<'_>,
        number: usize,
        group: &Group,
    ) -> Result<(), ReleaseError> {
        let (circles, goals) = (group.starts.len(), group.goals.len());
        if circles != goals {
            return Err(ReleaseError::Goals { group: number, circles, goals });
        }
        if circles == 0 {
            return Ok(());
        }
        let ground = planner.ground();
        let (from, to) = (middle_of(&group.starts), middle_of(&group.goals));
        let lanes_of = |legs: &[DVec2]| {
            if circles == 1 {
                return Lanes::none();
            }
            Lanes::new(ground, from, legs, 2.0 * ground.radius() + MARGIN).without(self.fewer_lanes)
        };
        let trunk = Trunk::new(planner, (from, to), lanes_of)?;
        let first = self.starts.len();
        if trunk.is_narrow() {
            self.add_through(planner, (number, group), &trunk)?;
        } else {
            self.add_free(planner, (number, group), &trunk)?;
        }
        self.starts[first..].sort_by(|a, b| a.distance.total_cmp(&b.distance).then(a.index.cmp(&b.index)));
        Ok(())
    }

    /// Takes in a group that goes through a narrow place: a stream for each lane.
    fn add_through(
        &mut self,
        planner: &mut Planner<'_>,
        (number, group): (usize, &Group),
        trunk: &Trunk,
    ) -> Result<(), ReleaseError> {
        let starts = seen(&group.starts, |start| trunk.sight_of_start(planner, start))?;
        let goals = seen(&group.goals, |goal| trunk.sight_of_goal(planner, goal))?;
        let count = trunk.lanes.count.min(starts.len());
        let (start_lanes, goal_lanes) = (lanes(&starts, count), lanes(&goals, count));
        let stream = self.streams.len();
        let is_own = group.whose == Goals::Own;
        self.streams.resize(stream + if is_own { starts.len() } else { count }, Vec::new());
        for (index, &point) in group.starts.iter().enumerate() {
            let lane = start_lanes[index];
            let legs = trunk.entry(planner, lane, point)?;
            let stream = stream + if is_own { index } else { lane };
            self.push_start(Start {
                group: number,
                index,
                point,
                stream,
                distance: starts[index].distance,
                trajectory: Trajectory::new(point, &legs, 1.0),
                legs,
            });
        }
        for (index, &point) in group.goals.iter().enumerate() {
            let lane = if is_own { start_lanes[index] } else { goal_lanes[index] };
            let legs = trunk.exit(planner, lane, point)?;
            let stream = stream + if is_own { index } else { lane };
            let trajectory = Trajectory::new(trunk.gate(lane), &legs, 1.0);
            self.push_goal(stream, Goal { index, point, trajectory, legs });
        }
        for goals_of in &mut self.streams[stream..] {
            let distance = |&goal: &usize| goals[self.goals[goal].index].distance;
            goals_of.sort_by(|a, b| distance(b).total_cmp(&distance(a)).then(a.cmp(b)));
        }
        Ok(())
    }

    /// Takes in a group that has nothing narrow before it: a stream for each circle.
    fn add_free(
        &mut self,
        planner: &mut Planner<'_>,
        (number, group): (usize, &Group),
        trunk: &Trunk,
    ) -> Result<(), ReleaseError> {
        let starts = seen(&group.starts, |start| trunk.sight_of_start(planner, start))?;
        let places: Vec<usize> = match group.whose {
            Goals::Own => (0..group.starts.len()).collect(),
            Goals::Interchangeable => by_distance(&group.starts, &group.goals),
        };
        for (index, &point) in group.starts.iter().enumerate() {
            let goal = group.goals[places[index]];
            let legs = trunk.way(planner, (point, goal))?;
            let stream = self.streams.len();
            self.streams.push(Vec::new());
            self.push_start(Start {
                group: number,
                index,
                point,
                stream,
                distance: starts[index].distance,
                trajectory: Trajectory::new(point, &legs, 1.0),
                legs,
            });
            let trajectory = Trajectory::still(goal);
            self.push_goal(stream, Goal { index: places[index], point: goal, trajectory, legs: Vec::new() });
        }
        Ok(())
    }

    fn push_start(&mut self, start: Start) {
        self.starts.push(start);
    }

    fn push_goal(&mut self, stream: usize, goal: Goal) {
        self.streams[stream].push(self.goals.len());
        self.goals.push(goal);
    }
}

fn seen(
    points: &[DVec2],
    see: impl FnMut(DVec2) -> Result<Sight, PlanError>,
) -> Result<Vec<Sight>, PlanError> {
    points.iter().copied().map(see).collect()
}

/// The point that is nearest to the middle of all.
pub(crate) fn middle_of(points: &[DVec2]) -> DVec2 {
    let middle = points.iter().sum::<DVec2>() / points.len() as f64;
    let distance = |point: &&DVec2| point.distance_squared(middle);
    *points.iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).expect("a group has circles")
}
