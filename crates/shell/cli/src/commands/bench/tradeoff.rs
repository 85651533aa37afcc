//! `maniple bench tradeoff`: what settings gain in speed, and what they cost in accuracy.

mod advice;
mod arena;
mod measure;
mod picture;
mod row;
mod run;
mod setting;

use serde::Serialize;

use crate::arguments::BenchTradeoff;
use crate::commands::bench::tradeoff::advice::{advice, conclusions};
use crate::commands::bench::tradeoff::arena::{Name, Source};
use crate::commands::bench::tradeoff::measure::{Plan, measure};
use crate::commands::bench::tradeoff::row::{Row, csv, mark_pareto};
use crate::failure::Failure;
use crate::files;
use crate::output::{Format, grouped, print, print_text};

/// All that was measured.
#[derive(Clone, Debug, Serialize)]
struct Comparison {
    rows: Vec<Row>,
    /// Sentences about each scene, and at last about all.
    advice: Vec<String>,
}

/// Runs `maniple bench tradeoff`.
pub(super) fn run(arguments: &BenchTradeoff) -> Result<(), Failure> {
    let sources = sources(&arguments.scenes)?;
    if let Some(folder) = &arguments.out {
        files::make_folder(folder)?;
    }
    let format = Format::of(&arguments.json);
    let mut comparison = Comparison { rows: Vec::new(), advice: Vec::new() };
    for source in &sources {
        let plan =
            Plan { source, objects: arguments.objects, cycles: arguments.cycles, seed: arguments.seed };
        let mut rows = measure(plan)?;
        mark_pareto(&mut rows);
        if format == Format::Text {
            print_text(&table(source, &rows))?;
        }
        let named = |sentence: String| format!("{}: {sentence}", source.text());
        comparison.advice.extend(advice(&rows).into_iter().map(named));
        comparison.rows.append(&mut rows);
    }
    comparison.advice.extend(conclusions(&comparison.rows));
    if let Some(folder) = &arguments.out {
        files::write(&folder.join("tradeoff.csv"), csv(&comparison.rows).as_bytes())?;
        files::write(&folder.join("tradeoff.svg"), picture::svg(&comparison.rows).as_bytes())?;
    }
    print(format, &comparison, |comparison| comparison.advice.join("\n") + "\n")
}

/// Returns what is asked for, each scene once.
fn sources(texts: &[String]) -> Result<Vec<Source>, Failure> {
    if texts.is_empty() {
        return Ok(Name::ALL.map(Source::Named).to_vec());
    }
    let mut sources: Vec<Source> = Vec::new();
    for text in texts {
        let source = Source::parse(text)?;
        if sources.iter().all(|other| other.text() != source.text()) {
            sources.push(source);
        }
    }
    Ok(sources)
}

fn table(source: &Source, rows: &[Row]) -> String {
    let mut text = String::new();
    if let Some(first) = rows.first() {
        text += &format!(
            "{}: {}; {} objects timed for {} cycles, {} judged in {} cycles with {} stops\n",
            source.text(),
            source.description(),
            grouped(u64::from(first.timed_objects)),
            first.timed_cycles,
            grouped(u64::from(first.judged_objects)),
            first.judged_cycles,
            grouped(first.judged_stops),
        );
    }
    text += &format!(
        "{:<16} {:>8} {:>8} {:>9} {:>9} {:>11} {:>9} {:>9} {:>8} {:>11} {:>9} {:>6}\n",
        "setting",
        "ns",
        "missed",
        "tunnelled",
        "deepest",
        "overlapping",
        "dev. mean",
        "dev. max",
        "skin",
        "bytes/cycle",
        "run dev.",
        "pareto",
    );
    for row in rows {
        text += &line(row);
    }
    text + "\n"
}

fn line(row: &Row) -> String {
    let percent = |share: f64| format!("{:.2} %", 100.0 * share);
    let length = |length: f64| if length == 0.0 { "0".to_owned() } else { format!("{length:.1e}") };
    format!(
        "{:<16} {:>8.1} {:>8} {:>9} {:>9} {:>11} {:>9} {:>9} {:>8} {:>11} {:>9} {:>6}\n",
        row.setting,
        row.ns_per_object_cycle,
        percent(row.missed),
        percent(row.tunnelled),
        length(row.deepest),
        percent(row.overlapping_share),
        length(row.deviation_mean),
        length(row.deviation_max),
        length(row.skin),
        format!("{:.0}", row.bytes_per_cycle),
        length(row.run_deviation),
        if row.pareto { "*" } else { "" },
    )
}
