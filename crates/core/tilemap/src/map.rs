//! The map: tiles, and the things that lie on them.

use glam::DVec2;
use maniple_geometry::Segment;

use crate::{MapError, Tile, TileShape, hash, walls};

/// Largest width and height of a map, in tiles; it bounds every allocation before one is made.
pub const SIZE_MAX: u32 = 4096;

/// Largest number of a player that a map can name.
pub const PLAYER_MAX: u32 = 255;

/// Most different terrain names in one map, so that an index of them fits into a byte.
const TERRAINS_MAX: usize = 256;

/// Where objects of a player start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spawn {
    /// The player, `0..=PLAYER_MAX`.
    pub player: u32,
    /// The place, in world units, within the map.
    pub position: DVec2,
}

/// Something to be gathered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resource {
    /// The place, in world units, within the map.
    pub position: DVec2,
    /// How much there is.
    pub amount: u32,
}

/// A rectangle with its sides along the axes, in world units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Area {
    /// The upper left corner.
    pub min: DVec2,
    /// The lower right corner; both coordinates larger than those of `min`.
    pub max: DVec2,
}

impl Area {
    /// Returns whether the point lies in the rectangle or on its border.
    #[must_use]
    pub fn contains(&self, point: DVec2) -> bool {
        self.min.x <= point.x && point.x <= self.max.x && self.min.y <= point.y && point.y <= self.max.y
    }
}

/// A named part of the map.
#[derive(Clone, Debug, PartialEq)]
pub struct Zone {
    /// The name; may be empty.
    pub name: String,
    /// The player that it belongs to, `0..=PLAYER_MAX`; `None` where it belongs to nobody.
    pub player: Option<u32>,
    /// Where it is, within the map.
    pub area: Area,
}

/// An object of a Tiled map that nothing is made of.
#[derive(Clone, Debug, PartialEq)]
pub struct Foreign {
    /// Its id in the map.
    pub object: u32,
    /// Its place in world units, as written: it may lie outside of the map.
    pub position: DVec2,
    /// Why it is ignored.
    pub reason: String,
}

/// A map: `width x height` tiles, and what lies on them. Never changes.
#[derive(Clone, Debug, PartialEq)]
pub struct TileMap {
    width: u32,
    height: u32,
    tiles: Vec<Tile>,
    terrains: Vec<String>,
    spawns: Vec<Spawn>,
    resources: Vec<Resource>,
    zones: Vec<Zone>,
    free_walls: Vec<Segment>,
    foreign: Vec<Foreign>,
}

impl TileMap {
    /// Returns a map of nothing but tiles, row by row, and walls of any angle; `None` where the size is out of `1..=SIZE_MAX`, or not that of the
    /// tiles.
    #[must_use]
    pub fn of_shapes(width: u32, shapes: &[TileShape], free_walls: Vec<Segment>) -> Option<Self> {
        let height = u32::try_from(shapes.len()).ok()?.checked_div(width)?;
        let is_size = |size| (1..=SIZE_MAX).contains(&size);
        if !is_size(width) || !is_size(height) || shapes.len() != width as usize * height as usize {
            return None;
        }
        let mut builder = Builder::new(width, height);
        for (tile, &shape) in builder.map.tiles.iter_mut().zip(shapes) {
            tile.shape = shape;
        }
        builder.map.free_walls = free_walls;
        Some(builder.finish())
    }

    /// Returns the width in tiles, `1..=SIZE_MAX`.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Returns the height in tiles, `1..=SIZE_MAX`.
    #[must_use]
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Returns the tile in column `x` and row `y`.
    ///
    /// # Panics
    /// Outside of the map.
    #[must_use]
    pub fn tile(&self, x: u32, y: u32) -> Tile {
        assert!(x < self.width && y < self.height, "tile ({x}, {y}) is outside of the map");
        self.tiles[y as usize * self.width as usize + x as usize]
    }

    /// Returns the tiles row by row, from the upper left.
    #[must_use]
    pub fn tiles(&self) -> &[Tile] {
        &self.tiles
    }

    /// Returns whether the tile is open as a whole: a half-blocked tile is not, and neither is anything outside
    /// of the map.
    #[must_use]
    pub fn is_passable(&self, x: u32, y: u32) -> bool {
        x < self.width && y < self.height && self.tile(x, y).shape == TileShape::Open
    }

    /// Returns the tile that a point lies in; the one to the right of and below an edge. For a point outside of the
    /// map it is the nearest tile of the map.
    #[must_use]
    pub fn tile_at(&self, point: DVec2) -> (u32, u32) {
        (nearest_tile(point.x, self.width), nearest_tile(point.y, self.height))
    }

    /// Returns the names that [`Tile::terrain`] is an index of, sorted; the empty name is that of tiles without.
    #[must_use]
    pub fn terrains(&self) -> &[String] {
        &self.terrains
    }

    /// Returns where players start, by (player, y, x).
    #[must_use]
    pub fn spawns(&self) -> &[Spawn] {
        &self.spawns
    }

    /// Returns what can be gathered, by (y, x, amount).
    #[must_use]
    pub fn resources(&self) -> &[Resource] {
        &self.resources
    }

    /// Returns the zones, by (player, name, y, x); those of nobody come first.
    #[must_use]
    pub fn zones(&self) -> &[Zone] {
        &self.zones
    }

    /// Returns the walls of any angle, in the order of the file, from point to point as drawn. They have no
    /// inside: both sides of them are as open as the tiles there.
    #[must_use]
    pub fn free_walls(&self) -> &[Segment] {
        &self.free_walls
    }

    /// Returns how many objects of the file were ignored.
    #[must_use]
    pub fn foreign_objects(&self) -> u32 {
        u32::try_from(self.foreign.len()).unwrap_or(u32::MAX)
    }

    /// Returns the objects of the file that were ignored, in the order of the file.
    #[must_use]
    pub fn foreign(&self) -> &[Foreign] {
        &self.foreign
    }

    /// Returns the border between open and blocked as the fewest segments, the edge of the map being blocked.
    ///
    /// Each is a maximal straight run with the blocked side to the right of start to end, along the axes or, for
    /// half-blocked tiles, at 45 degrees. No part of the border is missing or there twice. Order: horizontal by
    /// (y, x), vertical by (x, y), then the diagonals that fall to the right by (x - y, y), then those that rise
    /// by (x + y, y), all of their upper or left end.
    #[must_use]
    pub fn border(&self) -> Vec<Segment> {
        walls::border(self)
    }

    /// Returns every wall: [`Self::border`], then [`Self::free_walls`].
    #[must_use]
    pub fn segments(&self) -> Vec<Segment> {
        let mut segments = self.border();
        segments.extend_from_slice(&self.free_walls);
        segments
    }

    /// Returns a number that two maps share only if they are the same to the game: the xxh3-64 of size, tiles
    /// with their terrain, spawns, resources, zones and free walls; not of ignored objects, nor of how the file
    /// was written.
    #[must_use]
    pub fn hash(&self) -> u64 {
        hash::hash(self)
    }
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the cast stops at both ends")]
fn nearest_tile(coordinate: f64, size: u32) -> u32 {
    (coordinate as u32).min(size - 1)
}

/// A map in the making.
pub(crate) struct Builder {
    map: TileMap,
}

impl Builder {
    /// Returns a map of open tiles without terrain; the size has been checked.
    pub(crate) fn new(width: u32, height: u32) -> Self {
        assert!((1..=SIZE_MAX).contains(&width));
        assert!((1..=SIZE_MAX).contains(&height));
        let open = Tile { shape: TileShape::Open, terrain: 0 };
        Self {
            map: TileMap {
                width,
                height,
                tiles: vec![open; width as usize * height as usize],
                terrains: vec![String::new()],
                spawns: Vec::new(),
                resources: Vec::new(),
                zones: Vec::new(),
                free_walls: Vec::new(),
                foreign: Vec::new(),
            },
        }
    }

    /// Returns the index of a terrain's name.
    pub(crate) fn terrain(&mut self, name: &str) -> Result<u8, MapError> {
        let terrains = &mut self.map.terrains;
        let index = terrains.iter().position(|known| known == name).unwrap_or(terrains.len());
        if index == terrains.len() && index < TERRAINS_MAX {
            terrains.push(name.to_owned());
        }
        u8::try_from(index).map_err(|_| MapError::TooMany {
            place: "map".to_owned(),
            what: "terrain names",
            found: TERRAINS_MAX as u64 + 1,
            limit: TERRAINS_MAX as u64,
        })
    }

    /// Lays a tile onto the ones that are there: blocked stays blocked, and the terrain, if any, is the new one.
    pub(crate) fn put(&mut self, x: u32, y: u32, shape: TileShape, terrain: Option<u8>) {
        let tile = &mut self.map.tiles[y as usize * self.map.width as usize + x as usize];
        tile.shape = tile.shape.united(shape);
        tile.terrain = terrain.unwrap_or(tile.terrain);
    }

    pub(crate) fn add_spawn(&mut self, spawn: Spawn) {
        self.map.spawns.push(spawn);
    }

    pub(crate) fn add_resource(&mut self, resource: Resource) {
        self.map.resources.push(resource);
    }

    pub(crate) fn add_zone(&mut self, zone: Zone) {
        self.map.zones.push(zone);
    }

    /// Adds a free wall and returns how many there are now.
    pub(crate) fn add_free_wall(&mut self, wall: Segment) -> usize {
        self.map.free_walls.push(wall);
        self.map.free_walls.len()
    }

    pub(crate) fn add_foreign(&mut self, foreign: Foreign) {
        self.map.foreign.push(foreign);
    }

    pub(crate) fn width(&self) -> u32 {
        self.map.width
    }

    /// Returns the map, everything in the order that its documentation promises.
    pub(crate) fn finish(mut self) -> TileMap {
        self.sort_terrains();
        let map = &mut self.map;
        map.spawns.sort_by(|a, b| a.player.cmp(&b.player).then(by_row(a.position, b.position)));
        map.resources.sort_by(|a, b| by_row(a.position, b.position).then(a.amount.cmp(&b.amount)));
        map.zones.sort_by(|a, b| {
            (a.player, &a.name)
                .cmp(&(b.player, &b.name))
                .then(by_row(a.area.min, b.area.min))
                .then(by_row(a.area.max, b.area.max))
        });
        self.map
    }

    /// Sorts the names of the terrains and drops those that no tile has, so that equal maps are equal however
    /// they were built.
    fn sort_terrains(&mut self) {
        let map = &mut self.map;
        let mut is_used = vec![false; map.terrains.len()];
        for tile in &map.tiles {
            is_used[tile.terrain as usize] = true;
        }
        let mut old: Vec<usize> = (0..map.terrains.len()).filter(|&index| is_used[index]).collect();
        old.sort_by(|&a, &b| map.terrains[a].cmp(&map.terrains[b]));
        let mut new = vec![0; map.terrains.len()];
        for (&index, place) in old.iter().zip(0..=u8::MAX) {
            new[index] = place;
        }
        for tile in &mut map.tiles {
            tile.terrain = new[tile.terrain as usize];
        }
        map.terrains = old.into_iter().map(|index| std::mem::take(&mut map.terrains[index])).collect();
    }
}

fn by_row(a: DVec2, b: DVec2) -> std::cmp::Ordering {
    a.y.total_cmp(&b.y).then(a.x.total_cmp(&b.x))
}

#[cfg(test)]
mod tests {
    use glam::DVec2;
    use maniple_geometry::Segment;

    use super::{SIZE_MAX, TileMap};
    use crate::{Corner, TileShape};

    const OPEN: TileShape = TileShape::Open;

    #[test]
    fn a_map_of_shapes_has_them_row_by_row_and_walls_behind_the_border() {
        let shapes = [OPEN, TileShape::Blocked, OPEN, OPEN, OPEN, TileShape::Diagonal(Corner::Southeast)];
        let wall = Segment::new(DVec2::new(0.25, 0.5), DVec2::new(0.75, 1.5));
        let map = TileMap::of_shapes(3, &shapes, vec![wall]).unwrap();
        assert_eq!((map.width(), map.height()), (3, 2));
        let found: Vec<TileShape> = (0..6).map(|tile| map.tile(tile % 3, tile / 3).shape).collect();
        assert_eq!(found, shapes);
        assert_eq!(map.free_walls(), [wall]);
        assert_eq!(map.segments().last(), Some(&wall));
        assert_eq!(map.segments().len(), map.border().len() + 1);
        assert_eq!(map.terrains(), [""], "no tile has terrain with a name");
        assert!(map.spawns().is_empty() && map.resources().is_empty() && map.zones().is_empty());
    }

    #[test]
    fn there_is_no_map_of_shapes_that_fill_no_rectangle_of_a_size_that_is_allowed() {
        let is_map = |width, tiles| TileMap::of_shapes(width, &vec![OPEN; tiles], Vec::new()).is_some();
        let most = SIZE_MAX as usize;
        for (width, tiles, expected) in [
            (1, 1, true),
            (3, 6, true),
            (3, 7, false),
            (3, 2, false),
            (3, 0, false),
            (0, 0, false),
            (0, 1, false),
            (SIZE_MAX, most, true),
            (SIZE_MAX + 1, most + 1, false),
            (1, most, true),
            (1, most + 1, false),
        ] {
            assert_eq!(is_map(width, tiles), expected, "{tiles} tiles {width} wide");
        }
    }
}
