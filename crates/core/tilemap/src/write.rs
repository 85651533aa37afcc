//! A map as a MovingAI file.

use thiserror::Error;

use crate::{TileMap, TileShape};

/// Why a map cannot be written as a MovingAI file.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum WriteError {
    /// The map holds something that the format has no way to say.
    #[error("the map has {count} {what}, which a .map cannot hold; write a .tmx")]
    Unsayable {
        /// What it is.
        what: &'static str,
        /// How many there are.
        count: usize,
    },
}

/// Returns the map as the text of a MovingAI file, `.map`.
///
/// Open tiles are `S` where their terrain is `swamp` and `.` otherwise, blocked ones `T` where it is `trees`, `W` where it
/// is `water` and `@` otherwise; so other names of terrain are read back as `ground` and `outside`.
///
/// # Errors
/// The map has half-blocked tiles, spawns, resources, zones or free walls.
pub fn write_map(map: &TileMap) -> Result<String, WriteError> {
    let is_half = |shape: TileShape| matches!(shape, TileShape::Diagonal(_));
    for (what, count) in [
        ("half-blocked tiles", map.tiles().iter().filter(|tile| is_half(tile.shape)).count()),
        ("spawns", map.spawns().len()),
        ("resources", map.resources().len()),
        ("zones", map.zones().len()),
        ("free walls", map.free_walls().len()),
    ] {
        if count > 0 {
            return Err(WriteError::Unsayable { what, count });
        }
    }
    let mut text = format!("type octile\nheight {}\nwidth {}\nmap\n", map.height(), map.width());
    for row in map.tiles().chunks(map.width() as usize) {
        text.extend(row.iter().map(|tile| {
            match (tile.shape == TileShape::Open, map.terrains()[tile.terrain as usize].as_str()) {
                (true, "swamp") => 'S',
                (true, _) => '.',
                (false, "trees") => 'T',
                (false, "water") => 'W',
                (false, _) => '@',
            }
        }));
        text.push('\n');
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Kind, Request, generate, octile, write_tmx};

    #[test]
    fn what_a_map_file_says_is_written_as_it_was_read() {
        let text = "type octile\nheight 2\nwidth 4\nmap\n.S@T\nW..@\n";
        let map = octile::read(text.as_bytes()).unwrap();
        assert_eq!(write_map(&map).unwrap(), text);
        assert!(write_tmx(&map).contains("1,2"), "tiles are numbered from 1");
    }

    #[test]
    fn what_a_map_file_cannot_say_is_named() {
        let request = Request {
            kind: Kind::Plain,
            width: 32,
            height: 32,
            players: 2,
            spawns: 1,
            clusters: 0,
            patches: 4,
            amount: 5,
            radius: 0.5,
        };
        let check = |request: Request, what, count| {
            let map = generate(&request, 1).unwrap();
            assert_eq!(write_map(&map), Err(WriteError::Unsayable { what, count }));
        };
        check(request, "spawns", 2);
        check(Request { players: 0, clusters: 1, ..request }, "resources", 4);
        let maze = generate(&Request { kind: Kind::Maze, players: 0, ..request }, 1).unwrap();
        let read = octile::read(write_map(&maze).unwrap().as_bytes()).unwrap();
        assert_eq!(read.border(), maze.border());
    }
}
