//! The search for a schedule, part by part.

mod departures;

use maniple_geometry::Circle;

use self::departures::Departures;
use super::bundle::{self, Keeping};
use super::ends::{Adding, Ends, Plan, reach_of};
use super::error::ReleaseError;
use super::lanes::Passing;
use super::order::{Care, Order};
use super::schedule::{Group, Moving, Request, Schedule, Walk};
use crate::around::{Detours, Memory};
use crate::ground::Ground;
use crate::planner::Planner;
use crate::work::{PATH, Work};

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
