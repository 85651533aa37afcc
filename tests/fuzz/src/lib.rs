//! What must hold whatever bytes come: no panic, no endless loop, no memory beyond the input, and what was read says the same when
//! it is written again. `cargo fuzz` looks for bytes that break it; the suite calls the same functions with the corpus.

#![allow(clippy::unwrap_used, reason = "whatever fails here is found")]

mod arena;

use maniple_game::{Overrides, Scenario, load};
use maniple_geometry::Cycle;
use maniple_protocol::{
    Encoding, FrameDecoder, Inbound, Input, PackedDelta, ReplayHeader, Rest, ServerMessage, decode_client,
    decode_server, decode_snapshot, encode_client, encode_server, encode_snapshot, read_partial, read_replay,
};
use maniple_referee::{Referee, Snapshot};
use maniple_tilemap::Resolver;
use maniple_view::{ClockMode, Seat};
use twox_hash::XxHash3_64;

use arena::{Bytes, Play};

/// What takes bytes that anybody may have made up: it panics where there is a mistake of ours.
pub type Body = fn(&[u8]);

/// Every target by its name, sorted.
pub const TARGETS: [(&str, Body); 12] = [
    ("client_message", client_message),
    ("frame", frame),
    ("inbound", inbound),
    ("json_line", json_line),
    ("map", map),
    ("packed", packed),
    ("referee", referee),
    ("replay", replay),
    ("scenario", scenario),
    ("server_message", server_message),
    ("snapshot", snapshot),
    ("tmx", tmx),
];

/// Largest length of a frame here, so that few bytes reach it.
const FRAME_MAX: usize = 32;

/// Cycles that are played on from a snapshot that was taken.
const CYCLES_ON: u32 = 4;

/// A body in the binary format of a client's message.
pub fn client_message(data: &[u8]) {
    let Ok(message) = decode_client(Encoding::Binary, data) else { return };
    let Ok(written) = encode_client(Encoding::Binary, &message) else { return };
    let again = decode_client(Encoding::Binary, &written[4..]).unwrap();
    assert_eq!(encode_client(Encoding::Binary, &again).unwrap(), written);
}

/// A body in the binary format of a server's message.
pub fn server_message(data: &[u8]) {
    let Ok(message) = decode_server(Encoding::Binary, data) else { return };
    let Ok(written) = encode_server(Encoding::Binary, &message) else { return };
    let again = decode_server(Encoding::Binary, &written[4..]).unwrap();
    assert_eq!(encode_server(Encoding::Binary, &again).unwrap(), written);
}

/// A line of JSON, from either side.
pub fn json_line(data: &[u8]) {
    let body = |written: &[u8]| written[..written.len() - 1].to_vec();
    if let Ok(message) = decode_client(Encoding::Json, data) {
        let written = encode_client(Encoding::Json, &message).unwrap();
        assert_eq!(decode_client(Encoding::Json, &body(&written)), Ok(message));
    }
    if let Ok(message) = decode_server(Encoding::Json, data) {
        let written = encode_server(Encoding::Json, &message).unwrap();
        assert_eq!(decode_server(Encoding::Json, &body(&written)), Ok(message));
    }
}

/// A stream of frames or lines, the first byte says which.
pub fn frame(data: &[u8]) {
    let Some((first, stream)) = data.split_first() else { return };
    let encoding = if first % 2 == 0 { Encoding::Binary } else { Encoding::Json };
    let whole = bodies(encoding, std::iter::once(stream));
    assert_eq!(bodies(encoding, stream.chunks(1)), whole);
    assert_eq!(bodies(encoding, stream.chunks(1 + usize::from(*first))), whole);
}

/// What a client sends from its first byte on; the first byte says in what portions it comes.
pub fn inbound(data: &[u8]) {
    let Some((first, stream)) = data.split_first() else { return };
    let whole = inputs(std::iter::once(stream));
    assert_eq!(inputs(stream.chunks(1)), whole);
    assert_eq!(inputs(stream.chunks(1 + usize::from(*first))), whole);
}

/// The motions of a packed delta, or a whole message with one.
pub fn packed(data: &[u8]) {
    let (view, rules) = arena::view();
    let rest = data.first().is_some_and(|first| first % 2 == 0).then(|| Box::new(Rest::default()));
    let motions = data.get(1..).unwrap_or_default().to_vec();
    let cycle = Cycle(view.cycle().0 + 1);
    let delta = PackedDelta { cycle, rest, motions, ..PackedDelta::default() };
    if let Ok(delta) = delta.unpack(view, rules) {
        let _ = view.clone().apply(&delta);
    }
    if let Ok(ServerMessage::Packed(delta)) = decode_server(Encoding::Binary, data)
        && let Ok(delta) = delta.unpack(view, rules)
    {
        let _ = view.clone().apply(&delta);
    }
}

/// A file of a replay, or one whose checksums are right: then the bytes are what it is made of.
pub fn replay(data: &[u8]) {
    if let Ok(partial) = read_partial(data) {
        assert!(partial.whole_bytes <= data.len());
        assert_eq!(read_replay(data).is_ok(), partial.fault.is_none());
    }
    if let Ok(header) = decode_snapshot::<ReplayHeader>(&forged(data)) {
        let files = header.files.into_iter().map(|(path, bytes)| maniple_game::LoadedFile { path, bytes });
        let overrides =
            Overrides { seed: Some(header.seed), rate: Some(header.rate), ..Overrides::default() };
        let overrides = overrides.with_profile(&header.profile);
        if let Err(error) = load(&maniple_game::Files(files.collect()), &header.scenario, &overrides) {
            let _ = error.to_string();
        }
    }
}

/// The text of a scenario.
pub fn scenario(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    if let Err(error) = Scenario::read("fuzz.toml", text) {
        let _ = error.to_string();
    }
}

/// A map in the format of MovingAI.
pub fn map(data: &[u8]) {
    tiles("fuzz.map", data);
}

/// A map in the format of Tiled.
pub fn tmx(data: &[u8]) {
    tiles("fuzz.tmx", data);
}

/// A snapshot, or its body: then the checksum is right. Where a match can go on from it, it does.
pub fn snapshot(data: &[u8]) {
    let _ = decode_snapshot::<Snapshot>(data);
    let Ok(snapshot) = decode_snapshot::<Snapshot>(&forged(data)) else { return };
    let mut referee = match Referee::resume(arena::loaded(), ClockMode::Realtime, &snapshot) {
        Ok(referee) => referee,
        Err(error) => {
            let _ = error.to_string();
            return;
        }
    };
    let written = encode_snapshot(&referee.snapshot()).unwrap();
    let read: Snapshot = decode_snapshot(&written).unwrap();
    assert!(Referee::resume(arena::loaded(), ClockMode::Realtime, &read).is_ok());
    for seat in (0..).map(Seat).take(referee.seats()) {
        referee.handle_join(seat, "fuzz").unwrap();
    }
    for _ in 0..CYCLES_ON {
        if referee.result().is_some() {
            return;
        }
        for seat in (0..).map(Seat).take(referee.seats()) {
            referee.take_delta(seat);
        }
        referee.take_records();
        referee.step();
    }
}

/// A whole match: the bytes are the commands of its seats, and when a cycle is played. It is played again from its records, and
/// from a snapshot.
pub fn referee(data: &[u8]) {
    let mut play = Play::new();
    let mut bytes = Bytes::new(data);
    while play.goes_on() && play.act(&mut bytes).is_some() {}
    play.check();
}

/// Returns the bytes of a snapshot of this body.
pub fn forged(body: &[u8]) -> Vec<u8> {
    let empty = encode_snapshot(&()).unwrap();
    let mut bytes = [&empty[..6], body].concat();
    let checksum = XxHash3_64::oneshot(&bytes);
    bytes.extend_from_slice(&checksum.to_le_bytes());
    bytes
}

/// Returns an input for the target `referee`, and the bodies of the snapshots of a match that goes so.
pub fn played() -> (Vec<u8>, Vec<Vec<u8>>) {
    arena::story()
}

fn bodies<'a>(encoding: Encoding, pieces: impl Iterator<Item = &'a [u8]>) -> Vec<Result<Vec<u8>, String>> {
    let mut decoder = FrameDecoder::new(encoding, FRAME_MAX);
    let mut found = Vec::new();
    for piece in pieces {
        decoder.handle_bytes(piece);
        loop {
            match decoder.poll() {
                Ok(Some(body)) => found.push(Ok(body.to_vec())),
                Ok(None) => break,
                Err(error) => {
                    found.push(Err(error.to_string()));
                    return found;
                }
            }
        }
    }
    found
}

fn inputs<'a>(pieces: impl Iterator<Item = &'a [u8]>) -> Vec<String> {
    let (mut inbound, mut found) = (Inbound::new(), Vec::new());
    for piece in pieces {
        inbound.handle_bytes(piece);
        while let Some(input) = inbound.poll() {
            assert!(!found.iter().any(|(is_last, _)| *is_last), "nothing comes after a violation");
            found.push((matches!(input, Input::Violation(_)), format!("{input:?}")));
        }
    }
    found.into_iter().map(|(_, input)| input).collect()
}

/// Gives every map the same tiles.
struct Tiles;

impl Resolver for Tiles {
    fn resolve(&self, path: &str) -> Result<Vec<u8>, String> {
        if path.ends_with(".tsx") {
            Ok(include_bytes!("../../../maps/tiles.tsx").to_vec())
        } else {
            Err("there is no such file".to_owned())
        }
    }
}

fn tiles(name: &str, data: &[u8]) {
    match maniple_tilemap::read(name, data, &Tiles) {
        Ok(map) => {
            assert_eq!(map.tiles().len(), (map.width() * map.height()) as usize);
            for wall in map.segments() {
                assert!(wall.start != wall.end);
            }
        }
        Err(error) => {
            let _ = error.to_string();
        }
    }
}
