//! Tiles, readers and writers for Tiled and MovingAI maps, walls as the fewest segments, and maps from a seed.
//!
//! The world unit is the edge of a tile, x points right, y points down, and tile (x, y) covers
//! `[x, x + 1] x [y, y + 1]`. Nothing here opens a file: [`read`] takes bytes, and a [`Resolver`] for the files
//! that they refer to.

mod check;
mod error;
mod gaps;
mod generate;
mod hash;
mod map;
mod octile;
mod pieces;
mod place;
mod queries;
mod read;
mod regions;
mod tile;
mod tmx;
mod walls;
mod write;

pub use check::{Finding, FindingKind, check};
pub use error::MapError;
pub use generate::{
    GENERATED_AMOUNT_MAX, GENERATED_CLUSTERS_MAX, GENERATED_PATCHES_MAX, GENERATED_PLAYERS_MAX,
    GENERATED_RADIUS_MAX, GENERATED_SIDE_MAX, GENERATED_SIDE_MIN, GENERATED_SPAWNS_MAX, GenerateError, Kind,
    Request, generate,
};
pub use map::{Area, Foreign, PLAYER_MAX, Resource, SIZE_MAX, Spawn, TileMap, Zone};
pub use place::place_far_apart;
pub use queries::{Query, QueryError, read_queries};
pub use read::{Resolver, read};
pub use regions::{Regions, regions};
pub use tile::{Corner, Tile, TileShape};
pub use tmx::{limits, write_tmx};
pub use walls::loops;
pub use write::{WriteError, write_map};
