//! The start of a match, from files on disk or in the program.

use std::path::Path;

use anyhow::Context;
use maniple_game::{Loaded, Overrides, load};
use maniple_referee::Referee;
use maniple_tilemap::Resolver;
use maniple_view::ClockMode;

use crate::failure::Failure;
use crate::files::{self, Disk, SHIPPED_SCENARIO};

/// Returns the start of a match; without a scenario that of the shipped one.
pub(crate) fn loaded(scenario: Option<&Path>, overrides: &Overrides) -> Result<Loaded, Failure> {
    match (scenario, &overrides.map) {
        (Some(path), _) => load(&Disk, &path.to_string_lossy(), overrides),
        (None, Some(_)) => load(&ShippedScenario, SHIPPED_SCENARIO, overrides),
        (None, None) => load(&files::shipped(), SHIPPED_SCENARIO, overrides),
    }
    .map_err(Failure::bad_input)
}

/// Returns the path of a map as files know it.
pub(crate) fn map_path(map: Option<&Path>) -> Option<String> {
    map.map(|map| map.to_string_lossy().into_owned())
}

/// Returns the referee of a match. Its errors name the files that the match is made of.
pub(crate) fn referee(loaded: Loaded, clock: ClockMode) -> Result<Referee, Failure> {
    let paths: Vec<String> = loaded.files.0.iter().map(|file| file.path.clone()).collect();
    let referee = Referee::new(loaded, clock).with_context(|| paths.join(", "));
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
