//! All units together, in step.

use std::time::Duration;

use anyhow::anyhow;
use maniple_pathfinding::in_step::{Algorithm, Board, Instance, Outcome, Place, Plan, Refinement};

use crate::arguments::BenchPath;
use crate::commands::bench::path::case::Case;
use crate::commands::bench::path::stopwatch::Stopwatch;
use crate::commands::bench::path::walk::Walk;
use crate::commands::bench::path::{Row, SPEED, percentile};
use crate::failure::Failure;

/// Cycles of a step from a middle of a tile to the next.
const CYCLES_A_STEP: u32 = 5;
const _: () = assert!(SPEED * CYCLES_A_STEP as f64 == 1.0);

/// States that are expanded, or rounds that are refined, between two looks at the clock.
const STATES_A_LOOK: u64 = 32;

/// How a plan in step comes about.
#[derive(Clone, Copy, Debug)]
pub(super) enum InStep {
    /// By a planner.
    Planned(Algorithm),
    /// By lacam, and then refined.
    Refined,
}

impl InStep {
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Planned(algorithm) => algorithm.name(),
            Self::Refined => "refined",
        }
    }
}

/// What planning took.
#[derive(Debug, Default)]
struct Planned {
    plan: Option<Plan>,
    /// States that were expanded.
    states: u64,
    /// Of the whole, with the distances to goals; of a closed loop, which needs those once, of its steps alone.
    took: Duration,
    /// Of what a caller waits for at a time.
    times: Vec<Duration>,
}

/// Plans for the first `units` of a case, and walks the plan.
pub(super) fn measure(way: InStep, case: &Case, units: usize, arguments: &BenchPath) -> Result<Row, Failure> {
    let clock = Stopwatch::start();
    let board = Board::new(&case.ground).map_err(Failure::bad_input)?;
    let (starts, goals) = ends(case, &board, units)?;
    let instance = Instance::new(&board, starts, goals)
        .map_err(|error| Failure::bad_input(anyhow!("{}: {error}", case.name)))?;
    let mut planned = match way {
        InStep::Planned(algorithm) => plan(algorithm, &instance, arguments, clock)?,
        InStep::Refined => refined(&instance, arguments, clock)?,
    };
    let mut walk = Walk::new(&case.map, case.ground.radius())?;
    let arrived = match &planned.plan {
        Some(plan) => walked(&mut walk, &instance, plan)?,
        None => 0,
    };
    let cycles = |steps: u32| f64::from(steps * CYCLES_A_STEP);
    let makespan = planned.plan.as_ref().map(|plan| cycles(plan.makespan()));
    let ratios = planned.plan.as_ref().map(|plan| ratios(&instance, plan));
    let per_unit_cycle = |cycles: &f64| 1e6 * planned.took.as_secs_f64() / (units as f64 * cycles.max(1.0));
    Ok(Row {
        map: case.name.clone(),
        planner: way.name(),
        units,
        arrived,
        makespan,
        bound: Some(cycles(instance.makespan_min())),
        throughput: None,
        collisions_per_unit: planned.plan.as_ref().map(|_| walk.collisions as f64 / units as f64),
        plan_us_per_unit_cycle: makespan.as_ref().map(per_unit_cycle),
        plan_us_p50: percentile(&mut planned.times, 50),
        plan_us_p99: percentile(&mut planned.times, 99),
        length_ratio_mean: ratios.map(|(mean, _)| mean),
        length_ratio_max: ratios.map(|(_, max)| max),
        states: Some(planned.states),
    })
}

fn ends(case: &Case, board: &Board, units: usize) -> Result<(Vec<Place>, Vec<Place>), Failure> {
    let place = |(x, y): (u32, u32)| {
        board.place(x, y).ok_or_else(|| {
            Failure::bad_input(anyhow!("{}: a unit has no room in tile ({x}, {y})", case.name))
        })
    };
    let queries = &case.queries[..units];
    let starts = queries.iter().map(|query| place(query.start)).collect::<Result<_, _>>()?;
    let goals = queries.iter().map(|query| place(query.goal)).collect::<Result<_, _>>()?;
    Ok((starts, goals))
}

/// Plans until there is a plan, there cannot be one, or the time is over. The clock of the whole runs since `clock`.
fn plan(
    algorithm: Algorithm,
    instance: &Instance<'_>,
    arguments: &BenchPath,
    clock: Stopwatch,
) -> Result<Planned, Failure> {
    let limit = Duration::from_secs_f64(arguments.seconds);
    let mut search = algorithm
        .begin(instance, arguments.seed)
        .map_err(|error| Failure::usage(format!("--units: {error}")))?;
    let is_closed_loop = algorithm == Algorithm::Pibt;
    let budget = match algorithm {
        // A state is a step of all, or many of them.
        Algorithm::Pibt | Algorithm::Spacetime => 1,
        Algorithm::Lacam | Algorithm::Joint | Algorithm::Conflict => STATES_A_LOOK,
    };
    let mut planned = Planned::default();
    while clock.elapsed() < limit {
        let before = Stopwatch::start();
        let outcome = search.advance(budget);
        if is_closed_loop {
            planned.times.push(before.elapsed());
        }
        match outcome {
            None => {}
            Some(Outcome::Solved(plan)) => {
                planned.plan = Some(plan);
                break;
            }
            Some(Outcome::Unsolvable | Outcome::Stuck) => break,
        }
    }
    planned.states = search.expanded();
    if is_closed_loop {
        planned.took = planned.times.iter().sum();
    } else {
        planned.took = clock.elapsed();
        planned.times.push(planned.took);
    }
    Ok(planned)
}

/// Plans by lacam and refines the plan for some seconds.
fn refined(instance: &Instance<'_>, arguments: &BenchPath, clock: Stopwatch) -> Result<Planned, Failure> {
    let planned = plan(Algorithm::Lacam, instance, arguments, clock)?;
    let Some(first) = &planned.plan else { return Ok(planned) };
    let limit = planned.took + Duration::from_secs_f64(arguments.refine);
    let mut refinement = Refinement::new(instance, first, arguments.seed);
    while clock.elapsed() < limit && refinement.sum_of_costs() > instance.sum_of_costs_min() {
        refinement.improve(STATES_A_LOOK);
    }
    let took = clock.elapsed();
    let states = planned.states + refinement.expanded();
    Ok(Planned { plan: Some(refinement.plan()), states, took, times: vec![took] })
}

/// Walks a plan, all in step, and returns how many are exactly at their goals at the end.
fn walked(walk: &mut Walk, instance: &Instance<'_>, plan: &Plan) -> Result<usize, Failure> {
    let board = instance.board();
    for (unit, &start) in (0..).zip(instance.starts()) {
        walk.insert(unit, board.point(start))?;
    }
    for step in 1..=plan.makespan() as usize {
        for (unit, (&from, &to)) in (0..).zip(plan.at(step - 1).iter().zip(plan.at(step))) {
            if from != to {
                walk.go(unit, board.point(to))?;
            }
        }
        for _ in 0..CYCLES_A_STEP {
            walk.step();
        }
    }
    let is_there = |&(unit, &goal): &(u32, &Place)| walk.is_at(unit, board.point(goal));
    Ok((0..).zip(instance.goals()).filter(is_there).count())
}

/// The sum of costs over its bound, and the largest ratio of a unit.
fn ratios(instance: &Instance<'_>, plan: &Plan) -> (f64, f64) {
    let shortest = |unit: usize| instance.distances().steps(unit, instance.starts()[unit]).unwrap_or(0);
    let ratio = |unit: usize| f64::from(plan.cost(unit).max(1)) / f64::from(shortest(unit).max(1));
    let max = (0..plan.agents()).map(ratio).fold(1.0, f64::max);
    (plan.sum_of_costs() as f64 / (instance.sum_of_costs_min() as f64).max(1.0), max)
}
