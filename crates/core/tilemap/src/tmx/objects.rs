//! Objects of a Tiled map: spawns, resources, walls and zones.

use glam::DVec2;
use maniple_geometry::{Planar, Segment};
use tiled::{Object, ObjectShape, PropertyValue};

use super::Offset;
use super::classify::type_name;
use super::limits::FREE_WALLS_MAX;
use super::scan::Frame;
use crate::map::Builder;
use crate::{Area, Foreign, MapError, PLAYER_MAX, Resource, Spawn, Zone};

/// Reads an object and adds what it stands for to the map.
pub(crate) fn read(
    object: &Object<'_>,
    frame: &Frame,
    offset: Offset,
    builder: &mut Builder,
) -> Result<(), MapError> {
    let name = class_name(object);
    let class = match name.as_str() {
        "spawn" => "spawn",
        "resource" => "resource",
        "wall" => "wall",
        "zone" => "zone",
        _ => {
            let reason = match name.as_str() {
                "" => "it has no class".to_owned(),
                name => format!("class {name:?} means nothing here"),
            };
            builder.add_foreign(foreign(object, frame, offset, reason));
            return Ok(());
        }
    };
    let thing = Thing { object, class, frame, offset };
    match class {
        "spawn" => match thing.number("player", PLAYER_MAX)? {
            Some(player) => builder.add_spawn(Spawn { player, position: thing.position()? }),
            None => {
                let reason = "a spawn without the int property player".to_owned();
                builder.add_foreign(foreign(object, frame, offset, reason));
            }
        },
        "resource" => {
            let amount = thing.number("amount", i32::MAX.cast_unsigned())?;
            let amount =
                amount.ok_or_else(|| thing.mistake("amount", "is missing; it must be an int".to_owned()))?;
            builder.add_resource(Resource { position: thing.position()?, amount });
        }
        "wall" => {
            for wall in thing.walls()? {
                limit_walls(builder.add_free_wall(wall) as u64)?;
            }
        }
        _ => builder.add_zone(Zone {
            name: object.name.clone(),
            player: thing.number("player", PLAYER_MAX)?,
            area: thing.area()?,
        }),
    }
    Ok(())
}

/// The class of an object, or else that of the tile that it shows, as Tiled has it.
fn class_name(object: &Object<'_>) -> String {
    let of_tile = || object.get_tile()?.get_tile().map(|tile| tile.user_type.clone());
    if object.user_type.is_empty() { of_tile().unwrap_or_default() } else { object.user_type.clone() }
}

fn foreign(object: &Object<'_>, frame: &Frame, offset: Offset, reason: String) -> Foreign {
    Foreign { object: object.id(), position: in_tiles(object, frame, offset, (0.0, 0.0)), reason }
}

/// A point `by` pixels from the origin of an object, in world units.
fn in_tiles(object: &Object<'_>, frame: &Frame, offset: Offset, by: (f64, f64)) -> DVec2 {
    let x = (f64::from(object.x) + offset.x + by.0) / f64::from(frame.tile_width);
    let y = (f64::from(object.y) + offset.y + by.1) / f64::from(frame.tile_height);
    Planar::flushed(DVec2::new(x, y))
}

/// An object of one of our classes.
struct Thing<'a> {
    object: &'a Object<'a>,
    class: &'static str,
    frame: &'a Frame,
    offset: Offset,
}

impl Thing<'_> {
    fn mistake(&self, property: &'static str, reason: String) -> MapError {
        MapError::ObjectProperty { object: self.object.id(), class: self.class, property, reason }
    }

    /// Returns an int property from 0 to `limit`; `None` where the object does not have it.
    fn number(&self, name: &'static str, limit: u32) -> Result<Option<u32>, MapError> {
        match self.object.properties.get(name) {
            None => Ok(None),
            Some(PropertyValue::IntValue(value)) => match u32::try_from(*value) {
                Ok(value) if value <= limit => Ok(Some(value)),
                _ => Err(self.mistake(name, format!("is {value}; it must be from 0 to {limit}"))),
            },
            Some(other) => Err(self.mistake(name, format!("is {}; it must be an int", type_name(other)))),
        }
    }

    /// Returns a point `by` pixels from the origin of the object, in world units, if it is on the map.
    fn point(&self, property: &'static str, by: (f64, f64)) -> Result<DVec2, MapError> {
        let point = in_tiles(self.object, self.frame, self.offset, by);
        let (width, height) = (f64::from(self.frame.width), f64::from(self.frame.height));
        // Written so that what is not a number fails too.
        if (0.0..=width).contains(&point.x) && (0.0..=height).contains(&point.y) {
            return Ok(point);
        }
        let reason = format!("({}, {}) is outside of the map, in tiles {width} x {height}", point.x, point.y);
        Err(self.mistake(property, reason))
    }

    /// Returns the point, or the middle of the rectangle, ellipse or capsule.
    fn position(&self) -> Result<DVec2, MapError> {
        let (width, height) = match &self.object.shape {
            ObjectShape::Point(..) => (0.0, 0.0),
            ObjectShape::Rect { width, height }
            | ObjectShape::Ellipse { width, height }
            | ObjectShape::Capsule { width, height } => (*width, *height),
            ObjectShape::Polyline { .. } | ObjectShape::Polygon { .. } | ObjectShape::Text { .. } => {
                return Err(self.mistake("shape", "must be a point, rectangle or ellipse".to_owned()));
            }
        };
        self.refuse_tile()?;
        if (width, height) != (0.0, 0.0) {
            self.refuse_rotation()?;
        }
        self.point("position", (f64::from(width) / 2.0, f64::from(height) / 2.0))
    }

    fn area(&self) -> Result<Area, MapError> {
        let ObjectShape::Rect { width, height } = self.object.shape else {
            return Err(self.mistake("shape", "must be a rectangle".to_owned()));
        };
        self.refuse_tile()?;
        self.refuse_rotation()?;
        let min = self.point("position", (0.0, 0.0))?;
        let max = self.point("size", (f64::from(width), f64::from(height)))?;
        if min.x < max.x && min.y < max.y {
            return Ok(Area { min, max });
        }
        Err(self.mistake("size", format!("is {width} x {height} pixels; it must be positive")))
    }

    fn walls(&self) -> Result<Vec<Segment>, MapError> {
        let ObjectShape::Polyline { points } = &self.object.shape else {
            return Err(self.mistake("shape", "must be a polyline".to_owned()));
        };
        self.refuse_rotation()?;
        let mut walls = Vec::new();
        let mut last = None;
        for &(x, y) in points {
            let point = self.point("points", (f64::from(x), f64::from(y)))?;
            if last == Some(point) {
                return Err(self.mistake("points", "has the same point twice in a row".to_owned()));
            }
            walls.extend(last.map(|last| Segment::new(last, point)));
            last = Some(point);
        }
        if walls.is_empty() {
            return Err(self.mistake("points", "has only one point; a wall has at least two".to_owned()));
        }
        Ok(walls)
    }

    /// A tile stands on its origin where a rectangle hangs from it, depending on the tileset; so none of them.
    fn refuse_tile(&self) -> Result<(), MapError> {
        if self.object.tile_data().is_none() {
            return Ok(());
        }
        Err(self.mistake("shape", "is a tile; draw a point or rectangle instead".to_owned()))
    }

    /// Turned points would differ in their last bits between platforms.
    fn refuse_rotation(&self) -> Result<(), MapError> {
        let rotation = self.object.rotation;
        if rotation == 0.0 {
            return Ok(());
        }
        Err(self.mistake("rotation", format!("is {rotation}; draw the object without rotation")))
    }
}

fn limit_walls(found: u64) -> Result<(), MapError> {
    if found <= FREE_WALLS_MAX {
        return Ok(());
    }
    let place = "map".to_owned();
    Err(MapError::TooMany { place, what: "pieces of free walls", found, limit: FREE_WALLS_MAX })
}
