//! Where units get onto a board, where they leave it, and who goes to which of these places.

use glam::DVec2;
use maniple_geometry::Circle;
use thiserror::Error;

use super::teams::{Team, Teams};
use crate::ground::Ground;
use crate::in_step::{Board, Distances, FAR, Place, Problem, Raster};
use crate::release::{Goals, by_cost};
use crate::work::Work;

/// How far from a point its place may be, in columns and rows: at first and at most. Each attempt doubles it.
const COLUMNS_MIN: u32 = 2;
const COLUMNS_MAX: u32 = 16;

/// What it costs to go to a place that cannot be seen, or not be reached: more than any way.
const BEYOND: f64 = 1e12;

/// Why units cannot be led in step.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum StepError {
    /// Not every unit, or not every goal, has a place of its own on the board near it.
    #[error(
        "a unit or a goal has no place on the lattice near it; choose goals that are farther apart and farther from walls"
    )]
    NoPlace,
    /// No unit has a way on the board to a goal, as those are who rest in the way.
    #[error(
        "no unit has a way on the lattice to a goal; wait until who rests in the way has gone, or choose other goals"
    )]
    NoWay,
    /// The search has looked at all there is, or at as much as it may.
    #[error("no plan in step was found; choose other goals, or lead fewer at once")]
    NoPlan,
    /// Units do not get to their places, or not from there to their goals.
    #[error(
        "a unit does not get to its place on the lattice or from there to its goal; choose goals that are farther apart"
    )]
    Crowded,
}

/// Units on a board: where each starts and ends, all as the agents of one problem.
#[derive(Clone, Debug)]
pub(crate) struct Lattice {
    pub(crate) board: Board,
    pub(crate) starts: Vec<Place>,
    pub(crate) ends: Vec<Place>,
    pub(crate) distances: Distances,
    /// The goal that each unit is to go to from its end; `None`: it stays there.
    pub(crate) goals: Vec<Option<usize>>,
}

impl Lattice {
    /// Returns the problem of all from some places on.
    pub(crate) fn problem<'a>(&'a self, starts: &'a [Place]) -> Problem<'a> {
        Problem { board: &self.board, starts, goals: &self.ends, distances: &self.distances }
    }
}

/// The choice of a lattice, part by part: the first raster on which units get to goals.
#[derive(Clone, Debug)]
pub(crate) struct Survey {
    /// Where the units are.
    points: Vec<DVec2>,
    others: Vec<Circle>,
    /// The rasters that are left, the next one last.
    rasters: Vec<Raster>,
    current: Option<Draft>,
    error: StepError,
}

/// A lattice, as far as it is known.
#[derive(Clone, Debug)]
struct Draft {
    board: Board,
    starts: Option<Vec<Place>>,
    of_goals: Option<Vec<Place>>,
    distances: Distances,
}

impl Survey {
    pub(crate) fn new(ground: &Ground, points: Vec<DVec2>, others: &[Circle]) -> Self {
        let mut rasters = Raster::finest(ground.radius());
        rasters.reverse();
        let (others, error) = (others.to_vec(), StepError::NoPlace);
        Self { points, others, rasters, current: None, error }
    }

    /// Goes on while work is left; returns the lattice, or why there is none.
    pub(crate) fn advance(
        &mut self,
        ground: &Ground,
        teams: &Teams,
        work: &mut Work,
    ) -> Option<Result<Lattice, StepError>> {
        while work.is_left() {
            let Some(draft) = &mut self.current else {
                let Some(raster) = self.rasters.pop() else { return Some(Err(self.error)) };
                let board = Board::on(ground, raster, &self.others).expect("the raster is for the radius");
                work.add((board.len() * (1 + self.others.len())) as u64);
                let distances = Distances::none(&board);
                self.current = Some(Draft { board, starts: None, of_goals: None, distances });
                continue;
            };
            match draft.advance(ground, (&self.points, teams), work) {
                Ok(false) => {}
                Ok(true) => return self.current.take().map(|draft| draft.finish(teams)),
                Err(error) => (self.error, self.current) = (error, None),
            }
        }
        None
    }
}

impl Draft {
    /// Does one part more; returns whether all is known.
    fn advance(
        &mut self,
        ground: &Ground,
        (points, teams): (&[DVec2], &Teams),
        work: &mut Work,
    ) -> Result<bool, StepError> {
        let Some(starts) = &self.starts else {
            self.starts = Some(places(ground, &self.board, points, work).ok_or(StepError::NoPlace)?);
            return Ok(false);
        };
        let Some(of_goals) = &self.of_goals else {
            self.of_goals = Some(places(ground, &self.board, &teams.goals, work).ok_or(StepError::NoPlace)?);
            return Ok(false);
        };
        let Some(&goal) = of_goals.get(self.distances.agents()) else {
            let is_reached = |team: &Team| {
                let starts = &starts[team.units.start.min(starts.len())..team.units.end.min(starts.len())];
                let mut tables = team.goals.clone().map(|goal| self.distances.of(goal));
                tables.any(|table| starts.iter().any(|start| table[start.index()] != FAR))
            };
            return if teams.teams.iter().any(is_reached) { Ok(true) } else { Err(StepError::NoWay) };
        };
        self.distances.push(&self.board, goal);
        work.add(self.board.len() as u64);
        Ok(false)
    }

    fn finish(self, teams: &Teams) -> Result<Lattice, StepError> {
        let Self { board, starts, of_goals, mut distances } = self;
        let (starts, of_goals) = (starts.unwrap_or_default(), of_goals.unwrap_or_default());
        let mut goals = vec![None; starts.len()];
        for team in &teams.teams {
            share_out(&board, (&starts, &of_goals, &distances), team, &mut goals);
        }
        let ends = ends(&starts, &of_goals, &mut goals);
        if goals.iter().all(Option::is_none) {
            return Err(StepError::NoWay);
        }
        // Those who have no goal stay where they get onto the board.
        let mut tables = Vec::new();
        for (unit, goal) in goals.iter().enumerate() {
            if goal.is_none() {
                distances.push(&board, ends[unit]);
            }
            tables.push(goal.unwrap_or(distances.agents() - 1));
        }
        Ok(Lattice { distances: distances.shared_out(&tables), board, starts, ends, goals })
    }
}

/// Returns a place for each point, no two the same: near it, and seen from it if any is. `None` where there are too few.
fn places(ground: &Ground, board: &Board, points: &[DVec2], work: &mut Work) -> Option<Vec<Place>> {
    let departures: Vec<DVec2> =
        points.iter().map(|&point| ground.departure(point).unwrap_or(point)).collect();
    let mut columns = COLUMNS_MIN;
    let chosen = loop {
        work.add(points.len() as u64 * u64::from(2 * columns + 1).pow(2));
        if let Some(chosen) = nearest(ground, board, (points, &departures), columns) {
            break chosen;
        }
        columns *= 2;
        if columns > COLUMNS_MAX {
            return None;
        }
    };
    // Nobody is to cross the way of another.
    let middles: Vec<DVec2> = chosen.iter().map(|&place| board.point(place)).collect();
    let cost = |point: usize, place: usize| {
        let is_seen = ground.is_clear(departures[point], middles[place]);
        points[point].distance_squared(middles[place]) + if is_seen { 0.0 } else { BEYOND }
    };
    work.add(points.len() as u64 * 512);
    let assigned = by_cost(points, &middles, cost);
    Some(assigned.into_iter().map(|place| chosen[place]).collect())
}

/// Shares places out: of all pairs of a point and a place that it sees, the nearest first.
fn nearest(
    ground: &Ground,
    board: &Board,
    (points, departures): (&[DVec2], &[DVec2]),
    columns: u32,
) -> Option<Vec<Place>> {
    let mut pairs = Vec::new();
    for (index, &point) in points.iter().enumerate() {
        for place in board.places_around(point, columns) {
            if ground.is_clear(departures[index], board.point(place)) {
                pairs.push((board.point(place).distance_squared(point), index, place));
            }
        }
    }
    pairs.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)).then(a.2.cmp(&b.2)));
    let mut is_taken = vec![false; board.len()];
    let mut chosen = vec![None; points.len()];
    for (_, index, place) in pairs {
        if chosen[index].is_none() && !is_taken[place.index()] {
            is_taken[place.index()] = true;
            chosen[index] = Some(place);
        }
    }
    chosen.into_iter().collect()
}

/// Gives each unit of a team a goal that it can reach, so that the sum of the squared lengths of the ways is small.
fn share_out(
    board: &Board,
    (starts, of_goals, distances): (&[Place], &[Place], &Distances),
    team: &Team,
    goals: &mut [Option<usize>],
) {
    let units: Vec<usize> = (team.units.start..team.units.end.min(starts.len())).collect();
    let steps = |unit: usize, goal: usize| distances.of(goal)[starts[unit].index()];
    let count = units.len().min(team.goals.len());
    let targets: Vec<usize> = team.goals.clone().take(count).collect();
    let cost = |row: usize, column: usize| {
        let steps = steps(units[row], targets[column]);
        if steps == FAR { BEYOND } else { f64::from(steps) * f64::from(steps) }
    };
    let assigned = match team.whose {
        Goals::Own => (0..count).collect(),
        Goals::Interchangeable => {
            let point = |&place: &Place| board.point(place);
            let from: Vec<DVec2> = units[..count].iter().map(|&unit| point(&starts[unit])).collect();
            let to: Vec<DVec2> = targets.iter().map(|&goal| point(&of_goals[goal])).collect();
            by_cost(&from, &to, cost)
        }
    };
    for (&unit, column) in units.iter().zip(assigned) {
        let goal = targets[column];
        goals[unit] = (steps(unit, goal) != FAR).then_some(goal);
    }
}

/// Returns the ends. Who has no goal ends where it starts, and who would end there, too, has none then.
fn ends(starts: &[Place], of_goals: &[Place], goals: &mut [Option<usize>]) -> Vec<Place> {
    loop {
        let staying = starts.iter().zip(&*goals).filter(|(_, goal)| goal.is_none());
        let mut stayed: Vec<Place> = staying.map(|(&start, _)| start).collect();
        stayed.sort_unstable();
        let mut has_changed = false;
        for goal in goals.iter_mut() {
            if goal.is_some_and(|goal| stayed.binary_search(&of_goals[goal]).is_ok()) {
                *goal = None;
                has_changed = true;
            }
        }
        if !has_changed {
            let end = |(&start, goal): (&Place, &Option<usize>)| goal.map_or(start, |goal| of_goals[goal]);
            return starts.iter().zip(&*goals).map(end).collect();
        }
    }
}
