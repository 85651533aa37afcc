//! All by a plan in step: onto the middles of tiles, over them, and from there to the goals.

use maniple_geometry::{Circle, Segment};

use super::boarding::{Boarding, StepError, Survey};
use super::passage::Passage;
use super::scene::{Delivery, GRACE, Order, Scene};
use super::scheduled::Scheduled;
use super::squads::Squads;
use super::walkers::{Astray, Walkers};
use crate::ground::{Ground, MARGIN};
use crate::in_step::{Outcome, Pibt, Place, Rings, Tree};
use crate::work::Work;

/// Decides the ties of plans.
const SEED: u64 = 1;

/// Steps that are taken one by one while there is no plan: at first and at most. Each time that there is none behind them, they
/// are twice as many.
const STEPS_MIN: u32 = 8;
const STEPS_MAX: u32 = 1 << 8;

/// Most places that a search remembers, one for each agent and configuration: with their priorities 200 MB.
const TRIED_MAX: u64 = 1 << 24;

/// What came of a cycle.
pub(crate) enum Verdict {
    /// It goes on with these orders.
    Going(Vec<Order>),
    /// Everybody rests at its goal; `None`: it has none.
    Done(Vec<Option<usize>>),
    /// It cannot go on.
    Failed(StepError),
}

/// Leads by plans in step.
#[derive(Clone, Debug)]
pub(crate) struct Stepping {
    squads: Squads,
    speed: f64,
    delivery: Delivery,
    stage: Stage,
    /// Who was in the way when it was looked at last.
    others: Vec<Circle>,
}

#[derive(Clone, Debug)]
enum Stage {
    /// All come to rest; from this cycle on they can be taken to rest.
    Halting { since: u32 },
    /// The board is chosen, and the places on it.
    Surveying(Box<Survey>),
    /// Each goes to its place.
    Entering(Box<Scheduled>, Box<Walking>),
    /// All walk over the board.
    Walking(Box<Walking>),
    /// Each goes to its goal.
    Leaving(Box<Scheduled>, Vec<Option<usize>>),
}

/// A walk over a board, and the search for it.
#[derive(Clone, Debug)]
struct Walking {
    boarding: Boarding,
    passage: Passage,
    walkers: Walkers,
    search: Search,
}

#[derive(Clone, Debug)]
enum Search {
    /// From these places on a plan is looked for; so many steps are taken before the next search.
    Open { from: Vec<Place>, tree: Box<Tree>, steps: u32 },
    /// So many steps are added to the ways by priorities alone; so many will be the next time.
    Without { left: u32, next: u32 },
    /// The ways lead to the goals.
    Found,
    /// There is no plan.
    Failed,
}

impl Stepping {
    pub(crate) fn new(squads: Squads, speed: f64, delivery: Delivery) -> Self {
        Self { squads, speed, delivery, stage: Stage::Halting { since: 0 }, others: Vec::new() }
    }

    pub(crate) fn advance(&mut self, ground: &Ground, scene: &Scene<'_>, work: &mut Work) -> Verdict {
        if let Stage::Halting { since } = self.stage {
            if scene.cycle < since || scene.units.iter().any(|unit| unit.is_moving) {
                return Verdict::Going(Vec::new());
            }
            self.others = scene.others.to_vec();
            let points = scene.units.iter().map(|unit| unit.position).collect();
            self.stage = Stage::Surveying(Box::new(Survey::new(ground, points, scene.others)));
        }
        if let Stage::Surveying(survey) = &mut self.stage {
            match survey.advance(ground, &self.squads, work) {
                None => return Verdict::Going(Vec::new()),
                Some(Ok(boarding)) => self.enter(boarding),
                Some(Err(error)) => return Verdict::Failed(error),
            }
        }
        match &mut self.stage {
            Stage::Halting { .. } | Stage::Surveying(_) => Verdict::Going(Vec::new()),
            Stage::Entering(scheduled, walking) => {
                walking.search(work);
                let orders = scheduled.advance(ground, scene, work);
                if scheduled.have_all_arrived() {
                    self.stage = Stage::Walking(walking.clone());
                    return self.walk(ground, scene, work);
                }
                if scheduled.is_stuck() {
                    Verdict::Failed(StepError::Crowded)
                } else {
                    Verdict::Going(orders)
                }
            }
            Stage::Walking(_) => self.walk(ground, scene, work),
            Stage::Leaving(scheduled, goals) => {
                let orders = scheduled.advance(ground, scene, work);
                if scheduled.have_all_arrived() {
                    return Verdict::Done(std::mem::take(goals));
                }
                if scheduled.is_stuck() {
                    Verdict::Failed(StepError::Crowded)
                } else {
                    Verdict::Going(orders)
                }
            }
        }
    }

    fn enter(&mut self, boarding: Boarding) {
        let points = boarding.starts.iter().map(|&place| boarding.board.point(place)).collect();
        let scheduled = Scheduled::new(Squads::of_each(points), self.speed, self.delivery).partly();
        self.stage =
            Stage::Entering(Box::new(scheduled), Box::new(Walking::new(boarding, self.speed, self.delivery)));
    }

    fn walk(&mut self, ground: &Ground, scene: &Scene<'_>, work: &mut Work) -> Verdict {
        let Stage::Walking(walking) = &mut self.stage else { return Verdict::Going(Vec::new()) };
        let is_astray = walking.look(scene).is_err();
        let is_in_the_way = self.others != scene.others && walking.is_met_by(scene.others, ground.radius());
        if self.others != scene.others {
            self.others = scene.others.to_vec();
        }
        if is_astray || is_in_the_way {
            let orders = walking.walkers.under_way().map(Order::stop).collect();
            self.stage = Stage::Halting { since: scene.cycle + GRACE };
            return Verdict::Going(orders);
        }
        walking.search(work);
        if matches!(walking.search, Search::Failed) && walking.walkers.are_done(&walking.passage) {
            return Verdict::Failed(StepError::NoPlan);
        }
        if !walking.is_over() {
            return Verdict::Going(walking.orders(scene.cycle));
        }
        let boarding = &walking.boarding;
        let end = |(unit, goal): (usize, &Option<usize>)| {
            goal.map_or(boarding.board.point(boarding.ends[unit]), |goal| self.squads.goals[goal])
        };
        let points = boarding.goals.iter().enumerate().map(end).collect();
        let mut scheduled = Scheduled::new(Squads::of_each(points), self.speed, self.delivery).partly();
        let goals = boarding.goals.clone();
        let orders = scheduled.advance(ground, scene, work);
        self.stage = Stage::Leaving(Box::new(scheduled), goals);
        Verdict::Going(orders)
    }
}

impl Walking {
    fn new(boarding: Boarding, speed: f64, delivery: Delivery) -> Self {
        let from = boarding.starts.clone();
        let tree = Box::new(Tree::new(boarding.problem(&from), Rings::Avoided, SEED));
        Self {
            passage: Passage::new(boarding.board.len(), &from),
            walkers: Walkers::new(from.len(), (boarding.board.pitch(), speed), delivery),
            search: Search::Open { from, tree, steps: STEPS_MIN },
            boarding,
        }
    }

    fn look(&mut self, scene: &Scene<'_>) -> Result<(), Astray> {
        self.walkers.look((&self.boarding.board, &self.passage), scene)
    }

    /// Whether all rest where the plan ends.
    fn is_over(&self) -> bool {
        matches!(self.search, Search::Found) && self.walkers.are_done(&self.passage)
    }

    /// Goes on with the search.
    fn search(&mut self, work: &mut Work) {
        let (board, distances) = (&self.boarding.board, &self.boarding.distances);
        let agents = self.boarding.starts.len() as u64;
        if let Search::Without { left, next } = &mut self.search {
            let mut pibt = Pibt::with_rings((board, Rings::Avoided), distances, &self.passage.ends(), SEED);
            while *left > 0 && work.is_left() {
                *left -= 1;
                self.passage.push(pibt.step(distances));
                work.add(agents);
            }
            if *left > 0 {
                return;
            }
            let (from, steps) = (self.passage.ends(), *next);
            let tree = Box::new(Tree::new(self.boarding.problem(&from), Rings::Avoided, SEED));
            self.search = Search::Open { from, tree, steps };
        }
        let Search::Open { from, tree, .. } = &mut self.search else { return };
        let mut outcome = None;
        while outcome.is_none() && work.is_left() && tree.expanded() * agents < TRIED_MAX {
            outcome = tree.advance(self.boarding.problem(from), 1);
            work.add(agents);
        }
        match outcome {
            None => {}
            Some(Outcome::Solved(plan)) => {
                for step in 1..=plan.steps() {
                    self.passage.push(plan.at(step));
                }
                self.search = Search::Found;
            }
            Some(Outcome::Unsolvable | Outcome::Stuck) => self.search = Search::Failed,
        }
    }

    /// Returns the orders of a cycle. Where all have come to where the search begins and it has not ended, some steps are taken
    /// without it, and it begins anew behind them.
    fn orders(&mut self, cycle: u32) -> Vec<Order> {
        if let Search::Open { steps, .. } = self.search
            && self.walkers.are_done(&self.passage)
        {
            let next = 2 * steps;
            self.search =
                if next > STEPS_MAX { Search::Failed } else { Search::Without { left: steps, next } };
        }
        self.walkers.orders((&self.boarding.board, &self.passage), cycle)
    }

    /// Whether what is left of some way leads over somebody.
    fn is_met_by(&self, others: &[Circle], radius: f64) -> bool {
        let board = &self.boarding.board;
        let is_met = |from: Place, to: Place| {
            let line: Segment = Segment::new(board.point(from), board.point(to));
            others.iter().any(|other| {
                let reach = radius + other.radius + MARGIN;
                line.nearest(other.center).distance_squared(other.center) < reach * reach
            })
        };
        (0..self.boarding.starts.len()).any(|unit| {
            let ahead = self.walkers.ahead(&self.passage, unit);
            ahead.windows(2).any(|step| is_met(step[0], step[1]))
        })
    }
}
