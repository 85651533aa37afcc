//! Where units start, and where they have to be.

use std::path::Path;

use anyhow::anyhow;
use maniple_pathfinding::Ground;
use maniple_pathfinding::in_step::{AGENTS_MAX, Board, scattered};
use maniple_tilemap::{TileMap, read_queries};

use crate::arguments::BenchPath;
use crate::failure::Failure;
use crate::files;

/// From where to where; columns and rows of tiles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Query {
    pub(super) start: (u32, u32),
    pub(super) goal: (u32, u32),
}

/// A map, and who goes where on it.
#[derive(Clone, Debug)]
pub(super) struct Case {
    pub(super) name: String,
    pub(super) map: TileMap,
    pub(super) ground: Ground,
    pub(super) queries: Vec<Query>,
}

/// Returns the cases that are asked for: one for each file of queries, or one with random ends.
pub(super) fn cases(arguments: &BenchPath) -> Result<Vec<Case>, Failure> {
    if !arguments.scen.is_empty() {
        return arguments.scen.iter().map(|scen| published(scen, arguments)).collect();
    }
    let (name, map) = match &arguments.map {
        Some(path) => (stem(path), files::map(path)?),
        None => ("choke".to_owned(), files::shipped_map()?),
    };
    let ground = ground(&map, arguments)?;
    let queries = random(&ground, arguments.seed)?;
    Ok(vec![Case { name, map, ground, queries }])
}

fn published(scen: &Path, arguments: &BenchPath) -> Result<Case, Failure> {
    let bytes = files::read(scen)?;
    let queries = read_queries(&bytes).map_err(|error| Failure::bad_input(error).within(scen))?;
    let first = queries.first().ok_or_else(|| Failure::bad_input(anyhow!("no query")).within(scen))?;
    let beside = Path::new(&first.map).file_name().unwrap_or_default();
    let path = arguments.map.clone().unwrap_or_else(|| scen.with_file_name(beside));
    let map = files::map(&path)?;
    let size = (map.width(), map.height());
    if let Some(query) = queries.iter().find(|query| query.size != size) {
        let text = format!(
            "the queries are for a map of {} x {} tiles, and {} has {} x {}; give the map that they are for with --map",
            query.size.0,
            query.size.1,
            path.display(),
            size.0,
            size.1
        );
        return Err(Failure::bad_input(anyhow!(text)).within(scen));
    }
    let ground = ground(&map, arguments)?;
    let query = |query: &maniple_tilemap::Query| Query { start: query.start, goal: query.goal };
    Ok(Case { name: stem(scen), map, ground, queries: queries.iter().map(query).collect() })
}

/// As many random ends as have room, each the start of one and the goal of one.
fn random(ground: &Ground, seed: u64) -> Result<Vec<Query>, Failure> {
    let board = Board::new(ground).map_err(Failure::bad_input)?;
    let (starts, goals) = scattered(&board, AGENTS_MAX, seed);
    let query = |(start, goal)| Query { start: board.tile(start), goal: board.tile(goal) };
    Ok(starts.into_iter().zip(goals).map(query).collect())
}

fn ground(map: &TileMap, arguments: &BenchPath) -> Result<Ground, Failure> {
    Ground::new(map, arguments.radius).map_err(Failure::bad_input)
}

/// The name of a file without folder and endings.
pub(super) fn stem(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let name = name.strip_suffix(".scen").unwrap_or(&name);
    name.strip_suffix(".map").or(name.strip_suffix(".tmx")).unwrap_or(name).to_owned()
}
