//! Being written.

use crate::failure::Failure;

pub(crate) fn run(_arguments: &crate::arguments::Serve) -> Result<(), Failure> {
    Err(Failure::usage(String::new()))
}
