//! The command `maniple`: serve, admin, match, bot, watch, conformance, replay, map, simulate, bench.

mod arguments;
mod commands;
mod configuration;
mod csv;
mod explain;
mod failure;
mod files;
mod headless;
mod interrupt;
mod logging;
mod models;
mod outcome;
mod output;
mod picture;
mod start;
mod told;

use std::process::ExitCode;

use clap::Parser;
use maniple_server::settings::Configuration;

use crate::arguments::{Arguments, BenchCommand, Command};
use crate::failure::Failure;

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    if let Err(failure) = begin(arguments) {
        eprintln!("{failure}");
        return failure.exit_code();
    }
    ExitCode::SUCCESS
}

fn begin(arguments: Arguments) -> Result<(), Failure> {
    let configuration = configuration::resolve(&arguments)?;
    logging::begin(&configuration)?;
    run(arguments.command, &configuration)
}

fn run(command: Command, configuration: &Configuration) -> Result<(), Failure> {
    if !minds_interrupts(&command) {
        interrupt::exit_when_interrupted();
    }
    match command {
        Command::Map(map) => commands::map::run(&map),
        Command::Simulate(simulate) => commands::simulate::run(&simulate),
        Command::Match(play) => commands::play::run(&play),
        Command::Serve(serve) => commands::serve::run(&serve, configuration),
        Command::Admin(admin) => commands::admin::run(&admin),
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
        Command::Serve(_) | Command::Bench(BenchCommand::Load(_)) => true,
        Command::Match(play) => play.many.count.is_some(),
        Command::Map(_)
        | Command::Simulate(_)
        | Command::Admin(_)
        | Command::Bot(_)
        | Command::Conformance(_)
        | Command::Watch(_)
        | Command::Replay(_)
        | Command::Bench(_) => false,
    }
}
