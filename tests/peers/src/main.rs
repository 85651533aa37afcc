//! Puts maniple and other engines side by side on the same scenes, in one run, on one thread.

mod engines;
mod judge;
mod march;
mod measure;

use std::error::Error;
use std::io::{self, Write};
use std::process::ExitCode;

use clap::Parser;
use serde::Serialize;

use crate::engines::Kind;
use crate::march::{DENSITY_MAX, Scene};
use crate::measure::{Measured, measure};

/// Smallest density: below it the square of the most objects is so large that single precision shows.
const DENSITY_MIN: f64 = 0.01;

/// Largest number of objects: more than that, and the engines together fill the memory of a small machine.
const OBJECTS_MAX: i64 = 1_000_000;

/// Largest number of timed cycles, so that a typing error does not run for days.
const CYCLES_MAX: i64 = 100_000;

/// Puts maniple and other engines side by side on the same scenes, in one run, on one thread.
#[derive(Debug, Parser)]
#[command(name = "maniple-peers")]
struct Arguments {
    /// Numbers of objects, separated by commas.
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_value = "1000,10000,100000")]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=OBJECTS_MAX))]
    objects: Vec<u32>,
    /// Shares of the area that the objects cover, separated by commas.
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_value = "0.05,0.25")]
    #[arg(value_parser = density)]
    density: Vec<f64>,
    /// Engines, separated by commas; all but box2d-bullets where none is named.
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    engine: Vec<Kind>,
    /// Timed cycles on each scene.
    #[arg(long, value_name = "N", default_value = "20")]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=CYCLES_MAX))]
    cycles: u32,
    /// Decides starts, speeds and headings.
    #[arg(long, value_name = "S", default_value = "1")]
    seed: u64,
    /// Prints a JSON array instead of a table.
    #[arg(long)]
    json: bool,
}

/// A line of the result.
#[derive(Debug, Serialize)]
struct Row {
    engine: Kind,
    objects: u32,
    density: f64,
    ns_per_object_cycle: f64,
    ns_per_object_orders: f64,
    /// Pairs per 1,000 objects and cycle.
    overlapping: f64,
    /// World units.
    deepest: f64,
    /// Pairs per 1,000 objects and cycle.
    tunnelled: f64,
    /// The time of this engine over that of maniple; `None` where maniple did not run.
    ratio: Option<f64>,
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    // This thread is the only one of the pool, so that nothing runs beside it.
    rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global()?;
    eprintln!("seed {}, {} timed cycles", arguments.seed, arguments.cycles);
    let mut out = io::stdout().lock();
    if !arguments.json {
        write_heads(&mut out)?;
    }
    let mut all = Vec::new();
    for &density in &arguments.density {
        for &objects in &arguments.objects {
            let rows = rows(arguments, objects, density);
            if !arguments.json {
                rows.iter().try_for_each(|row| write_row(&mut out, row))?;
            }
            all.extend(rows);
        }
    }
    if arguments.json {
        serde_json::to_writer_pretty(&mut out, &all)?;
        writeln!(out)?;
    }
    Ok(())
}

fn rows(arguments: &Arguments, objects: u32, density: f64) -> Vec<Row> {
    let named = if arguments.engine.is_empty() { Kind::DEFAULT } else { &arguments.engine };
    let is_able = |kind: &Kind| match kind.obstacle(objects) {
        Some(obstacle) => {
            eprintln!("{} is left out at {objects} objects: {obstacle}", kind.name());
            false
        }
        None => true,
    };
    let engines: Vec<Kind> = named.iter().copied().filter(is_able).collect();
    let scene = Scene::random(objects, density, arguments.seed);
    let measured = measure(&engines, &scene, arguments.cycles as usize);
    let ours = measured.iter().find(|measured| measured.engine == Kind::Maniple);
    let ours = ours.map(|measured| measured.step_ns);
    let row = |Measured { engine, step_ns, orders_ns, verdict }: &Measured| Row {
        engine: *engine,
        objects,
        density,
        ns_per_object_cycle: *step_ns,
        ns_per_object_orders: *orders_ns,
        overlapping: verdict.overlapping(),
        deepest: verdict.deepest(),
        tunnelled: verdict.tunnelled(),
        ratio: ours.map(|ours| step_ns / ours),
    };
    measured.iter().map(row).collect()
}

fn write_heads(out: &mut impl Write) -> io::Result<()> {
    writeln!(
        out,
        "{:13} {:>9} {:>8} {:>20} {:>21} {:>12} {:>9} {:>10} {:>8}",
        "engine",
        "objects",
        "density",
        "ns_per_object_cycle",
        "ns_per_object_orders",
        "overlapping",
        "deepest",
        "tunnelled",
        "ratio",
    )
}

fn write_row(out: &mut impl Write, row: &Row) -> io::Result<()> {
    writeln!(
        out,
        "{:13} {:>9} {:>8} {:>20.1} {:>21.1} {:>12.2} {:>9} {:>10.3} {:>8}",
        row.engine.name(),
        row.objects,
        row.density,
        row.ns_per_object_cycle,
        row.ns_per_object_orders,
        row.overlapping,
        depth(row.deepest),
        row.tunnelled,
        row.ratio.map_or("-".to_owned(), |ratio| format!("{ratio:.2}")),
    )?;
    out.flush()
}

/// Writes a small depth so that it is not taken for zero.
fn depth(depth: f64) -> String {
    if depth == 0.0 || depth >= 0.001 { format!("{depth:.3}") } else { format!("{depth:.1e}") }
}

fn density(text: &str) -> Result<f64, String> {
    let density: f64 = text.parse().map_err(|_| "not a number".to_owned())?;
    if (DENSITY_MIN..=DENSITY_MAX).contains(&density) {
        Ok(density)
    } else {
        Err(format!("a density is in {DENSITY_MIN}..={DENSITY_MAX}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bad_input_is_an_error_that_names_the_argument() {
        let bad = [
            ("--objects", "0"),
            ("--objects", "100,many"),
            ("--objects", "1000001"),
            ("--density", "0"),
            ("--density", "0.5"),
            ("--density", "nan"),
            ("--engine", "other"),
            ("--cycles", "0"),
            ("--seed", "-1"),
        ];
        for (argument, value) in bad {
            let error = Arguments::try_parse_from(["maniple-peers", &format!("{argument}={value}")]);
            let error = error.expect_err(value).to_string();
            assert!(error.contains(argument), "{error}");
        }
    }

    #[test]
    fn a_row_has_the_ratio_to_maniple() {
        let line = ["maniple-peers", "--objects=50", "--density=0.1", "--cycles=2"];
        let arguments = Arguments::parse_from(line);
        let rows = rows(&arguments, 50, 0.1);
        assert_eq!(rows.len(), Kind::DEFAULT.len());
        assert_eq!(rows[0].ratio, Some(1.0));
        for row in &rows {
            assert_eq!(row.ratio, Some(row.ns_per_object_cycle / rows[0].ns_per_object_cycle));
        }
    }
}
