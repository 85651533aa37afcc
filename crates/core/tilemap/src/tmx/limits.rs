//! How much a Tiled map may hold; each limit is checked before anything is allocated for it.

/// Most tiles in all layers of a map together: four layers of the largest size, or 256 of 512 x 512.
pub const LAYER_TILES_MAX: u64 = 1 << 26;

/// Most tilesets of a map.
pub const TILESETS_MAX: u64 = 64;

/// Most tiles of a tileset, and the bound of their ids: a picture of 128 x 128 tiles.
pub const TILESET_TILES_MAX: u32 = 16_384;

/// Deepest nesting of elements in a file; Tiled's own elements need 10, and 2 more per group in a group.
pub const DEPTH_MAX: u64 = 64;

/// Most attributes of an element; the richest one that Tiled writes has 20.
pub const ATTRIBUTES_MAX: usize = 64;

/// Largest size of a tile, its margin and its spacing, in pixels.
pub const TILE_PIXELS_MAX: u32 = 4096;

/// Largest size of a tileset's picture, in pixels.
pub const IMAGE_PIXELS_MAX: u32 = 1 << 20;

/// Most straight pieces of free walls in a map.
pub const FREE_WALLS_MAX: u64 = 16_384;
