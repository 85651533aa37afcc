//! The search for a schedule, part by part.

mod exchange;

use std::collections::BTreeSet;

use maniple_geometry::{Circle, Scalar};

use self::exchange::{Departed, EXCHANGES_MAX};
use super::beats::{Beats, Passed};
use super::bundle::{self, Keeping};
use super::ends::{Adding, Ends, Plan, reach_of};
use super::error::ReleaseError;
use super::lanes::Passing;
use super::order::{Care, Order};
use super::schedule::{Goals, Group, Moving, Request, Schedule, Walk};
use super::traffic::{Planned, Traffic};
use super::trajectory::Trajectory;
use crate::around::{Detours, Memory};
use crate::crowd::Crowd;
use crate::ground::{Ground, MARGIN};
use crate::planner::Planner;
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

/// Side by side, a group that takes so many times as long as it would in lanes without a gap tries fewer lanes, and the shortest way.
const GOOD: f64 = 1.25;

/// So many times as many looks as that took that is known an attempt may take that comes behind it.
const LOOKS_MORE: u64 = 4;

/// A search for a schedule that goes on by as much as it is told to, so that it can be spread over cycles. How much that is does not
/// change what comes of it.
#[derive(Clone, Debug)]
pub struct Releasing {
    groups: Vec<Group>,
    surroundings: Surroundings,
    reliance: Reliance,
    attempt: Attempt,
    /// The best of the attempts that have ended.
    best: Option<Ended>,
    looks: u64,
    /// What searches for ways around others remember between two parts.
    memory: Memory,
}

/// The speed of all, who stays, and who is on its way.
#[derive(Clone, Debug)]
struct Surroundings {
    speed: f64,
    still: Vec<Circle>,
    moving: Vec<Moving>,
}

/// On whom somebody may rely who departs: that others leave in time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Reliance {
    All,
    /// The same on shortest ways that only have to be better than a schedule that is known: where somebody would have to look for a way
    /// around others, the attempt is given up.
    OwnWays,
    Nobody,
}

/// When an attempt is given up, since a schedule is known that is better or was found sooner.
#[derive(Clone, Copy, Debug)]
struct Limit {
    /// The latest arrival, in cycles.
    arrival: f64,
    /// The most looks.
    looks: u64,
}

impl Limit {
    const NONE: Self = Self { arrival: f64::INFINITY, looks: u64::MAX };
}

/// What came of one attempt.
#[derive(Clone, Debug)]
pub(crate) struct Ended {
    pub(crate) walks: Vec<Vec<Option<Walk>>>,
    makespan: f64,
    /// How much it took.
    looks: u64,
    /// Why not all have a walk.
    pub(crate) stuck: Option<ReleaseError>,
}

impl Releasing {
    /// Begins to look for a schedule for all.
    #[must_use]
    pub fn new(request: &Request<'_>) -> Self {
        Self::with_reliance(request, Reliance::All)
    }

    /// Begins to look for a schedule for those who can go even if all others stay.
    pub(crate) fn of_some(request: &Request<'_>) -> Self {
        Self::with_reliance(request, Reliance::Nobody)
    }

    fn with_reliance(request: &Request<'_>, reliance: Reliance) -> Self {
        let Request { groups, speed, still, moving } = *request;
        let surroundings = Surroundings { speed, still: still.to_vec(), moving: moving.to_vec() };
        let (groups, attempt) = (groups.to_vec(), Attempt::new(first_plan(request.groups)));
        Self { groups, surroundings, reliance, attempt, best: None, looks: 0, memory: Memory::default() }
    }

    /// Does so many looks more, and what it takes to end the last part; returns what came of the search, or `None` where it goes on,
    /// and then it can be asked again. A look is a pair of straight pieces that are compared, or as much. The ground has to be the
    /// same each time.
    ///
    /// # Errors
    /// As [`release`](crate::release).
    pub fn advance(&mut self, ground: &Ground, budget: u64) -> Option<Result<Schedule, ReleaseError>> {
        let ended = self.go_on(ground, &mut Work::new(budget))?;
        Some(ended.and_then(|ended| match ended.stuck {
            Some(error) => Err(error),
            None => {
                let all = |walks: Vec<Option<Walk>>| walks.into_iter().flatten().collect();
                Ok(Schedule { walks: ended.walks.into_iter().map(all).collect(), makespan: ended.makespan })
            }
        }))
    }

    /// Returns how many looks it has taken up to now.
    #[must_use]
    pub fn looks(&self) -> u64 {
        self.looks
    }

    /// Goes on while work is left; returns the best attempt when all that are to be made have ended.
    pub(crate) fn go_on(&mut self, ground: &Ground, work: &mut Work) -> Option<Result<Ended, ReleaseError>> {
        let before = work.done();
        let mut tools = Tools::new(ground, std::mem::take(&mut self.memory));
        let mut found = None;
        while found.is_none() && work.is_left() {
            found = self.step(&mut tools, work).transpose();
        }
        self.memory = tools.detours.into_memory();
        self.looks += work.done() - before;
        found
    }

    fn step(&mut self, tools: &mut Tools<'_>, work: &mut Work) -> Result<Option<Ended>, ReleaseError> {
        let Self { groups, surroundings, attempt, .. } = self;
        let was_enough = self.best.as_ref().is_some_and(|best| best.stuck.is_none());
        let is_last = was_enough && matches!(attempt.plan, Plan::Shortest(_));
        let reliance = if is_last { Reliance::OwnWays } else { self.reliance };
        let known = self.best.as_ref().filter(|_| was_enough);
        let limit = known.map_or(Limit::NONE, |best| Limit {
            arrival: best.makespan,
            looks: best.looks.saturating_mul(LOOKS_MORE),
        });
        let before = work.done();
        let ended = attempt.step(tools, (groups, surroundings, reliance, limit), work)?;
        attempt.looks += work.done() - before;
        let Some(mut ended) = ended else { return Ok(None) };
        ended.looks = attempt.looks;
        let is_better = match &self.best {
            None => true,
            Some(best) => ended.stuck.is_none() && (!was_enough || ended.makespan < best.makespan),
        };
        if is_better {
            self.best = Some(ended);
        }
        match attempt.next((self.best.as_ref(), is_better), surroundings.speed) {
            Some(plan) if self.reliance == Reliance::All => *attempt = Attempt::new(plan),
            Some(_) | None => return Ok(self.best.take()),
        }
        Ok(None)
    }
}

/// How it is tried first: where several groups go, all keep to the right.
fn first_plan(groups: &[Group]) -> Plan {
    let large = groups.iter().filter(|group| group.starts.len() >= bundle::CIRCLES_MIN).count();
    let keeping = if large > 1 { Keeping::Right } else { Keeping::Middle };
    Plan::SideBySide { lanes_max: usize::MAX, keeping }
}

/// What a search uses and does not keep.
struct Tools<'a> {
    ground: &'a Ground,
    planner: Planner<'a>,
    detours: Detours<'a>,
}

impl<'a> Tools<'a> {
    fn new(ground: &'a Ground, memory: Memory) -> Self {
        Self { ground, planner: Planner::new(ground), detours: Detours::with_memory(ground, memory) }
    }

    /// How far the middles of two circles keep from each other.
    fn reach(&self) -> f64 {
        reach_of(self.ground)
    }
}

/// One try to find a schedule.
#[derive(Clone, Debug)]
struct Attempt {
    plan: Plan,
    /// How much it has looked up to now.
    looks: u64,
    /// How many lanes side by side there are at most; `None` where all groups go on shortest ways.
    side_by_side: Option<usize>,
    ends: Ends,
    stage: Stage,
}

#[derive(Clone, Debug)]
enum Stage {
    /// The groups are taken in: so many have been, and one is being.
    Groups { done: usize, adding: Option<Box<Adding>> },
    /// It is looked at what is in whose way: so many ends have been.
    Order { order: Box<Order>, done: usize },
    /// One after the other departs.
    Departures(Box<Departures>),
}

/// Who has departed, who waits, and what they meet.
#[derive(Clone, Debug)]
struct Departures {
    order: Order,
    walks: Vec<Vec<Option<Walk>>>,
    departed: Vec<Departed>,
    /// When the last one arrives of those who have departed, or would have before goals were exchanged.
    arrival: f64,
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

impl Attempt {
    fn new(plan: Plan) -> Self {
        let stage = Stage::Groups { done: 0, adding: None };
        Self { plan, looks: 0, side_by_side: None, ends: Ends::default(), stage }
    }

    /// Returns what is tried next, if anything is, when the best attempt is known, and whether that is this one.
    ///
    /// Side by side all are as fast as they can be; with fewer lanes they get stuck less often, and leave fewer gaps. Who keeps to the right
    /// tries the middle next, and then the shortest way, as long as all attempts have got stuck.
    fn next(&self, (best, is_better): (Option<&Ended>, bool), speed: f64) -> Option<Plan> {
        let is_stuck = best.is_none_or(|best| best.stuck.is_some());
        let is_good = best.is_some_and(|best| best.makespan * speed < GOOD * self.ends.course);
        let passed = match (self.plan, self.side_by_side) {
            (_, Some(_)) if self.ends.is_shortest_denser => return Some(Plan::Shortest(Passing::Densest)),
            (_, Some(_)) if !is_stuck && (is_good || !is_better) => return None,
            (Plan::SideBySide { keeping, .. }, Some(lanes))
                if keeping.fewer(lanes) >= keeping.lanes_min() =>
            {
                return Some(Plan::SideBySide { lanes_max: keeping.fewer(lanes), keeping });
            }
            (Plan::SideBySide { keeping: Keeping::Right, .. }, _) => {
                return Some(Plan::SideBySide { lanes_max: usize::MAX, keeping: Keeping::Middle });
            }
            (_, Some(_)) => return is_stuck.then_some(Plan::Shortest(Passing::Densest)),
            // No group goes side by side: it was the shortest way.
            (Plan::SideBySide { .. }, None) => Passing::Densest,
            (Plan::Shortest(passing), None) => passing,
        };
        let is_worth_it =
            |&passing: &Passing| passing > passed && (is_stuck || passing <= Passing::KeepRight);
        self.ends.passings.iter().copied().find(is_worth_it).map(Plan::Shortest)
    }

    /// Does one part more; returns what came of the attempt when it has ended.
    fn step(
        &mut self,
        tools: &mut Tools<'_>,
        (groups, surroundings, reliance, limit): (&[Group], &Surroundings, Reliance, Limit),
        work: &mut Work,
    ) -> Result<Option<Ended>, ReleaseError> {
        let Self { plan, looks, side_by_side, ends, stage } = self;
        match stage {
            Stage::Groups { done, adding: Some(current) } => {
                match current.advance((&mut tools.planner, &mut tools.detours), &groups[*done], ends)? {
                    Some(looks) => work.add(looks),
                    None => {
                        *side_by_side = current.side_by_side().max(*side_by_side);
                        *stage = Stage::Groups { done: *done + 1, adding: None };
                    }
                }
            }
            Stage::Groups { done, adding } => {
                let Some(group) = groups.get(*done) else {
                    *stage = Stage::Order { order: Box::new(Order::new(ends)), done: 0 };
                    return Ok(None);
                };
                let begun = Adding::new(&mut tools.planner, (*done, group), *plan, ends)?;
                work.add(PATH);
                match begun {
                    Some(begun) => *adding = Some(Box::new(begun)),
                    None => *done += 1,
                }
            }
            Stage::Order { order, done } => match order.look(ends, *done, tools.reach()) {
                Some(looks) => {
                    work.add(looks);
                    *done += 1;
                }
                None => {
                    // Whoever keeps to the right meets nobody who comes the other way, but only stands where that one goes to.
                    let is_right = matches!(plan, Plan::SideBySide { keeping: Keeping::Right, .. });
                    let is_trusted = is_right && reliance != Reliance::Nobody && side_by_side.is_some();
                    let trusted = if is_trusted { Care::OwnOpen } else { Care::Open };
                    let order = ((**order).clone(), trusted);
                    let departures = Departures::new(tools, (groups, surroundings), ends, order);
                    *stage = Stage::Departures(Box::new(departures));
                }
            },
            Stage::Departures(departures) => {
                if departures.arrival > limit.arrival || *looks > limit.looks {
                    return Ok(Some(departures.given_up(ends)));
                }
                return departures.step(tools, ends, reliance, work);
            }
        }
        Ok(None)
    }
}

impl Departures {
    fn new(
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
    fn step(
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
    fn given_up(&mut self, ends: &Ends) -> Ended {
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
