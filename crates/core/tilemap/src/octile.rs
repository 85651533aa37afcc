//! The MovingAI format, after Sturtevant, *Benchmarks for Grid-Based Pathfinding*, 2012.

use crate::map::{Builder, SIZE_MAX};
use crate::{MapError, TileMap, TileShape};

/// Returns the map of a `.map` file: `type octile`, `height`, `width` (in either order), `map`, then the rows.
pub(crate) fn read(bytes: &[u8]) -> Result<TileMap, MapError> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut lines = Lines { rest: bytes.split(|&byte| byte == b'\n'), number: 0 };
    header(&mut lines, &["type", "octile"], "`type octile`")?;
    let (width, height) = size(&mut lines)?;
    header(&mut lines, &["map"], "`map`")?;
    let mut builder = Builder::new(width, height);
    for y in 0..height {
        let Some(row) = lines.next_line() else {
            return Err(MapError::RowCount {
                line: lines.number,
                problem: "ends too early",
                expected: height,
            });
        };
        read_row(&mut builder, y, row, lines.number)?;
    }
    while let Some(row) = lines.next_line() {
        if !row.trim_ascii().is_empty() {
            return Err(MapError::RowCount { line: lines.number, problem: "goes on", expected: height });
        }
    }
    Ok(builder.finish())
}

/// The lines of the file and the number, from 1, of the one that was asked for last.
struct Lines<I> {
    rest: I,
    number: usize,
}

impl<'a, I: Iterator<Item = &'a [u8]>> Lines<I> {
    fn next_line(&mut self) -> Option<&'a [u8]> {
        self.number += 1;
        let line = self.rest.next()?;
        Some(line.strip_suffix(b"\r").unwrap_or(line))
    }
}

fn words(line: &[u8]) -> Vec<String> {
    String::from_utf8_lossy(line).split_ascii_whitespace().map(str::to_owned).collect()
}

fn header<'a, I: Iterator<Item = &'a [u8]>>(
    lines: &mut Lines<I>,
    wanted: &[&str],
    expected: &'static str,
) -> Result<(), MapError> {
    let found = lines.next_line().unwrap_or_default();
    if words(found) == wanted {
        return Ok(());
    }
    Err(MapError::Header { line: lines.number, expected, found: excerpt(found) })
}

/// Reads the two lines with width and height, and returns (width, height).
fn size<'a, I: Iterator<Item = &'a [u8]>>(lines: &mut Lines<I>) -> Result<(u32, u32), MapError> {
    let (mut width, mut height) = (None, None);
    while width.is_none() || height.is_none() {
        let line = lines.next_line().unwrap_or_default();
        let words = words(line);
        let (what, place) = match words.first().map(String::as_str) {
            Some("width") if width.is_none() => ("width", &mut width),
            Some("height") if height.is_none() => ("height", &mut height),
            _ => {
                let expected = if height.is_none() { "`height N`" } else { "`width N`" };
                return Err(MapError::Header { line: lines.number, expected, found: excerpt(line) });
            }
        };
        let found = words[1..].join(" ");
        let number = found.parse::<u32>().ok().filter(|number| (1..=SIZE_MAX).contains(number));
        let place_name = format!("line {}", lines.number);
        *place = Some(number.ok_or(MapError::Size { place: place_name, what, found, limit: SIZE_MAX })?);
    }
    Ok((width.unwrap_or(0), height.unwrap_or(0)))
}

fn read_row(builder: &mut Builder, y: u32, row: &[u8], line: usize) -> Result<(), MapError> {
    let expected = builder.width();
    for (x, &byte) in (0..expected).zip(row) {
        let (shape, terrain) = tile(byte).ok_or_else(|| MapError::Character {
            line,
            column: x as usize + 1,
            found: byte.escape_ascii().to_string(),
        })?;
        let terrain = builder.terrain(terrain)?;
        builder.put(x, y, shape, Some(terrain));
    }
    if row.len() != expected as usize {
        return Err(MapError::RowLength { line, found: row.len(), expected });
    }
    Ok(())
}

fn tile(byte: u8) -> Option<(TileShape, &'static str)> {
    match byte {
        b'.' | b'G' => Some((TileShape::Open, "ground")),
        b'S' => Some((TileShape::Open, "swamp")),
        b'@' | b'O' => Some((TileShape::Blocked, "outside")),
        b'T' => Some((TileShape::Blocked, "trees")),
        b'W' => Some((TileShape::Blocked, "water")),
        _ => None,
    }
}

/// The beginning of a line, short enough for a message.
fn excerpt(line: &[u8]) -> String {
    String::from_utf8_lossy(line).chars().take(40).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error(text: &str) -> MapError {
        read(text.as_bytes()).unwrap_err()
    }

    #[test]
    fn every_tile_character_is_known() {
        let map = read(b"type octile\nheight 1\nwidth 7\nmap\n.GS@OTW\n").unwrap();
        let passable: Vec<bool> = (0..7).map(|x| map.is_passable(x, 0)).collect();
        assert_eq!(passable, [true, true, true, false, false, false, false]);
        assert_eq!(map.terrains()[map.tile(2, 0).terrain as usize], "swamp");
        assert_eq!(map.terrains()[map.tile(6, 0).terrain as usize], "water");
    }

    #[test]
    fn line_ends_of_any_system_and_blank_lines_at_the_end_are_fine() {
        let unix = read(b"type octile\nheight 2\nwidth 2\nmap\n.@\n..").unwrap();
        let dos = read(b"type octile\r\nwidth 2\r\nheight 2\r\nmap\r\n.@\r\n..\r\n\r\n").unwrap();
        assert_eq!(unix.hash(), dos.hash());
    }

    #[test]
    fn every_mistake_is_named_with_its_line() {
        let size = |line: usize, what, found: &str| MapError::Size {
            place: format!("line {line}"),
            what,
            found: found.to_owned(),
            limit: SIZE_MAX,
        };
        let header =
            |line, expected, found: &str| MapError::Header { line, expected, found: found.to_owned() };
        let cases = [
            ("", header(1, "`type octile`", "")),
            ("type tile\nheight 1", header(1, "`type octile`", "type tile")),
            ("type octile\nwidht 3", header(2, "`height N`", "widht 3")),
            ("type octile\nheight 3\nheight 3", header(3, "`width N`", "height 3")),
            ("type octile\nheight 3", header(3, "`width N`", "")),
            ("type octile\nheight 0\nwidth 1\nmap\n", size(2, "height", "0")),
            ("type octile\nheight 1\nwidth -1\nmap\n.", size(3, "width", "-1")),
            ("type octile\nheight 4097\nwidth 1\nmap\n", size(2, "height", "4097")),
            ("type octile\nheight 99999999999\nwidth 1\nmap\n", size(2, "height", "99999999999")),
            ("type octile\nheight\nwidth 1\nmap\n", size(2, "height", "")),
            ("type octile\nheight 1\nwidth 1\nmop\n.", header(4, "`map`", "mop")),
            (
                "type octile\nheight 1\nwidth 3\nmap\n.x.\n",
                MapError::Character { line: 5, column: 2, found: "x".to_owned() },
            ),
            (
                "type octile\nheight 1\nwidth 3\nmap\n. .\n",
                MapError::Character { line: 5, column: 2, found: " ".to_owned() },
            ),
            (
                "type octile\nheight 2\nwidth 3\nmap\n...\n..",
                MapError::RowLength { line: 6, found: 2, expected: 3 },
            ),
            (
                "type octile\nheight 2\nwidth 3\nmap\n....\n...",
                MapError::RowLength { line: 5, found: 4, expected: 3 },
            ),
            (
                "type octile\nheight 2\nwidth 3\nmap\n...",
                MapError::RowCount { line: 6, problem: "ends too early", expected: 2 },
            ),
            (
                "type octile\nheight 1\nwidth 3\nmap\n...\n\n...",
                MapError::RowCount { line: 7, problem: "goes on", expected: 1 },
            ),
        ];
        for (text, expected) in cases {
            assert_eq!(error(text), expected, "{text:?}");
        }
    }

    #[test]
    fn bytes_that_are_no_text_are_named() {
        let text = b"type octile\nheight 1\nwidth 2\nmap\n.\xff\n";
        let expected = MapError::Character { line: 5, column: 2, found: "\\xff".to_owned() };
        assert_eq!(read(text).unwrap_err(), expected);
    }
}
