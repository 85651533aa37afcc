//! Where circles start and where they go, and the legs at both ends.

use std::collections::BTreeSet;

use glam::DVec2;
use maniple_geometry::Scalar;

use super::assign::{Assignment, Sight, lanes};
use super::beats::{Passage, Timing};
use super::bundle::{self, Bundle, Keeping};
use super::error::ReleaseError;
use super::lanes::{Lanes, Passing};
use super::schedule::{Goals, Group};
use super::trajectory::Trajectory;
use super::trunk::Trunk;
use crate::around::Detours;
use crate::ground::{Ground, MARGIN};
use crate::planner::{Planner, length};
use crate::work::PATH;

/// A circle that is to go.
#[derive(Clone, Debug)]
pub(crate) struct Start {
    pub(crate) group: usize,
    /// Its place among the circles of its group.
    pub(crate) index: usize,
    pub(crate) point: DVec2,
    /// Which goals it may have: those of the same stream.
    pub(crate) stream: usize,
    /// How it passes the narrow place; `None` where nothing is narrow.
    pub(crate) passage: Option<Passage>,
    /// Who is nearer to where all have to pass goes first, in world units.
    pub(crate) distance: f64,
    /// As far as the way does not depend on the goal.
    pub(crate) legs: Vec<DVec2>,
    /// The same with times; only its places matter.
    pub(crate) trajectory: Trajectory,
}

#[cfg(test)]
impl Start {
    /// A circle that goes nowhere.
    pub(crate) fn still(point: DVec2) -> Self {
        let (legs, trajectory) = (Vec::new(), Trajectory::still(point));
        Self { group: 0, index: 0, point, stream: 0, passage: None, distance: 0.0, legs, trajectory }
    }
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
    /// How far the slowest group goes, the last behind the first of each lane, in world units; 0 where none is in lanes.
    pub(crate) course: f64,
    /// Whether the shortest way of a group that goes side by side has a narrow place that lets many more through.
    pub(crate) is_shortest_denser: bool,
    /// How else narrow places can be passed.
    pub(crate) passings: BTreeSet<Passing>,
}

/// Circles a lane that are shared out at a time, so that lanes keep step: places behind are taken before those before them, whatever their
/// lanes are.
const AT_A_TIME: usize = 12;

/// The part of the way of a group side by side that is to be saved where a narrow place lets more through.
const DENSER: f64 = 0.0625;

/// Which lanes are tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Plan {
    /// Side by side wherever that ends earlier, in so many lanes at most.
    SideBySide { lanes_max: usize, keeping: Keeping },
    /// On the shortest way, passing narrow places so.
    Shortest(Passing),
}

/// A group that is taken in circle by circle.
#[derive(Clone, Debug)]
pub(crate) struct Adding {
    number: usize,
    trunk: Trunk,
    timing: Timing,
    /// How many lanes side by side are tried next.
    untried: Option<(usize, Keeping)>,
    /// How the starts and the goals look from the narrow place, as far as it was looked.
    starts: Vec<Sight>,
    goals: Vec<Sight>,
    /// The lanes of the circles and of the goals.
    start_lanes: Vec<usize>,
    goal_lanes: Vec<usize>,
    /// Who goes to which goal where nothing is narrow.
    assignment: Option<Assignment>,
    /// Where its ends begin among those of all.
    first: usize,
    first_goal: usize,
    first_stream: usize,
}

impl Adding {
    /// Begins to take in a group. `None` for a group of nobody.
    pub(crate) fn new(
        planner: &mut Planner<'_>,
        (number, group): (usize, &Group),
        plan: Plan,
        ends: &mut Ends,
    ) -> Result<Option<Self>, ReleaseError> {
        let (circles, goals) = (group.starts.len(), group.goals.len());
        if circles != goals {
            return Err(ReleaseError::Goals { group: number, circles, goals });
        }
        if circles == 0 {
            return Ok(None);
        }
        let ground = planner.ground();
        let (from, to) = (middle_of(&group.starts), middle_of(&group.goals));
        let passing = match plan {
            Plan::SideBySide { .. } => Passing::Densest,
            Plan::Shortest(passing) => passing,
        };
        let lanes_of = |path: &[DVec2]| {
            if circles == 1 {
                return Lanes::none();
            }
            let (lanes, reach) = (Lanes::new(ground, group, path, reach_of(ground)), reach_of(ground));
            // The first group has nobody to meet.
            let is_tried = |&other: &Passing| other != Passing::KeepRight || number > 0;
            let is_other = |&other: &Passing| lanes.passed(other, reach).is_some();
            ends.passings.extend(Passing::ALL.into_iter().filter(is_tried).filter(is_other));
            lanes.passed(passing, reach).unwrap_or(lanes)
        };
        let trunk = Trunk::new(planner, (from, to), lanes_of)?;
        let untried = match plan {
            Plan::SideBySide { lanes_max, keeping }
                if circles >= bundle::CIRCLES_MIN && (trunk.has_turns || keeping == Keeping::Right) =>
            {
                Some((bundle::lanes_max(circles).min(lanes_max), keeping))
            }
            Plan::SideBySide { .. } | Plan::Shortest(_) => None,
        };
        let timing = if passing == Passing::OnBeats { Timing::OnBeats } else { Timing::Anytime };
        Ok(Some(Self {
            number,
            trunk,
            timing,
            untried: untried.filter(|&(lanes, keeping)| lanes >= keeping.lanes_min()),
            starts: Vec::new(),
            goals: Vec::new(),
            start_lanes: Vec::new(),
            goal_lanes: Vec::new(),
            assignment: None,
            first: ends.starts.len(),
            first_goal: ends.goals.len(),
            first_stream: ends.streams.len(),
        }))
    }

    /// Does one part more, and returns how many looks it took; `None` where all is done.
    pub(crate) fn advance(
        &mut self,
        (planner, detours): (&mut Planner<'_>, &mut Detours<'_>),
        group: &Group,
        ends: &mut Ends,
    ) -> Result<Option<u64>, ReleaseError> {
        let circles = group.starts.len();
        if let Some(untried) = self.untried {
            self.try_side_by_side((planner.ground(), &mut *detours), group, (untried, &mut *ends));
            return Ok(Some(PATH + detours.expanded() as u64));
        }
        if let Some(&start) = group.starts.get(self.starts.len()) {
            self.starts.push(self.trunk.sight_of_start(planner, start)?);
            return Ok(Some(PATH));
        }
        if !self.trunk.has_lanes() {
            return self.add_free(planner, group, ends);
        }
        if let Some(&goal) = group.goals.get(self.goals.len()) {
            self.goals.push(self.trunk.sight_of_goal(planner, goal)?);
            return Ok(Some(PATH));
        }
        let (starts, goals) = (ends.starts.len() - self.first, ends.goals.len() - self.first_goal);
        if starts < circles {
            self.add_start(planner, (group, starts), ends)?;
        } else if goals < circles {
            self.add_goal(planner, (group, goals), ends)?;
        } else {
            for goals_of in &mut ends.streams[self.first_stream..] {
                let distance = |&goal: &usize| self.goals[ends.goals[goal].index].distance;
                goals_of.sort_by(|a, b| distance(b).total_cmp(&distance(a)).then(a.cmp(b)));
            }
            self.sort(ends);
            return Ok(None);
        }
        Ok(Some(PATH))
    }

    /// Tries so many lanes side by side; they are taken if they end earlier than one after the other on the shortest way: around corners
    /// all come into one track, however many a narrow place lets through.
    fn try_side_by_side(
        &mut self,
        (ground, detours): (&Ground, &mut Detours<'_>),
        group: &Group,
        ((lanes, keeping), ends): ((usize, Keeping), &mut Ends),
    ) {
        let (circles, reach) = (group.starts.len() as f64, reach_of(ground));
        let (from, to) =
            (bundle::End::of(ground, keeping, &group.starts), bundle::End::of(ground, keeping, &group.goals));
        let bundle = Bundle::new((ground, detours), (from, to), (lanes, keeping, reach));
        let saved = match keeping {
            Keeping::Middle => circles * reach * (1.0 - 1.0 / lanes as f64),
            Keeping::Right => circles * reach,
        };
        match bundle.filter(|bundle| bundle.length() < self.trunk.length + saved) {
            Some(bundle) => {
                let course = self.trunk.length.greater(bundle.length()) + circles * reach / lanes as f64;
                ends.course = ends.course.greater(course);
                let saved = |density: f64| circles * (reach / lanes as f64 - 1.0 / density);
                let is_denser = |density: f64| saved(density) > DENSER * course;
                ends.is_shortest_denser |= self.trunk.lanes.density.is_some_and(is_denser);
                self.trunk = Trunk::of_bundle((from.middle, to.middle), bundle);
                self.untried = None;
            }
            None => {
                let fewer = bundle::fewer(lanes);
                self.untried = (fewer >= keeping.lanes_min()).then_some((fewer, keeping));
            }
        }
    }

    /// How many lanes side by side the group goes in; `None` where it goes on the shortest way.
    pub(crate) fn side_by_side(&self) -> Option<usize> {
        (self.trunk.lanes.is_side_by_side()).then_some(self.trunk.lanes.count)
    }

    /// How many lanes lead through the narrow place.
    fn lanes(&self) -> usize {
        self.trunk.lanes.count.min(self.starts.len())
    }

    /// Takes in a circle that goes through a narrow place: there is a stream for each lane, or for each circle with a goal of its own.
    fn add_start(
        &mut self,
        planner: &mut Planner<'_>,
        (group, index): (&Group, usize),
        ends: &mut Ends,
    ) -> Result<(), ReleaseError> {
        let is_own = group.whose == Goals::Own;
        if index == 0 {
            let count = self.lanes();
            let at_a_time = count * AT_A_TIME;
            let near_first = by_distance(&self.starts);
            let far_first = by_distance(&self.goals).into_iter().rev().collect();
            self.start_lanes = lanes(&self.starts, near_first, (count, at_a_time));
            self.goal_lanes = match group.whose {
                Goals::Own => self.start_lanes.clone(),
                Goals::Interchangeable => lanes(&self.goals, far_first, (count, at_a_time)),
            };
            if self.side_by_side().is_none() {
                let (starts, goals) = (&self.start_lanes, &self.goal_lanes);
                let ends = (by_lane(&group.starts, starts, count), by_lane(&group.goals, goals, count));
                self.trunk.fan_out(planner.ground(), ends, reach_of(planner.ground()));
            }
            let streams = if is_own { self.starts.len() } else { count };
            ends.streams.resize(self.first_stream + streams, Vec::new());
        }
        let lane = self.start_lanes[index];
        let point = group.starts[index];
        let legs = self.trunk.entry(planner, lane, point)?;
        let passage = self.side_by_side().is_none().then(|| Passage {
            lane,
            distance: length(point, &legs),
            spacing: self.trunk.lanes.spacing(reach_of(planner.ground())),
            timing: self.timing,
        });
        ends.starts.push(Start {
            group: self.number,
            index,
            point,
            stream: self.first_stream + if is_own { index } else { lane },
            passage,
            distance: self.starts[index].distance,
            trajectory: Trajectory::new(point, &legs, 1.0),
            legs,
        });
        Ok(())
    }

    fn add_goal(
        &self,
        planner: &mut Planner<'_>,
        (group, index): (&Group, usize),
        ends: &mut Ends,
    ) -> Result<(), ReleaseError> {
        let is_own = group.whose == Goals::Own;
        let lane = self.goal_lanes[index];
        let point = group.goals[index];
        let legs = self.trunk.exit(planner, lane, point)?;
        let stream = self.first_stream + if is_own { index } else { lane };
        let trajectory = Trajectory::new(self.trunk.gate(lane), &legs, 1.0);
        ends.push_goal(stream, Goal { index, point, trajectory, legs });
        Ok(())
    }

    /// Takes in one circle more that has nothing narrow before it: there is a stream for each.
    fn add_free(
        &mut self,
        planner: &mut Planner<'_>,
        group: &Group,
        ends: &mut Ends,
    ) -> Result<Option<u64>, ReleaseError> {
        let index = ends.starts.len() - self.first;
        if index == group.starts.len() {
            self.sort(ends);
            return Ok(None);
        }
        let place = match group.whose {
            Goals::Own => index,
            Goals::Interchangeable => {
                let assignment =
                    self.assignment.get_or_insert_with(|| Assignment::new(&group.starts, &group.goals));
                let cost =
                    |start: usize, goal: usize| group.starts[start].distance_squared(group.goals[goal]);
                if let Some(looks) = assignment.advance(cost) {
                    return Ok(Some(looks));
                }
                assignment.assigned[index]
            }
        };
        let (point, goal) = (group.starts[index], group.goals[place]);
        let legs = self.trunk.way(planner, (point, goal))?;
        let stream = ends.streams.len();
        ends.streams.push(Vec::new());
        ends.starts.push(Start {
            group: self.number,
            index,
            point,
            stream,
            passage: None,
            distance: self.starts[index].distance,
            trajectory: Trajectory::new(point, &legs, 1.0),
            legs,
        });
        let trajectory = Trajectory::still(goal);
        ends.push_goal(stream, Goal { index: place, point: goal, trajectory, legs: Vec::new() });
        Ok(Some(PATH))
    }

    /// Puts those first who go first: the nearest of each lane, then the next of each, and so on, every second lane before its neighbours.
    ///
    /// Neighbouring lanes of a narrow place are nearer to each other than circles, which stand in each other's gaps: if one lane ran ahead,
    /// those beside it would find gaps that do not fit both.
    fn sort(&self, ends: &mut Ends) {
        let starts = &mut ends.starts[self.first..];
        starts.sort_by(|a, b| a.distance.total_cmp(&b.distance).then(a.index.cmp(&b.index)));
        if self.trunk.has_lanes() {
            let mut taken = vec![0; self.lanes()];
            let mut turns = vec![(0, 0); starts.len()];
            for start in starts.iter() {
                let lane = self.start_lanes[start.index];
                turns[start.index] = (taken[lane], lane % 2);
                taken[lane] += 1;
            }
            starts.sort_by_key(|start| turns[start.index]);
        }
    }
}

impl Ends {
    fn push_goal(&mut self, stream: usize, goal: Goal) {
        self.streams[stream].push(self.goals.len());
        self.goals.push(goal);
    }
}

/// How far the middles of two circles keep from each other, in world units.
pub(crate) fn reach_of(ground: &Ground) -> f64 {
    2.0 * ground.radius() + MARGIN
}

/// The places by how far they are, the nearest first.
fn by_distance(seen: &[Sight]) -> Vec<usize> {
    let mut places: Vec<usize> = (0..seen.len()).collect();
    places.sort_unstable_by(|&a, &b| seen[a].distance.total_cmp(&seen[b].distance).then(a.cmp(&b)));
    places
}

/// The points of each of so many lanes.
fn by_lane(points: &[DVec2], lanes: &[usize], count: usize) -> Vec<Vec<DVec2>> {
    let mut sorted = vec![Vec::new(); count];
    for (&point, &lane) in points.iter().zip(lanes) {
        sorted[lane].push(point);
    }
    sorted
}

/// The mean of all, at least one.
pub(crate) fn mean_of(points: &[DVec2]) -> DVec2 {
    points.iter().sum::<DVec2>() / points.len() as f64
}

/// The point that is nearest to the middle of all.
pub(crate) fn middle_of(points: &[DVec2]) -> DVec2 {
    let middle = mean_of(points);
    let distance = |point: &&DVec2| point.distance_squared(middle);
    *points.iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).expect("a group has circles")
}
