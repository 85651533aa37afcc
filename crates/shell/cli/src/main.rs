//! The command `maniple`: serve, match, bot, watch, conformance, replay, map, simulate, bench.

mod arguments;
mod commands;
mod csv;
mod explain;
mod failure;
mod files;
mod headless;
mod interrupt;
mod models;
mod outcome;
mod output;
mod picture;
mod start;
mod told;

use std::io::IsTerminal;
use std::process::ExitCode;

use clap::Parser;

use crate::arguments::{Arguments, Command};
use crate::failure::Failure;

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    if let Err(failure) = log_to_stderr(&arguments.log).and_then(|()| run(arguments.command)) {
        eprintln!("{failure}");
        return failure.exit_code();
    }
    ExitCode::SUCCESS
}

fn run(command: Command) -> Result<(), Failure> {
    if !minds_interrupts(&command) {
        interrupt::exit_when_interrupted();
    }
    match command {
        Command::Map(map) => commands::map::run(&map),
        Command::Simulate(simulate) => commands::simulate::run(&simulate),
        Command::Match(play) => commands::play::run(&play),
        Command::Serve(serve) => commands::serve::run(&serve),
        Command::Bot(bot) => commands::bot::run(&bot),
        Command::Conformance(conformance) => commands::conformance::run(&conformance),
        Command::Watch(watch) => commands::watch::run(&watch),
        Command::Replay(replay) => commands::replay::run(&replay),
        Command::Bench(bench) => commands::bench::run(&bench),
    }
}

/// Returns whether a command has something to do when it is interrupted.
fn minds_interrupts(command: &Command) -> bool {
    match command {
        Command::Serve(_) => true,
        Command::Match(play) => play.many.count.is_some(),
        Command::Map(_)
        | Command::Simulate(_)
        | Command::Bot(_)
        | Command::Conformance(_)
        | Command::Watch(_)
        | Command::Replay(_)
        | Command::Bench(_) => false,
    }
}

fn log_to_stderr(filter: &str) -> Result<(), Failure> {
    let filter = tracing_subscriber::EnvFilter::try_new(filter)
        .map_err(|error| Failure::usage(format!("--log {filter:?}: {error}")))?;
    let is_plain = std::env::var_os("NO_COLOR").is_some_and(|wish| !wish.is_empty());
    let has_colours = std::io::stderr().is_terminal() && !is_plain;
    tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_ansi(has_colours)
        .with_writer(std::io::stderr)
        .init();
    Ok(())
}
