//! Paths on real maps, for the queries that are published with them.

use std::io::Write;
use std::path::{Path, PathBuf};

use glam::DVec2;
use maniple_tilemap::{Query, TileMap, read, read_queries};

use super::Nothing;
use super::walk::{is_walked, world};
use crate::jump::Search;
use crate::{Field, Ground, Planner};

/// Queries of each file in the ordinary run; `MANIPLE_LONG=1` takes all of them.
const QUERIES: usize = 12;

/// The radius of the walkers.
const RADIUS: f64 = 0.35;

/// A file whose queries begin and end in walls, too, and whose lengths are of ways through them: it belongs to another version of
/// the map. Its paths are walked all the same.
const OF_ANOTHER_MAP: &str = "wc3maps512/losttemple.map.scen";

/// The shared real maps; `None` where they are not, and then that is said, with what was not tested.
#[expect(clippy::disallowed_methods, reason = "real maps are files")]
pub(crate) fn shared_maps(what: &str) -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../../shared/maps/movingai");
    if folder.is_dir() {
        return Some(folder);
    }
    let said =
        writeln!(std::io::stderr(), "SKIPPED: no maps at {}; {what} were not tested", folder.display());
    said.expect("standard error takes a line");
    None
}

/// Every query of every file is walked; and the search finds ways of the length that the file says.
#[test]
#[expect(clippy::disallowed_methods, reason = "a test may look at its environment")]
fn paths_for_published_queries_are_walked_without_a_collision() {
    let Some(folder) = shared_maps("paths on real maps") else { return };
    let is_long = std::env::var_os("MANIPLE_LONG").is_some();
    let files = scenes_in(&folder);
    assert!(files.len() >= 20, "only {} files of queries", files.len());
    let mut walked = 0;
    for file in files {
        let (map, queries) = load(&file);
        let stride = if is_long { 1 } else { queries.len().div_ceil(QUERIES) };
        let chosen: Vec<&Query> = queries.iter().step_by(stride).collect();
        check(&map, &chosen, &file);
        walked += chosen.len();
    }
    println!("{walked} paths");
}

fn check(map: &TileMap, queries: &[&Query], file: &Path) {
    let ground = Ground::new(map, RADIUS).unwrap();
    let mut world = world(map, RADIUS);
    let mut planner = Planner::new(&ground);
    let mut search = Search::default();
    let is_of_another_map = file.ends_with(OF_ANOTHER_MAP);
    for Query { start, goal, length: octile, .. } in queries {
        let (from, to) = (middle(*start), middle(*goal));
        let legs = match planner.path(from, to) {
            Ok(legs) => legs,
            Err(error) => {
                assert!(is_of_another_map, "{}: {error}", file.display());
                let field = Field::new(&ground, to);
                assert!(field.is_err() || field.unwrap().distance(&ground, from).is_none(), "{error}");
                continue;
            }
        };
        assert!(is_walked(&mut world, RADIUS, from, legs), "{}: {from} to {to}", file.display());
        let way = way(map, &ground, &mut search, (from, to));
        let points: Vec<DVec2> = way.iter().map(|&node| ground.lattice.point(node)).collect();
        let length = crate::length(from, &points);
        let is_as_said = (length - octile).abs() <= 1e-4 * octile + 1e-3;
        assert!(is_as_said || is_of_another_map, "{}: {length} {octile}", file.display());
    }
}

fn way(map: &TileMap, ground: &Ground, search: &mut Search, (from, to): (DVec2, DVec2)) -> Vec<u32> {
    let node = |point: DVec2| {
        let (x, y) = map.tile_at(point);
        ground.lattice.node(x, y)
    };
    let mut way = Vec::new();
    search.find(&ground.lattice, node(from), node(to), &mut way);
    way
}

#[expect(clippy::disallowed_methods, reason = "real maps are files")]
pub(crate) fn scenes_in(folder: &Path) -> Vec<PathBuf> {
    let mut scenes = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|ending| ending == "scen") {
            scenes.push(path);
        } else if path.extension().is_none() {
            scenes.extend(scenes_in(&path));
        }
    }
    scenes.sort();
    scenes
}

/// The queries of a file and their map, which is beside it.
#[expect(clippy::disallowed_methods, reason = "real maps are files")]
pub(crate) fn load(scene: &Path) -> (TileMap, Vec<Query>) {
    let bytes =
        |file: &Path| std::fs::read(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
    let queries = read_queries(&bytes(scene)).unwrap_or_else(|error| panic!("{}: {error}", scene.display()));
    let name = Path::new(&queries[0].map).file_name().unwrap();
    let map = read("real.map", &bytes(&scene.with_file_name(name)), &Nothing).unwrap();
    (map, queries)
}

/// The middle of a tile.
pub(crate) fn middle((x, y): (u32, u32)) -> DVec2 {
    DVec2::new(f64::from(x), f64::from(y)) + 0.5
}
