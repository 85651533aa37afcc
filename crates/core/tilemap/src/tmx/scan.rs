//! One pass over a file before the Tiled reader gets it, which panics on layers that are too short, lets tiles with an
//! unknown id vanish, recurses as deep as the file says, and allocates what the file asks for.

use std::ops::RangeInclusive;

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

use super::data::{self, LayerHead};
use super::limits::{ATTRIBUTES_MAX, DEPTH_MAX, LAYER_TILES_MAX, TILE_PIXELS_MAX, TILESETS_MAX};
use super::tileset::OpenTileset;
use crate::{MapError, SIZE_MAX};

/// The name of the map in messages; the caller knows the real one.
const MAP: &str = "map";

/// The size of a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Frame {
    /// Columns, `1..=SIZE_MAX`.
    pub(crate) width: u32,
    /// Rows, `1..=SIZE_MAX`.
    pub(crate) height: u32,
    /// Width of a tile in pixels, `1..=TILE_PIXELS_MAX`.
    pub(crate) tile_width: u32,
    /// Height of a tile in pixels, `1..=TILE_PIXELS_MAX`.
    pub(crate) tile_height: u32,
}

/// A map that the Tiled reader can take.
pub(crate) struct ScannedMap {
    /// The file, with what is missing filled in.
    pub(crate) bytes: Vec<u8>,
    /// Its size.
    pub(crate) frame: Frame,
    /// The global id of the first tile of each tileset, growing.
    pub(crate) first_ids: Vec<u32>,
}

/// Scans a `.tmx` file.
pub(crate) fn scan_map(bytes: &[u8]) -> Result<ScannedMap, MapError> {
    let scan = Scan::new(MAP, bytes, Root::Map).run()?;
    Ok(ScannedMap { bytes: scan.patched(), frame: scan.frame, first_ids: scan.first_ids })
}

/// What a file is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Root {
    /// A `.tmx`.
    Map,
    /// A `.tsx`.
    Tileset,
}

/// An element that is open.
#[derive(Debug)]
enum Element {
    /// The map, or a group of layers in it.
    Group,
    Objects,
    Layer {
        name: String,
        has_data: bool,
    },
    Data {
        head: LayerHead,
        is_read: bool,
    },
    Tileset(OpenTileset),
    Other,
}

/// A file being scanned.
pub(crate) struct Scan<'a> {
    file: &'a str,
    bytes: &'a [u8],
    reader: Reader<&'a [u8]>,
    root: Root,
    open: Vec<Element>,
    frame: Frame,
    first_ids: Vec<u32>,
    layer_tiles: u64,
    /// What to insert where, in the order of the file.
    patches: Vec<(usize, String)>,
}

impl<'a> Scan<'a> {
    /// Returns a scan of a file with this name.
    pub(crate) fn new(file: &'a str, bytes: &'a [u8], root: Root) -> Self {
        Self {
            file,
            bytes,
            reader: Reader::from_reader(bytes),
            root,
            open: Vec::new(),
            frame: Frame { width: 0, height: 0, tile_width: 0, tile_height: 0 },
            first_ids: Vec::new(),
            layer_tiles: 0,
            patches: Vec::new(),
        }
    }

    /// Reads up to the end of the root element.
    pub(crate) fn run(mut self) -> Result<Self, MapError> {
        loop {
            match self.reader.read_event().map_err(|error| self.xml_error(error.to_string()))? {
                Event::Start(element) => self.start(&element, 1)?,
                Event::Empty(element) => {
                    self.start(&element, 2)?;
                    self.end()?;
                }
                Event::End(_) => self.end()?,
                Event::Text(content) if self.is_in_data() => {
                    let content = content.unescape().map_err(|error| self.xml_error(error.to_string()))?;
                    self.content(&content)?;
                }
                Event::CData(content) => self.content(&String::from_utf8_lossy(&content))?,
                Event::Eof => return Err(self.xml_error("the file ends too early".to_owned())),
                Event::Text(_) | Event::Comment(_) | Event::Decl(_) | Event::PI(_) | Event::DocType(_) => {
                    continue;
                }
            }
            if self.open.is_empty() {
                return Ok(self);
            }
        }
    }

    /// Returns the file with everything inserted.
    pub(crate) fn patched(&self) -> Vec<u8> {
        let mut patched = Vec::with_capacity(self.bytes.len());
        let mut copied = 0;
        for (at, text) in &self.patches {
            patched.extend_from_slice(&self.bytes[copied..*at]);
            patched.extend_from_slice(text.as_bytes());
            copied = *at;
        }
        patched.extend_from_slice(&self.bytes[copied..]);
        patched
    }

    fn xml_error(&self, reason: String) -> MapError {
        let read = &self.bytes[..self.reader.buffer_position().min(self.bytes.len())];
        let line = 1 + read.iter().filter(|&&byte| byte == b'\n').count();
        MapError::Xml { file: self.file.to_owned(), line, reason }
    }

    fn too_many(&self, what: &'static str, found: u64, limit: u64) -> Result<(), MapError> {
        if found <= limit {
            return Ok(());
        }
        Err(MapError::TooMany { place: self.file.to_owned(), what, found, limit })
    }

    fn is_in_data(&self) -> bool {
        matches!(self.open.last(), Some(Element::Data { is_read: false, .. }))
    }

    /// Opens an element that ends in so many bytes, `>` or `/>`.
    fn start(&mut self, element: &BytesStart<'_>, closing: usize) -> Result<(), MapError> {
        self.too_many("elements in each other", self.open.len() as u64 + 1, DEPTH_MAX)?;
        // Counted without the search for attributes that are there twice: it takes the square of their number.
        let attributes = element.attributes().with_checks(false).take(ATTRIBUTES_MAX + 1).count();
        self.too_many("attributes of an element", attributes as u64, ATTRIBUTES_MAX as u64)?;
        let name = element.local_name();
        if name.as_ref() == b"object" {
            self.object(element)?;
        }
        let patch_at = self.reader.buffer_position().saturating_sub(closing);
        let is_in_root = self.open.len() == 1;
        let opened = match (self.open.last_mut(), name.as_ref()) {
            (None, name) => self.root(element, name, patch_at)?,
            (Some(Element::Group), b"group") => Element::Group,
            (Some(Element::Group), b"objectgroup") => Element::Objects,
            (Some(Element::Group), b"layer") => self.layer(element)?,
            (Some(Element::Group), b"tileset") if is_in_root => self.tileset(element, patch_at)?,
            (Some(Element::Layer { name, has_data }), b"data") => {
                *has_data = true;
                let encoding = text(self.file, element, "encoding")?;
                let compression = text(self.file, element, "compression")?;
                let head = LayerHead { name: name.clone(), encoding, compression };
                Element::Data { head, is_read: false }
            }
            (Some(Element::Tileset(tileset)), _) => {
                tileset.child(element)?;
                Element::Other
            }
            (Some(_), _) => Element::Other,
        };
        self.open.push(opened);
        Ok(())
    }

    fn root(&mut self, element: &BytesStart<'_>, name: &[u8], patch_at: usize) -> Result<Element, MapError> {
        match (self.root, name) {
            (Root::Map, b"map") => {
                self.frame = frame(element)?;
                Ok(Element::Group)
            }
            (Root::Tileset, b"tileset") => {
                Ok(Element::Tileset(OpenTileset::new(self.file, element, patch_at)?))
            }
            (Root::Map, _) => Err(self.xml_error("the first element must be <map>".to_owned())),
            (Root::Tileset, _) => Err(self.xml_error("the first element must be <tileset>".to_owned())),
        }
    }

    fn tileset(&mut self, element: &BytesStart<'_>, patch_at: usize) -> Result<Element, MapError> {
        self.too_many("tilesets", self.first_ids.len() as u64 + 1, TILESETS_MAX)?;
        let place = format!("{}: tileset {}", self.file, self.first_ids.len() + 1);
        let least = self.first_ids.last().map_or(1, |last| last.saturating_add(1));
        let first_id = number(&place, element, "firstgid", least..=u32::MAX)?;
        let reason = "is missing".to_owned();
        self.first_ids.push(first_id.ok_or(MapError::Attribute { place, attribute: "firstgid", reason })?);
        if text(self.file, element, "source")?.is_none() {
            return Ok(Element::Tileset(OpenTileset::new(self.file, element, patch_at)?));
        }
        if text(self.file, element, "tilecount")?.is_some() {
            return Err(self.xml_error("a tileset with a source cannot have a tilecount".to_owned()));
        }
        Ok(Element::Other)
    }

    fn layer(&mut self, element: &BytesStart<'_>) -> Result<Element, MapError> {
        let Frame { width: map_width, height: map_height, .. } = self.frame;
        let name = text(self.file, element, "name")?.unwrap_or_default();
        let width = text(self.file, element, "width")?.unwrap_or_default();
        let height = text(self.file, element, "height")?.unwrap_or_default();
        if (width.parse(), height.parse()) != (Ok(map_width), Ok(map_height)) {
            return Err(MapError::LayerSize { layer: name, width, height, map_width, map_height });
        }
        self.layer_tiles += u64::from(map_width) * u64::from(map_height);
        self.too_many("tiles in all layers", self.layer_tiles, LAYER_TILES_MAX)?;
        Ok(Element::Layer { name, has_data: false })
    }

    /// Checks an object wherever it is: a template could refer to itself, over a tileset or directly.
    fn object(&mut self, element: &BytesStart<'_>) -> Result<(), MapError> {
        let object = text(self.file, element, "id")?.unwrap_or_default();
        if text(self.file, element, "template")?.is_some() {
            return Err(MapError::Template { place: self.file.to_owned(), object });
        }
        if !matches!(self.open.last(), Some(Element::Objects)) {
            return Ok(());
        }
        let place = format!("{}: object {object}", self.file);
        let least = self.first_ids.first().copied().unwrap_or(u32::MAX);
        number(&place, element, "gid", least..=u32::MAX).map(drop)
    }

    fn end(&mut self) -> Result<(), MapError> {
        match self.open.pop() {
            Some(Element::Layer { name, has_data: false }) => {
                let expected = self.frame.width as usize * self.frame.height as usize;
                let problem = "missing";
                Err(MapError::TileCount { layer: name, found: 0, expected, problem, x: 0, y: 0 })
            }
            Some(Element::Data { head, is_read: false }) => {
                data::check(&head, "", &self.frame, &self.first_ids)
            }
            Some(Element::Tileset(tileset)) => {
                self.patches.push(tileset.patch()?);
                Ok(())
            }
            Some(
                Element::Group
                | Element::Objects
                | Element::Layer { .. }
                | Element::Data { .. }
                | Element::Other,
            )
            | None => Ok(()),
        }
    }

    /// Takes the text of an element. As the Tiled reader does, only the first piece of it counts.
    fn content(&mut self, text: &str) -> Result<(), MapError> {
        match self.open.last_mut() {
            Some(Element::Data { head, is_read }) if !*is_read => {
                *is_read = true;
                data::check(head, text, &self.frame, &self.first_ids)
            }
            _ => Ok(()),
        }
    }
}

fn frame(element: &BytesStart<'_>) -> Result<Frame, MapError> {
    let orientation = text(MAP, element, "orientation")?.unwrap_or_default();
    if orientation != "orthogonal" {
        return Err(MapError::Orientation { found: format!("{orientation:?}") });
    }
    if text(MAP, element, "infinite")?.is_some_and(|infinite| infinite != "0") {
        return Err(MapError::Infinite);
    }
    let size = |what: &'static str, limit| {
        let found = text(MAP, element, what)?.unwrap_or_default();
        let value = found.parse().ok().filter(|value| (1..=limit).contains(value));
        value.ok_or(MapError::Size { place: "<map>".to_owned(), what, found, limit })
    };
    Ok(Frame {
        width: size("width", SIZE_MAX)?,
        height: size("height", SIZE_MAX)?,
        tile_width: size("tilewidth", TILE_PIXELS_MAX)?,
        tile_height: size("tileheight", TILE_PIXELS_MAX)?,
    })
}

/// Returns the value of an attribute; `None` where the element does not have it.
pub(crate) fn text(
    file: &str,
    element: &BytesStart<'_>,
    name: &'static str,
) -> Result<Option<String>, MapError> {
    let mistake = |reason: String| MapError::Attribute { place: file.to_owned(), attribute: name, reason };
    let mut value = None;
    for attribute in element.attributes() {
        let attribute = attribute.map_err(|error| mistake(format!("cannot be read: {error}")))?;
        if attribute.key.local_name().as_ref() == name.as_bytes() {
            let text =
                attribute.unescape_value().map_err(|error| mistake(format!("cannot be read: {error}")))?;
            value = Some(text.into_owned());
        }
    }
    Ok(value)
}

/// Returns the value of an attribute that is a whole number; `None` where the element does not have it.
pub(crate) fn number(
    place: &str,
    element: &BytesStart<'_>,
    name: &'static str,
    range: RangeInclusive<u32>,
) -> Result<Option<u32>, MapError> {
    let Some(found) = text(place, element, name)? else { return Ok(None) };
    match found.parse().ok().filter(|number| range.contains(number)) {
        Some(number) => Ok(Some(number)),
        None => {
            let reason =
                format!("is {found:?}; it must be a whole number from {} to {}", range.start(), range.end());
            Err(MapError::Attribute { place: place.to_owned(), attribute: name, reason })
        }
    }
}
