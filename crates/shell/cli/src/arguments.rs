//! The command line.

mod admin;
mod configuration;
mod conformance;
mod generate;
mod load;
mod path;
mod profile;
mod tls;
mod tournament;

use std::net::SocketAddr;
use std::ops::RangeInclusive;
use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use maniple_game::Overrides;
use maniple_view::ClockMode;
use maniple_view::Digest;

use crate::output::JsonFlag;
pub(crate) use admin::Admin;
pub(crate) use configuration::ConfigurationArguments;
pub(crate) use conformance::{ConformanceCommand, ConformanceServe};
pub(crate) use generate::MapGenerate;
pub(crate) use load::BenchLoad;
pub(crate) use path::BenchPath;
pub(crate) use profile::ProfileArguments;
pub(crate) use tls::TlsArguments;
pub(crate) use tournament::ManyArguments;

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

/// An authoritative real-time-strategy server with exact kinematics
#[derive(Debug, Parser)]
#[command(name = "maniple", version, arg_required_else_help = true)]
#[command(after_help = "Try it: maniple match")]
pub(crate) struct Arguments {
    /// What to log to standard error, as in `debug` or `maniple_server=trace,warn` [default: warn, or the environment's MANIPLE_LOG_FILTER]
    #[arg(long, global = true, value_name = "FILTER")]
    pub(crate) log: Option<String>,

    /// How to log: text or json [default: text, or the environment's MANIPLE_LOG_FORMAT]
    #[arg(long, global = true, value_name = "FORMAT")]
    pub(crate) log_format: Option<String>,

    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Look at a map: its figures, what is odd about it, its picture; or make one from a seed
    #[command(subcommand, after_help = "Example: maniple map info maps/choke.tmx")]
    Map(MapCommand),
    /// Run a kinematic scene from a JSON file
    #[command(after_help = "Example: maniple simulate scene.json --cycles 100 --json")]
    Simulate(Simulate),
    /// Play a match between bots in this process, as fast as it goes; or, with --count, many
    #[command(after_help = tournament::MATCH_HELP)]
    Match(Match),
    /// Run a match that clients join over TCP
    #[command(after_help = "Example: maniple serve --clock lockstep --listen 127.0.0.1:0 --once")]
    Serve(Serve),
    /// Ask something of a daemon that runs, or let it do something
    #[command(after_help = "Example: maniple admin --socket /run/maniple/admin.sock list")]
    Admin(Admin),
    /// Play a seat of a running match with a shipped bot
    #[command(after_help = "Example: maniple bot straight --connect 127.0.0.1:7171 --token TOKEN")]
    Bot(Bot),
    /// Test a client that somebody wrote
    #[command(subcommand, after_help = "Example: maniple conformance serve")]
    Conformance(ConformanceCommand),
    /// Watch a running match, as far behind as its scenario says: what a seat sees, or everything
    #[command(after_help = "Example: maniple watch --connect 127.0.0.1:7171 --seat 0")]
    Watch(Watch),
    /// Look at a replay: what it holds, whether it plays again to the same hashes, what a seat saw, a
    /// picture of it
    #[command(subcommand, after_help = "Example: maniple replay verify duel.replay")]
    Replay(ReplayCommand),
    /// Measure what a cycle costs: in time on this machine, and in bytes
    #[command(subcommand, after_help = "Example: maniple bench scale --objects 1000,10000")]
    Bench(BenchCommand),
}

#[derive(Debug, Subcommand)]
pub(crate) enum MapCommand {
    /// Print size, passable tiles, walls, regions and spawns
    #[command(after_help = "Example: maniple map info maps/choke.tmx --json")]
    Info(MapInfo),
    /// List what is odd: narrow gaps, spawns in walls, regions cut off; exit code 1 if anything is. Objects that are
    /// ignored are listed and counted, and are no failure
    #[command(after_help = "Example: maniple map check maps/choke.tmx --radius 0.45")]
    Check(MapCheck),
    /// Draw tiles, walls, spawns and resources
    #[command(after_help = "Example: maniple map render maps/diamond.tmx --out diamond.png --scale 16")]
    Render(MapRender),
    /// Make a map from a seed: the same one on every machine, everything on it within reach of the largest unit, and with
    /// two players the same for both
    #[command(after_help = "Example: maniple map generate islands --seed 7 --out islands.tmx")]
    Generate(MapGenerate),
}

#[derive(Debug, Args)]
pub(crate) struct MapInfo {
    /// A map: .tmx or .map
    pub(crate) file: PathBuf,
    #[command(flatten)]
    pub(crate) json: JsonFlag,
}

#[derive(Debug, Args)]
pub(crate) struct MapCheck {
    /// A map: .tmx or .map
    pub(crate) file: PathBuf,
    /// Radius of the largest circle that shall get everywhere, in tiles; without it gaps are not looked at
    #[arg(long, value_name = "R", value_parser = positive)]
    pub(crate) radius: Option<f64>,
    #[command(flatten)]
    pub(crate) json: JsonFlag,
}

#[derive(Debug, Args)]
pub(crate) struct MapRender {
    /// A map: .tmx or .map
    pub(crate) file: PathBuf,
    /// The picture to write
    #[arg(long, value_name = "FILE.png")]
    pub(crate) out: PathBuf,
    /// Pixels a tile; without it the picture gets about 1,024 pixels wide or high
    #[arg(long, value_name = "PIXELS", value_parser = clap::value_parser!(u32).range(1..=64))]
    pub(crate) scale: Option<u32>,
}

#[derive(Debug, Args)]
pub(crate) struct Simulate {
    /// A scene: bounds, segments, objects, moves
    pub(crate) scene: PathBuf,
    /// Cycles to run; without it until all rest
    #[arg(long, value_name = "N")]
    pub(crate) cycles: Option<u32>,
    /// Threads to use; the result has the same bits with any number
    #[arg(long, value_name = "T", value_parser = clap::value_parser!(u32).range(1..=256))]
    pub(crate) threads: Option<u32>,
    #[command(flatten)]
    pub(crate) json: JsonFlag,
}

#[derive(Debug, Args)]
pub(crate) struct Match {
    /// A scenario; without it the shipped duel
    pub(crate) scenario: Option<PathBuf>,
    /// Play on this map: .tmx or .map
    #[arg(long, value_name = "FILE")]
    pub(crate) map: Option<PathBuf>,
    /// The bot of the next seat, as `straight` or `commander`, an unknown name lists all; seats without one get the scenario's
    #[arg(long = "bot", value_name = "NAME")]
    pub(crate) bots: Vec<String>,
    /// The seed of the match; without it the scenario's
    #[arg(long, value_name = "S")]
    pub(crate) seed: Option<u64>,
    #[command(flatten)]
    pub(crate) profile: ProfileArguments,
    /// Cycles that the match lasts at most; without it the scenario's length
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) cycles: Option<u32>,
    /// Print what each part of a cycle cost, and what is not modelled and so costs nothing
    #[arg(long, conflicts_with = "json")]
    pub(crate) explain: bool,
    /// Where to write the replay
    #[arg(long, value_name = "FILE")]
    pub(crate) replay: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) json: JsonFlag,
    #[command(flatten)]
    pub(crate) many: ManyArguments,
}

/// How time passes.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum Clock {
    /// So many cycles a second, whoever is late
    Realtime,
    /// The next cycle starts when every seat has said `done`
    Lockstep,
}

impl Clock {
    /// Returns it as the referee knows it.
    pub(crate) fn mode(self) -> ClockMode {
        match self {
            Self::Realtime => ClockMode::Realtime,
            Self::Lockstep => ClockMode::Lockstep,
        }
    }
}

#[derive(Debug, Args)]
pub(crate) struct Serve {
    /// A scenario; without it the shipped duel
    #[arg(long, value_name = "FILE")]
    pub(crate) scenario: Option<PathBuf>,
    /// Play on this map: .tmx or .map
    #[arg(long, value_name = "FILE")]
    pub(crate) map: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) configuration: ConfigurationArguments,
    /// How time passes
    #[arg(long, value_enum, default_value = "realtime")]
    pub(crate) clock: Clock,
    /// The seed of the first match; without it the scenario's; each further match has the next
    #[arg(long, value_name = "S")]
    pub(crate) seed: Option<u64>,
    #[command(flatten)]
    pub(crate) profile: ProfileArguments,
    /// Stop after one match
    #[arg(long)]
    pub(crate) once: bool,
    /// Where to write the replay of the match
    #[arg(long, value_name = "FILE", requires = "once", conflicts_with = "journal")]
    pub(crate) replay: Option<PathBuf>,
    /// Let clients create matches of this scenario, instead of playing one after the other; may be given several times
    #[arg(long, value_name = "FILE", conflicts_with_all = ["scenario", "map", "seed", "once", "clock"])]
    pub(crate) lobby: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) json: JsonFlag,
}

#[derive(Debug, Args)]
pub(crate) struct Bot {
    /// The bot, as `straight` or `commander`; an unknown name lists all
    pub(crate) name: String,
    /// Where the match runs
    #[arg(long, value_name = "ADDRESS", default_value = "127.0.0.1:7171")]
    pub(crate) connect: SocketAddr,
    #[command(flatten)]
    pub(crate) tls: TlsArguments,
    /// The number of the match, where the server has a lobby
    #[arg(long = "match", value_name = "NUMBER")]
    pub(crate) match_id: Option<Digest>,
    /// The token of the seat, as `maniple serve` prints it; without it any seat that is open to all
    #[arg(
        long,
        value_name = "T",
        env = "MANIPLE_TOKEN",
        hide_env_values = true,
        default_value = "",
        hide_default_value = true
    )]
    pub(crate) token: String,
    /// The seed of the match; the bot's own is made of it and of the seat, as `maniple match` does
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub(crate) seed: u64,
    #[command(flatten)]
    pub(crate) json: JsonFlag,
}

#[derive(Debug, Args)]
pub(crate) struct Watch {
    /// Where the match runs
    #[arg(long, value_name = "ADDRESS", default_value = "127.0.0.1:7171")]
    pub(crate) connect: SocketAddr,
    #[command(flatten)]
    pub(crate) tls: TlsArguments,
    /// The number of the match, where the server has a lobby
    #[arg(long = "match", value_name = "NUMBER")]
    pub(crate) match_id: Option<Digest>,
    /// The seat to watch; without it everything
    #[arg(long, value_name = "K")]
    pub(crate) seat: Option<u16>,
    /// Print the messages of the server instead of a line a cycle: a JSON line each, the keyframe first
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Subcommand)]
pub(crate) enum ReplayCommand {
    /// Print what was played, by whom, and how it ended
    #[command(after_help = "Example: maniple replay info duel.replay")]
    Info(ReplayFile),
    /// Play it again and compare the hash of every cycle; exit code 1 if one differs
    #[command(after_help = "Example: maniple replay verify duel.replay --json")]
    Verify(ReplayVerify),
    /// Write the whole state at a cycle, for `replay verify --snapshot` on another machine or build
    #[command(after_help = "Example: maniple replay snapshot duel.replay --cycle 100 --out duel.snapshot")]
    Snapshot(ReplaySnapshot),
    /// Print what a seat was told, cycle by cycle; or what a spectator of everything would have been told
    #[command(after_help = "Example: maniple replay view duel.replay --seat 0 --from 100 --to 120 --json")]
    View(ReplayView),
    /// Draw the match at a cycle, or what a seat saw of it
    #[command(after_help = "Example: maniple replay render duel.replay --cycle 100 --out duel.png --seat 0")]
    Render(ReplayRender),
}

#[derive(Debug, Args)]
pub(crate) struct ReplayFile {
    /// A replay
    pub(crate) file: PathBuf,
    #[command(flatten)]
    pub(crate) json: JsonFlag,
}

#[derive(Debug, Args)]
pub(crate) struct ReplayVerify {
    /// A replay
    pub(crate) file: PathBuf,
    /// The state of the same match at a cycle, elsewhere: objects and fields that differ from it are named
    #[arg(long, value_name = "FILE.snapshot")]
    pub(crate) snapshot: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) json: JsonFlag,
}

#[derive(Debug, Args)]
pub(crate) struct ReplaySnapshot {
    /// A replay
    pub(crate) file: PathBuf,
    /// The cycle at whose start the state is taken
    #[arg(long, value_name = "N")]
    pub(crate) cycle: u32,
    /// The snapshot to write
    #[arg(long, value_name = "FILE.snapshot")]
    pub(crate) out: PathBuf,
}

#[derive(Debug, Args)]
pub(crate) struct ReplayView {
    /// A replay
    pub(crate) file: PathBuf,
    /// The seat whose view it is; without it everything
    #[arg(long, value_name = "K")]
    pub(crate) seat: Option<u16>,
    /// The first cycle to print; it begins with the keyframe of this cycle
    #[arg(long, value_name = "C", default_value_t = 0)]
    pub(crate) from: u32,
    /// The last cycle to print; without it the end of the match
    #[arg(long, value_name = "C")]
    pub(crate) to: Option<u32>,
    /// Print the very messages that a client at the seat got as JSON lines, instead of a line a cycle
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, Args)]
pub(crate) struct ReplayRender {
    /// A replay
    pub(crate) file: PathBuf,
    /// Draw only what this seat saw: fog is dark, what it did not know is black
    #[arg(long, value_name = "K")]
    pub(crate) seat: Option<u16>,
    /// The cycle at whose start the match is drawn
    #[arg(long, value_name = "N")]
    pub(crate) cycle: u32,
    /// The picture to write
    #[arg(long, value_name = "FILE.png")]
    pub(crate) out: PathBuf,
    /// Pixels a tile; without it the picture gets about 1,024 pixels wide or high
    #[arg(long, value_name = "PIXELS", value_parser = clap::value_parser!(u32).range(1..=64))]
    pub(crate) scale: Option<u32>,
}

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

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number > 0.0 && number.is_finite() => Ok(number),
        Ok(number) => Err(format!("{number} is not a positive number of tiles")),
        Err(error) => Err(error.to_string()),
    }
}
