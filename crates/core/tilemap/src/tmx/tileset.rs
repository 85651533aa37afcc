//! Tilesets before the Tiled reader sees them: limits checked, and what old versions of Tiled left out filled in.

use quick_xml::events::BytesStart;

use super::limits::{IMAGE_PIXELS_MAX, TILE_PIXELS_MAX, TILESET_TILES_MAX};
use super::scan::{Root, Scan, number, text};
use crate::MapError;

/// Scans a `.tsx` file, and returns it with what is missing filled in.
pub(crate) fn scan_file(path: &str, bytes: &[u8]) -> Result<Vec<u8>, MapError> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let scan = Scan::new(path, bytes, Root::Tileset).run()?;
    Ok(scan.patched())
}

/// A tileset whose element is open.
#[derive(Debug)]
pub(crate) struct OpenTileset {
    place: String,
    /// Where attributes can be added to its element.
    patch_at: usize,
    tile_count: Option<u32>,
    columns: Option<u32>,
    tile_width: u32,
    tile_height: u32,
    margin: u32,
    spacing: u32,
    /// The size of its picture in pixels.
    image: Option<(u32, u32)>,
    tiles: u32,
}

impl OpenTileset {
    /// Reads the element; `patch_at` is where attributes can be added to it.
    pub(crate) fn new(file: &str, element: &BytesStart<'_>, patch_at: usize) -> Result<Self, MapError> {
        let name = text(file, element, "name")?.unwrap_or_default();
        let place = format!("{file}: tileset {name:?}");
        let optional = |attribute, limit| number(&place, element, attribute, 0..=limit);
        let required = |attribute| {
            optional(attribute, TILE_PIXELS_MAX)?.ok_or_else(|| MapError::Attribute {
                place: place.clone(),
                attribute,
                reason: "is missing".to_owned(),
            })
        };
        Ok(Self {
            patch_at,
            tile_count: optional("tilecount", TILESET_TILES_MAX)?,
            columns: optional("columns", TILESET_TILES_MAX)?,
            tile_width: required("tilewidth")?,
            tile_height: required("tileheight")?,
            margin: optional("margin", TILE_PIXELS_MAX)?.unwrap_or(0),
            spacing: optional("spacing", TILE_PIXELS_MAX)?.unwrap_or(0),
            image: None,
            tiles: 0,
            place,
        })
    }

    /// Reads an element in the tileset.
    pub(crate) fn child(&mut self, element: &BytesStart<'_>) -> Result<(), MapError> {
        match element.local_name().as_ref() {
            b"image" => {
                let pixels = |name| number(&self.place, element, name, 0..=IMAGE_PIXELS_MAX);
                self.image = pixels("width")?.zip(pixels("height")?);
            }
            b"tile" => {
                self.tiles += 1;
                self.limit(self.tiles)?;
            }
            _ => {}
        }
        Ok(())
    }

    /// Returns where to add which attributes, when all of the tileset has been read. The Tiled reader insists on
    /// `tilecount`, which versions of Tiled before 0.13 did not write, and computes `columns` without looking at
    /// the bounds.
    pub(crate) fn patch(&self) -> Result<(usize, String), MapError> {
        let columns = self.columns_of(self.image.map(|image| image.0), self.tile_width)?;
        let rows = self.columns_of(self.image.map(|image| image.1), self.tile_height)?;
        let mut attributes = String::new();
        if self.tile_count.is_none() {
            let count = if self.image.is_some() { columns.saturating_mul(rows) } else { self.tiles };
            self.limit(count)?;
            attributes += &format!(" tilecount=\"{count}\"");
        }
        if self.columns.is_none() {
            attributes += &format!(" columns=\"{columns}\"");
        }
        Ok((self.patch_at, attributes))
    }

    /// Returns how many tiles fit into `pixels`; 0 where there is no picture.
    fn columns_of(&self, pixels: Option<u32>, tile: u32) -> Result<u32, MapError> {
        let Some(pixels) = pixels else { return Ok(0) };
        if tile == 0 {
            let reason = "or tileheight is 0; both must be positive".to_owned();
            return Err(MapError::Attribute { place: self.place.clone(), attribute: "tilewidth", reason });
        }
        Ok((pixels + self.spacing).saturating_sub(self.margin) / (tile + self.spacing))
    }

    fn limit(&self, tiles: u32) -> Result<(), MapError> {
        if tiles <= TILESET_TILES_MAX {
            return Ok(());
        }
        let place = self.place.clone();
        let limit = u64::from(TILESET_TILES_MAX);
        Err(MapError::TooMany { place, what: "tiles", found: u64::from(tiles), limit })
    }
}
