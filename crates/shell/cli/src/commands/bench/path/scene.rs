//! Scenes for groups of units that go anywhere, not in step.

use std::collections::BTreeSet;

use anyhow::anyhow;
use clap::ValueEnum;
use glam::DVec2;
use maniple_pathfinding::{Goals, Ground, Group};
use maniple_tilemap::{Kind, Request, TileMap, TileShape, generate};

use crate::arguments::{BenchPath, GroupScene};
use crate::commands::bench::path::case::stem;
use crate::failure::Failure;
use crate::files;

/// Tiles before and behind a group.
const AROUND: usize = 5;

/// How thick the wall with a gap is, in tiles.
const THICK: usize = 3;

/// Width of the passages of a maze, as a radius of units that it is made for.
const MAZE_RADIUS: f64 = 0.7;

/// A map, and groups on it that go somewhere.
#[derive(Clone, Debug)]
pub(super) struct Scene {
    pub(super) name: String,
    pub(super) map: TileMap,
    pub(super) ground: Ground,
    pub(super) groups: Vec<Group>,
    /// The height of the middle of a gap that all pass downwards, if there is one.
    pub(super) gap: Option<f64>,
}

/// Returns the scenes for so many units: those that are asked for, or, on a map that is named, a group that crosses it.
pub(super) fn scenes(units: usize, arguments: &BenchPath) -> Result<Vec<Scene>, Failure> {
    if let Some(path) = &arguments.map {
        let map = files::map(path)?;
        return Ok(vec![across((stem(path), map), units, arguments)?]);
    }
    let side = units.isqrt() + usize::from(units.isqrt().pow(2) < units);
    let of = |scene: &GroupScene| match scene {
        GroupScene::Open => open(side, units, arguments),
        GroupScene::Gap1 => gap(1, (side, units), arguments),
        GroupScene::Gap2 => gap(2, (side, units), arguments),
        GroupScene::Gap3 => gap(3, (side, units), arguments),
        GroupScene::BothWays => both_ways((side, units), arguments),
        GroupScene::Maze => across(("maze".to_owned(), maze(side, arguments.seed)?), units, arguments),
        GroupScene::Corners => corners(side.div_ceil(2), units, arguments),
    };
    let scenes = if arguments.scenes.is_empty() { GroupScene::value_variants() } else { &arguments.scenes };
    scenes.iter().map(of).collect()
}

fn open(side: usize, units: usize, arguments: &BenchPath) -> Result<Scene, Failure> {
    let size = 3 * side + 2 * AROUND;
    let near = middle(AROUND, side);
    let far = size as f64 - near;
    let groups = vec![group(units, (side, DVec2::splat(near)), (side, DVec2::splat(far)))];
    scene("open", map(size, size, |_, _| true)?, groups, arguments)
}

fn gap(width: usize, (side, units): (usize, usize), arguments: &BenchPath) -> Result<Scene, Failure> {
    let (map, above, below) = rooms(width, (side, side))?;
    let gap = Some(0.5 * (above.y + below.y));
    let groups = vec![group(units, (side, above), (side, below))];
    Ok(Scene { gap, ..scene(&format!("gap-{width}"), map, groups, arguments)? })
}

/// Two groups of half the units that meet at a gap of two tiles.
fn both_ways((side, units): (usize, usize), arguments: &BenchPath) -> Result<Scene, Failure> {
    let (map, above, below) = rooms(2, (2 * side + AROUND, side))?;
    let columns = side.div_ceil(2);
    let aside = DVec2::new(0.5 * (columns + AROUND) as f64, 0.0);
    let half = units / 2;
    let groups = vec![
        group(half, (columns, above - aside), (columns, below - aside)),
        group(units - half, (columns, below + aside), (columns, above + aside)),
    ];
    scene("both-ways", map, groups, arguments)
}

fn corners(side: usize, units: usize, arguments: &BenchPath) -> Result<Scene, Failure> {
    let size = 4 * side + 6 * AROUND;
    let near = middle(AROUND, side);
    let far = size as f64 - near;
    let ends = [(near, near), (far, far), (far, near), (near, far)];
    let groups = (0..4).map(|corner: usize| {
        let (from, to) = (DVec2::from(ends[corner]), DVec2::from(ends[corner ^ 1]));
        group((units + corner) / 4, (side, from), (side, to))
    });
    let groups = groups.collect();
    scene("corners", map(size, size, |_, _| true)?, groups, arguments)
}

/// A group that crosses a map, in its largest region: from around the middle of a tile that is nearest to its upper left to around that
/// which is nearest to the lower right.
fn across((name, map): (String, TileMap), units: usize, arguments: &BenchPath) -> Result<Scene, Failure> {
    let ground = ground(&map, arguments)?;
    let regions = maniple_tilemap::regions(&map);
    let tiles = (0..map.height()).flat_map(|y| (0..map.width()).map(move |x| (x, y)));
    let has_room =
        |&(x, y): &(u32, u32)| regions.largest() == regions.label(x, y) && ground.holds(middle_of(x, y));
    let with_room: BTreeSet<(u32, u32)> = tiles.filter(has_room).collect();
    let by_corner = |&&(x, y): &&(u32, u32)| (x + y, x);
    let (first, last) = (with_room.iter().min_by_key(by_corner), with_room.iter().max_by_key(by_corner));
    let (starts, goals) = (around(&with_room, first, units), around(&with_room, last, units));
    if starts.len() < units || goals.len() < units || starts.iter().any(|start| goals.contains(start)) {
        return Err(Failure::usage(format!(
            "--units {units}: {name} has no room for so many at both ends; choose fewer"
        )));
    }
    let groups = vec![Group { starts, goals, whose: Goals::Interchangeable }];
    Ok(Scene { name, map, ground, groups, gap: None })
}

/// The middles of so many tiles that are reached first from one of them, or of all that are reached.
fn around(tiles: &BTreeSet<(u32, u32)>, first: Option<&(u32, u32)>, count: usize) -> Vec<DVec2> {
    let mut found: Vec<(u32, u32)> = first.copied().into_iter().collect();
    let mut is_found: BTreeSet<(u32, u32)> = found.iter().copied().collect();
    let mut next = 0;
    while let Some(&(x, y)) = found.get(next).filter(|_| found.len() < count) {
        next += 1;
        for tile in [(x + 1, y), (x.wrapping_sub(1), y), (x, y + 1), (x, y.wrapping_sub(1))] {
            if tiles.contains(&tile) && is_found.insert(tile) {
                found.push(tile);
            }
        }
    }
    found.truncate(count);
    found.into_iter().map(|(x, y)| middle_of(x, y)).collect()
}

fn middle_of(x: u32, y: u32) -> DVec2 {
    DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)
}

/// A room above and one below a wall with a gap, for groups so many columns wide and rows deep, and the middles of both rooms.
fn rooms(width: usize, (columns, rows): (usize, usize)) -> Result<(TileMap, DVec2, DVec2), Failure> {
    let across = columns + 2 * AROUND + (columns + width) % 2;
    let deep = rows + 2 * AROUND;
    let left = (across - width) / 2;
    let is_open =
        |x: usize, y: usize| !(deep..deep + THICK).contains(&y) || (left..left + width).contains(&x);
    let map = map(across, 2 * deep + THICK, is_open)?;
    let middle = DVec2::new(0.5 * across as f64, 0.5 * deep as f64);
    let below = middle + DVec2::new(0.0, (deep + THICK) as f64);
    Ok((map, middle, below))
}

fn maze(side: usize, seed: u64) -> Result<TileMap, Failure> {
    let size = u32::try_from(4 * side + 4 * AROUND).unwrap_or(u32::MAX).min(512);
    let request = Request {
        kind: Kind::Maze,
        width: size,
        height: size,
        players: 1,
        spawns: 1,
        clusters: 0,
        patches: 1,
        amount: 0,
        radius: MAZE_RADIUS,
    };
    generate(&request, seed).map_err(Failure::failed)
}

fn map(width: usize, height: usize, is_open: impl Fn(usize, usize) -> bool) -> Result<TileMap, Failure> {
    let shape = |open| if open { TileShape::Open } else { TileShape::Blocked };
    let tiles = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let shapes: Vec<TileShape> = tiles.map(|(x, y)| shape(is_open(x, y))).collect();
    let width = u32::try_from(width).unwrap_or(u32::MAX);
    let map = TileMap::of_shapes(width, &shapes, Vec::new());
    map.ok_or_else(|| Failure::usage("--units: the map of so many would be too large".to_owned()))
}

fn scene(name: &str, map: TileMap, groups: Vec<Group>, arguments: &BenchPath) -> Result<Scene, Failure> {
    let ground = ground(&map, arguments)?;
    let holds = |group: &Group| group.starts.iter().chain(&group.goals).all(|&point| ground.holds(point));
    if !groups.iter().all(holds) {
        return Err(Failure::bad_input(anyhow!("--radius: the units of {name} have no room")));
    }
    Ok(Scene { name: name.to_owned(), map, ground, groups, gap: None })
}

fn ground(map: &TileMap, arguments: &BenchPath) -> Result<Ground, Failure> {
    Ground::new(map, arguments.radius).map_err(Failure::bad_input)
}

/// So many units from one block to another; blocks by their columns and their middles.
fn group(units: usize, from: (usize, DVec2), to: (usize, DVec2)) -> Group {
    Group { starts: block(units, from), goals: block(units, to), whose: Goals::Interchangeable }
}

/// So many points in rows of so many columns, a tile apart.
fn block(units: usize, (columns, middle): (usize, DVec2)) -> Vec<DVec2> {
    let rows = units.div_ceil(columns.max(1));
    let first = middle - 0.5 * DVec2::new(columns as f64 - 1.0, rows as f64 - 1.0);
    let point = |unit: usize| first + DVec2::new((unit % columns) as f64, (unit / columns) as f64);
    (0..units).map(point).collect()
}

/// The middle of a group that is so wide, so far from an edge.
fn middle(before: usize, side: usize) -> f64 {
    before as f64 + 0.5 * side as f64
}
