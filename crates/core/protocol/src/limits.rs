//! How long a name, a message and a record may be, and why.

/// Bytes of a message before the handshake is over: a hello has 3 texts of at most 64 bytes, and whoever has not
/// shown a token yet shall not make the server keep more.
pub const HELLO_MAX: usize = 4 * 1024;

/// Bytes of a message from a client after the handshake: about 170 commands as JSON, 600 in binary. A seat's
/// commands of a cycle may come in several messages; [`crate::encode_commands`] splits them.
pub const FRAME_FROM_CLIENT_MAX: usize = 16 * 1024;

/// Bytes of a message from a client that is dropped because it is longer: who says more in one is not heard out.
pub const SKIPPED_MAX: usize = 1024 * 1024;

/// Bytes of a message from the server: a welcome with 16 MiB of tiles, which is a map of 4096 x 4096, and 48 MiB
/// of walls, or a keyframe of a million objects.
pub const FRAME_FROM_SERVER_MAX: usize = 64 * 1024 * 1024;

/// Bytes of the name of a player or a client: it has to fit in a table of results.
pub const NAME_MAX: usize = 64;

/// Hex digits of a seat's token: 128 bits, which nobody guesses.
pub const TOKEN_DIGITS: usize = 32;

/// Bytes of one record of a replay: the header holds a map file, and one of 4096 x 4096 tiles as comma-separated
/// text has 32 to 100 MiB.
pub const REPLAY_RECORD_MAX: usize = 128 * 1024 * 1024;

/// Bytes of a snapshot: as many as a record of a replay may have, so that a journal can hold it. A battle of 140 units that is
/// watched in three views, five cycles behind, takes 94,000.
pub const SNAPSHOT_MAX: usize = REPLAY_RECORD_MAX;
