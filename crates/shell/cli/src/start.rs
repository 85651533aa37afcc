//! The start of a match, from files on disk or in the program.

use std::path::Path;

use anyhow::Context;
use maniple_game::{Loaded, load};
use maniple_referee::Referee;
use maniple_tilemap::Resolver;
use maniple_view::ClockMode;

use crate::failure::Failure;
use crate::files::{self, Disk, SHIPPED_SCENARIO};

/// Returns the start of a match; without a scenario that of the shipped one.
pub(crate) fn loaded(
    scenario: Option<&Path>,
    map: Option<&Path>,
    seed: Option<u64>,
) -> Result<Loaded, Failure> {
    let map = map.map(Path::to_string_lossy);
    match (scenario, map.as_deref()) {
        (Some(path), map) => load(&Disk, &path.to_string_lossy(), map, seed),
        (None, Some(map)) => load(&ShippedScenario, SHIPPED_SCENARIO, Some(map), seed),
        (None, None) => load(&files::shipped(), SHIPPED_SCENARIO, None, seed),
    }
    .map_err(Failure::bad_input)
}

/// Returns the referee of a match. Its errors name the files that the match is made of.
pub(crate) fn referee(loaded: Loaded, clock: ClockMode) -> Result<Referee, Failure> {
    let paths: Vec<String> = loaded.files.0.iter().take(2).map(|file| file.path.clone()).collect();
    let referee = Referee::new(loaded, clock).with_context(|| paths.join(" on "));
    referee.map_err(Failure::BadInput)
}

/// The shipped scenario from the program, and every other file from disk. What ships beside it does not count: the map
/// that is asked for may have the name of a shipped one, and so may its tilesets.
struct ShippedScenario;

impl Resolver for ShippedScenario {
    fn resolve(&self, path: &str) -> Result<Vec<u8>, String> {
        if path == SHIPPED_SCENARIO { files::shipped().resolve(path) } else { Disk.resolve(path) }
    }
}
