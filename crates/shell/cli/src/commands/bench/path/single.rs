//! Each unit alone, in straight legs.

use glam::DVec2;
use maniple_pathfinding::{Planner, length};

use crate::commands::bench::path::bound::Bound;
use crate::commands::bench::path::case::Case;
use crate::commands::bench::path::stopwatch::Stopwatch;
use crate::commands::bench::path::walk::Walk;
use crate::commands::bench::path::{Row, percentile};
use crate::failure::Failure;

/// Plans `units` of the queries, taken evenly from all, and walks each path with nobody else there. What has no path has not arrived.
pub(super) fn measure(case: &Case, units: usize) -> Result<Row, Failure> {
    let mut planner = Planner::new(&case.ground);
    let mut walk = Walk::new(&case.map, case.ground.radius())?;
    let mut bound = Bound::new(&case.map);
    let mut times = Vec::with_capacity(units);
    let mut ratios: Vec<f64> = Vec::new();
    let mut arrived = 0;
    for index in 0..units {
        let query = case.queries[index * case.queries.len() / units];
        let (from, to) = (middle(query.start), middle(query.goal));
        let clock = Stopwatch::start();
        let legs = planner.path(from, to);
        times.push(clock.elapsed());
        let Ok(legs) = legs else { continue };
        let shortest = bound.length_min(query.start, query.goal).filter(|&shortest| shortest > 0.0);
        ratios.extend(shortest.map(|shortest| length(from, legs) / shortest));
        let before = walk.collisions;
        walk.insert(0, from)?;
        walk.go_along(0, legs)?;
        arrived += usize::from(walk.is_at(0, to) && walk.collisions == before);
        walk.remove(0)?;
    }
    let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
    Ok(Row {
        map: case.name.clone(),
        planner: "single",
        units,
        arrived,
        makespan: None,
        bound: None,
        throughput: None,
        collisions_per_unit: Some(walk.collisions as f64 / units as f64),
        plan_us_p50: percentile(&mut times, 50),
        plan_us_p99: percentile(&mut times, 99),
        plan_us_per_unit_cycle: None,
        length_ratio_mean: (!ratios.is_empty()).then_some(mean),
        length_ratio_max: ratios.into_iter().reduce(f64::max),
        states: None,
    })
}

fn middle((x, y): (u32, u32)) -> DVec2 {
    DVec2::new(f64::from(x), f64::from(y)) + 0.5
}
