//! `maniple bench path`: what planning costs, and whether what was planned is walked by the kinematics.

mod bound;
mod case;
mod group;
mod in_step;
mod scene;
mod single;
mod stopwatch;
mod walk;

use std::time::Duration;

use maniple_pathfinding::in_step::Algorithm;
use serde::Serialize;

use crate::arguments::BenchPath;
use crate::commands::bench::path::case::Case;
use crate::commands::bench::path::group::Leading;
use crate::commands::bench::path::in_step::InStep;
use crate::commands::bench::path::stopwatch::Stopwatch;
use crate::failure::Failure;
use crate::output::{Format, print, print_text};

/// World units a cycle.
const SPEED: f64 = 0.2;

/// Units where nothing is said, for planners of many.
const UNITS: u32 = 100;

/// What a planner did on a map.
#[derive(Clone, Debug, Serialize)]
struct Row {
    map: String,
    planner: &'static str,
    units: usize,
    arrived: usize,
    /// Cycles; `None` where not all arrived, or nobody goes together.
    makespan: Option<f64>,
    /// Cycles.
    bound: Option<f64>,
    /// Share of the most that can pass the gap in a cycle; `None` where there is no gap that all pass the same way.
    throughput: Option<f64>,
    collisions_per_unit: Option<f64>,
    plan_us_p50: f64,
    plan_us_p99: f64,
    plan_us_per_unit_cycle: Option<f64>,
    length_ratio_mean: Option<f64>,
    length_ratio_max: Option<f64>,
    /// States that were expanded.
    states: Option<u64>,
}

/// A planner that can be asked for by name.
#[derive(Clone, Copy, Debug)]
enum Planner {
    /// Each unit alone.
    Single,
    /// All together, in step.
    InStep(InStep),
    /// Groups, on scenes of their own.
    Group(Leading),
}

impl Planner {
    fn all() -> Vec<Self> {
        let in_step = Algorithm::ALL.map(InStep::Planned).into_iter().chain([InStep::Refined]);
        let groups = Leading::all().map(Self::Group);
        std::iter::once(Self::Single).chain(in_step.map(Self::InStep)).chain(groups).collect()
    }

    fn name(self) -> &'static str {
        match self {
            Self::Single => "single",
            Self::InStep(way) => way.name(),
            Self::Group(leading) => leading.name(),
        }
    }

    fn parse(name: &str) -> Result<Self, Failure> {
        let all = Self::all();
        all.iter().copied().find(|planner| planner.name() == name).ok_or_else(|| {
            let names: Vec<&str> = all.iter().map(|planner| planner.name()).collect();
            Failure::usage(format!("--planner {name}: there is none; choose of {}", names.join(", ")))
        })
    }

    /// For how many units it plans in a case, row by row.
    fn units(self, case: &Case, arguments: &BenchPath) -> Vec<usize> {
        let most = case.queries.len();
        let mut units: Vec<usize> = arguments.units.iter().map(|&units| (units as usize).min(most)).collect();
        if units.is_empty() {
            units.push(match self {
                Self::Single => most,
                Self::InStep(_) | Self::Group(_) => most.min(UNITS as usize),
            });
        }
        units.dedup();
        units
    }

    fn measure(self, case: &Case, units: usize, arguments: &BenchPath) -> Result<Option<Row>, Failure> {
        match self {
            Self::Single => single::measure(case, units).map(Some),
            Self::InStep(way) => in_step::measure(way, case, units, arguments).map(Some),
            Self::Group(_) => Ok(None),
        }
    }
}

/// Runs `maniple bench path`.
pub(super) fn run(arguments: &BenchPath) -> Result<(), Failure> {
    let format = Format::of(&arguments.json);
    let planners = arguments.planners.iter().map(|name| Planner::parse(name));
    let planners = planners.collect::<Result<Vec<_>, _>>()?;
    let leadings = planners.iter().filter_map(|planner| match planner {
        Planner::Group(leading) => Some(*leading),
        Planner::Single | Planner::InStep(_) => None,
    });
    let leadings: Vec<Leading> = leadings.collect();
    if leadings.is_empty() && !arguments.scenes.is_empty() {
        let names: Vec<&str> = Leading::all().map(Leading::name).collect();
        return Err(Failure::usage(format!(
            "--scene: only for planners that lead groups; choose --planner of {}",
            names.join(", ")
        )));
    }
    if format == Format::Text {
        print_text(&header(arguments))?;
    }
    let mut rows = Vec::new();
    let mut tell = |row: Row| {
        let told = if format == Format::Text { print_text(&line(&row)) } else { Ok(()) };
        rows.push(row);
        told
    };
    if planners.iter().any(|planner| !matches!(planner, Planner::Group(_))) {
        for case in case::cases(arguments)? {
            for &planner in &planners {
                for units in planner.units(&case, arguments) {
                    planner.measure(&case, units, arguments)?.map_or(Ok(()), &mut tell)?;
                }
            }
        }
    }
    if !leadings.is_empty() {
        let units = if arguments.units.is_empty() { vec![UNITS] } else { arguments.units.clone() };
        for units in units {
            for scene in scene::scenes(units as usize, arguments)? {
                for &leading in &leadings {
                    tell(group::measure(leading, &scene)?)?;
                }
            }
        }
    }
    match format {
        Format::Json => print(format, &rows, |_| String::new()),
        Format::Text => print_text(&summary(&rows)),
    }
}

/// Returns a percentile of times, in microseconds; they are sorted.
fn percentile(times: &mut [Duration], percent: usize) -> f64 {
    times.sort_unstable();
    let place = (times.len() * percent / 100).min(times.len().saturating_sub(1));
    times.get(place).map_or(0.0, |time| 1e6 * time.as_secs_f64())
}

fn header(arguments: &BenchPath) -> String {
    format!(
        "planning in microseconds of {}; radius {}, seed {}\n{:<34} {:<10} {:>6} {:>7} {:>8} {:>8} {:>10} {:>10} {:>11} {:>11} {:>13} {:>6} {:>6} {:>9}\n",
        Stopwatch::MEASURES,
        arguments.radius,
        arguments.seed,
        "map",
        "planner",
        "units",
        "arrived",
        "makespan",
        "bound",
        "throughput",
        "collisions",
        "us p50",
        "us p99",
        "us/unit/cycle",
        "length",
        "max",
        "states",
    )
}

fn line(row: &Row) -> String {
    let number = |value: Option<f64>, digits: usize| {
        value.map_or_else(|| "-".to_owned(), |value| format!("{value:.digits$}"))
    };
    format!(
        "{:<34} {:<10} {:>6} {:>7} {:>8} {:>8} {:>10} {:>10} {:>11.1} {:>11.1} {:>13} {:>6} {:>6} {:>9}\n",
        row.map,
        row.planner,
        row.units,
        row.arrived,
        number(row.makespan, 0),
        number(row.bound, 0),
        number(row.throughput, 2),
        number(row.collisions_per_unit, 2),
        row.plan_us_p50,
        row.plan_us_p99,
        number(row.plan_us_per_unit_cycle, 4),
        number(row.length_ratio_mean, 3),
        number(row.length_ratio_max, 2),
        row.states.map_or_else(|| "-".to_owned(), |states| states.to_string()),
    )
}

/// In how many rows of a planner all arrived.
fn summary(rows: &[Row]) -> String {
    let mut text = String::new();
    for planner in Planner::all().into_iter().map(Planner::name) {
        let of_planner = rows.iter().filter(|row| row.planner == planner);
        let all = of_planner.clone().count();
        let arrived = of_planner.filter(|row| row.arrived == row.units).count();
        if all > 1 {
            text += &format!("{planner}: all arrived in {arrived} of {all}\n");
        }
    }
    text
}
