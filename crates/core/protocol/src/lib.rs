//! Messages, frames, codec, handshake and replay bytes: turns values into bytes and back, and does no I/O.
//!
//! `docs/PROTOCOL.md` says the same for authors of clients in other languages, byte by byte.

#[cfg(test)]
mod arbitrary;
mod codec;
mod encoding;
mod feed;
mod fingerprint;
mod frame;
mod handshake;
mod lag;
mod limits;
mod message;
mod outbound;
mod packed;
mod refused;
mod replay;
mod replay_reader;
mod snapshot;

pub use encoding::{
    DecodeError, EncodeError, Encoding, EncodingError, decode_client, decode_server, encode_client,
    encode_commands, encode_server,
};
pub use feed::{Feed, MERGED_CYCLES_MAX, MERGED_ENTRIES_MAX, SharedBytes};
pub use fingerprint::{Content, Difference, Fingerprint};
pub use frame::{FrameDecoder, FrameError};
pub use handshake::{Inbound, Input};
pub use lag::{
    BYTES_UNTAKEN_MAX, CYCLES_UNSEEN_MAX, CYCLES_WITHHELD_MAX, DELTAS_UNTAKEN_MAX, Lag, Turn, Untaken,
};
pub use limits::{
    FRAME_FROM_CLIENT_MAX, FRAME_FROM_SERVER_MAX, HELLO_MAX, NAME_MAX, REPLAY_RECORD_MAX, SKIPPED_MAX,
    SNAPSHOT_MAX, TOKEN_DIGITS,
};
pub use message::{
    ClientMessage, Create, Hello, Listed, ListedSeat, ListedSpectators, PROTOCOL, ServerMessage, Watch,
    Welcome,
};
pub use outbound::Outbound;
pub use packed::{PackedAppeared, PackedDelta, PackedError, PackedProblem, Packer, Rest};
pub use refused::Refused;
pub use replay::{REPLAY_VERSION, Record, ReplayHeader, ReplayWriter};
pub use replay_reader::{Partial, Replay, ReplayError, ReplayProblem, read_partial, read_replay};
pub use snapshot::{SNAPSHOT_VERSION, SnapshotError, decode_snapshot, encode_snapshot};
