//! Groups of units that go anywhere: by a schedule, or led by a tactic while they are watched.

use std::time::Duration;

use anyhow::anyhow;
use glam::DVec2;
use maniple_kinematics::WAYPOINTS_MAX;
use maniple_pathfinding::{
    Controller, Group, Progress, Request, Scene as View, Tactic, bound_of_groups, release, throughput_max,
};

use crate::commands::bench::path::scene::Scene;
use crate::commands::bench::path::stopwatch::Stopwatch;
use crate::commands::bench::path::walk::Walk;
use crate::commands::bench::path::{Row, SPEED, percentile};
use crate::failure::Failure;

/// A tactic that has not brought all home after so many times the bound, and some cycles, does not.
const BOUNDS_MAX: f64 = 6.0;
const CYCLES_MORE: f64 = 300.0;

/// How groups are led.
#[derive(Clone, Copy, Debug)]
pub(super) enum Leading {
    /// By one schedule, ordered at the start.
    Release,
    /// By a controller.
    Tactic(Tactic),
}

impl Leading {
    pub(super) fn all() -> impl Iterator<Item = Self> {
        std::iter::once(Self::Release).chain(Tactic::ALL.map(Self::Tactic))
    }

    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Release => "release",
            Self::Tactic(tactic) => tactic.name(),
        }
    }
}

/// What planning took, and how it ended.
#[derive(Debug, Default)]
struct Walked {
    times: Vec<Duration>,
    /// The last cycle in which somebody moved.
    makespan: f64,
}

/// Leads the groups of a scene and walks as they are led.
pub(super) fn measure(leading: Leading, scene: &Scene) -> Result<Row, Failure> {
    let bound = bound_of_groups(&scene.ground, &scene.groups, SPEED)
        .map_err(|error| Failure::bad_input(anyhow!("{}: {error}, or a smaller --radius", scene.name)))?;
    let mut walk = Walk::new(&scene.map, scene.ground.radius())?;
    let starts = scene.groups.iter().flat_map(|group| &group.starts);
    for (unit, &start) in (0..).zip(starts) {
        walk.insert(unit, start)?;
    }
    if let Some(height) = scene.gap {
        walk.watch(height, scene.groups.iter().map(|group| group.starts.len()).sum());
    }
    let cycles_max = BOUNDS_MAX * bound + CYCLES_MORE;
    let mut walked = match leading {
        Leading::Release => released(&mut walk, scene)?,
        Leading::Tactic(tactic) => led(&mut walk, scene, tactic, cycles_max)?,
    };
    let goals = |group: &Group| group.goals.clone();
    let (mut unit, mut arrived) = (0, 0);
    for group in &scene.groups {
        for _ in &group.starts {
            let at = walk.position(unit);
            let is_there = |goal: &DVec2| at.is_some_and(|at| at.distance(*goal) < 1e-3);
            arrived += usize::from(goals(group).iter().any(is_there));
            unit += 1;
        }
    }
    let units = unit as usize;
    let whole: f64 = walked.times.iter().map(Duration::as_secs_f64).sum();
    let is_whole = arrived == units;
    let limit = throughput_max(&scene.ground, &scene.groups[0], SPEED).map_err(Failure::bad_input)?;
    let throughput = walk.throughput().zip(limit).map(|(throughput, limit)| throughput / limit);
    Ok(Row {
        map: scene.name.clone(),
        planner: leading.name(),
        units,
        arrived,
        makespan: is_whole.then_some(walked.makespan),
        bound: Some(bound),
        throughput,
        collisions_per_unit: Some(walk.collisions as f64 / units as f64),
        plan_us_per_unit_cycle: Some(1e6 * whole / (units as f64 * walked.makespan.max(1.0))),
        plan_us_p50: percentile(&mut walked.times, 50),
        plan_us_p99: percentile(&mut walked.times, 99),
        length_ratio_mean: None,
        length_ratio_max: None,
        states: None,
    })
}

/// Orders a schedule and lets all walk; nobody walks where there is none.
fn released(walk: &mut Walk, scene: &Scene) -> Result<Walked, Failure> {
    let clock = Stopwatch::start();
    let request = Request { groups: &scene.groups, speed: SPEED, still: &[], moving: &[] };
    let schedule = release(&scene.ground, &request);
    let times = vec![clock.elapsed()];
    let Ok(schedule) = schedule else { return Ok(Walked { times, makespan: 0.0 }) };
    let most = schedule.walks.iter().flatten().map(|walk| walk.legs.len()).max().unwrap_or(0);
    if most > WAYPOINTS_MAX {
        return Err(Failure::bad_input(anyhow!(
            "--planner release: {}: the schedule for {} units has a way of {most} legs, and a unit takes {WAYPOINTS_MAX} waypoints at a time; \
             --planner auto orders such ways in parts, or choose fewer --units",
            scene.name,
            schedule.walks.iter().map(Vec::len).sum::<usize>()
        )));
    }
    for (unit, walked) in (0..).zip(schedule.walks.iter().flatten()) {
        if !walked.legs.is_empty() {
            walk.depart(unit, &walked.legs, Some(walked.departure))?;
        }
    }
    let makespan = walk.rest();
    Ok(Walked { times, makespan })
}

/// Leads the groups by a controller, until all have arrived or the cycles are over.
fn led(walk: &mut Walk, scene: &Scene, tactic: Tactic, cycles_max: f64) -> Result<Walked, Failure> {
    let mut controller = Controller::of_groups(tactic, &scene.groups, SPEED);
    let mut walked = Walked::default();
    let mut cycle = 0;
    while f64::from(cycle) < cycles_max {
        let seen: Vec<_> = (0..).map_while(|unit| walk.seen(unit)).collect();
        let clock = Stopwatch::start();
        let orders = controller.advance(&scene.ground, &View { cycle, units: &seen, others: &[] });
        walked.times.push(clock.elapsed());
        for order in orders {
            let unit = u32::try_from(order.unit).unwrap_or(u32::MAX);
            if order.legs.is_empty() {
                walk.halt(unit)?;
            } else {
                walk.depart(unit, &order.legs, order.start)?;
            }
        }
        if let Some(time) = walk.step() {
            walked.makespan = time;
        }
        cycle += 1;
        if walk.is_at_rest() && (0..seen.len()).all(|unit| controller.progress(unit) == Progress::Arrived) {
            break;
        }
    }
    Ok(walked)
}
