//! `maniple bench`: what the core can do on this machine.

mod march;
mod scale;

use crate::arguments::BenchCommand;
use crate::failure::Failure;

/// Runs `maniple bench`.
pub(crate) fn run(command: &BenchCommand) -> Result<(), Failure> {
    match command {
        BenchCommand::Scale(arguments) => scale::run(arguments),
    }
}
