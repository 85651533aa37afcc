//! Bytes in, map out.

use crate::{MapError, TileMap, octile, tmx};

/// Gives the bytes of the files that a map refers to: the tilesets of a `.tmx`. Images are never asked for.
pub trait Resolver {
    /// Returns the bytes of the file at `path`, which is relative to the folder that the map itself is in: `/`
    /// between the parts, `.` and `..` removed but for `..` at the beginning, never absolute.
    ///
    /// # Errors
    /// Why the file cannot be had, as text.
    fn resolve(&self, path: &str) -> Result<Vec<u8>, String>;
}

/// Returns the map that `bytes` hold.
///
/// The ending of `name` says the format, `.tmx` for Tiled and `.map` for MovingAI in any letter case, and the
/// content has to agree. Nothing else of `name` is used; the folder of the map is the resolver's business.
///
/// # Errors
/// See [`MapError`]; the name of the map is left to the caller to add.
pub fn read(name: &str, bytes: &[u8], resolver: &dyn Resolver) -> Result<TileMap, MapError> {
    let lower = name.to_ascii_lowercase();
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    if lower.ends_with(".map") {
        if text.starts_with(b"<") {
            return Err(MapError::WrongEnding {
                name: name.to_owned(),
                expected: "MovingAI",
                found: "XML, as Tiled writes it",
                ending: ".tmx",
            });
        }
        return octile::read(bytes);
    }
    if lower.ends_with(".tmx") {
        if is_octile(text) {
            return Err(MapError::WrongEnding {
                name: name.to_owned(),
                expected: "Tiled",
                found: "a MovingAI map",
                ending: ".map",
            });
        }
        return tmx::read(bytes, resolver);
    }
    Err(MapError::UnknownEnding { name: name.to_owned() })
}

fn is_octile(text: &[u8]) -> bool {
    let first = text.split(|&byte| byte == b'\n').next().unwrap_or(text);
    let mut words = first.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
    words.next() == Some(b"type") && words.next() == Some(b"octile")
}
