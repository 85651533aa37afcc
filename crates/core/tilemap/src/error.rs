//! What can be wrong with a map.

use thiserror::Error;

/// Why a map could not be read: what, where, the limit and the remedy. The caller adds the name of the map.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum MapError {
    /// The name of the map ends in nothing that is known.
    #[error("{name}: a map's name ends in .tmx (Tiled) or .map (MovingAI)")]
    UnknownEnding {
        /// The name.
        name: String,
    },
    /// The name says one format and the content another.
    #[error("{name}: the name says {expected}, but the content is {found}; rename it to end in {ending}")]
    WrongEnding {
        /// The name.
        name: String,
        /// The format that the ending stands for.
        expected: &'static str,
        /// The format of the content.
        found: &'static str,
        /// The ending that fits the content.
        ending: &'static str,
    },
    /// A line of a MovingAI header is not what it has to be.
    #[error("line {line}: expected {expected}, found {found:?}")]
    Header {
        /// The line, from 1.
        line: usize,
        /// What belongs there.
        expected: &'static str,
        /// What is there.
        found: String,
    },
    /// A width or height that no map can have.
    #[error("{place}: {what} is {found:?}; it must be a whole number from 1 to {limit}")]
    Size {
        /// Where: a line of a `.map`, an element of a `.tmx`.
        place: String,
        /// Which number.
        what: &'static str,
        /// The number as written.
        found: String,
        /// The largest that is allowed.
        limit: u32,
    },
    /// A character of a MovingAI map that stands for no tile.
    #[error("line {line}, column {column}: '{found}' is no tile; . G S are passable, @ O T W are not")]
    Character {
        /// The line, from 1.
        line: usize,
        /// The column, from 1.
        column: usize,
        /// The character; a byte that is not ASCII is written `\xNN`.
        found: String,
    },
    /// A row of a MovingAI map that is shorter or longer than the width says.
    #[error(
        "line {line}: the row has {found} tiles; the width says {expected}; give each row as many tiles as the width says"
    )]
    RowLength {
        /// The line, from 1.
        line: usize,
        /// How many tiles it has.
        found: usize,
        /// How many it has to have.
        expected: u32,
    },
    /// More or fewer rows in a MovingAI map than the height says.
    #[error(
        "line {line}: the map {problem}; the height says {expected} rows; add or remove rows, or mend the height"
    )]
    RowCount {
        /// The line, from 1, where the first row is missing or too many.
        line: usize,
        /// Whether it ends too early or goes on.
        problem: &'static str,
        /// How many rows it has to have.
        expected: u32,
    },
    /// XML that cannot be parsed.
    #[error("{file}, line {line}: {reason}")]
    Xml {
        /// The file, or `map` for the map itself.
        file: String,
        /// The line, from 1.
        line: usize,
        /// What the parser says.
        reason: String,
    },
    /// An attribute is missing or is not what it has to be.
    #[error("{place}: attribute {attribute} {reason}")]
    Attribute {
        /// The file and element.
        place: String,
        /// The attribute.
        attribute: &'static str,
        /// What is wrong with it.
        reason: String,
    },
    /// An orientation other than orthogonal.
    #[error(
        "<map>: orientation {found} is not supported; only orthogonal maps are (Map > Map Properties in Tiled)"
    )]
    Orientation {
        /// The orientation.
        found: String,
    },
    /// A map without bounds.
    #[error("<map>: infinite maps are not supported; switch Infinite off (Map > Map Properties in Tiled)")]
    Infinite,
    /// More of something than is allowed.
    #[error("{place}: {found} {what}; at most {limit} are allowed")]
    TooMany {
        /// The file and element.
        place: String,
        /// What there is too much of.
        what: &'static str,
        /// How many there are, as far as they were counted.
        found: u64,
        /// How many are allowed.
        limit: u64,
    },
    /// An object that is an instance of a template.
    #[error(
        "{place}: object {object} uses a template, which is not supported; detach it (context menu in Tiled)"
    )]
    Template {
        /// The file.
        place: String,
        /// The id of the object.
        object: String,
    },
    /// A file that the map refers to could not be had.
    #[error("{path}: {reason}")]
    File {
        /// The path, relative to the folder of the map.
        path: String,
        /// Why.
        reason: String,
    },
    /// A layer that is larger or smaller than the map.
    #[error(
        "layer {layer:?}: it is {width} x {height} tiles, the map {map_width} x {map_height}; they must be equal"
    )]
    LayerSize {
        /// The name of the layer.
        layer: String,
        /// Its width in tiles, as written.
        width: String,
        /// Its height in tiles, as written.
        height: String,
        /// The width of the map in tiles.
        map_width: u32,
        /// The height of the map in tiles.
        map_height: u32,
    },
    /// The tiles of a layer are stored in a way that is not supported.
    #[error(
        "layer {layer:?}: {found} data is not supported; choose CSV, or Base64 uncompressed, zlib or gzip, as Tile Layer Format (Map > Map Properties in Tiled)"
    )]
    LayerFormat {
        /// The name of the layer.
        layer: String,
        /// Encoding and compression.
        found: String,
    },
    /// The tiles of a layer could not be decoded.
    #[error("layer {layer:?}: {reason}")]
    LayerData {
        /// The name of the layer.
        layer: String,
        /// Where and why.
        reason: String,
    },
    /// A layer with fewer or more tiles than its size says.
    #[error(
        "layer {layer:?}: {found} tiles instead of {expected}; the first one {problem} is tile ({x}, {y})"
    )]
    TileCount {
        /// The name of the layer.
        layer: String,
        /// How many there are; at most one more than expected is counted.
        found: usize,
        /// How many there have to be.
        expected: usize,
        /// Whether tiles are missing or too many.
        problem: &'static str,
        /// The column of the first one that is missing or too many.
        x: usize,
        /// Its row.
        y: usize,
    },
    /// A tile id that no tileset of the map has.
    #[error("layer {layer:?}, tile ({x}, {y}): no tileset of the map has a tile with the global id {id}")]
    UnknownTile {
        /// The name of the layer.
        layer: String,
        /// The column.
        x: u32,
        /// The row.
        y: u32,
        /// The global id, without its flip bits.
        id: u32,
    },
    /// A layer whose blocked tiles do not lie on the grid of the map.
    #[error(
        "layer {layer:?}, tile ({x}, {y}): a blocked tile in a layer with an offset; set the layer's offset to 0"
    )]
    LayerOffset {
        /// The name of the layer.
        layer: String,
        /// The column of the first blocked tile.
        x: u32,
        /// Its row.
        y: u32,
    },
    /// A property of a tile in a tileset that is not what it has to be.
    #[error("tileset {tileset:?}, tile {tile}: property {property} {reason}")]
    TileProperty {
        /// The name of the tileset.
        tileset: String,
        /// The id of the tile in its tileset.
        tile: u32,
        /// The property.
        property: &'static str,
        /// What is wrong with it.
        reason: String,
    },
    /// A property or attribute of an object that is missing or not what it has to be.
    #[error("object {object} of class {class}: {property} {reason}")]
    ObjectProperty {
        /// The id of the object.
        object: u32,
        /// The class of the object.
        class: &'static str,
        /// The property.
        property: &'static str,
        /// What is wrong with it.
        reason: String,
    },
    /// Anything else that the Tiled reader refuses.
    #[error("not a map that Tiled wrote: {reason}")]
    Tiled {
        /// What the reader says.
        reason: String,
    },
}
