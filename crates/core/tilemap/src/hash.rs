//! One number for a whole map.

use glam::DVec2;
use twox_hash::XxHash3_64;

use crate::{Corner, TileMap, TileShape};

/// What the bytes begin with, so that another encoding gives other numbers.
const FORMAT: &[u8] = b"maniple tilemap 1";

/// Returns the xxh3-64 of the map in this encoding, all numbers little-endian: [`FORMAT`]; width, height;
/// the terrain names; per tile its shape and terrain, a byte each; spawns, resources, zones, free walls. Lists
/// and texts are preceded by their length in 8 bytes.
pub(crate) fn hash(map: &TileMap) -> u64 {
    let mut encoder = Encoder { bytes: FORMAT.to_vec() };
    encoder.number(map.width());
    encoder.number(map.height());
    encoder.length(map.terrains().len());
    for name in map.terrains() {
        encoder.text(name);
    }
    encoder.bytes.extend(map.tiles().iter().flat_map(|tile| [shape_byte(tile.shape), tile.terrain]));
    encoder.length(map.spawns().len());
    for spawn in map.spawns() {
        encoder.number(spawn.player);
        encoder.point(spawn.position);
    }
    encoder.length(map.resources().len());
    for resource in map.resources() {
        encoder.point(resource.position);
        encoder.number(resource.amount);
    }
    encoder.length(map.zones().len());
    for zone in map.zones() {
        encoder.text(&zone.name);
        // One more than the player, so that player 0 and nobody differ.
        encoder.number(zone.player.map_or(0, |player| player + 1));
        encoder.point(zone.area.min);
        encoder.point(zone.area.max);
    }
    encoder.length(map.free_walls().len());
    for wall in map.free_walls() {
        encoder.point(wall.start);
        encoder.point(wall.end);
    }
    XxHash3_64::oneshot(&encoder.bytes)
}

struct Encoder {
    bytes: Vec<u8>,
}

impl Encoder {
    fn number(&mut self, number: u32) {
        self.bytes.extend_from_slice(&number.to_le_bytes());
    }

    fn length(&mut self, length: usize) {
        self.bytes.extend_from_slice(&(length as u64).to_le_bytes());
    }

    fn text(&mut self, text: &str) {
        self.length(text.len());
        self.bytes.extend_from_slice(text.as_bytes());
    }

    fn point(&mut self, point: DVec2) {
        self.bytes.extend_from_slice(&point.x.to_le_bytes());
        self.bytes.extend_from_slice(&point.y.to_le_bytes());
    }
}

fn shape_byte(shape: TileShape) -> u8 {
    match shape {
        TileShape::Open => 0,
        TileShape::Blocked => 1,
        TileShape::Diagonal(Corner::Northwest) => 2,
        TileShape::Diagonal(Corner::Northeast) => 3,
        TileShape::Diagonal(Corner::Southwest) => 4,
        TileShape::Diagonal(Corner::Southeast) => 5,
    }
}
