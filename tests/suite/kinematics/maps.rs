//! Nothing overlaps, ever, and nobody goes through a wall, on the maps that ship.

use glam::DVec2;
use maniple_geometry::{ObjectId, Segment};
use maniple_kinematics::WallKind;
use maniple_tilemap::{TileMap, TileShape};

use super::march::{Field, March, wall};
use crate::maps::{load, maps_in, root};

/// Objects times cycles on each map in the ordinary run; `MANIPLE_LONG=1` makes it a million.
const OBJECT_CYCLES: u32 = 100_000;

/// Passable tiles for each circle: a quarter of the ground is covered.
const TILES_AN_OBJECT: usize = 2;

#[test]
fn k1_holds_exactly_after_every_cycle_on_each_shipped_map() {
    let seed = 19;
    println!("seed {seed}");
    let wanted = if std::env::var_os("MANIPLE_LONG").is_some() { 10 * OBJECT_CYCLES } else { OBJECT_CYCLES };
    for file in maps_in(&root().join("maps")) {
        let (map, name) = (load(&file), file.display());
        let field = field(&map);
        let tiles = map.tiles().iter().filter(|tile| tile.shape == TileShape::Open).count();
        let objects = u32::try_from(tiles / TILES_AN_OBJECT).expect("a small map");
        let places = field.places(objects, seed, |center| shape(&map, center) == TileShape::Open);
        let mut march = March::new(&field, &places, seed);
        let cycles = wanted.div_ceil(objects);
        println!("{name}: {objects} objects, {cycles} cycles");
        for cycle in 0..cycles {
            march.order();
            march.step();
            assert_eq!(march.world.overlaps(), [], "{name}, after cycle {cycle}");
            for id in (0..objects).map(ObjectId) {
                let center = march.world.circle(id).expect("the object is there").center;
                let shape = shape(&map, center);
                assert_ne!(
                    shape,
                    TileShape::Blocked,
                    "{name}, after cycle {cycle}: {id} is in rock at {center}"
                );
            }
        }
    }
}

fn shape(map: &TileMap, point: DVec2) -> TileShape {
    let (x, y) = map.tile_at(point);
    map.tile(x, y).shape
}

fn field(map: &TileMap) -> Field {
    let size = DVec2::new(f64::from(map.width()), f64::from(map.height()));
    let kind = |Segment { start, end }: &Segment| {
        let is_at = |a: f64, b: f64, size: f64| a == b && (a == 0.0 || a == size);
        let is_edge = is_at(start.x, end.x, size.x) || is_at(start.y, end.y, size.y);
        if is_edge { WallKind::Edge } else { WallKind::Segment }
    };
    let walls = map.segments().into_iter().map(|segment| wall(segment.start, segment.end, kind(&segment)));
    Field { size, walls: walls.collect() }
}
