//! What a tile of a tileset means to the game.

use tiled::{LayerTileData, Map, PropertyValue, Tile, Tileset};

use super::limits::TILESET_TILES_MAX;
use crate::map::Builder;
use crate::{Corner, MapError, TileShape};

/// What the properties of a tile say.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct TileClass {
    /// What of it is blocked, in any layer.
    pub(crate) shape: TileShape,
    /// The index of the name of its terrain, where it has one.
    pub(crate) terrain: Option<u8>,
}

/// The classes of all tiles of all tilesets.
pub(crate) struct Classes {
    /// By tileset and id in it; `None` for ids that the tileset does not have.
    tilesets: Vec<Vec<Option<TileClass>>>,
    /// The global id of the first tile of each tileset.
    first_ids: Vec<u32>,
}

impl Classes {
    /// Classifies the tiles of every tileset, in the order of their ids.
    pub(crate) fn new(map: &Map, first_ids: Vec<u32>, builder: &mut Builder) -> Result<Self, MapError> {
        let mut tilesets = Vec::new();
        for tileset in map.tilesets() {
            let mut classes = Vec::new();
            let mut ids: Vec<u32> = tileset.tiles().map(|(id, _)| id).collect();
            ids.sort_unstable();
            for id in ids {
                if id >= TILESET_TILES_MAX {
                    return Err(MapError::TooMany {
                        place: format!("tileset {:?}", tileset.name),
                        what: "is the id of a tile",
                        found: u64::from(id),
                        limit: u64::from(TILESET_TILES_MAX) - 1,
                    });
                }
                classes.resize(id as usize, None);
                let tile = tileset.get_tile(id);
                classes.push(tile.map(|tile| classify(tileset, id, &tile, builder)).transpose()?);
            }
            tilesets.push(classes);
        }
        Ok(Self { tilesets, first_ids })
    }

    /// Returns what a tile in a layer means, turned and mirrored as it lies there; `None` where its tileset does not
    /// have it.
    pub(crate) fn of(&self, data: &LayerTileData) -> Option<TileClass> {
        let mut class = (*self.tilesets.get(data.tileset_index())?.get(data.id() as usize)?)?;
        if let TileShape::Diagonal(corner) = class.shape {
            class.shape = TileShape::Diagonal(turned(corner, data));
        }
        Some(class)
    }

    /// Returns the global id of a tile in a layer.
    pub(crate) fn global_id(&self, data: &LayerTileData) -> u32 {
        self.first_ids.get(data.tileset_index()).copied().unwrap_or(0).saturating_add(data.id())
    }
}

/// The order of the three flips is that of the format: first the diagonal one.
fn turned(corner: Corner, data: &LayerTileData) -> Corner {
    let corner = if data.flip_d { corner.transposed() } else { corner };
    let corner = if data.flip_h { corner.flipped_horizontally() } else { corner };
    if data.flip_v { corner.flipped_vertically() } else { corner }
}

fn classify(
    tileset: &Tileset,
    id: u32,
    tile: &Tile<'_>,
    builder: &mut Builder,
) -> Result<TileClass, MapError> {
    let mistake = |property, reason: String| MapError::TileProperty {
        tileset: tileset.name.clone(),
        tile: id,
        property,
        reason,
    };
    let is_blocked = match tile.properties.get("blocked") {
        None => false,
        Some(PropertyValue::BoolValue(is_blocked)) => *is_blocked,
        Some(other) => return Err(mistake("blocked", format!("is {}; it must be a bool", type_name(other)))),
    };
    let text = |property| match tile.properties.get(property) {
        None => Ok(""),
        Some(PropertyValue::StringValue(text)) => Ok(text.as_str()),
        Some(other) => Err(mistake(property, format!("is {}; it must be a string", type_name(other)))),
    };
    let diagonal = text("diagonal")?;
    let shape = match (diagonal, is_blocked) {
        ("", false) => TileShape::Open,
        ("", true) => TileShape::Blocked,
        (name, _) => TileShape::Diagonal(Corner::from_name(name).ok_or_else(|| {
            mistake("diagonal", format!("is {name:?}; it must be nw, ne, sw or se, the blocked corner"))
        })?),
    };
    let terrain = match text("terrain")? {
        "" => None,
        name => Some(builder.terrain(name)?),
    };
    Ok(TileClass { shape, terrain })
}

/// Returns what a property is, with its article, for a message.
pub(crate) fn type_name(value: &PropertyValue) -> &'static str {
    match value {
        PropertyValue::BoolValue(_) => "a bool",
        PropertyValue::FloatValue(_) => "a float",
        PropertyValue::IntValue(_) => "an int",
        PropertyValue::ColorValue(_) => "a color",
        PropertyValue::StringValue(_) => "a string",
        PropertyValue::FileValue(_) => "a file",
        PropertyValue::ObjectValue(_) => "an object",
        PropertyValue::ListValue(_) => "a list",
        PropertyValue::ClassValue { .. } => "a class",
    }
}
