//! Every constant of a match that a client needs.

use glam::DVec2;
use maniple_tilemap::{Corner, Tile, TileMap, TileShape};
use serde::{Deserialize, Serialize};

use crate::identity::Seat;
use crate::profile::Positions;
use crate::unit_type::UnitType;

/// How time passes in a match.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ClockMode {
    /// So many cycles a second, whoever is late.
    Realtime,
    /// The next cycle starts when every seat has said `done`.
    Lockstep,
}

/// The rules of a match.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rules {
    /// The scenario's name.
    pub scenario: String,
    /// Cycles that the match lasts at most.
    pub cycles_max: u32,
    /// Names of the players, by seat; empty until one has come.
    pub players: Vec<String>,
    /// The unit types; an object's `unit_type` is the place in this list.
    pub unit_types: Vec<UnitType>,
    /// Who stops in a collision.
    pub stops: Stops,
    /// Distance above touching at which a colliding circle stops, in world units.
    pub skin: f64,
    /// Largest number of waypoints behind a motion.
    pub waypoints_max: u32,
    /// Largest number of a seat's commands that one cycle takes.
    pub commands_a_cycle_max: u32,
    /// What the match is about.
    pub objective: Objective,
    /// The team of each seat, in order of the seats. A team shares what it sees, and wins together.
    pub teams: Vec<u16>,
    /// Whether splash hurts objects of the same team, too.
    pub friendly_fire: bool,
    /// Largest number of objects of a seat.
    pub objects_max: u32,
    /// Largest number of units that a building trains or has waiting.
    pub training_max: u32,
    /// Whether there is fog; without it every seat sees everything.
    pub fog: bool,
    /// What terrain a seat knows.
    pub terrain: TerrainKnowledge,
    /// Whether walls hide what lies behind them from those on the ground.
    pub walls_block: bool,
    /// Whether an object that comes back into sight is known again.
    pub identity: Identity,
    /// How exact the positions are that a client is told.
    pub positions: Positions,
}

/// Who stops in a collision of two objects.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Stops {
    /// Both, if they move.
    #[default]
    Both,
    /// Only who moves towards the contact.
    Approaching,
}

/// Whether a player knows again what comes back into sight.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Identity {
    /// No: at each appearance an object of another seat gets a handle that was never used before.
    #[default]
    Fresh,
    /// Yes: it gets the handle that it had.
    Persistent,
}

/// What terrain a seat knows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TerrainKnowledge {
    /// All of it, from the start.
    #[default]
    Known,
    /// What its team has seen.
    Explored,
}

/// What a match is about.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Objective {
    /// The units of each seat must reach its zone.
    Race {
        /// The zone of each seat, in order of the seats.
        zones: Vec<Zone>,
    },
    /// Who gathers most.
    Resources {
        /// Resources with which a team wins at once; `None`: the match goes on to its length.
        goal: Option<u32>,
    },
    /// Who destroys most units; it ends when only one team has any.
    Kills,
    /// Who destroys most buildings; it ends when only one team has any.
    Buildings,
    /// Who is the last to have units or buildings.
    LastStanding,
    /// Whether a team still has units or buildings when the match is over.
    Survive {
        /// The team.
        team: u16,
    },
}

impl Objective {
    /// Returns the zone that the units of a seat have to reach; `None` where the match is about something else.
    #[must_use]
    pub fn zone_of(&self, seat: Seat) -> Option<Zone> {
        match self {
            Self::Race { zones } => zones.iter().find(|zone| zone.seat == seat).copied(),
            Self::Resources { .. }
            | Self::Kills
            | Self::Buildings
            | Self::LastStanding
            | Self::Survive { .. } => None,
        }
    }
}

/// A rectangle of the map that belongs to a seat.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Zone {
    /// The seat.
    pub seat: Seat,
    /// The corner with the smallest coordinates, in world units.
    pub min: DVec2,
    /// The corner with the largest coordinates, in world units.
    pub max: DVec2,
}

impl Zone {
    /// Returns whether a point lies in the zone; its border belongs to it.
    #[must_use]
    pub fn contains(&self, point: DVec2) -> bool {
        self.min.x <= point.x && point.x <= self.max.x && self.min.y <= point.y && point.y <= self.max.y
    }
}

/// What stands for a tile that is not known.
pub const UNKNOWN_TILE: char = '?';

/// What stands for tiles that are known.
pub(crate) const TILES_KNOWN: &str = ".@1234";

/// The terrain that a seat knows.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Terrain {
    /// Tiles to the right; a tile edge is one world unit.
    pub width: u32,
    /// Tiles down.
    pub height: u32,
    /// One text a row, one character a tile: `.` open, `@` blocked, and half-blocked tiles by the blocked
    /// corner: `1` north-west, `2` north-east, `3` south-west, `4` south-east; `?` is not known.
    pub tiles: Vec<String>,
    /// The walls as (x1, y1, x2, y2), the blocked side to the right.
    pub segments: Vec<(f64, f64, f64, f64)>,
}

impl Terrain {
    /// Returns the whole terrain of a map.
    #[must_use]
    pub fn of(map: &TileMap) -> Self {
        let row = |y| (0..map.width()).map(|x| character(map.tile(x, y))).collect();
        let wall = |segment: &maniple_geometry::Segment| {
            (segment.start.x, segment.start.y, segment.end.x, segment.end.y)
        };
        Self {
            width: map.width(),
            height: map.height(),
            tiles: (0..map.height()).map(row).collect(),
            segments: map.segments().iter().map(wall).collect(),
        }
    }

    /// Returns the map of the terrain as far as it is known, for those who plan: what is not known is open, and of walls that are no
    /// border of a tile only those are there that are known from the start. `None` where the terrain is no map.
    #[must_use]
    pub fn map(&self) -> Option<TileMap> {
        let shapes: Vec<TileShape> = self.tiles.iter().flat_map(|row| row.chars().map(shape)).collect();
        let tiles = TileMap::of_shapes(self.width, &shapes, Vec::new())?;
        let border = tiles.border();
        let is_known = self.tiles.iter().all(|row| !row.contains(UNKNOWN_TILE));
        let behind = self.segments.get(border.len()..).filter(|_| is_known).unwrap_or_default();
        let wall = |&(x1, y1, x2, y2): &(f64, f64, f64, f64)| {
            maniple_geometry::Segment::new(DVec2::new(x1, y1), DVec2::new(x2, y2))
        };
        TileMap::of_shapes(self.width, &shapes, behind.iter().map(wall).collect())
    }

    /// Returns terrain of which nothing is known but its size, in tiles.
    #[must_use]
    pub fn unknown(width: u32, height: u32) -> Self {
        let row = UNKNOWN_TILE.to_string().repeat(width as usize);
        Self { width, height, tiles: vec![row; height as usize], segments: Vec::new() }
    }

    /// Returns the character of a tile; `None` where it is not known, or outside of the map.
    #[must_use]
    pub fn tile(&self, x: u32, y: u32) -> Option<char> {
        let byte = *self.tiles.get(y as usize)?.as_bytes().get(x as usize)?;
        Some(char::from(byte)).filter(|&tile| tile != UNKNOWN_TILE)
    }
}

/// The opposite of [`character`]; what is not known is open.
fn shape(character: char) -> TileShape {
    match character {
        '@' => TileShape::Blocked,
        '1' => TileShape::Diagonal(Corner::Northwest),
        '2' => TileShape::Diagonal(Corner::Northeast),
        '3' => TileShape::Diagonal(Corner::Southwest),
        '4' => TileShape::Diagonal(Corner::Southeast),
        _ => TileShape::Open,
    }
}

fn character(tile: Tile) -> char {
    match tile.shape {
        TileShape::Open => '.',
        TileShape::Blocked => '@',
        TileShape::Diagonal(Corner::Northwest) => '1',
        TileShape::Diagonal(Corner::Northeast) => '2',
        TileShape::Diagonal(Corner::Southwest) => '3',
        TileShape::Diagonal(Corner::Southeast) => '4',
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec2;
    use maniple_geometry::Segment;
    use maniple_tilemap::{Corner, TileMap, TileShape};

    use super::Terrain;

    /// Every shape, and a wall of any angle.
    fn map() -> TileMap {
        let corners = [Corner::Northwest, Corner::Northeast, Corner::Southwest, Corner::Southeast];
        let shapes: Vec<TileShape> = [TileShape::Open, TileShape::Blocked]
            .into_iter()
            .chain(corners.map(TileShape::Diagonal))
            .collect();
        let wall = Segment::new(DVec2::new(0.25, 0.5), DVec2::new(0.75, 0.125));
        TileMap::of_shapes(3, &shapes, vec![wall]).unwrap()
    }

    #[test]
    fn the_map_of_a_whole_terrain_is_the_map_that_it_was_made_of() {
        let terrain = Terrain::of(&map());
        assert_eq!(terrain.tiles, [".@1", "234"]);
        assert_eq!(terrain.map(), Some(map()));
    }

    #[test]
    fn what_is_not_known_is_open_and_its_walls_are_not_there() {
        let mut terrain = Terrain::of(&map());
        terrain.tiles[0].replace_range(1..2, "?");
        let found = terrain.map().unwrap();
        assert_eq!(found.tile(1, 0).shape, TileShape::Open);
        assert_eq!(found.tile(2, 0), map().tile(2, 0));
        assert!(found.free_walls().is_empty());
        let unknown = Terrain::unknown(4, 3).map().unwrap();
        assert_eq!((unknown.width(), unknown.height()), (4, 3));
        assert!(unknown.tiles().iter().all(|tile| tile.shape == TileShape::Open));
    }

    #[test]
    fn terrain_that_is_no_map_has_none() {
        let with_rows = |width, rows: &[&str]| {
            let tiles = rows.iter().map(|&row| row.to_owned()).collect();
            Terrain { width, height: 2, tiles, segments: Vec::new() }
        };
        assert!(with_rows(2, &["..", ".."]).map().is_some());
        assert_eq!(with_rows(2, &["..", "."]).map(), None, "a row is too short");
        assert_eq!(with_rows(0, &[]).map(), None, "nothing at all");
        assert_eq!(Terrain::default().map(), None);
    }
}
