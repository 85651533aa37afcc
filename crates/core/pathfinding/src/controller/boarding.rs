//! Where units get onto a board, where they leave it, and who goes to which of these places.

use glam::DVec2;
use maniple_geometry::Circle;
use thiserror::Error;

use super::squads::{Squad, Squads};
use crate::ground::Ground;
use crate::in_step::{Board, Distances, FAR, Place, Problem, Raster};
use crate::release::{Assignment, Goals};
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
        "a unit or a goal has no place on the board near it; choose goals that are farther apart and farther from walls"
    )]
    NoPlace,
    /// No unit has a way on the board to a goal, as those are who rest in the way.
    #[error(
        "no unit has a way on the board to a goal; wait until who rests in the way has gone, or choose other goals"
    )]
    NoWay,
    /// The search has looked at all there is, or at as much as it may.
    #[error("no plan in step was found; choose other goals, or lead fewer at once")]
    NoPlan,
    /// Units do not get to their places, or not from there to their goals.
    #[error(
        "a unit does not get to its place on the board or from there to its goal; choose goals that are farther apart"
    )]
    Crowded,
}

/// Units on a board: where each starts and ends, all as the agents of one problem.
#[derive(Clone, Debug)]
pub(crate) struct Boarding {
    pub(crate) board: Board,
    pub(crate) starts: Vec<Place>,
    pub(crate) ends: Vec<Place>,
    pub(crate) distances: Distances,
    /// The goal that each unit is to go to from its end; `None`: it stays there.
    pub(crate) goals: Vec<Option<usize>>,
}

impl Boarding {
    /// Returns the problem of all from some places on.
    pub(crate) fn problem<'a>(&'a self, starts: &'a [Place]) -> Problem<'a> {
        Problem { board: &self.board, starts, goals: &self.ends, distances: &self.distances }
    }
}

/// The choice of a board and of the places on it, part by part: the first raster on which units get to goals.
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

/// A board and the places on it, as far as they are known.
#[derive(Clone, Debug)]
struct Draft {
    board: Board,
    starts: Vec<Place>,
    of_goals: Vec<Place>,
    distances: Distances,
    /// The goal of each unit.
    goals: Vec<Option<usize>>,
    part: Part,
}

/// What is being looked for.
#[derive(Clone, Debug)]
enum Part {
    /// Where each unit gets onto the board.
    Starts(Settling),
    /// Where each goal is left for.
    Goals(Settling),
    /// How far it is from everywhere to each goal.
    Distances,
    /// Which unit of a squad goes to which goal.
    Squads { squad: usize, assignment: Option<Assignment> },
}

/// The choice of a place for each of some points.
#[derive(Clone, Debug)]
struct Settling {
    /// How far from its point a place may be, in columns and rows.
    columns: u32,
    /// The places, and who gets which.
    chosen: Option<(Vec<Place>, Assignment)>,
}

impl Survey {
    pub(crate) fn new(ground: &Ground, points: Vec<DVec2>, others: &[Circle]) -> Self {
        let mut rasters = Raster::finest(ground.radius());
        rasters.reverse();
        let (others, error) = (others.to_vec(), StepError::NoPlace);
        Self { points, others, rasters, current: None, error }
    }

    /// Goes on while work is left; returns the board and the places, or why there are none.
    pub(crate) fn advance(
        &mut self,
        ground: &Ground,
        squads: &Squads,
        work: &mut Work,
    ) -> Option<Result<Boarding, StepError>> {
        while work.is_left() {
            let Some(draft) = &mut self.current else {
                let Some(raster) = self.rasters.pop() else { return Some(Err(self.error)) };
                let board = Board::on(ground, raster, &self.others).expect("the raster is for the radius");
                work.add((board.len() * (1 + self.others.len())) as u64);
                self.current = Some(Draft::new(board, self.points.len()));
                continue;
            };
            match draft.advance(ground, (&self.points, squads), work) {
                Ok(false) => {}
                Ok(true) => return self.current.take().map(Draft::finish),
                Err(error) => (self.error, self.current) = (error, None),
            }
        }
        None
    }
}

impl Draft {
    fn new(board: Board, units: usize) -> Self {
        let (starts, of_goals, distances) = (Vec::new(), Vec::new(), Distances::none(&board));
        Self {
            board,
            starts,
            of_goals,
            distances,
            goals: vec![None; units],
            part: Part::Starts(Settling::new()),
        }
    }

    /// Does one part more; returns whether all is known.
    fn advance(
        &mut self,
        ground: &Ground,
        (points, squads): (&[DVec2], &Squads),
        work: &mut Work,
    ) -> Result<bool, StepError> {
        match &mut self.part {
            Part::Starts(settling) => {
                if let Some(places) = settling.advance((ground, &self.board), points, work)? {
                    self.starts = places;
                    self.part = Part::Goals(Settling::new());
                }
            }
            Part::Goals(settling) => {
                if let Some(places) = settling.advance((ground, &self.board), &squads.goals, work)? {
                    self.of_goals = places;
                    self.part = Part::Distances;
                }
            }
            Part::Distances => match self.of_goals.get(self.distances.agents()) {
                Some(&goal) => {
                    self.distances.push(&self.board, goal);
                    work.add(self.board.len() as u64);
                }
                None => self.part = Part::Squads { squad: 0, assignment: None },
            },
            Part::Squads { squad, assignment } => {
                let Some(current) = squads.squads.get(*squad) else { return Ok(true) };
                let sharing = Sharing::new((&self.starts, &self.of_goals), &self.distances, current);
                let assignment = assignment.get_or_insert_with(|| sharing.begin(&self.board));
                if let Some(looks) = assignment.advance(|row, column| sharing.cost(row, column)) {
                    work.add(looks);
                    return Ok(false);
                }
                sharing.end(&assignment.assigned, &mut self.goals);
                self.part = Part::Squads { squad: *squad + 1, assignment: None };
            }
        }
        Ok(false)
    }

    fn finish(self) -> Result<Boarding, StepError> {
        let Self { board, starts, of_goals, mut distances, mut goals, .. } = self;
        assert!(are_different(&starts), "each unit has a place of its own");
        assert!(are_different(&of_goals), "each goal has a place of its own");
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
        Ok(Boarding { distances: distances.shared_out(&tables), board, starts, ends, goals })
    }
}

impl Settling {
    fn new() -> Self {
        Self { columns: COLUMNS_MIN, chosen: None }
    }

    /// Does one part more. At the end returns a place for each point, no two the same: near it, and seen from it if any is.
    fn advance(
        &mut self,
        (ground, board): (&Ground, &Board),
        points: &[DVec2],
        work: &mut Work,
    ) -> Result<Option<Vec<Place>>, StepError> {
        let departure = |point: DVec2| ground.departure(point).unwrap_or(point);
        let Some((chosen, assignment)) = &mut self.chosen else {
            if self.columns > COLUMNS_MAX {
                return Err(StepError::NoPlace);
            }
            work.add(points.len() as u64 * u64::from(2 * self.columns + 1).pow(2));
            let departures: Vec<DVec2> = points.iter().map(|&point| departure(point)).collect();
            self.chosen = nearest(ground, board, (points, &departures), self.columns).map(|chosen| {
                let middles: Vec<DVec2> = chosen.iter().map(|&place| board.point(place)).collect();
                let assignment = Assignment::new(points, &middles);
                (chosen, assignment)
            });
            self.columns *= 2;
            return Ok(None);
        };
        // Nobody is to cross the way of another.
        let cost = |index: usize, place: usize| {
            let (point, middle) = (points[index], board.point(chosen[place]));
            let is_seen = ground.is_clear(departure(point), middle);
            point.distance_squared(middle) + if is_seen { 0.0 } else { BEYOND }
        };
        if let Some(looks) = assignment.advance(cost) {
            work.add(looks);
            return Ok(None);
        }
        Ok(Some(assignment.assigned.iter().map(|&place| chosen[place]).collect()))
    }
}

/// The units of a squad and as many goals, those that it has first.
struct Sharing<'a> {
    units: std::ops::Range<usize>,
    goals: std::ops::Range<usize>,
    whose: Goals,
    starts: &'a [Place],
    of_goals: &'a [Place],
    distances: &'a Distances,
}

impl<'a> Sharing<'a> {
    fn new((starts, of_goals): (&'a [Place], &'a [Place]), distances: &'a Distances, squad: &Squad) -> Self {
        let end = squad.units.end.min(starts.len());
        let count = end.saturating_sub(squad.units.start).min(squad.goals.len());
        let from = |first: usize| first..first + count;
        let (units, goals) = (from(squad.units.start), from(squad.goals.start));
        Self { units, goals, whose: squad.whose, starts, of_goals, distances }
    }

    fn begin(&self, board: &Board) -> Assignment {
        let points =
            |places: &[Place]| -> Vec<DVec2> { places.iter().map(|&place| board.point(place)).collect() };
        match self.whose {
            Goals::Own => Assignment::default(),
            Goals::Interchangeable => Assignment::new(
                &points(&self.starts[self.units.clone()]),
                &points(&self.of_goals[self.goals.clone()]),
            ),
        }
    }

    fn steps(&self, row: usize, column: usize) -> u32 {
        self.distances.of(self.goals.start + column)[self.starts[self.units.start + row].index()]
    }

    /// The square of the length of a way, so that ways are about as long.
    fn cost(&self, row: usize, column: usize) -> f64 {
        let steps = self.steps(row, column);
        if steps == FAR { BEYOND } else { f64::from(steps) * f64::from(steps) }
    }

    /// Gives each unit its goal, if it can reach it.
    fn end(&self, assigned: &[usize], goals: &mut [Option<usize>]) {
        for row in 0..self.units.len() {
            let column = assigned.get(row).copied().unwrap_or(row);
            let is_reached = self.steps(row, column) != FAR;
            goals[self.units.start + row] = is_reached.then_some(self.goals.start + column);
        }
    }
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

fn are_different(places: &[Place]) -> bool {
    let mut sorted = places.to_vec();
    sorted.sort_unstable();
    sorted.windows(2).all(|pair| pair[0] != pair[1])
}
