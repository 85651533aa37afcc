//! The arguments of `maniple bench`.

mod load;
mod path;

use std::ops::RangeInclusive;
use std::path::PathBuf;

use clap::{Args, Subcommand};
use maniple_game::Overrides;

use crate::output::JsonFlag;
pub(crate) use load::BenchLoad;
pub(crate) use path::{BenchPath, GroupScene};

/// Most circles of a benchmark of each kind: 4 million take about a gigabyte.
const OBJECTS_MAX: i64 = 4_000_000;

/// Shares of the area that circles may cover: random placing gets slow above, and cannot go beyond 0.547.
const DENSITIES: RangeInclusive<f64> = 0.01..=0.4;

/// What the figures of `bench tradeoff` are.
const TRADEOFF_HELP: &str = "\
Columns, the same in the table, as JSON and as CSV:
  ns_per_object_cycle  median of the timed cycles, the step alone in one thread; where a cycle is longer (rate 0.5, 0.25),
                       a share of it, so that rows compare; commands then wait up to two or four times as long
  missed               share of the stops that should have been, and were not
  tunnelled            share of the objects that went through something in a cycle, deeper than a hundredth of the radius
  deepest              deepest penetration at any time, in world units
  overlapping_share    share of the objects that overlap something at the end of a cycle, by whatever little
  deviation_mean, deviation_max
                       how far an object is from where the oracle says at the end of a cycle, in world units
  bytes_per_cycle      for the points where the motions of a cycle start and where objects stop, and nothing else: two doubles
                       each, or, on a grid, two varints of the protocol that hold multiples of 2^-8 or 2^-12 (zigzag); the
                       other figures of such a row are about what a client sees
  pareto               whether the row is on the front: no other row of the scene costs as little, in ns and in bytes a point,
                       errs as little (deviation_mean, where below the skin of exact it counts as 0) and lets commands wait
                       as little, and is better in one of them
The oracle judges single cycles, each from the state in which the setting itself has come to it: whole runs part lawfully at
the first near tie. How far they part is run_deviation: the mean distance of an object from where it is in the exact run.

Example: maniple bench tradeoff --scene open --scene maps/choke.tmx --out figures";

#[derive(Debug, Subcommand)]
pub(crate) enum BenchCommand {
    /// Let circles march on random headings, and time each cycle: over their number, their density and threads; exit
    /// code 1 if the state hash depends on the number of threads
    #[command(after_help = "Example: maniple bench scale --objects 1000,10000 --density 0.05 --threads 1,2")]
    Scale(BenchScale),
    /// Look for the pairs that may meet in a cycle by all pairs, bounding boxes, motion spheres and sectors, and time each
    #[command(after_help = "Example: maniple bench broad --objects 1000,10000 --density 0.05")]
    Broad(BenchBroad),
    /// Let circles march beside parts of the model that they never meet, and time what those cost them
    #[command(after_help = "Example: maniple bench absent --objects 10000 --density 0.05")]
    Absent(BenchAbsent),
    /// Play the same scenes under every setting, and compare what a cycle costs with how far it is from the truth
    #[command(
        after_help = "Example: maniple bench tradeoff --scene open --scene maps/choke.tmx --out figures",
        after_long_help = TRADEOFF_HELP
    )]
    Tradeoff(BenchTradeoff),
    /// Count the bytes that a view costs in a cycle, for each object that moves in it, as absolute positions, plain and packed
    /// deltas, with the bound that no encoding goes below
    #[command(after_help = "Example: maniple bench wire --scenario config/scenarios/orts4.toml --cycles 400")]
    Wire(BenchWire),
    /// Put a daemon under load: matches of bots, spectators, and connections that mean it ill; how late its cycles are, and what it
    /// takes in bytes, time and memory
    #[command(after_help = "Example: maniple bench load --clients 4000 --matches 64 --hostile 1000")]
    Load(BenchLoad),
    /// Plan ways for many units, walk them in the kinematics, and compare what planning costs and how far it is from the best
    #[command(
        after_help = "Example: maniple bench path --map maps/rooms.map --planner pibt --units 50,100",
        after_long_help = path::PATH_HELP
    )]
    Path(BenchPath),
}

#[derive(Debug, Args)]
pub(crate) struct BenchScale {
    /// How many circles march, 1 to 4000000 each
    #[arg(
        long,
        value_name = "LIST",
        value_delimiter = ',',
        default_value = "1000,10000,100000,1000000",
        value_parser = clap::value_parser!(u32).range(1..=OBJECTS_MAX)
    )]
    pub(crate) objects: Vec<u32>,
    /// Shares of the area that they cover, 0.01 to 0.4 each; on a map of the passable tiles, and at most so much
    #[arg(
        long,
        value_name = "LIST",
        value_delimiter = ',',
        default_value = "0.05,0.25",
        value_parser = density
    )]
    pub(crate) density: Vec<f64>,
    /// Numbers of threads, 1 to 256 each; the result has the same bits with any of them
    #[arg(
        long,
        value_name = "LIST",
        value_delimiter = ',',
        default_value = "1,2",
        value_parser = clap::value_parser!(u32).range(1..=256)
    )]
    pub(crate) threads: Vec<u32>,
    /// March on this map: .tmx or .map; and once more in an empty world of its size
    #[arg(long, value_name = "FILE")]
    pub(crate) map: Option<PathBuf>,
    /// Cycles that are timed, behind those to warm up
    #[arg(
        long,
        value_name = "N",
        default_value_t = 20,
        value_parser = clap::value_parser!(u32).range(1..=1_000_000)
    )]
    pub(crate) cycles: u32,
    /// Circles at rest besides, in a part of the world apart, up to 4000000
    #[arg(
        long,
        value_name = "N",
        default_value_t = 0,
        value_parser = clap::value_parser!(u32).range(0..=OBJECTS_MAX)
    )]
    pub(crate) resting: u32,
    /// The seed of places, headings and speeds
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub(crate) seed: u64,
    /// Show what each part of a cycle takes, too; with --json it is always there
    #[arg(long)]
    pub(crate) parts: bool,
    #[command(flatten)]
    pub(crate) json: JsonFlag,
}

#[derive(Debug, Args)]
pub(crate) struct BenchBroad {
    /// How many circles march, 1 to 4000000 each; up to 10000 also by the methods that test every pair
    #[arg(
        long,
        value_name = "LIST",
        value_delimiter = ',',
        default_value = "100,1000,10000,100000",
        value_parser = clap::value_parser!(u32).range(1..=OBJECTS_MAX)
    )]
    pub(crate) objects: Vec<u32>,
    /// The share of the area that they cover, 0.01 to 0.4
    #[arg(long, value_name = "SHARE", default_value_t = 0.25, value_parser = density)]
    pub(crate) density: f64,
    /// The seed of places, headings and speeds
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub(crate) seed: u64,
    #[command(flatten)]
    pub(crate) json: JsonFlag,
}

#[derive(Debug, Args)]
pub(crate) struct BenchAbsent {
    /// How many circles march, 1 to 4000000
    #[arg(
        long,
        value_name = "N",
        default_value_t = 10_000,
        value_parser = clap::value_parser!(u32).range(1..=OBJECTS_MAX)
    )]
    pub(crate) objects: u32,
    /// The share of the area that they cover, 0.01 to 0.4
    #[arg(long, value_name = "SHARE", default_value_t = 0.05, value_parser = density)]
    pub(crate) density: f64,
    /// Cycles that are timed, behind those to warm up
    #[arg(
        long,
        value_name = "N",
        default_value_t = 200,
        value_parser = clap::value_parser!(u32).range(1..=1_000_000)
    )]
    pub(crate) cycles: u32,
    /// The seed of places, headings and speeds
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub(crate) seed: u64,
    #[command(flatten)]
    pub(crate) json: JsonFlag,
}

#[derive(Debug, Args)]
pub(crate) struct BenchWire {
    /// A scenario to play with its bots, and to count what all seats are told; without it units walk that one seat watches
    #[arg(long, value_name = "SCENARIO.toml")]
    pub(crate) scenario: Option<PathBuf>,
    /// How many units walk, 1 to 1000
    #[arg(
        long,
        value_name = "N",
        default_value_t = 200,
        conflicts_with = "scenario",
        value_parser = clap::value_parser!(u32).range(1..=1000)
    )]
    pub(crate) objects: u32,
    /// Cycles that are counted at most
    #[arg(
        long,
        value_name = "N",
        default_value_t = 1000,
        value_parser = clap::value_parser!(u32).range(1..=100_000)
    )]
    pub(crate) cycles: u32,
    /// The seed of the match
    #[arg(long, value_name = "S")]
    pub(crate) seed: Option<u64>,
    #[command(flatten)]
    pub(crate) json: JsonFlag,
}

impl BenchWire {
    /// Returns what is asked for instead of what the scenario says.
    pub(crate) fn overrides(&self) -> Overrides {
        Overrides { seed: self.seed, ..Overrides::default() }
    }
}

#[derive(Debug, Args)]
pub(crate) struct BenchTradeoff {
    /// A scene by its name, or a map to march on (.tmx or .map); without it all that have a name: open, crowd, choke,
    /// gathering, fast, far, map
    #[arg(long = "scene", value_name = "NAME|FILE")]
    pub(crate) scenes: Vec<String>,
    /// How many circles march in the cycles that are timed, 20 to 100000; on a map at most as many as cover a quarter of
    /// its ground. The oracle judges the same scene with at most 400
    #[arg(
        long,
        value_name = "N",
        default_value_t = 4_000,
        value_parser = clap::value_parser!(u32).range(20..=100_000)
    )]
    pub(crate) objects: u32,
    /// Cycles that are timed, behind those to warm up; rounded up to a multiple of 8
    #[arg(
        long,
        value_name = "N",
        default_value_t = 48,
        value_parser = clap::value_parser!(u32).range(1..=100_000)
    )]
    pub(crate) cycles: u32,
    /// The seed of places, goals and speeds
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub(crate) seed: u64,
    /// Write tradeoff.csv and tradeoff.svg into this folder, which is made if it is not there
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) json: JsonFlag,
}

fn density(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(share) if DENSITIES.contains(&share) => Ok(share),
        Ok(share) => Err(format!("{share} is not in {} to {}", DENSITIES.start(), DENSITIES.end())),
        Err(error) => Err(error.to_string()),
    }
}
