//! How the Tiled reader gets at files.

use std::io::Cursor;
use std::path::Path;

use tiled::{Error, Loader, Map};

use super::tileset;
use crate::{MapError, Resolver};

/// The name that the map has for the Tiled reader. It has no folder, so what the map refers to is relative to that.
const MAP: &str = "map.tmx";

/// Parses a map that has been scanned.
pub(crate) fn load(bytes: &[u8], resolver: &dyn Resolver) -> Result<Map, MapError> {
    let reader = |path: &Path| -> Result<Cursor<Vec<u8>>, MapError> {
        if path == Path::new(MAP) {
            return Ok(Cursor::new(bytes.to_vec()));
        }
        let path = normalised(path)?;
        let bytes =
            resolver.resolve(&path).map_err(|reason| MapError::File { path: path.clone(), reason })?;
        Ok(Cursor::new(tileset::scan_file(&path, &bytes)?))
    };
    Loader::with_reader(reader).load_tmx_map(MAP).map_err(from_reader)
}

/// Our own errors pass through the reader and come back as they were.
fn from_reader(error: Error) -> MapError {
    if let Error::ResourceLoadingError { path, err } = error {
        let path = path.to_string_lossy().into_owned();
        return match err.downcast::<MapError>() {
            Ok(own) => *own,
            Err(other) => MapError::File { path, reason: other.to_string() },
        };
    }
    MapError::Tiled { reason: error.to_string() }
}

/// Returns a path without `.` and `..` in it, but for `..` at its beginning.
fn normalised(path: &Path) -> Result<String, MapError> {
    let path = path.to_string_lossy();
    let mut parts: Vec<&str> = Vec::new();
    let is_absolute = path.starts_with(['/', '\\']) || path.get(1..2) == Some(":");
    if is_absolute {
        let reason = "the path is absolute; make it relative to the folder of the map".to_owned();
        return Err(MapError::File { path: path.into_owned(), reason });
    }
    for part in path.split('/') {
        match part {
            "" | "." => {}
            ".." if parts.last().is_some_and(|&last| last != "..") => {
                parts.pop();
            }
            part => parts.push(part),
        }
    }
    Ok(parts.join("/"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_lose_their_detours_and_keep_the_way_out_of_the_folder() {
        for (path, expected) in [
            ("tiles.tsx", "tiles.tsx"),
            ("./a/../tiles.tsx", "tiles.tsx"),
            ("../../b/./c//tiles.tsx", "../../b/c/tiles.tsx"),
            ("a/../../tiles.tsx", "../tiles.tsx"),
        ] {
            assert_eq!(normalised(Path::new(path)).unwrap(), expected);
        }
        for path in ["/etc/tiles.tsx", "C:/tiles.tsx", "\\tiles.tsx"] {
            assert!(matches!(normalised(Path::new(path)), Err(MapError::File { .. })));
        }
    }
}
