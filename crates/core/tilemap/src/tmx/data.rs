//! The tiles of a layer as the file has them: counted and checked, so that the Tiled reader can take them.

use std::io::Read;

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::general_purpose::{GeneralPurpose, PAD};
use flate2::bufread::{GzDecoder, ZlibDecoder};

use super::scan::Frame;
use crate::MapError;

/// The bits of a global tile id that say how the tile is flipped.
const FLIPS: u32 = 0xE000_0000;

/// A layer whose tiles are checked.
#[derive(Clone, Debug, Default)]
pub(crate) struct LayerHead {
    /// The name of the layer.
    pub(crate) name: String,
    /// The `encoding` of its data, where it has one.
    pub(crate) encoding: Option<String>,
    /// The `compression` of its data, where it has one.
    pub(crate) compression: Option<String>,
}

/// Checks that the data of a layer can be decoded, has as many tiles as the map, and no id below those of
/// all tilesets. No more is decoded than the map can have.
pub(crate) fn check(layer: &LayerHead, text: &str, frame: &Frame, first_ids: &[u32]) -> Result<(), MapError> {
    let expected = frame.width as usize * frame.height as usize;
    let ids = decode(layer, text, frame)?;
    let (x, y) = (ids.len() % frame.width as usize, ids.len() / frame.width as usize);
    if ids.len() < expected {
        return Err(count_error(layer, ids.len(), expected, ("missing", x, y)));
    }
    if ids.len() > expected {
        return Err(count_error(layer, ids.len(), expected, ("too many", 0, frame.height as usize)));
    }
    let least = first_ids.first().copied().unwrap_or(u32::MAX);
    for (y, row) in (0..frame.height).zip(ids.chunks(frame.width as usize)) {
        for (x, id) in (0..frame.width).zip(row) {
            let id = id & !FLIPS;
            if id != 0 && id < least {
                return Err(MapError::UnknownTile { layer: layer.name.clone(), x, y, id });
            }
        }
    }
    Ok(())
}

fn count_error(
    layer: &LayerHead,
    found: usize,
    expected: usize,
    (problem, x, y): (&'static str, usize, usize),
) -> MapError {
    MapError::TileCount { layer: layer.name.clone(), found, expected, problem, x, y }
}

/// Returns the global ids, at most one more than the map has tiles.
fn decode(layer: &LayerHead, text: &str, frame: &Frame) -> Result<Vec<u32>, MapError> {
    match (layer.encoding.as_deref(), layer.compression.as_deref()) {
        (Some("csv"), None) => decode_csv(layer, text, frame),
        (Some("base64"), None) => ids(layer, &decode_base64(layer, text)?[..], frame),
        (Some("base64"), Some("zlib")) => {
            ids(layer, ZlibDecoder::new(&decode_base64(layer, text)?[..]), frame)
        }
        (Some("base64"), Some("gzip")) => ids(layer, GzDecoder::new(&decode_base64(layer, text)?[..]), frame),
        (encoding, compression) => {
            let words = [encoding.unwrap_or("XML"), compression.unwrap_or("")];
            let found = words.join(" ").trim_end().to_owned();
            Err(MapError::LayerFormat { layer: layer.name.clone(), found })
        }
    }
}

fn decode_csv(layer: &LayerHead, text: &str, frame: &Frame) -> Result<Vec<u32>, MapError> {
    let mut ids = Vec::new();
    let width = frame.width as usize;
    for cell in text.split(',').take(width * frame.height as usize + 1) {
        let cell = cell.trim();
        let id = cell.parse().map_err(|_| {
            let (x, y) = (ids.len() % width, ids.len() / width);
            let cell: String = cell.chars().take(20).collect();
            let reason = format!("tile ({x}, {y}) is {cell:?}; it must be a number");
            MapError::LayerData { layer: layer.name.clone(), reason }
        })?;
        ids.push(id);
    }
    Ok(ids)
}

fn decode_base64(layer: &LayerHead, text: &str) -> Result<Vec<u8>, MapError> {
    GeneralPurpose::new(&STANDARD, PAD).decode(text.trim()).map_err(|error| MapError::LayerData {
        layer: layer.name.clone(),
        reason: format!("the Base64 data is damaged: {error}"),
    })
}

/// Reads ids of four bytes, and stops when there are more than the map can have, however small the compressed data.
fn ids(layer: &LayerHead, source: impl Read, frame: &Frame) -> Result<Vec<u32>, MapError> {
    let limit = 4 * (u64::from(frame.width) * u64::from(frame.height) + 1);
    let mut bytes = Vec::new();
    source.take(limit).read_to_end(&mut bytes).map_err(|error| MapError::LayerData {
        layer: layer.name.clone(),
        reason: format!("the data cannot be unpacked: {error}"),
    })?;
    let (ids, rest) = bytes.as_chunks::<4>();
    if !rest.is_empty() {
        let reason = format!("the data has {} bytes; a tile has 4", bytes.len());
        return Err(MapError::LayerData { layer: layer.name.clone(), reason });
    }
    Ok(ids.iter().map(|&id| u32::from_le_bytes(id)).collect())
}
