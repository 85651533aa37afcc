//! `maniple bench`: what a cycle costs, in time on this machine and in bytes.

mod absent;
mod broad;
mod load;
mod march;
mod path;
mod scale;
mod tradeoff;
mod wire;

use std::time::Duration;

use crate::arguments::BenchCommand;
use crate::failure::Failure;

/// Runs `maniple bench`.
pub(crate) fn run(command: &BenchCommand) -> Result<(), Failure> {
    match command {
        BenchCommand::Scale(arguments) => scale::run(arguments),
        BenchCommand::Broad(arguments) => broad::run(arguments),
        BenchCommand::Absent(arguments) => absent::run(arguments),
        BenchCommand::Tradeoff(arguments) => tradeoff::run(arguments),
        BenchCommand::Wire(arguments) => wire::run(arguments),
        BenchCommand::Load(arguments) => load::run(arguments),
        BenchCommand::Path(arguments) => path::run(arguments),
    }
}

/// Returns the failure of a scene in which only some find room.
fn too_dense(objects: u32, density: f64, found: u32) -> Failure {
    Failure::usage(format!(
        "--objects {objects} --density {density}: only {found} find room; choose a lower density"
    ))
}

/// Returns the median; the upper one of the two of an even number.
fn median(times: &mut [Duration]) -> Duration {
    times.sort_unstable();
    times[times.len() / 2]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_that_of_sorted_times() {
        let times = |millis: &[u64]| millis.iter().copied().map(Duration::from_millis).collect::<Vec<_>>();
        let check = |millis, expected| {
            assert_eq!(median(&mut times(millis)), Duration::from_millis(expected));
        };
        check(&[9], 9);
        check(&[9, 1, 5], 5);
        check(&[4, 1, 3, 2], 3);
    }
}
