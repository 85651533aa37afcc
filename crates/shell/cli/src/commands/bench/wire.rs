//! `maniple bench wire`: how many bytes a view costs, in each way to write it.
//!
//! A scene of one's own: one seat watches the units of another walk from goal to goal, straight and at full speed. Whoever has
//! arrived or was stopped gets a new goal at once; or everybody does in every cycle. Or a scenario, played by its bots.

mod meter;
mod walk;

use maniple_geometry::Cycle;
use maniple_view::{ClockMode, Positions};
use serde::Serialize;

use crate::arguments::BenchWire;
use crate::commands::bench::wire::meter::{Count, Meter, Metered};
use crate::commands::bench::wire::walk::Walk;
use crate::failure::Failure;
use crate::output::{Format, print, print_text};
use crate::{headless, start};

/// The grid of the rows on a grid: a 256th of a tile.
const GRID: Positions = Positions::Grid { bits: 8 };

/// Cycles that a walk takes from goal to goal, about; none: everybody turns in every cycle.
const WALKS: [Option<u32>; 4] = [None, Some(8), Some(40), Some(160)];

/// A way to write a view.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
enum Encoding {
    /// The handle and two doubles of each moving object, in every cycle.
    Absolute,
    /// Deltas as the general codec writes them.
    Bincode,
    /// Deltas as binary connections get them.
    Packed,
    /// What no encoding of these walks can go below: the goals are all that is random, and as likely as each other.
    Bound,
}

/// What a scene costs in one way to write it, with frame lengths and all that is said besides motions.
#[derive(Clone, Debug, Serialize)]
struct Row {
    scene: String,
    encoding: Encoding,
    positions: &'static str,
    bytes_per_object_cycle: f64,
    /// Motions that began or ended.
    events_per_object_cycle: f64,
    /// Moving objects in the view, in the mean.
    objects: f64,
    cycles: u32,
    /// Cycles from the start of a motion to its end, in the mean.
    mean_move_cycles: f64,
}

/// Runs `maniple bench wire`.
pub(crate) fn run(arguments: &BenchWire) -> Result<(), Failure> {
    let rows = match &arguments.scenario {
        Some(_) => scenario(arguments)?,
        None => walks(arguments)?,
    };
    match Format::of(&arguments.json) {
        Format::Json => print(Format::Json, &rows, |_| String::new()),
        Format::Text => print_text(&table(&rows)),
    }
}

fn walks(arguments: &BenchWire) -> Result<Vec<Row>, Failure> {
    let mut rows = Vec::new();
    for cycles in WALKS {
        for positions in [Positions::Exact, GRID] {
            let mut walk = Walk::begin(arguments, positions, cycles)?;
            let mut meter = Meter::new(&walk.referee().rules());
            meter.take(walk.view(), &walk.referee().keyframe(Walk::WATCHER));
            for _ in 0..arguments.cycles {
                let delta = walk.step()?;
                meter.take(walk.view(), &delta);
            }
            let scene = cycles.map_or("turning".to_owned(), |cycles| format!("walks of {cycles}"));
            let scene = Scene { name: &scene, positions, cycles: arguments.cycles };
            let bound = walk.bits_per_walk() / 8.0 * meter.count.begun;
            rows.extend(scene.rows(&meter.count));
            rows.push(scene.row(Encoding::Bound, &meter.count, bound));
        }
    }
    Ok(rows)
}

/// Plays a scenario with its bots, and counts what all seats are told.
fn scenario(arguments: &BenchWire) -> Result<Vec<Row>, Failure> {
    let mut loaded = start::loaded(arguments.scenario.as_deref(), &arguments.overrides())?;
    loaded.limit_cycles(loaded.scenario.cycles_max.min(Cycle(arguments.cycles)));
    let (name, positions) = (loaded.scenario.name.clone(), loaded.scenario.profile.positions);
    let mut bots: Vec<_> = headless::bots(&loaded, &[])?.into_iter().map(Metered::new).collect();
    let referee = start::referee(loaded, ClockMode::Lockstep)?;
    let result = headless::play(referee, &mut bots, None::<Vec<u8>>, |_| {}, |_| {})?;
    let mut count = Count::default();
    for bot in &bots {
        count.add(&bot.count());
    }
    Ok(Scene { name: &name, positions, cycles: result.cycles.0 }.rows(&count))
}

/// What was played.
struct Scene<'a> {
    name: &'a str,
    positions: Positions,
    cycles: u32,
}

impl Scene<'_> {
    /// Returns the rows of what was counted. Absolute positions and plain deltas are doubles on a grid, too, so they have a row where
    /// positions are exact.
    fn rows(&self, count: &Count) -> Vec<Row> {
        let packed = self.row(Encoding::Packed, count, count.packed);
        match self.positions {
            Positions::Exact => vec![
                self.row(Encoding::Absolute, count, count.absolute),
                self.row(Encoding::Bincode, count, count.plain),
                packed,
            ],
            Positions::Grid { .. } => vec![packed],
        }
    }

    fn row(&self, encoding: Encoding, count: &Count, bytes: f64) -> Row {
        // Where nobody moves there is nothing to divide by: all is zero then.
        let share = |sum: f64, of: f64| if of > 0.0 { sum / of } else { 0.0 };
        Row {
            scene: self.name.to_owned(),
            encoding,
            positions: match self.positions {
                Positions::Exact => "exact",
                Positions::Grid { .. } => "grid",
            },
            bytes_per_object_cycle: share(bytes, count.moving),
            events_per_object_cycle: share(count.events, count.moving),
            objects: share(count.moving, count.deltas),
            cycles: self.cycles,
            mean_move_cycles: share(count.moving, count.begun),
        }
    }
}

fn table(rows: &[Row]) -> String {
    let mut text = format!(
        "{:<14} {:<9} {:<9} {:>12} {:>13} {:>8} {:>7} {:>11}\n",
        "scene", "encoding", "positions", "bytes/object", "events/object", "objects", "cycles", "cycles/move"
    );
    for row in rows {
        let encoding = match row.encoding {
            Encoding::Absolute => "absolute",
            Encoding::Bincode => "bincode",
            Encoding::Packed => "packed",
            Encoding::Bound => "bound",
        };
        text += &format!(
            "{:<14} {encoding:<9} {:<9} {:>12.3} {:>13.4} {:>8.1} {:>7} {:>11.1}\n",
            row.scene,
            row.positions,
            row.bytes_per_object_cycle,
            row.events_per_object_cycle,
            row.objects,
            row.cycles,
            row.mean_move_cycles,
        );
    }
    text
}
