//! Paths on real maps, for the queries that are published with them.

use std::io::Write;
use std::path::{Path, PathBuf};

use glam::DVec2;
use maniple_tilemap::{TileMap, read};

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

/// A query of a `.scen` file.
struct Query {
    from: DVec2,
    to: DVec2,
    /// The length of the shortest way on tiles, corners not cut.
    octile: f64,
}

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
        let queries = queries(&file);
        let stride = if is_long { 1 } else { queries.len().div_ceil(QUERIES) };
        let map = map_of(&file);
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
    for Query { from, to, octile } in queries {
        let legs = match planner.path(*from, *to) {
            Ok(legs) => legs,
            Err(error) => {
                assert!(is_of_another_map, "{}: {error}", file.display());
                let field = Field::new(&ground, *to);
                assert!(field.is_err() || field.unwrap().distance(&ground, *from).is_none(), "{error}");
                continue;
            }
        };
        assert!(is_walked(&mut world, RADIUS, *from, legs), "{}: {from} to {to}", file.display());
        let way = way(map, &ground, &mut search, (*from, *to));
        let points: Vec<DVec2> = way.iter().map(|&node| ground.lattice.point(node)).collect();
        let length = crate::length(*from, &points);
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

/// The map of `x.map.scen` is `x.map`, that of `x-random-1.scen` is `x.map`.
#[expect(clippy::disallowed_methods, reason = "real maps are files")]
fn map_of(scene: &Path) -> TileMap {
    let name = scene.file_stem().unwrap().to_string_lossy();
    let name = name.trim_end_matches(".map");
    let name = name.split("-random-").take(name.matches("-random-").count().max(1)).collect::<Vec<_>>();
    let file = scene.with_file_name(name.join("-random-") + ".map");
    let bytes = std::fs::read(&file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
    read("real.map", &bytes, &Nothing).unwrap()
}

#[expect(clippy::disallowed_methods, reason = "real maps are files")]
fn queries(scene: &Path) -> Vec<Query> {
    let text = std::fs::read_to_string(scene).unwrap();
    let middle =
        |x: &str, y: &str| DVec2::new(x.parse::<f64>().unwrap() + 0.5, y.parse::<f64>().unwrap() + 0.5);
    let query = |line: &str| {
        let fields: Vec<&str> = line.split_ascii_whitespace().collect();
        Query {
            from: middle(fields[4], fields[5]),
            to: middle(fields[6], fields[7]),
            octile: fields[8].parse().unwrap(),
        }
    };
    text.lines().skip(1).filter(|line| !line.trim().is_empty()).map(query).collect()
}
