//! The arguments of `maniple bench load`.

use std::path::PathBuf;

use clap::Args;

use crate::output::JsonFlag;

#[derive(Debug, Args)]
pub(crate) struct BenchLoad {
    /// Spectators, shared out among the matches
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = number(0, 20_000))]
    pub(crate) clients: usize,
    /// Matches at the same time, 1 or more, each of two bots over TCP
    #[arg(long, value_name = "M", default_value_t = 50, value_parser = number(1, 5_000))]
    pub(crate) matches: usize,
    /// Connections that stall, flood, talk nonsense, say nothing, or say a byte at a time, a fifth each
    #[arg(long, value_name = "K", default_value_t = 0, value_parser = number(0, 5_000))]
    pub(crate) hostile: usize,
    /// How long to measure, 0.1 to 86400 seconds
    #[arg(long, value_name = "S", default_value_t = 10.0, value_parser = within(0.1, 86_400.0))]
    pub(crate) seconds: f64,
    /// Cycles a second, 0.1 to 1000
    #[arg(long, value_name = "CYCLES", default_value_t = 8.0, value_parser = within(0.1, 1000.0))]
    pub(crate) rate: f64,
    /// Let the daemon keep journals of the matches in this folder
    #[arg(long, value_name = "FOLDER")]
    pub(crate) journal: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) json: JsonFlag,
}

/// Returns a parser of counts.
fn number(least: usize, most: usize) -> impl Fn(&str) -> Result<usize, String> + Clone {
    move |text| match text.parse() {
        Ok(number) if (least..=most).contains(&number) => Ok(number),
        Ok(_) | Err(_) => Err(format!("a whole number from {least} to {most} is needed")),
    }
}

/// Returns a parser of numbers.
fn within(least: f64, most: f64) -> impl Fn(&str) -> Result<f64, String> + Clone {
    move |text| match text.parse() {
        Ok(number) if (least..=most).contains(&number) => Ok(number),
        Ok(_) | Err(_) => Err(format!("a number from {least} to {most} is needed")),
    }
}
