//! Files on disk, and those that ship inside the program.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use anyhow::Context;
use maniple_game::{Files, LoadedFile};
use maniple_tilemap::{Resolver, TileMap};

use crate::failure::Failure;

/// The largest file that is read: a map of 4096 x 4096 tiles as text needs 16 MiB for each layer.
const FILE_SIZE_MAX: u64 = 256 << 20;

/// Files on disk; a path that is not absolute starts at the working directory.
pub(crate) struct Disk;

impl Resolver for Disk {
    fn resolve(&self, path: &str) -> Result<Vec<u8>, String> {
        let size = std::fs::metadata(path).map_err(|error| unreadable(&error))?.len();
        if size > FILE_SIZE_MAX {
            return Err(format!("{size} bytes; a file may have {FILE_SIZE_MAX}"));
        }
        std::fs::read(path).map_err(|error| unreadable(&error))
    }
}

/// Returns what is wrong with a file that cannot be read, and how to mend it.
fn unreadable(error: &io::Error) -> String {
    let remedy = if error.kind() == io::ErrorKind::NotFound {
        "; name a file that is there, paths count from the working directory"
    } else if error.kind() == io::ErrorKind::PermissionDenied {
        "; permit to read it"
    } else {
        ""
    };
    format!("{error}{remedy}")
}

/// Files beside another one on disk.
struct Beside<'a>(&'a Path);

impl Resolver for Beside<'_> {
    fn resolve(&self, path: &str) -> Result<Vec<u8>, String> {
        Disk.resolve(&self.0.join(path).to_string_lossy())
    }
}

/// Returns the bytes of a file.
pub(crate) fn read(path: &Path) -> Result<Vec<u8>, Failure> {
    Disk.resolve(&path.to_string_lossy())
        .map_err(anyhow::Error::msg)
        .with_context(|| path.display().to_string())
        .map_err(Failure::BadInput)
}

/// Writes a file.
pub(crate) fn write(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    std::fs::write(path, bytes).with_context(|| path.display().to_string()).map_err(Failure::Failed)
}

/// Makes a folder, and those around it, where there is none yet.
pub(crate) fn make_folder(path: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(path)
        .with_context(|| format!("{}: no folder can be made there", path.display()))
        .map_err(Failure::Failed)
}

/// A file that is written bit by bit. Its errors name it.
pub(crate) struct Output {
    path: PathBuf,
    file: BufWriter<File>,
}

/// Creates a file that is written bit by bit, or empties the one that is there.
pub(crate) fn create(path: &Path) -> Result<Output, Failure> {
    let file = File::create(path).with_context(|| path.display().to_string()).map_err(Failure::Failed)?;
    Ok(Output { path: path.to_owned(), file: BufWriter::new(file) })
}

impl Output {
    fn named(&self, error: &io::Error) -> io::Error {
        io::Error::new(error.kind(), format!("{}: {error}", self.path.display()))
    }
}

impl Write for Output {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes).map_err(|error| self.named(&error))
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush().map_err(|error| self.named(&error))
    }
}

/// Returns the map in a file.
pub(crate) fn map(path: &Path) -> Result<TileMap, Failure> {
    let bytes = read(path)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    maniple_tilemap::read(&path.to_string_lossy(), &bytes, &Beside(folder))
        .with_context(|| path.display().to_string())
        .map_err(Failure::BadInput)
}

/// Returns the map of [`SHIPPED_SCENARIO`].
pub(crate) fn shipped_map() -> Result<TileMap, Failure> {
    let Files(mut files) = shipped();
    for file in &mut files {
        file.path = file.path.trim_start_matches("maps/").to_owned();
    }
    let beside = Files(files);
    let bytes = beside.resolve("choke.tmx").map_err(anyhow::Error::msg).map_err(Failure::Failed)?;
    maniple_tilemap::read("choke.tmx", &bytes, &beside).map_err(Failure::failed)
}

/// The scenario that is played when none is named.
pub(crate) const SHIPPED_SCENARIO: &str = "config/scenarios/duel.toml";

/// Returns the files of [`SHIPPED_SCENARIO`]; they are in the program, so that it needs nothing beside it.
pub(crate) fn shipped() -> Files {
    let file = |path: &str, bytes: &[u8]| LoadedFile { path: path.to_owned(), bytes: bytes.to_vec() };
    Files(vec![
        file(SHIPPED_SCENARIO, include_bytes!("../../../../config/scenarios/duel.toml")),
        file("maps/choke.tmx", include_bytes!("../../../../maps/choke.tmx")),
        file("maps/tiles.tsx", include_bytes!("../../../../maps/tiles.tsx")),
    ])
}
