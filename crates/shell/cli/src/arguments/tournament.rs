//! How many matches are played, and what is kept of them.

use std::path::PathBuf;

use clap::Args;

/// Most matches of one run: each row is kept in memory, a million of them take some hundred megabytes.
const MATCHES_MAX: i64 = 1_000_000;

/// Most matches at the same time; more than there are processors gain nothing.
const JOBS_MAX: i64 = 256;

/// What `--help` says of many matches.
pub(super) const MATCH_HELP: &str = "\
With --count, bots switch seats: in a scenario of two seats, matches 0 and 1 have the first seed, S, and bots sit in each
other's seats in the second of them; matches 2 and 3 have the seed S + 1, and so on. With n seats there are n matches a
seed, in each of which every bot sits one seat further; with one seat each match has a seed of its own. Wins count for the
bot, and a second table says what each seat has won. Bots with the same name get numbers: straight (1), straight (2).

The interval of a win rate is that of Wilson (1927) at 95 %; draws count as played and not as won, and the score takes them
for half a win. What is behind +- is the standard deviation of the sample.
It takes matches for independent. Those of a pair share a seed and may not be: two bots that decide alike play the same match
twice, and then the interval should be read as if there were half as many.

A bot that panics resigns, and that counts as its crash; it is no failure of the command. A match that cannot be played is
told apart, counts for nobody, and makes the exit code 1. The interrupt key ends the run with what was played so far, and the
exit code 130. The result does not depend on --jobs: in --json all that does is under `timing`.

Columns of --csv: match (from 0), seed, winner (empty for a draw; of a team all, with + between them), reason, cycles, hash,
failure (why it could not be played), and for each seat, as in seat_0_player: player, won, points, late and refused
commands, crash. --json has the same under `matches`, and with --replays where each replay is.

Example: maniple match config/scenarios/duel.toml --bot straight --bot random --seed 7 --replay duel.replay
Example: maniple match --bot straight --bot random --count 1000 --csv matches.csv";

/// What is asked for of many matches.
#[derive(Debug, Args)]
#[command(next_help_heading = "Many matches")]
pub(crate) struct ManyArguments {
    /// Play K matches, with the seats switched, and count who wins; 1 to 1000000
    #[arg(long, value_name = "K", conflicts_with_all = ["replay", "explain"], value_parser = clap::value_parser!(u32).range(1..=MATCHES_MAX))]
    pub(crate) count: Option<u32>,
    /// Matches at the same time, each in one thread, 1 to 256; without it as many as there are processors
    #[arg(long, value_name = "J", requires = "count", value_parser = clap::value_parser!(u32).range(1..=JOBS_MAX))]
    pub(crate) jobs: Option<u32>,
    /// Write a row for each match into this file
    #[arg(long, value_name = "FILE", requires = "count")]
    pub(crate) csv: Option<PathBuf>,
    /// Write the replay of each match into this folder, which is made if it is not there: SEED-MATCH.replay
    #[arg(long, value_name = "DIR", requires = "count")]
    pub(crate) replays: Option<PathBuf>,
}
