//! One scene under all settings: the time of cycles, and what the oracle says to some.

use std::time::Duration;

use rayon::ThreadPoolBuilder;

use crate::commands::bench::median;
use crate::commands::bench::tradeoff::arena::{Arena, Source};
use crate::commands::bench::tradeoff::row::Row;
use crate::commands::bench::tradeoff::run::{Judged, Run, Sent, start};
use crate::commands::bench::tradeoff::setting::Setting;
use crate::failure::Failure;

/// Most objects in the cycles that are judged: the oracle takes all pairs in numbers of 256 bits, some 30 ms.
const JUDGED_OBJECTS_MAX: u32 = 400;

/// Cycles that are judged, for each setting.
const JUDGED_CYCLES: u32 = 16;

/// One cycle of so many base cycles is judged; a multiple of the longest cycle.
const JUDGED_EVERY: u32 = 8;

/// Base cycles before the first that is timed.
const WARM_UP: u32 = 16;

/// Base cycles that a setting is timed at a stretch. All settings take turns, so that what else the machine does concerns
/// them alike; a multiple of the longest cycle.
const TURN: u32 = 8;

/// Base cycles at the start of a turn that are not timed, since the objects are not in the caches yet: one longest cycle.
const TURN_WARM_UP: u32 = 4;

/// A scene and how it is measured.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plan<'a> {
    pub(super) source: &'a Source,
    pub(super) objects: u32,
    /// Base cycles to be timed at least.
    pub(super) cycles: u32,
    pub(super) seed: u64,
}

/// Returns a row for each setting.
pub(super) fn measure(plan: Plan<'_>) -> Result<Vec<Row>, Failure> {
    let Plan { source, objects, cycles, seed } = plan;
    let large = Arena::new(source, objects, seed)?;
    let small = Arena::new(source, objects.min(JUDGED_OBJECTS_MAX), seed)?;
    let turns = cycles.div_ceil(TURN);
    // Cost is that of one thread.
    let pool = ThreadPoolBuilder::new().num_threads(1).build().map_err(Failure::failed)?;
    let timed = pool.install(|| time(&large, turns));
    let judged = pool.install(|| judge(&small));
    let rows = Setting::ALL
        .iter()
        .zip(timed)
        .zip(judged)
        .map(|((setting, timed), judged)| Row::new(&source.text(), setting, &timed, &judged));
    Ok(rows.collect())
}

/// What the cycles of a run took.
#[derive(Clone, Copy, Debug)]
pub(super) struct Timed {
    pub(super) objects: u32,
    /// Base cycles that were timed.
    pub(super) cycles: u32,
    /// The median of a cycle, as a share of it for one base cycle.
    pub(super) cycle: Duration,
    /// In a base cycle, on average.
    pub(super) bytes: f64,
    pub(super) bytes_per_point: f64,
}

fn time(arena: &Arena, turns: u32) -> Vec<Timed> {
    let mut runs: Vec<Box<dyn Run + '_>> = Setting::ALL.iter().map(|setting| start(arena, setting)).collect();
    for (run, setting) in runs.iter_mut().zip(&Setting::ALL) {
        for _ in 0..WARM_UP / u32::from(setting.stretch) {
            run.order();
            run.step();
        }
    }
    let before: Vec<Sent> = runs.iter().map(|run| run.sent()).collect();
    let mut times: Vec<Vec<Duration>> = vec![Vec::new(); runs.len()];
    for _ in 0..turns {
        for (place, (run, setting)) in runs.iter_mut().zip(&Setting::ALL).enumerate() {
            for base in (0..TURN_WARM_UP + TURN).step_by(usize::from(setting.stretch)) {
                run.order();
                let took = run.step();
                if base >= TURN_WARM_UP {
                    times[place].push(took);
                }
            }
        }
    }
    // Who runs alike costs the same, and chance shall not say otherwise.
    let like = |setting: &Setting| {
        Setting::ALL.iter().position(|other| other.runs_like(setting)).expect("a setting is like itself")
    };
    let medians: Vec<Duration> = times.iter_mut().map(|times| median(times)).collect();
    let timed = Setting::ALL.iter().enumerate().map(|(place, setting)| {
        let sent = runs[place].sent().since(before[place]);
        Timed {
            objects: arena.objects(),
            cycles: turns * TURN,
            cycle: medians[like(setting)] / u32::from(setting.stretch),
            bytes: sent.bytes as f64 / f64::from(turns * (TURN_WARM_UP + TURN)),
            bytes_per_point: sent.bytes as f64 / sent.points.max(1) as f64,
        }
    });
    timed.collect()
}

/// What the oracle says to a run.
#[derive(Clone, Copy, Debug)]
pub(super) struct Assessed {
    pub(super) judged: Judged,
    pub(super) objects: u32,
    /// World units.
    pub(super) skin: f64,
    /// Mean distance of the objects from where they are in the exact run, after the last cycle.
    pub(super) run_deviation: f64,
}

fn judge(arena: &Arena) -> Vec<Assessed> {
    let mut exact = Vec::new();
    let mut assessed = Vec::new();
    for setting in &Setting::ALL {
        let (mut run, mut judged) = (start(arena, setting), Judged::default());
        for _ in 0..JUDGED_CYCLES {
            for _ in 1..JUDGED_EVERY / u32::from(setting.stretch) {
                run.order();
                run.step();
            }
            judged.add(&run.judge());
        }
        let centers = run.centers();
        if exact.is_empty() {
            exact.clone_from(&centers);
        }
        let sum: f64 = centers.iter().zip(&exact).map(|(center, other)| center.distance(*other)).sum();
        let run_deviation = sum / f64::from(arena.objects());
        assessed.push(Assessed { judged, objects: arena.objects(), skin: run.skin(), run_deviation });
    }
    assessed
}
