//! What the Tiled reader accepts, and what it says about the rest.

#![expect(clippy::wildcard_enum_match_arm, reason = "every error but the expected one is the same failure")]

use std::io::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::{GzEncoder, ZlibEncoder};
use glam::DVec2;
use maniple_geometry::Segment;
use twox_hash::XxHash3_64;

use super::limits::{ATTRIBUTES_MAX, DEPTH_MAX, LAYER_TILES_MAX, TILESET_TILES_MAX, TILESETS_MAX};
use crate::{
    Area, Corner, FindingKind, MapError, Resolver, Resource, SIZE_MAX, Spawn, TileMap, TileShape, Zone,
    check, read,
};

/// Ids: 1 open, 2 blocked, 3 to 6 half-blocked at nw, ne, sw, se, 7 open.
const TILES: &str = r#"<tileset name="tiles" tilewidth="16" tileheight="16" tilecount="7" columns="7">
<image source="absent.png" width="112" height="16"/>
<tile id="0"><properties><property name="terrain" value="grass"/></properties></tile>
<tile id="1"><properties><property name="blocked" type="bool" value="true"/></properties></tile>
<tile id="2"><properties><property name="diagonal" value="nw"/></properties></tile>
<tile id="3"><properties><property name="diagonal" value="ne"/></properties></tile>
<tile id="4"><properties><property name="diagonal" value="sw"/></properties></tile>
<tile id="5"><properties><property name="diagonal" value="se"/></properties></tile>
</tileset>"#;

/// Serves [`TILES`] as `tiles.tsx` in the folder above that of the map, and other files with the text of their name.
struct Files<'a>(&'a [(&'a str, &'a str)]);

impl Resolver for Files<'_> {
    fn resolve(&self, path: &str) -> Result<Vec<u8>, String> {
        if path == "../tiles.tsx" {
            return Ok(TILES.as_bytes().to_vec());
        }
        let found = self.0.iter().find(|(name, _)| *name == path);
        found.map(|(_, text)| text.as_bytes().to_vec()).ok_or_else(|| "no such file".to_owned())
    }
}

/// A map of 2 x 2 tiles of 16 pixels with the tileset and, in it, `content`.
fn map(content: &str) -> String {
    map_of(
        r#"orientation="orthogonal" width="2" height="2" tilewidth="16" tileheight="16" infinite="0""#,
        content,
    )
}

fn map_of(attributes: &str, content: &str) -> String {
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<map version=\"1.10\" {attributes}>\n\
         <tileset firstgid=\"1\" source=\"./x/../../tiles.tsx\"/>\n{content}\n</map>\n"
    )
}

fn layer(name: &str, cells: &str) -> String {
    data(name, "encoding=\"csv\"", cells)
}

fn data(name: &str, encoding: &str, text: &str) -> String {
    format!(r#"<layer id="1" name="{name}" width="2" height="2"><data {encoding}>{text}</data></layer>"#)
}

fn object(attributes: &str, content: &str) -> String {
    format!(
        r#"{}<objectgroup id="2"><object id="5" {attributes}>{content}</object></objectgroup>"#,
        layer("a", "1,1,1,1")
    )
}

fn int(name: &str, value: &str) -> String {
    format!(r#"<properties><property name="{name}" type="int" value="{value}"/></properties>"#)
}

fn load(text: &str) -> TileMap {
    read("test.tmx", text.as_bytes(), &Files(&[])).unwrap()
}

fn error(text: &str) -> MapError {
    read("test.tmx", text.as_bytes(), &Files(&[])).unwrap_err()
}

fn shapes(map: &TileMap) -> Vec<TileShape> {
    map.tiles().iter().map(|tile| tile.shape).collect()
}

#[test]
fn tiles_are_what_their_properties_say() {
    let map = load(&map(&layer("ground", "1,2,0,7")));
    assert_eq!(shapes(&map), [TileShape::Open, TileShape::Blocked, TileShape::Open, TileShape::Open]);
    assert_eq!(map.terrains(), ["", "grass"]);
    assert_eq!(map.tile(0, 0).terrain, 1);
}

#[test]
fn every_encoding_gives_the_same_map() {
    let bytes: Vec<u8> = [1_u32, 2, 3, 0x8000_0003].iter().flat_map(|id| id.to_le_bytes()).collect();
    let mut zlib = ZlibEncoder::new(Vec::new(), Compression::default());
    zlib.write_all(&bytes).unwrap();
    let mut gzip = GzEncoder::new(Vec::new(), Compression::default());
    gzip.write_all(&bytes).unwrap();
    let expected = load(&map(&layer("a", "\n1,2,\n3,2147483651\n")));
    assert_eq!(expected.tile(1, 1).shape, TileShape::Diagonal(Corner::Northeast));
    for (encoding, bytes) in [
        ("encoding=\"base64\"", bytes),
        ("encoding=\"base64\" compression=\"zlib\"", zlib.finish().unwrap()),
        ("encoding=\"base64\" compression=\"gzip\"", gzip.finish().unwrap()),
    ] {
        assert_eq!(load(&map(&data("a", encoding, &STANDARD.encode(bytes)))), expected, "{encoding}");
    }
}

/// The table was read off the picture that `tmxrasterizer` of Tiled 1.8 makes of these ids.
#[test]
fn flipped_half_blocked_tiles_lie_as_tiled_draws_them() {
    let names = ["nw", "ne", "sw", "se"];
    let table = [
        ["nw", "ne", "sw", "se"],
        ["nw", "sw", "ne", "se"],
        ["sw", "se", "nw", "ne"],
        ["sw", "nw", "se", "ne"],
        ["ne", "nw", "se", "sw"],
        ["ne", "se", "nw", "sw"],
        ["se", "sw", "ne", "nw"],
        ["se", "ne", "sw", "nw"],
    ];
    for (flips, row) in (0_u32..).zip(table) {
        for (tile, expected) in (3_u32..).zip(row) {
            let id = (flips << 29) | tile;
            let map = load(&map(&layer("a", &format!("{id},1,1,1"))));
            let expected = TileShape::Diagonal(Corner::from_name(expected).unwrap());
            assert_eq!(map.tile(0, 0).shape, expected, "flips {flips:03b} of {}", names[tile as usize - 3]);
        }
    }
}

#[test]
fn layers_add_up_also_within_groups() {
    let below = layer("below", "1,2,3,3");
    let above = format!("<group><group>{}</group></group>", layer("above", "1,0,3,6"));
    let map = load(&map(&format!("{below}{above}")));
    let northwest = TileShape::Diagonal(Corner::Northwest);
    assert_eq!(shapes(&map), [TileShape::Open, TileShape::Blocked, northwest, TileShape::Blocked]);
}

#[test]
fn every_tile_of_a_collision_layer_blocks_by_name_or_class() {
    for head in [r#"name="COLLISION""#, r#"name="x" class="Collision""#, r#"name="x" type="collision""#] {
        let text = format!(
            r#"<layer id="1" {head} width="2" height="2"><data encoding="csv">1,0,7,4</data></layer>"#
        );
        let expected = [TileShape::Blocked, TileShape::Open, TileShape::Blocked, TileShape::Blocked];
        assert_eq!(shapes(&load(&map(&text))), expected, "{head}");
    }
}

#[test]
fn objects_become_what_their_class_says() {
    let objects = r#"<objectgroup id="2" offsetx="16"><object id="1" class="spawn" x="8" y="8"><properties>
        <property name="player" type="int" value="1"/></properties><point/></object>
        <object id="2" type="spawn" x="-16" y="0" width="16" height="32"><properties>
        <property name="player" type="int" value="0"/></properties><ellipse/></object>
        <object id="3" type="resource" x="0" y="24"><properties>
        <property name="amount" type="int" value="70"/></properties><point/></object>
        <object id="4" type="zone" name="home" x="-8" y="0" width="24" height="16"/>
        <object id="5" type="wall" x="0" y="16"><polyline points="0,0 8,4 16,-16"/></object>
        <object id="6" type="warp" x="4000" y="-5"/></objectgroup>"#;
    let map = load(&map(&format!("{}{objects}", layer("a", "1,1,1,1"))));
    let at = DVec2::new;
    let spawn = |player, position| Spawn { player, position };
    assert_eq!(map.spawns(), [spawn(0, at(0.5, 1.0)), spawn(1, at(1.5, 0.5))]);
    assert_eq!(map.resources(), [Resource { position: at(1.0, 1.5), amount: 70 }]);
    let area = Area { min: at(0.5, 0.0), max: at(2.0, 1.0) };
    assert_eq!(map.zones(), [Zone { name: "home".to_owned(), player: None, area }]);
    let walls = [Segment::new(at(1.0, 1.0), at(1.5, 1.25)), Segment::new(at(1.5, 1.25), at(2.0, 0.0))];
    assert_eq!(map.free_walls(), walls);
    assert_eq!(map.segments()[4..], walls);
    assert_eq!(map.foreign_objects(), 1);
    let findings = check(&map, None);
    assert_eq!((findings[0].kind, findings[0].tile), (FindingKind::ForeignObject, (1, 0)));
}

#[test]
fn a_spawn_without_player_is_foreign_and_a_mistyped_one_is_an_error() {
    let map_with =
        |properties: &str| map(&object(r#"type="spawn" x="8" y="8""#, &format!("{properties}<point/>")));
    let found = load(&map_with(""));
    assert_eq!((found.spawns().len(), found.foreign_objects()), (0, 1));
    assert_eq!(check(&found, None)[0].kind, FindingKind::ForeignObject);
    let text = r#"<properties><property name="player" value="1"/></properties>"#;
    for (properties, reason) in [
        (int("player", "-1"), "is -1; it must be from 0 to 255"),
        (int("player", "256"), "is 256; it must be from 0 to 255"),
        (text.to_owned(), "is a string; it must be an int"),
    ] {
        let expected = MapError::ObjectProperty {
            object: 5,
            class: "spawn",
            property: "player",
            reason: reason.to_owned(),
        };
        assert_eq!(error(&map_with(&properties)), expected);
    }
}

#[test]
fn objects_that_are_wrong_are_named_with_their_property() {
    let amount = int("amount", "3");
    for (attributes, content, property) in [
        (r#"type="resource""#, "", "amount"),
        (r#"type="resource""#, int("amount", "-1").as_str(), "amount"),
        (r#"type="resource" x="33""#, &amount, "position"),
        (r#"type="resource" y="-1""#, &amount, "position"),
        (r#"type="resource" x="NaN""#, &amount, "position"),
        (r#"type="resource" gid="1" y="16" width="16" height="16""#, &amount, "shape"),
        (r#"type="resource""#, &(amount.clone() + r#"<polyline points="0,0 1,1"/>"#), "shape"),
        (r#"type="resource" width="8" height="8" rotation="45""#, &amount, "rotation"),
        (r#"type="zone" width="8""#, "", "size"),
        (r#"type="zone" width="-8" height="8" x="16""#, "", "size"),
        (r#"type="zone" width="8" height="33""#, "", "size"),
        (r#"type="zone" width="8" height="8""#, "<ellipse/>", "shape"),
        (r#"type="zone" width="8" height="8" rotation="1""#, "", "rotation"),
        (r#"type="zone" width="8" height="8""#, &int("player", "-1"), "player"),
        (r#"type="wall" width="8" height="8""#, "", "shape"),
        (r#"type="wall""#, r#"<polygon points="0,0 8,8 0,8"/>"#, "shape"),
        (r#"type="wall""#, r#"<polyline points="0,0 0,0"/>"#, "points"),
        (r#"type="wall""#, r#"<polyline points="0,0"/>"#, "points"),
        (r#"type="wall""#, r#"<polyline points="0,0 40,8"/>"#, "points"),
        (r#"type="wall" rotation="90""#, r#"<polyline points="0,0 4,8"/>"#, "rotation"),
    ] {
        match error(&map(&object(attributes, content))) {
            MapError::ObjectProperty { object: 5, property: found, .. } => {
                assert_eq!(found, property, "{attributes}");
            }
            other => panic!("{attributes}: {other}"),
        }
    }
}

#[test]
fn only_orthogonal_and_finite_maps_of_a_sane_size_are_taken() {
    let attributes = |orientation, infinite, width, tile| {
        let attributes = format!(
            r#"orientation="{orientation}" infinite="{infinite}" width="{width}" height="2" tilewidth="{tile}" tileheight="16""#
        );
        error(&map_of(&attributes, ""))
    };
    for name in ["isometric", "staggered", "hexagonal", "oblique", "round"] {
        assert_eq!(attributes(name, "0", "2", "16"), MapError::Orientation { found: format!("{name:?}") });
    }
    assert_eq!(attributes("orthogonal", "1", "2", "16"), MapError::Infinite);
    let size = |what, found: &str| MapError::Size {
        place: "<map>".to_owned(),
        what,
        found: found.to_owned(),
        limit: SIZE_MAX,
    };
    for width in ["0", "-1", "4097", "99999999999", "x"] {
        assert_eq!(attributes("orthogonal", "0", width, "16"), size("width", width));
    }
    assert_eq!(attributes("orthogonal", "0", "2", "0"), size("tilewidth", "0"));
}

#[test]
fn layers_with_too_few_or_too_many_tiles_are_errors() {
    let count = |found, problem, (x, y)| {
        let layer = "a".to_owned();
        MapError::TileCount { layer, found, expected: 4, problem, x, y }
    };
    assert_eq!(error(&map(&layer("a", "1,1,1"))), count(3, "missing", (1, 1)));
    assert_eq!(error(&map(&layer("a", "1,1,1,1,1,1"))), count(5, "too many", (0, 2)));
    assert_eq!(error(&map(&data("a", "encoding=\"base64\"", "AQAAAA=="))), count(1, "missing", (1, 0)));
    assert_eq!(error(&map(r#"<layer name="a" width="2" height="2"/>"#)), count(0, "missing", (0, 0)));
    let size = r#"<layer name="a" width="2" height="3"><data encoding="csv">1,1,1,1,1,1</data></layer>"#;
    assert!(matches!(error(&map(size)), MapError::LayerSize { map_height: 2, .. }));
}

#[test]
fn a_small_file_cannot_unpack_to_a_huge_layer() {
    let mut zlib = ZlibEncoder::new(Vec::new(), Compression::best());
    zlib.write_all(&vec![0; 1 << 24]).unwrap();
    let packed = STANDARD.encode(zlib.finish().unwrap());
    let found = error(&map(&data("a", "encoding=\"base64\" compression=\"zlib\"", &packed)));
    assert!(matches!(found, MapError::TileCount { found: 5, problem: "too many", .. }), "{found}");
}

#[test]
fn data_that_cannot_be_decoded_is_an_error() {
    let csv = error(&map(&layer("a", "1,x,1,1")));
    assert_eq!(csv.to_string(), "layer \"a\": tile (1, 0) is \"x\"; it must be a number");
    for (encoding, text) in [
        ("encoding=\"csv\"", "1,1,1,1,"),
        ("encoding=\"csv\"", "1,1,,1"),
        ("encoding=\"base64\"", "!"),
        ("encoding=\"base64\"", "AQAA"),
        ("encoding=\"base64\" compression=\"zlib\"", "AQAAAA=="),
    ] {
        let found = error(&map(&data("a", encoding, text)));
        assert!(
            matches!(found, MapError::LayerData { .. } | MapError::TileCount { .. }),
            "{encoding}: {found}"
        );
    }
    for (encoding, name) in [
        ("", "XML"),
        ("encoding=\"base64\" compression=\"zstd\"", "base64 zstd"),
        ("encoding=\"csv\" compression=\"zlib\"", "csv zlib"),
    ] {
        let expected = MapError::LayerFormat { layer: "a".to_owned(), found: name.to_owned() };
        assert_eq!(error(&map(&data("a", encoding, "<tile gid=\"1\"/>"))), expected);
    }
}

#[test]
fn unknown_tile_ids_are_errors_with_their_place() {
    let unknown = |id, x, y| MapError::UnknownTile { layer: "a".to_owned(), x, y, id };
    assert_eq!(error(&map(&layer("a", "1,1,8,1"))), unknown(8, 0, 1));
    assert_eq!(error(&map(&layer("a", "1,1,1,268435457"))), unknown(0x1000_0001, 1, 1));
    let late = map(&layer("a", "0,4,0,0")).replace("firstgid=\"1\"", "firstgid=\"5\"");
    assert_eq!(error(&late), unknown(4, 1, 0));
    assert!(matches!(error(&map(&object(r#"gid="0""#, ""))), MapError::Attribute { attribute: "gid", .. }));
}

#[test]
fn blocked_tiles_in_a_shifted_layer_are_an_error_and_open_ones_are_not() {
    let shifted = |cells| layer("a", cells).replace("<layer", "<layer offsetx=\"4\"");
    assert_eq!(load(&map(&shifted("1,1,7,0"))).tile(0, 0).shape, TileShape::Open);
    let expected = MapError::LayerOffset { layer: "a".to_owned(), x: 1, y: 1 };
    assert_eq!(error(&map(&shifted("1,1,7,2"))), expected);
}

#[test]
fn tile_properties_of_the_wrong_kind_are_errors() {
    for (property, name) in [
        (r#"name="blocked" value="true""#, "blocked"),
        (r#"name="terrain" type="int" value="3""#, "terrain"),
        (r#"name="diagonal" value="north""#, "diagonal"),
        (r#"name="diagonal" type="bool" value="true""#, "diagonal"),
    ] {
        let tiles = format!(
            r#"<tileset firstgid="8" name="t" tilewidth="16" tileheight="16" tilecount="2" columns="2">
            <tile id="1"><properties><property {property}/></properties></tile></tileset>"#
        );
        match error(&map(&format!("{tiles}{}", layer("a", "1,1,1,1")))) {
            MapError::TileProperty { tile: 1, property: found, .. } => assert_eq!(found, name),
            other => panic!("{property}: {other}"),
        }
    }
}

#[test]
fn tilesets_may_be_embedded_and_may_lack_what_old_versions_of_tiled_left_out() {
    let tiles = r#"<tileset firstgid="8" name="t" tilewidth="16" tileheight="16" margin="1" spacing="2" >
        <image source="absent.png" width="54" height="36"/></tileset>"#;
    assert_eq!(
        load(&map(&format!("{tiles}{}", layer("a", "8,13,2,0")))).tile(0, 1).shape,
        TileShape::Blocked
    );
    let unknown = error(&map(&format!("{tiles}{}", layer("a", "8,14,2,0"))));
    assert_eq!(unknown, MapError::UnknownTile { layer: "a".to_owned(), x: 1, y: 0, id: 14 });
}

#[test]
fn files_that_cannot_be_had_or_read_are_named() {
    let with = |source: &str| map("").replace("./x/../../tiles.tsx", source);
    let expected = MapError::File { path: "gone.tsx".to_owned(), reason: "no such file".to_owned() };
    assert_eq!(error(&with("gone.tsx")), expected);
    assert!(matches!(error(&with("/etc/tiles.tsx")), MapError::File { .. }));
    let broken = [
        ("b.tsx", "<tileset name=\"b\"\ntilewidth=\"1\" tileheight=\"1\"><tile></tileset>"),
        ("m.tsx", "<map/>"),
    ];
    for name in ["b.tsx", "m.tsx"] {
        match read("test.tmx", with(name).as_bytes(), &Files(&broken)).unwrap_err() {
            MapError::Xml { file, .. } => assert_eq!(file, name),
            other => panic!("{name}: {other}"),
        }
    }
}

#[test]
fn what_could_exhaust_memory_or_stack_is_refused_first() {
    let too_many = |text: &str, expected: &str| match error(text) {
        MapError::TooMany { what, .. } => assert_eq!(what, expected),
        other => panic!("{expected}: {other}"),
    };
    let depth = usize::try_from(DEPTH_MAX).unwrap();
    too_many(
        &map(&format!("{}{}", "<group>".repeat(depth), "</group>".repeat(depth))),
        "elements in each other",
    );
    let many: String = (0..=ATTRIBUTES_MAX).map(|index| format!(" a{index}=\"\"")).collect();
    too_many(&map(&format!("<group{many}/>")), "attributes of an element");
    let tilesets: String =
        (0..TILESETS_MAX).map(|id| format!(r#"<tileset firstgid="{}" source="x"/>"#, id + 2)).collect();
    too_many(&map(&tilesets), "tilesets");
    for count in ["4294967295", "99999999999", &(TILESET_TILES_MAX + 1).to_string()] {
        let tiles =
            format!(r#"<tileset firstgid="8" name="t" tilewidth="1" tileheight="1" tilecount="{count}"/>"#);
        assert!(matches!(error(&map(&tiles)), MapError::Attribute { attribute: "tilecount", .. }), "{count}");
    }
    let tiles = r#"<tileset firstgid="8" name="t" tilewidth="1" tileheight="1"><image source="a" width="1000" height="1000"/></tileset>"#;
    too_many(&map(tiles), "tiles");
    assert!(matches!(error(&map(&object("template=\"a.tx\"", ""))), MapError::Template { .. }));
}

#[test]
fn layers_share_one_limit_of_tiles() {
    let attributes = r#"orientation="orthogonal" width="4096" height="4096" tilewidth="1" tileheight="1""#;
    let mut zlib = ZlibEncoder::new(Vec::new(), Compression::fast());
    zlib.write_all(&vec![0; 4 * 4096 * 4096]).unwrap();
    let packed = STANDARD.encode(zlib.finish().unwrap());
    let layer = data("a", "encoding=\"base64\" compression=\"zlib\"", &packed).replace("\"2\"", "\"4096\"");
    let layers = usize::try_from(LAYER_TILES_MAX).unwrap() / (4096 * 4096);
    match error(&map_of(attributes, &layer.repeat(layers + 1))) {
        MapError::TooMany { what: "tiles in all layers", limit: LAYER_TILES_MAX, .. } => {}
        other => panic!("{other}"),
    }
}

#[test]
fn broken_xml_and_the_wrong_format_are_named() {
    assert!(matches!(error("<map><layer></map>"), MapError::Orientation { .. }));
    assert!(matches!(error(&map("<group>")), MapError::Xml { .. }));
    assert!(matches!(error("<tileset/>"), MapError::Xml { line: 1, .. }));
    assert!(matches!(error(""), MapError::Xml { line: 1, .. }));
    assert!(matches!(error("not xml"), MapError::Xml { .. }));
    assert!(matches!(error(&map("</group>")), MapError::Xml { .. }));
    let whole = map(&layer("a", "1,1,1,1"));
    for length in 0..whole.len() - 7 {
        error(&whole[..length]);
    }
    let ending = |name: &str, text: &str| match read(name, text.as_bytes(), &Files(&[])).unwrap_err() {
        MapError::WrongEnding { ending, .. } => ending,
        MapError::UnknownEnding { .. } => "unknown",
        other => panic!("{name}: {other}"),
    };
    assert_eq!(ending("a.map", &whole), ".tmx");
    assert_eq!(ending("a.TMX", "type octile\nheight 1\nwidth 1\nmap\n."), ".map");
    assert_eq!(ending("a.json", "{}"), "unknown");
    assert_eq!(read("a.TMX", format!("\u{feff}{whole}").as_bytes(), &Files(&[])), Ok(load(&whole)));
}

#[test]
fn the_hash_tells_maps_apart_and_ignores_how_they_were_written() {
    let base = load(&map(&object(r#"type="spawn" x="8" y="8""#, &(int("player", "0") + "<point/>"))));
    let others = [
        object(r#"type="spawn" x="8" y="8""#, &(int("player", "1") + "<point/>")),
        object(r#"type="spawn" x="8" y="9""#, &(int("player", "0") + "<point/>")),
        object(r#"type="spawn" x="8" y="8""#, &(int("player", "0") + "<point/>"))
            .replace("1,1,1,1", "1,1,1,2"),
        object(r#"type="spawn" x="8" y="8""#, &(int("player", "0") + "<point/>"))
            .replace("1,1,1,1", "1,1,1,7"),
        object(r#"type="zone" width="8" height="8""#, ""),
        object(r#"type="zone" width="8" height="8""#, &int("player", "0")),
    ];
    let mut hashes: Vec<u64> = others.iter().map(|other| load(&map(other)).hash()).collect();
    hashes.push(base.hash());
    hashes.sort_unstable();
    hashes.dedup();
    assert_eq!(hashes.len(), others.len() + 1);
    let foreign = object(r#"type="spawn" x="8" y="8""#, &(int("player", "0") + "<point/>"))
        .replace("</objectgroup>", "<object id=\"9\" type=\"tree\"/></objectgroup>")
        .replace("1,1,1,1", "1, 1,\n1,1");
    assert_eq!(load(&map(&foreign)).hash(), base.hash());
}

/// Damage in the map, and in the tileset that is embedded in it, ends in an error or in a map and never in a panic.
#[test]
fn damaged_files_never_panic() {
    let tiles = TILES.replace("<tileset", "<tileset firstgid=\"8\"");
    let objects = r#"<objectgroup id="2"><object id="1" type="wall"><polyline points="0,0 8,4 16,16"/></object>
        <object id="2" type="zone" width="16" height="8"/></objectgroup>"#;
    let whole = map(&format!("{tiles}<group>{}</group>{objects}", layer("a", "1,9,10,2147483651")));
    load(&whole);
    let mut loaded = 0;
    for seed in 0..20_000_u64 {
        let dice = |purpose: u64, sides: usize| {
            let roll = XxHash3_64::oneshot_with_seed(seed, &purpose.to_le_bytes()) % sides as u64;
            usize::try_from(roll).unwrap()
        };
        let mut bytes = whole.clone().into_bytes();
        for hit in 0..=dice(0, 3) as u64 {
            let at = dice(3 * hit + 1, bytes.len());
            let other = b"<>/\"=0159-, x\xff\0&"[dice(3 * hit + 2, 16)];
            match dice(3 * hit + 3, 3) {
                0 => bytes[at] = other,
                1 => bytes.insert(at, other),
                _ => drop(bytes.remove(at)),
            }
        }
        if let Ok(map) = read("test.tmx", &bytes, &Files(&[])) {
            loaded += 1;
            assert!(check(&map, Some(0.6)).len() < 20, "seed {seed}");
        }
    }
    assert!((100..19_900).contains(&loaded), "{loaded} of 20000 loaded");
}
