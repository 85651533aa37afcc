//! `maniple bench scale`: what a cycle costs, over the number of objects, their density and threads.

use std::path::Path;
use std::time::Duration;

use anyhow::{Context, anyhow};
use maniple_kinematics::Part;
use maniple_view::Digest;
use rayon::ThreadPoolBuilder;
use serde::Serialize;

use crate::arguments::BenchScale;
use crate::commands::bench::march::{Field, March, Scene};
use crate::commands::bench::{median, too_dense};
use crate::failure::Failure;
use crate::files;
use crate::output::{Format, grouped, print, print_text};

/// Overlaps are looked for after each cycle whose number is a multiple of this, and after the last.
const AUDIT_CYCLES: u32 = 5;

/// With more objects than this, overlaps are looked for after the last cycle only, since that takes seconds.
const AUDITED_OFTEN_MAX: usize = 200_000;

/// What a march took; all figures of a cycle are those of the timed cycles.
#[derive(Clone, Debug, Serialize)]
struct Row {
    /// Circles that march.
    objects: u32,
    /// The share of the area that was asked for; on a map the largest that it may be.
    density: f64,
    threads: u32,
    /// Median of the cycles.
    ns_per_object_cycle: f64,
    /// Of the median.
    cycles_per_second: f64,
    /// Mean of the cycles.
    pairs_tested: f64,
    /// Mean of the cycles.
    components: f64,
    /// Of all cycles.
    largest_component: usize,
    /// Mean of the cycles.
    collisions: f64,
    /// Of all states that were looked at.
    overlaps_found: usize,
    /// Of all circles, those at rest too.
    bytes_per_object: f64,
    /// The state hash after the last cycle.
    hash: Digest,
    /// Wall segments.
    walls: usize,
    /// Circles that rest apart.
    resting: u32,
    /// ns an object and cycle of each of [`Part::ALL`]; mean of the cycles.
    parts: [f64; Part::ALL.len()],
    #[serde(skip_serializing_if = "Option::is_none")]
    map: Option<String>,
}

/// Runs `maniple bench scale`.
pub(super) fn run(arguments: &BenchScale) -> Result<(), Failure> {
    let format = Format::of(&arguments.json);
    let mut rows: Vec<Row> = Vec::new();
    for plan in scenes(arguments)? {
        let scene = plan.scene(arguments)?;
        if format == Format::Text && rows.is_empty() {
            print_text(&header(arguments))?;
        }
        let emptied = plan.map.map(|_| scene.emptied());
        for scene in std::iter::once(&scene).chain(&emptied) {
            for &threads in &arguments.threads {
                let row = measure(scene, plan.density, threads, arguments)?;
                if format == Format::Text {
                    print_text(&line(&row))?;
                    if arguments.parts {
                        print_text(&parts_line(&row))?;
                    }
                }
                rows.push(row);
            }
        }
    }
    if format == Format::Json {
        print(format, &rows, |_| String::new())?;
    }
    match difference(&rows) {
        None => Ok(()),
        Some(text) => Err(Failure::failed(anyhow!(text))),
    }
}

/// A scene to be made.
#[derive(Debug)]
struct Plan<'a> {
    field: Field,
    objects: u32,
    density: f64,
    map: Option<&'a Path>,
}

/// Returns the scenes that are asked for. On a map, numbers that do not fit become the largest that does, once.
fn scenes(arguments: &BenchScale) -> Result<Vec<Plan<'_>>, Failure> {
    let map = arguments.map.as_deref();
    let field = map.map(files::map).transpose()?.map(|map| Field::of_map(&map));
    let mut plans: Vec<Plan<'_>> = Vec::new();
    for &density in &arguments.density {
        let mut counts = arguments.objects.clone();
        if let (Some(field), Some(path)) = (&field, map) {
            let capacity = field.capacity(density);
            if capacity == 0 {
                return Err(Failure::bad_input(anyhow!(
                    "{}: no circle fits at density {density}",
                    path.display()
                )));
            }
            for count in &mut counts {
                *count = capacity.min(*count);
            }
            counts.dedup();
        }
        for objects in counts {
            let field = field.clone().unwrap_or_else(|| Field::square(objects, density));
            plans.push(Plan { field, objects, density, map });
        }
    }
    Ok(plans)
}

impl Plan<'_> {
    fn scene(&self, arguments: &BenchScale) -> Result<Scene, Failure> {
        let Self { objects, density, .. } = *self;
        let placed = Scene::place(self.field.clone(), objects, arguments.resting, arguments.seed);
        let scene = placed.map_err(|error| match self.map {
            Some(path) => Failure::bad_input(error).within(path),
            None => Failure::failed(error),
        })?;
        let found = scene.objects();
        if found == 0 || (self.map.is_none() && found < objects) {
            return Err(too_dense(objects, density, found));
        }
        Ok(scene)
    }
}

/// Lets a scene march and times it.
fn measure(scene: &Scene, density: f64, threads: u32, arguments: &BenchScale) -> Result<Row, Failure> {
    let pool = ThreadPoolBuilder::new().num_threads(threads as usize).build();
    let pool = pool.with_context(|| format!("--threads {threads}")).map_err(Failure::Failed)?;
    let cycles = arguments.cycles;
    let figures = pool.install(|| Figures::of(scene, cycles));
    let per_cycle = |sum: u64| sum as f64 / f64::from(cycles);
    let median = figures.median.as_secs_f64();
    Ok(Row {
        objects: scene.objects(),
        density,
        threads,
        ns_per_object_cycle: 1e9 * median / f64::from(scene.objects()),
        cycles_per_second: 1.0 / median,
        pairs_tested: per_cycle(figures.pairs_tested),
        components: per_cycle(figures.components),
        largest_component: figures.largest_component,
        collisions: per_cycle(figures.collisions),
        overlaps_found: figures.overlaps_found,
        bytes_per_object: figures.bytes as f64 / (f64::from(scene.objects()) + f64::from(scene.resting)),
        hash: figures.hash,
        walls: scene.field.walls().len(),
        resting: scene.resting,
        parts: figures
            .parts
            .map(|sum| 1e9 * sum.as_secs_f64() / (f64::from(cycles) * f64::from(scene.objects()))),
        map: arguments.map.as_ref().map(|path| path.display().to_string()),
    })
}

/// What was counted; sums over the timed cycles.
#[derive(Clone, Debug)]
struct Figures {
    median: Duration,
    parts: [Duration; Part::ALL.len()],
    pairs_tested: u64,
    components: u64,
    largest_component: usize,
    collisions: u64,
    overlaps_found: usize,
    bytes: usize,
    hash: Digest,
}

impl Figures {
    fn of(scene: &Scene, cycles: u32) -> Self {
        let mut march = March::new(scene);
        march.warm_up();
        let mut figures = Self {
            median: Duration::ZERO,
            parts: [Duration::ZERO; Part::ALL.len()],
            pairs_tested: 0,
            components: 0,
            largest_component: 0,
            collisions: 0,
            overlaps_found: 0,
            bytes: 0,
            hash: Digest(0),
        };
        let mut times = Vec::with_capacity(cycles as usize);
        for cycle in 1..=cycles {
            march.order();
            let cycled = march.step();
            times.push(cycled.took);
            for (sum, part) in figures.parts.iter_mut().zip(cycled.parts) {
                *sum += part;
            }
            figures.collisions += cycled.collisions;
            let activity = march.world.activity();
            figures.pairs_tested += activity.pairs_tested as u64;
            figures.components += activity.components as u64;
            figures.largest_component = figures.largest_component.max(march.world.largest_component());
            let is_audited = cycle % AUDIT_CYCLES == 0 && march.world.len() <= AUDITED_OFTEN_MAX;
            if is_audited || cycle == cycles {
                figures.overlaps_found += march.world.overlaps().len();
            }
        }
        figures.median = median(&mut times);
        figures.bytes = march.world.bytes();
        figures.hash = Digest(march.world.digest());
        figures
    }
}

/// Returns which rows differ in nothing but threads and hash; `None` where there are none.
fn difference(rows: &[Row]) -> Option<String> {
    let same = |a: &Row, b: &Row| {
        (a.objects, a.density.to_bits(), a.walls) == (b.objects, b.density.to_bits(), b.walls)
    };
    for (place, row) in rows.iter().enumerate() {
        let Some(first) = rows[..place].iter().position(|other| same(row, other) && row.hash != other.hash)
        else {
            continue;
        };
        let Row { objects, density, walls, .. } = row;
        return Some(format!(
            "rows {} and {} ({objects} objects, density {density}, {walls} walls): the hash is {} with {} threads and \
             {} with {}",
            first + 1,
            place + 1,
            rows[first].hash,
            rows[first].threads,
            row.hash,
            row.threads,
        ));
    }
    None
}

fn header(arguments: &BenchScale) -> String {
    let place = match &arguments.map {
        Some(path) => format!(" on {}, and in an empty world of its size", path.display()),
        None => String::new(),
    };
    format!(
        "circles that march{place}; seed {}, median and means of {} cycles\n\
         {:>9} {:>7} {:>7} {:>7} {:>9} {:>9} {:>9} {:>11} {:>10} {:>7} {:>10} {:>8} {:>8} {:>16}\n",
        arguments.seed,
        grouped(u64::from(arguments.cycles)),
        "objects",
        "density",
        "threads",
        "walls",
        "resting",
        "ns/object",
        "cycles/s",
        "pairs",
        "components",
        "largest",
        "collisions",
        "overlaps",
        "bytes",
        "hash",
    )
}

fn line(row: &Row) -> String {
    format!(
        "{:>9} {:>7} {:>7} {:>7} {:>9} {:>9.1} {:>9.1} {:>11.0} {:>10.0} {:>7} {:>10.0} {:>8} {:>8.1} {:>16}\n",
        grouped(u64::from(row.objects)),
        row.density,
        row.threads,
        grouped(row.walls as u64),
        grouped(u64::from(row.resting)),
        row.ns_per_object_cycle,
        row.cycles_per_second,
        row.pairs_tested,
        row.components,
        row.largest_component,
        row.collisions,
        row.overlaps_found,
        row.bytes_per_object,
        row.hash.to_string(),
    )
}

/// What the parts of a cycle took.
fn parts_line(row: &Row) -> String {
    let parts = Part::ALL.iter().zip(row.parts).map(|(part, ns)| format!("{part:?} {ns:.1}").to_lowercase());
    format!("          of this: {}\n", parts.collect::<Vec<_>>().join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(objects: u32, threads: u32, hash: u64) -> Row {
        Row {
            objects,
            density: 0.05,
            threads,
            ns_per_object_cycle: 50.0,
            cycles_per_second: 1.0,
            pairs_tested: 1.0,
            components: 1.0,
            largest_component: 1,
            collisions: 1.0,
            overlaps_found: 0,
            bytes_per_object: 160.0,
            hash: Digest(hash),
            walls: 4,
            resting: 0,
            parts: [0.0; Part::ALL.len()],
            map: None,
        }
    }

    #[test]
    fn rows_whose_hash_depends_on_the_threads_are_named() {
        assert_eq!(difference(&[row(10, 1, 7), row(10, 2, 7), row(20, 1, 8)]), None);
        let found = difference(&[row(20, 1, 8), row(10, 1, 7), row(10, 2, 9)]).expect("a difference");
        for named in ["rows 2 and 3", "10 objects", "density 0.05", "1 threads", "with 2"] {
            assert!(found.contains(named), "{found} does not name {named}");
        }
    }
}
