//! Replays: what a match started from, every command, and a hash of every state.
//!
//! The file is `MNPR`, a version of 2 bytes, and records; see `docs/PROTOCOL.md`. A replay needs nothing else: it
//! holds the scenario and every file that it refers to. A journal is a replay that goes on.

use maniple_geometry::Cycle;
use maniple_view::{Digest, MatchResult, Profile, Seat, Sequenced};
use serde::{Deserialize, Serialize};
use twox_hash::XxHash3_64;

use crate::codec;
use crate::encoding::EncodeError;
use crate::limits::REPLAY_RECORD_MAX;

/// The version of the file's layout. What is in the records changes with [`crate::PROTOCOL`].
pub const REPLAY_VERSION: u16 = 1;

/// What a replay begins with.
pub(crate) const MAGIC: &[u8; 4] = b"MNPR";

/// Bytes before the first record: magic and version.
pub(crate) const PREAMBLE_SIZE: usize = 6;

/// Bytes of the length before a record's body.
pub(crate) const LENGTH_SIZE: usize = 4;

/// Bytes of the checksum behind a record's body.
pub(crate) const CHECKSUM_SIZE: usize = 8;

/// What a match started from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ReplayHeader {
    /// The [`crate::PROTOCOL`] whose types the records hold.
    pub protocol: u32,
    /// Name and version of the program that recorded it.
    pub build: String,
    /// The scenario's name.
    pub scenario_name: String,
    /// Names and contents of the files: the scenario first, then the map and what it refers to.
    pub files: Vec<(String, Vec<u8>)>,
    /// The scenario's name in `files`.
    pub scenario: String,
    /// The map's name in `files`, where another one than the scenario's was played.
    pub map_override: Option<String>,
    /// The seed of the match.
    pub seed: u64,
    /// Cycles that the match lasts at most; the scenario's length, unless another was asked for.
    pub cycles_max: u32,
    /// Cycles a second; the scenario's rate, unless another was asked for.
    pub rate: f64,
    /// What accuracy was traded with; the scenario's profile, with what was asked for instead.
    pub profile: Profile,
    /// The hash of the map.
    pub map_hash: Digest,
    /// How many seats the match has.
    pub seats: u16,
}

/// One thing that happened in a match. Cycles never go back from one record to the next.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Record {
    /// A player took a seat.
    Joined {
        /// The cycle that was next.
        cycle: Cycle,
        /// The seat.
        seat: Seat,
        /// The player's name.
        name: String,
    },
    /// A seat's commands; a seat may have several of these records in a cycle.
    Commands {
        /// The cycle in which they were applied.
        cycle: Cycle,
        /// The seat.
        seat: Seat,
        /// The last cycle that the client had seen.
        seen_cycle: Cycle,
        /// The commands, in order.
        list: Vec<Sequenced>,
    },
    /// The stall policy forfeited a seat.
    Absent {
        /// The cycle in which it did.
        cycle: Cycle,
        /// The seat.
        seat: Seat,
    },
    /// The state at the start of a cycle; from one of these records to the next the cycle rises by 1.
    Cycle {
        /// The cycle.
        cycle: Cycle,
        /// The state hash.
        hash: Digest,
    },
    /// The match has ended; the last record.
    Ended {
        /// How.
        result: MatchResult,
    },
}

/// Writes a replay, record by record. It gives the bytes; the caller puts them behind the ones before.
#[derive(Clone, Debug)]
pub struct ReplayWriter {
    /// The checksum of the last record.
    chain: u64,
}

impl ReplayWriter {
    /// Returns the writer of a new replay, and the bytes that it begins with.
    ///
    /// # Errors
    /// A header, which holds the files, of more than [`REPLAY_RECORD_MAX`] bytes.
    pub fn begin(header: &ReplayHeader) -> Result<(Self, Vec<u8>), EncodeError> {
        let mut bytes = preamble().to_vec();
        let mut writer = Self::after(preamble_chain());
        writer.append(&mut bytes, header)?;
        Ok((writer, bytes))
    }

    /// Returns the bytes of the next record.
    ///
    /// # Errors
    /// A record of more than [`REPLAY_RECORD_MAX`] bytes; the writer is as before.
    pub fn push(&mut self, record: &Record) -> Result<Vec<u8>, EncodeError> {
        let mut bytes = Vec::new();
        self.append(&mut bytes, record)?;
        Ok(bytes)
    }

    /// Returns a writer that goes on behind a record with this checksum.
    pub(crate) fn after(chain: u64) -> Self {
        Self { chain }
    }

    fn append<T: Serialize>(&mut self, bytes: &mut Vec<u8>, value: &T) -> Result<(), EncodeError> {
        let start = bytes.len();
        bytes.extend_from_slice(&[0; LENGTH_SIZE]);
        codec::encode_onto(bytes, value);
        let length = bytes.len() - start - LENGTH_SIZE;
        if length > REPLAY_RECORD_MAX {
            return Err(EncodeError::TooLarge { length, limit: REPLAY_RECORD_MAX });
        }
        let prefix = u32::try_from(length).expect("the limit of a record is below 2^32");
        bytes[start..start + LENGTH_SIZE].copy_from_slice(&prefix.to_le_bytes());
        self.chain = next_chain(self.chain, &bytes[start..]);
        bytes.extend_from_slice(&self.chain.to_le_bytes());
        Ok(())
    }
}

/// Returns the bytes that every replay of this version begins with.
pub(crate) fn preamble() -> [u8; PREAMBLE_SIZE] {
    let mut bytes = [0; PREAMBLE_SIZE];
    bytes[..MAGIC.len()].copy_from_slice(MAGIC);
    bytes[MAGIC.len()..].copy_from_slice(&REPLAY_VERSION.to_le_bytes());
    bytes
}

/// Returns the checksum before the first record.
pub(crate) fn preamble_chain() -> u64 {
    next_chain(0, &preamble())
}

/// Returns the checksum of a record, of which `bytes` is length and body: its XXH3-64 with the checksum before it as
/// the seed. So each checksum depends on every byte before it.
pub(crate) fn next_chain(chain: u64, bytes: &[u8]) -> u64 {
    XxHash3_64::oneshot_with_seed(chain, bytes)
}
