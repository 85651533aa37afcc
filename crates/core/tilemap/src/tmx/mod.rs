//! The format of the Tiled editor: <https://doc.mapeditor.org/en/stable/reference/tmx-map-format/>.

mod classify;
mod data;
mod files;
pub mod limits;
mod objects;
mod scan;
#[cfg(test)]
mod tests;
mod tileset;
mod write;

use tiled::{FiniteTileLayer, Layer, LayerType, TileLayer};

use crate::map::Builder;
use crate::{MapError, Resolver, TileMap, TileShape};
use classify::{Classes, TileClass};
use scan::Frame;
pub use write::write_tmx;

/// Name of the layers in which every tile blocks, in lower case.
const COLLISION: &str = "collision";

/// Returns the map of a `.tmx` file.
pub(crate) fn read(bytes: &[u8], resolver: &dyn Resolver) -> Result<TileMap, MapError> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let scanned = scan::scan_map(bytes)?;
    let map = files::load(&scanned.bytes, resolver)?;
    let mut builder = Builder::new(scanned.frame.width, scanned.frame.height);
    let classes = Classes::new(&map, scanned.first_ids, &mut builder)?;
    let mut reading = Reading { frame: scanned.frame, classes, builder };
    reading.layers(Box::new(map.layers()), Offset { x: 0.0, y: 0.0 })?;
    Ok(reading.builder.finish())
}

/// How far a layer is shifted, with all groups that it is in, in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Offset {
    /// To the right.
    pub(crate) x: f64,
    /// Downwards.
    pub(crate) y: f64,
}

struct Reading {
    frame: Frame,
    classes: Classes,
    builder: Builder,
}

impl Reading {
    /// Reads layers from the lowest to the topmost; the depth of groups has been checked.
    fn layers(&mut self, layers: Layers<'_>, outer: Offset) -> Result<(), MapError> {
        for layer in layers {
            let x = outer.x + f64::from(layer.offset_x);
            let offset = Offset { x, y: outer.y + f64::from(layer.offset_y) };
            match layer.layer_type() {
                LayerType::Tiles(TileLayer::Finite(tiles)) => self.tiles(&layer, &tiles, offset)?,
                LayerType::Tiles(TileLayer::Infinite(_)) => return Err(MapError::Infinite),
                LayerType::Objects(objects) => {
                    for object in objects.objects() {
                        objects::read(&object, &self.frame, offset, &mut self.builder)?;
                    }
                }
                LayerType::Group(group) => self.layers(Box::new(group.layers()), offset)?,
                LayerType::Image(_) => {}
            }
        }
        Ok(())
    }

    fn tiles(
        &mut self,
        layer: &Layer<'_>,
        tiles: &FiniteTileLayer<'_>,
        offset: Offset,
    ) -> Result<(), MapError> {
        let is_collision =
            [&layer.name, &layer.user_type].iter().any(|name| name.eq_ignore_ascii_case(COLLISION));
        for y in 0..self.frame.height {
            for x in 0..self.frame.width {
                let Some(data) = tiles.get_tile_data(x.cast_signed(), y.cast_signed()) else { continue };
                let Some(class) = self.classes.of(data) else {
                    let id = self.classes.global_id(data);
                    return Err(MapError::UnknownTile { layer: layer.name.clone(), x, y, id });
                };
                let shape = shape_in_layer(class, is_collision);
                let is_shifted = offset != Offset { x: 0.0, y: 0.0 };
                if is_shifted && shape != TileShape::Open {
                    return Err(MapError::LayerOffset { layer: layer.name.clone(), x, y });
                }
                self.builder.put(x, y, shape, class.terrain);
            }
        }
        Ok(())
    }
}

/// Layers of a group; boxed, as the type of layers in groups in groups would never end.
type Layers<'map> = Box<dyn Iterator<Item = Layer<'map>> + 'map>;

fn shape_in_layer(class: TileClass, is_collision: bool) -> TileShape {
    if is_collision { TileShape::Blocked } else { class.shape }
}
