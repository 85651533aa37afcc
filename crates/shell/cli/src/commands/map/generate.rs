//! `maniple map generate`: a map from a seed, as a file.

use maniple_tilemap::{TileMap, generate, write_map, write_tmx};
use serde::Serialize;

use crate::arguments::MapGenerate;
use crate::failure::Failure;
use crate::files;
use crate::output::{Format, grouped, print};

/// Runs `maniple map generate`.
pub(super) fn run(arguments: &MapGenerate) -> Result<(), Failure> {
    let write = writer(arguments)?;
    let map =
        generate(&arguments.request(), arguments.seed).map_err(|error| Failure::usage(error.to_string()))?;
    files::write(&arguments.out, write(&map)?.as_bytes())?;
    print(Format::of(&arguments.json), &Generated::of(&map, arguments), Generated::text)
}

/// Makes a file of a map.
type Writer = fn(&TileMap) -> Result<String, Failure>;

/// Returns what writes the format that the ending of the file names.
fn writer(arguments: &MapGenerate) -> Result<Writer, Failure> {
    let name = arguments.out.to_string_lossy().to_ascii_lowercase();
    if name.ends_with(".tmx") {
        return Ok(|map| Ok(write_tmx(map)));
    }
    if name.ends_with(".map") {
        return Ok(|map| write_map(map).map_err(|error| Failure::usage(error.to_string())));
    }
    let out = arguments.out.display();
    Err(Failure::usage(format!("--out {out}: a map's name ends in .tmx (Tiled) or .map (MovingAI)")))
}

/// What was made.
#[derive(Debug, Serialize)]
struct Generated {
    file: String,
    kind: &'static str,
    seed: u64,
    width: u32,
    height: u32,
    /// The share of the tiles that are open as a whole.
    open_share: f64,
    /// Wall segments.
    segments: usize,
    spawns: usize,
    patches: usize,
    /// The hash of the map, 16 hexadecimal digits.
    hash: String,
}

impl Generated {
    fn of(map: &TileMap, arguments: &MapGenerate) -> Self {
        let tiles = (0..map.height()).flat_map(|y| (0..map.width()).map(move |x| (x, y)));
        let open: f64 = tiles.filter(|&(x, y)| map.is_passable(x, y)).map(|_| 1.0).sum();
        Self {
            file: arguments.out.display().to_string(),
            kind: arguments.kind.name(),
            seed: arguments.seed,
            width: map.width(),
            height: map.height(),
            open_share: open / (f64::from(map.width()) * f64::from(map.height())),
            segments: map.segments().len(),
            spawns: map.spawns().len(),
            patches: map.resources().len(),
            hash: format!("{:016x}", map.hash()),
        }
    }

    fn text(&self) -> String {
        format!(
            "{}: {}, seed {}, {} x {} tiles, {:.1} % of them open\n\
             {} wall segments, {} spawns, {} patches; hash {}\n",
            self.file,
            self.kind,
            self.seed,
            self.width,
            self.height,
            100.0 * self.open_share,
            grouped(self.segments as u64),
            self.spawns,
            self.patches,
            self.hash,
        )
    }
}
