//! The command line.

mod admin;
mod bench;
mod configuration;
mod conformance;
mod generate;
mod profile;
mod tls;
mod tournament;

use std::net::SocketAddr;
use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use maniple_view::ClockMode;
use maniple_view::Digest;

use crate::output::JsonFlag;
pub(crate) use admin::Admin;
pub(crate) use bench::{
    BenchAbsent, BenchBroad, BenchCommand, BenchLoad, BenchPath, BenchScale, BenchTradeoff, BenchWire,
    GroupScene,
};
pub(crate) use configuration::ConfigurationArguments;
pub(crate) use conformance::{ConformanceCommand, ConformanceServe};
pub(crate) use generate::MapGenerate;
pub(crate) use profile::ProfileArguments;
pub(crate) use tls::TlsArguments;
pub(crate) use tournament::ManyArguments;

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

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number > 0.0 && number.is_finite() => Ok(number),
        Ok(number) => Err(format!("{number} is not a positive number of tiles")),
        Err(error) => Err(error.to_string()),
    }
}
