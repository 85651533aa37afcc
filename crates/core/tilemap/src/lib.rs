//! Tiles, readers for Tiled and MovingAI maps, and walls as the fewest segments.
//!
//! The world unit is the edge of a tile, x points right, y points down, and tile (x, y) covers
//! `[x, x + 1] x [y, y + 1]`. Nothing here opens a file: [`read`] takes bytes, and a [`Resolver`] for the files
//! that they refer to.

mod check;
mod error;
mod gaps;
mod hash;
mod map;
mod octile;
mod place;
mod read;
mod regions;
mod tile;
mod tmx;
mod walls;

pub use check::{Finding, FindingKind, check};
pub use error::MapError;
pub use map::{Area, Foreign, PLAYER_MAX, Resource, SIZE_MAX, Spawn, TileMap, Zone};
pub use place::place_far_apart;
pub use read::{Resolver, read};
pub use regions::{Regions, regions};
pub use tile::{Corner, Tile, TileShape};
pub use tmx::limits;
pub use walls::loops;
