//! A map as a Tiled file.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use glam::DVec2;

use crate::{Tile, TileMap, TileShape};

/// Pixels along a tile, and the picture of the tiles that ship: grass, rock, four half tiles, sand, in a row.
const TILE_PIXELS: u32 = 16;
const PICTURE: &str = "<image source=\"tiles.png\" width=\"112\" height=\"16\"/>";

/// Returns the map as the text of a Tiled file, `.tmx`.
///
/// Its tileset is in it: a tile for each shape with each terrain, shown as in the picture `tiles.png` of the maps that
/// ship, which Tiled looks for beside the file. Read again it is an equal map but for ignored objects, provided that
/// all coordinates times 16 are 32-bit floats, as multiples of 1/16 are.
#[must_use]
pub fn write_tmx(map: &TileMap) -> String {
    let tiles: BTreeSet<_> = map.tiles().iter().map(|tile| (tile.terrain, tile.shape)).collect();
    let tiles: Vec<_> = tiles.into_iter().collect();
    let objects = objects(map);
    let (width, height) = (map.width(), map.height());
    let mut text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <map version=\"1.10\" tiledversion=\"1.10.1\" orientation=\"orthogonal\" renderorder=\"right-down\" \
         width=\"{width}\" height=\"{height}\" tilewidth=\"{TILE_PIXELS}\" tileheight=\"{TILE_PIXELS}\" \
         infinite=\"0\" nextlayerid=\"3\" nextobjectid=\"{}\">\n",
        objects.len() + 1
    );
    write_tileset(&mut text, map, &tiles);
    let _ = write!(
        text,
        " <layer id=\"1\" name=\"Ground\" width=\"{width}\" height=\"{height}\">\n  <data encoding=\"csv\">\n"
    );
    write_rows(&mut text, map, &tiles);
    text += "</data>\n </layer>\n";
    if !objects.is_empty() {
        text += " <objectgroup id=\"2\" name=\"Objects\">\n";
        for (id, object) in (1..).zip(objects) {
            let _ = writeln!(text, "  <object id=\"{id}\" {object}</object>");
        }
        text += " </objectgroup>\n";
    }
    text + "</map>\n"
}

fn write_tileset(text: &mut String, map: &TileMap, tiles: &[(u8, TileShape)]) {
    let count = tiles.len();
    let _ = writeln!(
        text,
        " <tileset firstgid=\"1\" name=\"tiles\" tilewidth=\"{TILE_PIXELS}\" tileheight=\"{TILE_PIXELS}\" \
         tilecount=\"{count}\" columns=\"0\">"
    );
    for (id, &(terrain, shape)) in tiles.iter().enumerate() {
        let terrain = &map.terrains()[terrain as usize];
        let (place, property) = match shape {
            TileShape::Open if ["", "ground", "grass"].contains(&terrain.as_str()) => (0, String::new()),
            TileShape::Open => (6, String::new()),
            TileShape::Blocked => (1, "<property name=\"blocked\" type=\"bool\" value=\"true\"/>".to_owned()),
            TileShape::Diagonal(corner) => {
                let name = corner.name();
                (2 + corner as u32, format!("<property name=\"diagonal\" value=\"{name}\"/>"))
            }
        };
        let x = place * TILE_PIXELS;
        let terrain = match terrain.as_str() {
            "" => String::new(),
            name => format!("<property name=\"terrain\" value=\"{}\"/>", escaped(name)),
        };
        let properties = match property + &terrain {
            none if none.is_empty() => none,
            some => format!("<properties>{some}</properties>"),
        };
        let _ = writeln!(
            text,
            "  <tile id=\"{id}\" type=\"tile\" x=\"{x}\" y=\"0\" width=\"{TILE_PIXELS}\" height=\"{TILE_PIXELS}\">\
             {properties}{PICTURE}</tile>"
        );
    }
    *text += " </tileset>\n";
}

fn write_rows(text: &mut String, map: &TileMap, tiles: &[(u8, TileShape)]) {
    let id = |tile: &Tile| tiles.binary_search(&(tile.terrain, tile.shape)).unwrap_or(0) + 1;
    let last = map.height() as usize - 1;
    for (y, row) in map.tiles().chunks(map.width() as usize).enumerate() {
        let ids: Vec<String> = row.iter().map(|tile| id(tile).to_string()).collect();
        *text += &ids.join(",");
        *text += if y == last { "\n" } else { ",\n" };
    }
}

/// Returns the objects, each from its class to before its end.
fn objects(map: &TileMap) -> Vec<String> {
    let int = |name: &str, value: u32| {
        format!("<properties><property name=\"{name}\" type=\"int\" value=\"{value}\"/></properties>")
    };
    let mut objects = Vec::new();
    for spawn in map.spawns() {
        let player = spawn.player;
        let head = format!("name=\"player {player}\" type=\"spawn\" {}", place(spawn.position));
        objects.push(format!("{head}>{}<point/>", int("player", player)));
    }
    for resource in map.resources() {
        let head = format!("type=\"resource\" {}", place(resource.position));
        objects.push(format!("{head}>{}<point/>", int("amount", resource.amount)));
    }
    for zone in map.zones() {
        let size = (zone.area.max - zone.area.min) * f64::from(TILE_PIXELS);
        let name = escaped(&zone.name);
        let head = format!("name=\"{name}\" type=\"zone\" {}", place(zone.area.min));
        let player = zone.player.map_or(String::new(), |player| int("player", player));
        objects.push(format!("{head} width=\"{}\" height=\"{}\">{player}", size.x, size.y));
    }
    for wall in map.free_walls() {
        let by = (wall.end - wall.start) * f64::from(TILE_PIXELS);
        let head = format!("type=\"wall\" {}", place(wall.start));
        objects.push(format!("{head}><polyline points=\"0,0 {},{}\"/>", by.x, by.y));
    }
    objects
}

fn place(position: DVec2) -> String {
    let pixels = position * f64::from(TILE_PIXELS);
    format!("x=\"{}\" y=\"{}\"", pixels.x, pixels.y)
}

/// Returns a text as it stands in an attribute.
fn escaped(text: &str) -> String {
    let mut escaped = String::new();
    for letter in text.chars() {
        match letter {
            '&' => escaped += "&amp;",
            '<' => escaped += "&lt;",
            '>' => escaped += "&gt;",
            '"' => escaped += "&quot;",
            // Readers turn these into spaces unless they are written as numbers.
            '\n' | '\r' | '\t' => {
                let _ = write!(escaped, "&#{};", u32::from(letter));
            }
            other => escaped.push(other),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use maniple_geometry::Segment;

    use super::*;
    use crate::map::Builder;
    use crate::{Area, Corner, Kind, Request, Resolver, Resource, Spawn, Zone, generate, read};

    struct NoFiles;

    impl Resolver for NoFiles {
        fn resolve(&self, path: &str) -> Result<Vec<u8>, String> {
            Err(format!("{path}: a written map refers to no file"))
        }
    }

    fn check(map: &TileMap, what: &str) {
        let text = write_tmx(map);
        let again = read("written.tmx", text.as_bytes(), &NoFiles);
        assert_eq!(again.as_ref(), Ok(map), "{what}:\n{text}");
        assert_eq!(again.map(|again| again.hash()), Ok(map.hash()), "{what}");
    }

    #[test]
    fn generated_maps_are_read_back_as_they_were() {
        for kind in Kind::ALL {
            for seed in 0..12 {
                let request = Request {
                    kind,
                    width: 48,
                    height: 41,
                    players: 2,
                    spawns: 1,
                    clusters: 3,
                    patches: 5,
                    amount: 700,
                    radius: 0.5,
                };
                check(&generate(&request, seed).unwrap(), &format!("{kind}, seed {seed}"));
            }
        }
    }

    #[test]
    fn everything_that_a_map_can_hold_is_read_back_as_it_was() {
        let mut builder = Builder::new(5, 3);
        let names = ["a \"b\" <c> & 'd'", "line\nbreak\ttab", "lake", ""];
        for (x, name) in (0..).zip(names) {
            let terrain = (!name.is_empty()).then(|| builder.terrain(name).unwrap());
            builder.put(x, 0, TileShape::Blocked, terrain);
        }
        let corners = [Corner::Northwest, Corner::Northeast, Corner::Southwest, Corner::Southeast];
        for (x, corner) in (0..).zip(corners) {
            builder.put(x, 1, TileShape::Diagonal(corner), None);
        }
        let at = DVec2::new;
        builder.add_spawn(Spawn { player: 7, position: at(4.5, 2.25) });
        builder.add_resource(Resource { position: at(0.0, 3.0), amount: 0 });
        let area = Area { min: at(0.5, 0.0), max: at(5.0, 2.0) };
        builder.add_zone(Zone { name: "<home>".to_owned(), player: None, area });
        builder.add_zone(Zone { name: String::new(), player: Some(0), area });
        builder.add_free_wall(Segment::new(at(1.0, 2.0), at(2.5, 2.75)));
        builder.add_free_wall(Segment::new(at(2.5, 2.75), at(0.25, 0.5)));
        check(&builder.finish(), "everything");
    }

    #[test]
    fn a_map_of_nothing_but_open_ground_is_read_back_as_it_was() {
        check(&Builder::new(1, 1).finish(), "one tile");
        check(&Builder::new(3, 2).finish(), "six tiles");
    }
}
