//! What a path costs on real maps, in one thread: `cargo bench -p maniple-pathfinding`.
//!
//! One sample is one query of the file that is published with a map; the median is that over all queries. The maps are
//! looked for in the shared folder beside the checkout; where they are not, nothing is measured, and that is said.

use std::cell::RefCell;
use std::path::{Path, PathBuf};

use divan::{Bencher, black_box};
use glam::DVec2;
use maniple_pathfinding::{Field, Ground, Obstacle, Obstacles, Planner};
use maniple_tilemap::{Area, Resolver, TileMap, read, read_queries};

/// The radius of who goes.
const RADIUS: f64 = 0.35;

const MAPS: [&str; 3] = ["dao/den520d", "dao/brc202d", "sc1/Aurora"];

fn main() {
    divan::main();
}

/// From one point to another, legs included.
#[divan::bench(args = MAPS, sample_size = 1, sample_count = 3000)]
fn path(bencher: Bencher<'_, '_>, name: &str) {
    let Some((map, queries)) = load(name) else { return };
    let ground = Ground::new(&map, RADIUS).expect("the radius is one");
    let planner = RefCell::new(Planner::new(&ground));
    let turn = RefCell::new(queries.iter().cycle());
    bencher
        .with_inputs(|| *turn.borrow_mut().next().expect("there are queries"))
        .bench_local_values(|(from, to)| planner.borrow_mut().path(from, to).map(<[DVec2]>::len));
}

/// From one point to another where the distances to the goal are known.
#[divan::bench(args = MAPS, sample_size = 1, sample_count = 500)]
fn path_by_field(bencher: Bencher<'_, '_>, name: &str) {
    let Some((map, queries)) = load(name) else { return };
    let ground = Ground::new(&map, RADIUS).expect("the radius is one");
    let planner = RefCell::new(Planner::new(&ground));
    let field = Field::new(&ground, queries[queries.len() / 2].1).expect("the goal has room");
    let turn = RefCell::new(queries.iter().cycle());
    bencher
        .with_inputs(|| turn.borrow_mut().next().expect("there are queries").0)
        .bench_local_values(|from| planner.borrow_mut().path_by(&field, from).map(<[DVec2]>::len));
}

/// The distances to one goal.
#[divan::bench(args = MAPS, sample_size = 1, sample_count = 10)]
fn field(bencher: Bencher<'_, '_>, name: &str) {
    let Some((map, queries)) = load(name) else { return };
    let ground = Ground::new(&map, RADIUS).expect("the radius is one");
    bencher.bench_local(|| Field::new(&ground, black_box(queries[0].1)));
}

/// What is computed once for a map and a radius.
#[divan::bench(args = MAPS, sample_size = 1, sample_count = 10)]
fn ground(bencher: Bencher<'_, '_>, name: &str) {
    let Some((map, _)) = load(name) else { return };
    bencher.bench_local(|| Ground::new(black_box(&map), RADIUS));
}

/// A building of four by four tiles that comes and goes again in the middle of the map.
#[divan::bench(args = MAPS, sample_count = 100)]
fn building(bencher: Bencher<'_, '_>, name: &str) {
    let Some((map, _)) = load(name) else { return };
    let ground = Ground::new(&map, RADIUS).expect("the radius is one");
    let mut obstacles = Obstacles::new(&ground);
    let min = DVec2::new(f64::from(map.width() / 2), f64::from(map.height() / 2));
    let building = Obstacle::Rectangle(Area { min, max: min + 4.0 });
    bencher.bench_local(|| {
        obstacles.insert(1, black_box(building)).expect("it is on the map");
        obstacles.remove(1)
    });
}

/// No file refers to another.
struct Nothing;

impl Resolver for Nothing {
    fn resolve(&self, path: &str) -> Result<Vec<u8>, String> {
        Err(format!("there is no {path}"))
    }
}

/// How far apart queries are taken from a file, in which the short ones come first: a prime, so that all have their turn.
const STRIDE: usize = 7919;

/// Returns a map, and the start and the goal of each of its queries, short and long ones mixed.
#[expect(clippy::disallowed_methods, reason = "real maps are files")]
fn load(name: &str) -> Option<(TileMap, Vec<(DVec2, DVec2)>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../../shared/maps/movingai");
    let file = |ending: &str| -> PathBuf { folder.join(format!("{name}.{ending}")) };
    let (Ok(bytes), Ok(text)) = (std::fs::read(file("map")), std::fs::read(file("map.scen"))) else {
        eprintln!("SKIPPED: {name} is not at {}", folder.display());
        return None;
    };
    let map = read("real.map", &bytes, &Nothing).expect("the map is one");
    let middle = |(x, y): (u32, u32)| DVec2::new(f64::from(x), f64::from(y)) + 0.5;
    let queries = read_queries(&text).expect("the queries are such");
    let queries: Vec<_> = queries.iter().map(|query| (middle(query.start), middle(query.goal))).collect();
    Some((map, (0..queries.len()).map(|index| queries[index * STRIDE % queries.len()]).collect()))
}
