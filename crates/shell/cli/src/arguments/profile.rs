//! What is asked for instead of what the scenario says, in speed against accuracy.

use std::ops::RangeInclusive;

use clap::{Args, ValueEnum};
use maniple_game::Overrides;
use maniple_game::scenario::{RATE_MAX, RATE_MIN};
use maniple_view::{GRID_BITS_MAX, Positions, SKIN_MAX, SUBSTEPS_MAX, Scalar, Solver};

use crate::failure::Failure;

/// What accuracy is traded with; without a flag the scenario says. What is played goes into the replay.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "Speed against accuracy")]
pub(crate) struct ProfileArguments {
    /// Cycles a second; units keep their speed a second. Fewer are cheaper, and commands wait longer
    #[arg(long, value_name = "CYCLES", value_parser = rate)]
    rate: Option<f64>,
    /// The numbers that kinematics runs in
    #[arg(long, value_enum)]
    scalar: Option<ScalarName>,
    /// How collisions are found: at their exact time, or by looking --substeps times a cycle
    #[arg(long, value_enum)]
    solver: Option<SolverName>,
    /// How often a cycle to look, 1 to 1000; only with --solver stepped
    #[arg(long, value_name = "K", requires = "solver", value_parser = clap::value_parser!(u32).range(1..=i64::from(SUBSTEPS_MAX)))]
    substeps: Option<u32>,
    /// Whether each cycle ends with the proof that nobody overlaps
    #[arg(long, value_enum)]
    certify: Option<Switch>,
    /// Distance above touching at which a colliding unit stops, 0 to 1 world units
    #[arg(long, value_name = "UNITS", allow_negative_numbers = true, value_parser = skin)]
    skin: Option<f64>,
    /// What clients are told of positions: doubles, or multiples of 2^-BITS world units
    #[arg(long, value_enum)]
    positions: Option<PositionsName>,
    /// Binary digits behind the point, 0 to 20; only with --positions grid
    #[arg(long, value_name = "BITS", requires = "positions", value_parser = clap::value_parser!(u8).range(..=i64::from(GRID_BITS_MAX)))]
    grid_bits: Option<u8>,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum ScalarName {
    /// Doubles
    F64,
    /// Single precision
    F32,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum SolverName {
    /// At their exact time
    Event,
    /// By looking now and then
    Stepped,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Switch {
    /// It does
    On,
    /// It does not
    Off,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum PositionsName {
    /// Doubles
    Exact,
    /// Multiples of 2^-BITS
    Grid,
}

impl ProfileArguments {
    /// Returns what is asked for.
    pub(crate) fn overrides(&self) -> Result<Overrides, Failure> {
        Ok(Overrides {
            rate: self.rate,
            scalar: self.scalar.map(|scalar| match scalar {
                ScalarName::F64 => Scalar::F64,
                ScalarName::F32 => Scalar::F32,
            }),
            solver: self.solver()?,
            certify: self.certify.map(|certify| match certify {
                Switch::On => true,
                Switch::Off => false,
            }),
            skin: self.skin,
            positions: self.positions()?,
            ..Overrides::default()
        })
    }

    /// Returns the flags that were given, each with a space before it.
    pub(crate) fn flags(&self) -> String {
        fn named<E: ValueEnum>(choice: Option<E>) -> Option<String> {
            choice.and_then(|choice| choice.to_possible_value()).map(|value| value.get_name().to_owned())
        }
        let flags = [
            ("--rate", self.rate.map(|rate| rate.to_string())),
            ("--scalar", named(self.scalar)),
            ("--solver", named(self.solver)),
            ("--substeps", self.substeps.map(|substeps| substeps.to_string())),
            ("--certify", named(self.certify)),
            ("--skin", self.skin.map(|skin| skin.to_string())),
            ("--positions", named(self.positions)),
            ("--grid-bits", self.grid_bits.map(|bits| bits.to_string())),
        ];
        flags.into_iter().filter_map(|(flag, value)| value.map(|value| format!(" {flag} {value}"))).collect()
    }

    fn solver(&self) -> Result<Option<Solver>, Failure> {
        match (self.solver, self.substeps) {
            (None, _) => Ok(None),
            (Some(SolverName::Event), None) => Ok(Some(Solver::Event)),
            (Some(SolverName::Event), Some(_)) => Err(pointless("--substeps", "--solver stepped")),
            (Some(SolverName::Stepped), Some(substeps)) => Ok(Some(Solver::Stepped { substeps })),
            (Some(SolverName::Stepped), None) => {
                Err(incomplete("--solver stepped", "--substeps", u64::from(SUBSTEPS_MAX)))
            }
        }
    }

    fn positions(&self) -> Result<Option<Positions>, Failure> {
        match (self.positions, self.grid_bits) {
            (None, _) => Ok(None),
            (Some(PositionsName::Exact), None) => Ok(Some(Positions::Exact)),
            (Some(PositionsName::Exact), Some(_)) => Err(pointless("--grid-bits", "--positions grid")),
            (Some(PositionsName::Grid), Some(bits)) => Ok(Some(Positions::Grid { bits })),
            (Some(PositionsName::Grid), None) => {
                Err(incomplete("--positions grid", "--grid-bits", u64::from(GRID_BITS_MAX)))
            }
        }
    }
}

fn pointless(flag: &str, choice: &str) -> Failure {
    Failure::usage(format!("{flag} means nothing without {choice}; leave it out, or choose that"))
}

fn incomplete(choice: &str, flag: &str, max: u64) -> Failure {
    Failure::usage(format!("{choice} needs {flag}, at most {max}; add it"))
}

fn rate(text: &str) -> Result<f64, String> {
    within(text, RATE_MIN..=RATE_MAX)
}

fn skin(text: &str) -> Result<f64, String> {
    within(text, 0.0..=SKIN_MAX)
}

fn within(text: &str, range: RangeInclusive<f64>) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if range.contains(&number) && (number != 0.0 || number.is_sign_positive()) => Ok(number),
        Ok(number) => Err(format!("{number} is not in {} to {}", range.start(), range.end())),
        Err(error) => Err(error.to_string()),
    }
}
