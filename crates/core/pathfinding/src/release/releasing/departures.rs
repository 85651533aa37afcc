//! One after the other departs: who goes next, when, and by which way.

mod exchange;

use std::collections::BTreeSet;

use maniple_geometry::Scalar;

use self::exchange::{Departed, EXCHANGES_MAX};
use super::{Ended, Reliance, Surroundings, Tools};
use crate::crowd::Crowd;
use crate::ground::MARGIN;
use crate::release::beats::{Beats, Passed};
use crate::release::ends::Ends;
use crate::release::error::ReleaseError;
use crate::release::order::{Care, Order};
use crate::release::schedule::{Goals, Group, Walk};
use crate::release::traffic::{Planned, Traffic};
use crate::release::trajectory::Trajectory;
use crate::work::{PATH, Work};

/// Circles, and goals for each, for which a way around others is looked for before somebody departs who relies on others to have left.
const DETOURS_MAX: usize = 4;

/// The same where nobody relies on others.
const DETOURS_OF_SOME_MAX: usize = 16;

/// From where on goals are numbered in a crowd, and from where those who stay, and the goals of those on their way.
const GOALS: usize = 1 << 24;
const STILL: usize = 1 << 25;
const MOVING: usize = 1 << 26;

/// Others of a lane who are looked at where one would leave it empty for long.
const OTHERS_MAX: usize = 3;

/// Who has departed, who waits, and what they meet.
#[derive(Clone, Debug)]
pub(super) struct Departures {
    order: Order,
    walks: Vec<Vec<Option<Walk>>>,
    departed: Vec<Departed>,
    /// When the last one arrives of those who have departed, or would have before goals were exchanged.
    pub(super) arrival: f64,
    /// With how much care somebody goes before ways around all who rest are looked for.
    trusted: Care,
    /// By group whether anybody may go to any goal.
    is_interchangeable: Vec<bool>,
    speed: f64,
    traffic: Traffic,
    /// Starts and goals between which the way is never free any more: whoever is on the way stays a part of the traffic.
    never: BTreeSet<(usize, usize)>,
    /// Who stays, who waits, and those who have arrived, as somebody sees them who goes when all others rest.
    crowd: Crowd,
    /// For how many of those who wait a way around the others has been looked for since the last departure.
    detours_tried: usize,
    /// How many exchanges of goals have been tried since the last departure.
    exchanges_tried: usize,
    passed: Passed,
}

/// A circle that has been found a departure.
struct Departing {
    start: usize,
    goal: usize,
    departure: f64,
    trajectory: Trajectory,
}

impl Departures {
    pub(super) fn new(
        tools: &Tools<'_>,
        (groups, surroundings): (&[Group], &Surroundings),
        ends: &Ends,
        (order, trusted): (Order, Care),
    ) -> Self {
        let radius = tools.ground.radius();
        let mut traffic = Traffic::new(radius, MARGIN);
        let mut crowd = Crowd::new();
        for (number, circle) in surroundings.still.iter().enumerate() {
            let trajectory = Trajectory::still(circle.center);
            let _ = traffic.push(Planned { trajectory, departure: 0.0, radius: circle.radius });
            crowd.insert(STILL + number, circle.center, radius + circle.radius + MARGIN);
        }
        for (number, moving) in surroundings.moving.iter().enumerate() {
            let trajectory = Trajectory::new(moving.from, &moving.legs, moving.speed);
            crowd.insert(MOVING + number, trajectory.goal(), radius + moving.radius + MARGIN);
            traffic.push(Planned { trajectory, departure: moving.departure, radius: moving.radius });
        }
        for (number, start) in ends.starts.iter().enumerate() {
            crowd.insert(number, start.point, tools.reach());
        }
        let walks = groups.iter().map(|group| vec![None; group.starts.len()]).collect();
        let speed = surroundings.speed;
        let (never, passed) = (BTreeSet::new(), Passed::new(speed));
        let is_interchangeable = groups.iter().map(|group| group.whose == Goals::Interchangeable).collect();
        let departed = Vec::new();
        Self {
            order,
            walks,
            departed,
            arrival: 0.0,
            trusted,
            is_interchangeable,
            speed,
            traffic,
            never,
            crowd,
            detours_tried: 0,
            exchanges_tried: 0,
            passed,
        }
    }

    /// Tries who goes next, or a way around all others for one of the first of those who wait; returns what came of all when nobody is
    /// left, or nobody who can go.
    pub(super) fn step(
        &mut self,
        tools: &mut Tools<'_>,
        ends: &Ends,
        reliance: Reliance,
        work: &mut Work,
    ) -> Result<Option<Ended>, ReleaseError> {
        if self.order.is_empty() {
            return Ok(Some(self.ended(None)));
        }
        work.add(self.order.waiting() as u64);
        let next = self.order.next(ends, self.trusted);
        if next.is_none_or(|(_, care)| care > self.trusted) {
            let is_any_left = next.is_some();
            let count = match reliance {
                Reliance::All => DETOURS_MAX,
                Reliance::OwnWays => 0,
                Reliance::Nobody => DETOURS_OF_SOME_MAX,
            };
            if is_any_left && self.detours_tried < count {
                let number = self.order.first(count).get(self.detours_tried).copied();
                self.detours_tried += 1;
                let departing =
                    number.map(|number| self.detour(tools, ends, number, work)).transpose()?.flatten();
                if let Some(departing) = departing {
                    self.depart(tools, ends, departing);
                }
                return Ok(None);
            }
            if !is_any_left && reliance == Reliance::All && self.exchanges_tried < EXCHANGES_MAX {
                let turn = self.exchanges_tried;
                self.exchanges_tried += 1;
                self.exchange(tools, ends, turn, work)?;
                return Ok(None);
            }
            if !is_any_left || reliance == Reliance::Nobody {
                return Ok(Some(self.given_up(ends)));
            }
        }
        let Some((choice, care)) = next else { return Ok(None) };
        if let Some(first) = self.by_own_way(ends, choice, work) {
            let soonest = self.soonest(ends, first, care, work);
            self.passed.take(&ends.starts[soonest.start], soonest.departure);
            self.depart(tools, ends, soonest);
            return Ok(None);
        }
        if reliance == Reliance::OwnWays {
            return Ok(Some(self.given_up(ends)));
        }
        match self.detour(tools, ends, choice.0, work)? {
            Some(departing) => self.depart(tools, ends, departing),
            None => self.order.put_off(choice.0),
        }
        Ok(None)
    }

    /// The departure of one who goes by its own way, or, where it would leave its lane empty for long, that of another who does not.
    fn soonest(&mut self, ends: &Ends, first: Departing, care: Care, work: &mut Work) -> Departing {
        let passes = |departures: &Self, departing: &Departing| {
            let passage = ends.starts[departing.start].passage?;
            Some((
                departures.passed.moment(passage, departing.departure),
                0.5 * passage.spacing / departures.speed,
            ))
        };
        let mut soonest = first;
        if care > Care::Open || !self.passed.is_late(&ends.starts[soonest.start], soonest.departure) {
            return soonest;
        }
        for choice in self.order.others(ends, soonest.start, (care, OTHERS_MAX)) {
            let Some(other) = self.by_own_way(ends, choice, work) else { continue };
            if let Some(((moment, much), (before, _))) = passes(self, &other).zip(passes(self, &soonest))
                && moment + much < before
            {
                soonest = other;
            }
        }
        soonest
    }

    /// Ends, since the first of those who wait cannot go.
    pub(super) fn given_up(&mut self, ends: &Ends) -> Ended {
        let stuck = self.order.first(1).first().map(|&number| {
            let start = &ends.starts[number];
            ReleaseError::NoDeparture { group: start.group, circle: start.index, from: start.point }
        });
        self.ended(stuck)
    }

    fn ended(&mut self, stuck: Option<ReleaseError>) -> Ended {
        let walks = std::mem::take(&mut self.walks);
        let arrivals = walks.iter().flatten().flatten().map(|walk| walk.arrival);
        let makespan = arrivals.fold(0.0, Scalar::greater);
        Ended { walks, makespan, looks: 0, stuck }
    }

    /// A departure for the way that was planned for a start and a goal.
    fn by_own_way(&mut self, ends: &Ends, choice: (usize, usize), work: &mut Work) -> Option<Departing> {
        if self.never.contains(&choice) {
            return None;
        }
        let (start, goal) = (&ends.starts[choice.0], &ends.goals[choice.1]);
        let legs = [&start.legs[..], &goal.legs].concat();
        let trajectory = Trajectory::new(start.point, &legs, self.speed);
        let beats = self.passed.departures(start);
        let departing = self.departing(choice, (trajectory, beats), work);
        if departing.is_none() {
            self.never.insert(choice);
        }
        departing
    }

    fn departing(
        &mut self,
        (start, goal): (usize, usize),
        (trajectory, beats): (Trajectory, Option<Beats>),
        work: &mut Work,
    ) -> Option<Departing> {
        let before = self.traffic.looks;
        let departure = self.traffic.earliest(&trajectory, beats);
        work.add(self.traffic.looks - before);
        departure.map(|departure| Departing { start, goal, departure, trajectory })
    }

    /// A way around all who rest, to the first goal of the stream to which there is one.
    fn detour(
        &mut self,
        tools: &mut Tools<'_>,
        ends: &Ends,
        number: usize,
        work: &mut Work,
    ) -> Result<Option<Departing>, ReleaseError> {
        let start = &ends.starts[number];
        let reach = tools.reach();
        self.crowd.remove(number, start.point, reach);
        let goals: Vec<usize> = self.order.goals(start.stream).iter().copied().take(DETOURS_MAX).collect();
        let mut found = None;
        for goal in goals {
            let legs = tools.detours.path(&self.crowd, start.point, ends.goals[goal].point)?;
            work.add(PATH / 8 + tools.detours.expanded() as u64);
            let Some(legs) = legs else { continue };
            let trajectory = Trajectory::new(start.point, &legs, self.speed);
            found = self.departing((number, goal), (trajectory, None), work);
            if found.is_some() {
                break;
            }
        }
        self.crowd.insert(number, start.point, reach);
        Ok(found)
    }

    fn depart(&mut self, tools: &Tools<'_>, ends: &Ends, departing: Departing) {
        let Departing { start: number, goal: goal_number, departure, trajectory } = departing;
        let (start, goal) = (&ends.starts[number], &ends.goals[goal_number]);
        let reach = tools.reach();
        self.crowd.remove(number, start.point, reach);
        self.crowd.insert(GOALS + goal_number, goal.point, reach);
        let planned = Planned { trajectory, departure, radius: tools.ground.radius() };
        let place = self.traffic.push(planned.clone());
        self.note(ends, Departed { start: number, goal: goal_number, place }, &planned);
        self.order.leave(ends, (number, goal_number));
        (self.detours_tried, self.exchanges_tried) = (0, 0);
    }

    /// Notes the plan of somebody.
    fn note(&mut self, ends: &Ends, departed: Departed, planned: &Planned) {
        let (start, goal) = (&ends.starts[departed.start], ends.goals[departed.goal].index);
        let arrival = planned.departure + planned.trajectory.duration();
        let legs = planned.trajectory.legs().iter().map(|leg| leg.stretch.end).collect();
        self.walks[start.group][start.index] =
            Some(Walk { goal, departure: planned.departure, arrival, legs });
        self.departed.push(departed);
        self.arrival = arrival.greater(self.arrival);
    }
}
