//! Files in, start of a match out.

use std::cell::RefCell;
use std::sync::Arc;

use maniple_geometry::Cycle;
use maniple_tilemap::{GenerateError, MapError, Resolver, TileMap, generate};
use maniple_view::{Digest, Positions, Profile, Scalar, Solver, Terrain, TerrainKnowledge};
use thiserror::Error;
use twox_hash::XxHash3_64;

use crate::placement::{PlaceError, Setup};
use crate::scenario::{Draft, MapSource, Overrides, Problem, Scenario, ScenarioError, Source};

/// Most files that a match is made of: the scenario, its unit types, the map, and its tilesets.
pub const FILES_MAX: usize = 64;

/// The start of a match, and all that it was made of.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The scenario, with what was asked for instead.
    pub scenario: Arc<Scenario>,
    /// The map.
    pub map: Arc<TileMap>,
    /// The file that it was read from; `None`: it was made from the seed.
    pub map_path: Option<String>,
    /// What clients are told of the map at the start.
    pub terrain: Arc<Terrain>,
    /// Where everything stands.
    pub setup: Setup,
    /// Every file that was read, in the order of reading. [`load`] gives the same from these alone.
    pub files: Files,
}

impl Loaded {
    /// Lets the match last at most so many cycles instead of the scenario's length; at least one.
    pub fn limit_cycles(&mut self, cycles_max: Cycle) {
        assert!(cycles_max > Cycle(0), "a match lasts at least a cycle");
        Arc::make_mut(&mut self.scenario).cycles_max = cycles_max;
    }

    /// Returns a hash of all that the match is made of: matches with the same one can go on from the snapshots of each other.
    ///
    /// The xxh3-64 of the content of each file, then seed, rate, length, profile and the hash of the map, little-endian. Paths are
    /// left out: they name the same files from another place.
    #[must_use]
    pub fn origin(&self) -> Digest {
        let scenario = &self.scenario;
        let Profile { scalar, solver, certify, skin, positions } = scenario.profile;
        let solver = match solver {
            Solver::Event => 0,
            Solver::Stepped { substeps } => u64::from(substeps),
        };
        let positions = match positions {
            Positions::Exact => 0,
            Positions::Grid { bits } => 1 + u64::from(bits),
        };
        let mut words: Vec<u64> = self.files.0.iter().map(|file| XxHash3_64::oneshot(&file.bytes)).collect();
        words.extend([
            scenario.seed,
            scenario.rate.to_bits(),
            u64::from(scenario.cycles_max.0),
            u64::from(scalar == Scalar::F32),
            solver,
            u64::from(certify),
            skin.map_or(u64::MAX, f64::to_bits),
            positions,
            self.map.hash(),
        ]);
        let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
        Digest(XxHash3_64::oneshot(&bytes))
    }
}

/// A file as it was read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LoadedFile {
    /// The path by which it was asked for.
    pub path: String,
    /// Its content.
    pub bytes: Vec<u8>,
}

/// Files that are in memory: those of a replay, or of a test.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Files(pub Vec<LoadedFile>);

impl Resolver for Files {
    fn resolve(&self, path: &str) -> Result<Vec<u8>, String> {
        let file = self.0.iter().find(|file| file.path == path);
        file.map(|file| file.bytes.clone()).ok_or_else(|| "no such file is embedded".to_owned())
    }
}

/// Why a match could not be loaded.
#[derive(Debug, Error)]
pub enum LoadError {
    /// A file cannot be had.
    #[error("{path}: {problem}")]
    File {
        /// The file.
        path: String,
        /// Why.
        problem: String,
    },
    /// A file that the scenario names cannot be had.
    #[error("{path}: {problem}; {scenario} names it: mend the path there, or put the file in its place")]
    Named {
        /// The file.
        path: String,
        /// The file of the scenario.
        scenario: String,
        /// Why.
        problem: String,
    },
    /// A scenario or a file of unit types that is not UTF-8.
    #[error("{path}: not UTF-8 after byte {valid}")]
    NotText {
        /// The file.
        path: String,
        /// Bytes before the first that is none.
        valid: usize,
    },
    /// What is asked for instead of what the scenario says is wrong.
    #[error("instead of what {path} says: {problem}")]
    Override {
        /// The file of the scenario.
        path: String,
        /// What is wrong.
        problem: Problem,
    },
    /// The scenario is wrong.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// The map is wrong.
    #[error("{path}: {problem}")]
    Map {
        /// The file.
        path: String,
        /// What is wrong with it.
        problem: MapError,
    },
    /// No map of the kind that the scenario asks for can be made from the seed.
    #[error("{scenario}: [generate]: no map from seed {seed}: {problem}")]
    Generate {
        /// The file of the scenario.
        scenario: String,
        /// The seed of the match.
        seed: u64,
        /// Why.
        problem: GenerateError,
    },
    /// The units of the scenario do not fit on the map.
    #[error("{scenario} on {map}: {problem}")]
    Place {
        /// The file of the scenario.
        scenario: String,
        /// The file of the map, or from what seed it was made.
        map: String,
        /// What does not fit.
        problem: PlaceError,
    },
}

impl LoadError {
    /// Returns it with the scenario that names the file, if it is one that cannot be had.
    fn named_by(self, scenario: &str) -> Self {
        if let Self::File { path, problem } = self {
            Self::Named { path, scenario: scenario.to_owned(), problem }
        } else {
            self
        }
    }
}

/// Returns the start of the match of a scenario.
///
/// `files` gives the bytes for a path, from disk or from a replay.
///
/// # Errors
/// See [`LoadError`]; each names the file.
pub fn load(files: &dyn Resolver, scenario_path: &str, overrides: &Overrides) -> Result<Loaded, LoadError> {
    let recorder = Recorder { files, read: RefCell::default() };
    let text = recorder.read_text(scenario_path)?;
    overrides.check().map_err(|problem| LoadError::Override { path: scenario_path.to_owned(), problem })?;
    let draft = Draft::parse(Source { name: scenario_path, text: &text })?;
    let unit_paths: Vec<String> =
        draft.unit_files().map(|path| joined(folder(scenario_path), path)).collect();
    let unit_texts =
        unit_paths.iter().map(|path| recorder.read_text(path)).collect::<Result<Vec<String>, _>>();
    let unit_texts = unit_texts.map_err(|error| error.named_by(scenario_path))?;
    let sources: Vec<Source<'_>> =
        unit_paths.iter().zip(&unit_texts).map(|(name, text)| Source { name, text }).collect();
    let scenario = draft.checked(&sources, overrides)?;
    let (map, map_path) = match (&overrides.map, &scenario.map) {
        (None, MapSource::Generated(request)) => {
            let map = generate(request, scenario.seed).map_err(|problem| LoadError::Generate {
                scenario: scenario_path.to_owned(),
                seed: scenario.seed,
                problem,
            })?;
            (map, None)
        }
        (None, MapSource::File(path)) => {
            let path = joined(folder(scenario_path), path);
            let map = recorder.read_map(&path).map_err(|error| error.named_by(scenario_path))?;
            (map, Some(path))
        }
        (Some(path), _) => (recorder.read_map(path)?, Some(path.clone())),
    };
    let setup = Setup::new(&scenario, &map).map_err(|problem| LoadError::Place {
        scenario: scenario_path.to_owned(),
        map: map_path.clone().unwrap_or_else(|| format!("the map of seed {}", scenario.seed)),
        problem,
    })?;
    let terrain = Arc::new(match scenario.vision.map(|vision| vision.terrain) {
        None | Some(TerrainKnowledge::Known) => Terrain::of(&map),
        Some(TerrainKnowledge::Explored) => Terrain::unknown(map.width(), map.height()),
    });
    let files = Files(recorder.read.into_inner());
    Ok(Loaded { scenario: Arc::new(scenario), map: Arc::new(map), map_path, terrain, setup, files })
}

/// Remembers every file that was read.
struct Recorder<'a> {
    files: &'a dyn Resolver,
    read: RefCell<Vec<LoadedFile>>,
}

impl Recorder<'_> {
    fn read_text(&self, path: &str) -> Result<String, LoadError> {
        String::from_utf8(self.read(path)?).map_err(|error| LoadError::NotText {
            path: path.to_owned(),
            valid: error.utf8_error().valid_up_to(),
        })
    }

    fn read_map(&self, path: &str) -> Result<TileMap, LoadError> {
        let bytes = self.read(path)?;
        let beside = Beside { folder: folder(path), files: self };
        maniple_tilemap::read(path, &bytes, &beside)
            .map_err(|problem| LoadError::Map { path: path.to_owned(), problem })
    }

    fn read(&self, path: &str) -> Result<Vec<u8>, LoadError> {
        self.resolve(path).map_err(|problem| LoadError::File { path: path.to_owned(), problem })
    }
}

impl Resolver for Recorder<'_> {
    fn resolve(&self, path: &str) -> Result<Vec<u8>, String> {
        let bytes = self.files.resolve(path)?;
        let mut read = self.read.borrow_mut();
        if read.iter().all(|file| file.path != path) {
            if read.len() == FILES_MAX {
                return Err(format!("a match is made of more than {FILES_MAX} files"));
            }
            read.push(LoadedFile { path: path.to_owned(), bytes: bytes.clone() });
        }
        Ok(bytes)
    }
}

/// Resolves paths that are relative to a folder.
struct Beside<'a> {
    folder: &'a str,
    files: &'a dyn Resolver,
}

impl Resolver for Beside<'_> {
    fn resolve(&self, path: &str) -> Result<Vec<u8>, String> {
        self.files.resolve(&joined(self.folder, path))
    }
}

/// Returns the part of a path up to its last `/`; empty where it has none.
fn folder(path: &str) -> &str {
    path.rfind('/').map_or("", |slash| &path[..=slash])
}

/// Returns `path` as seen from `folder`, with `.` and `..` removed where that is possible. An absolute path stays.
fn joined(folder: &str, path: &str) -> String {
    if path.starts_with('/') {
        return path.to_owned();
    }
    let root = if folder.starts_with('/') { "/" } else { "" };
    let mut parts: Vec<&str> = Vec::new();
    for part in folder.split('/').chain(path.split('/')) {
        match part {
            "" | "." => {}
            ".." if parts.last().is_some_and(|&last| last != "..") => {
                parts.pop();
            }
            ".." if !root.is_empty() => {}
            part => parts.push(part),
        }
    }
    format!("{root}{}", parts.join("/"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_joined_as_a_shell_would() {
        let check = |from: &str, path: &str, expected: &str| {
            assert_eq!(joined(folder(from), path), expected, "{from} {path}");
        };
        check("config/scenarios/duel.toml", "../../maps/choke.tmx", "maps/choke.tmx");
        check("duel.toml", "choke.tmx", "choke.tmx");
        check("duel.toml", "../maps/choke.tmx", "../maps/choke.tmx");
        check("../a/duel.toml", "../../choke.tmx", "../../choke.tmx");
        check("/a/b/duel.toml", "./c/../choke.tmx", "/a/b/choke.tmx");
        check("/a/duel.toml", "../../choke.tmx", "/choke.tmx");
        check("a/duel.toml", "/maps/choke.tmx", "/maps/choke.tmx");
    }

    #[test]
    fn the_files_that_were_read_are_enough_to_load_it_again() {
        let files = crate::world::tests::files(
            "",
            "....\n....\n....\n....\n",
            "groups = [{ unit = 'a', count = 1 }]",
        );
        let asked =
            Overrides { seed: Some(9), rate: Some(2.0), scalar: Some(Scalar::F32), ..Overrides::default() };
        let first = load(&files, "s/tiny.toml", &asked).unwrap();
        let paths: Vec<&str> = first.files.0.iter().map(|file| file.path.as_str()).collect();
        assert_eq!(paths, ["s/tiny.toml", "m/tiny.map"]);
        let second = load(&first.files, "s/tiny.toml", &asked).unwrap();
        assert_eq!(first.setup, second.setup);
        assert_eq!(first.scenario, second.scenario);
        assert_eq!((first.scenario.seed, first.scenario.rate), (9, 2.0));
        assert_eq!(first.scenario.profile.scalar, Scalar::F32);
    }

    #[test]
    fn every_error_names_its_file() {
        let files = crate::world::tests::files(
            "",
            "....\n....\n....\n....\n",
            "groups = [{ unit = 'a', count = 1 }]",
        );
        let check = |path: &str, map: Option<&str>, expected: &str| {
            let asked = Overrides { map: map.map(str::to_owned), ..Overrides::default() };
            let error = load(&files, path, &asked).unwrap_err().to_string();
            assert!(error.starts_with(expected), "{error}");
        };
        check("none.toml", None, "none.toml: no such file");
        check("s/tiny.toml", Some("none.map"), "none.map: no such file");
        check("m/tiny.map", None, "m/tiny.map:1:");
        let lost = Files(files.0.iter().filter(|file| file.path != "m/tiny.map").cloned().collect());
        let error = load(&lost, "s/tiny.toml", &Overrides::default()).unwrap_err().to_string();
        assert!(error.starts_with("m/tiny.map: no such file is embedded; s/tiny.toml names it"), "{error}");
        let mut with_units = lost;
        let text = String::from_utf8(with_units.0[0].bytes.clone()).unwrap();
        with_units.0[0].bytes = format!("units = ['../u/none.toml']\n{text}").into_bytes();
        let error = load(&with_units, "s/tiny.toml", &Overrides::default()).unwrap_err().to_string();
        assert!(error.starts_with("u/none.toml: no such file is embedded; s/tiny.toml names it"), "{error}");
        check("s/tiny.toml", Some("s/tiny.toml"), "s/tiny.toml: ");
    }
}
