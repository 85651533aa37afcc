//! Snapshots as bytes: `MNPS`, a version of 2 bytes, the body in the binary format, and a checksum of 8 bytes over all of it.
//!
//! What is in the body is for the referee to say. A snapshot is for the build that took it: where the version differs, the match
//! is played again from its replay.

use serde::Serialize;
use serde::de::DeserializeOwned;
use thiserror::Error;
use twox_hash::XxHash3_64;

use crate::codec;
use crate::encoding::EncodeError;
use crate::limits::SNAPSHOT_MAX;

/// The version of the layout; it rises with every change of a field of a snapshot.
pub const SNAPSHOT_VERSION: u16 = 1;

/// What a snapshot begins with.
const MAGIC: &[u8; 4] = b"MNPS";

/// Bytes of the checksum at the end: the XXH3-64 of all before it.
const CHECKSUM_SIZE: usize = 8;

/// Bytes that are no whole snapshot.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum SnapshotError {
    /// They do not begin with `MNPS`.
    #[error("this is no snapshot: it does not begin with `MNPS`")]
    NotASnapshot,
    /// The layout has another version.
    #[error(
        "the snapshot's layout has version {found}, this program reads {SNAPSHOT_VERSION}; go on from the replay instead"
    )]
    Version {
        /// The version of the snapshot.
        found: u16,
    },
    /// More bytes than a snapshot may have.
    #[error("the snapshot has {length} bytes, at most {SNAPSHOT_MAX} are possible")]
    TooLarge {
        /// How many it has.
        length: usize,
    },
    /// A checksum that does not belong to the bytes before it.
    #[error("the checksum does not match: the snapshot was cut or altered")]
    Altered,
    /// A body that is no snapshot, under the right checksum.
    #[error("byte {offset} of the snapshot's body: {problem}")]
    Malformed {
        /// The byte within the body.
        offset: usize,
        /// What is wrong there.
        problem: String,
    },
}

/// Returns the bytes of a snapshot.
///
/// # Errors
/// More than [`SNAPSHOT_MAX`] bytes.
pub fn encode_snapshot<T: Serialize>(snapshot: &T) -> Result<Vec<u8>, EncodeError> {
    let mut bytes = MAGIC.to_vec();
    bytes.extend_from_slice(&SNAPSHOT_VERSION.to_le_bytes());
    codec::encode_onto(&mut bytes, snapshot);
    let checksum = XxHash3_64::oneshot(&bytes);
    bytes.extend_from_slice(&checksum.to_le_bytes());
    let length = bytes.len();
    if length > SNAPSHOT_MAX {
        return Err(EncodeError::TooLarge { length, limit: SNAPSHOT_MAX });
    }
    Ok(bytes)
}

/// Returns the snapshot of bytes. Whether a match can go on from it is for the referee to say.
///
/// # Errors
/// See [`SnapshotError`].
pub fn decode_snapshot<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, SnapshotError> {
    if bytes.len() > SNAPSHOT_MAX {
        return Err(SnapshotError::TooLarge { length: bytes.len() });
    }
    let rest = bytes.strip_prefix(MAGIC).ok_or(SnapshotError::NotASnapshot)?;
    let (version, rest) = rest.split_first_chunk().ok_or(SnapshotError::Altered)?;
    let found = u16::from_le_bytes(*version);
    if found != SNAPSHOT_VERSION {
        return Err(SnapshotError::Version { found });
    }
    let (body, checksum) = rest.split_last_chunk::<CHECKSUM_SIZE>().ok_or(SnapshotError::Altered)?;
    let summed = &bytes[..bytes.len() - CHECKSUM_SIZE];
    if u64::from_le_bytes(*checksum) != XxHash3_64::oneshot(summed) {
        return Err(SnapshotError::Altered);
    }
    codec::decode(body)
        .map_err(|error| SnapshotError::Malformed { offset: error.offset, problem: error.problem })
}

#[cfg(test)]
mod tests {
    use super::*;

    type Value = (u32, Vec<(String, f64)>);

    #[test]
    fn a_snapshot_reads_back_and_every_cut_or_altered_one_is_an_error() {
        let value: Value = (7, vec![("a".to_owned(), 0.5), ("b".to_owned(), -0.0)]);
        let bytes = encode_snapshot(&value).unwrap();
        assert_eq!(decode_snapshot::<Value>(&bytes), Ok(value));
        for length in 0..bytes.len() {
            assert!(decode_snapshot::<Value>(&bytes[..length]).is_err(), "cut after {length}");
        }
        for bit in 0..8 * bytes.len() {
            let mut altered = bytes.clone();
            altered[bit / 8] ^= 1 << (bit % 8);
            assert!(decode_snapshot::<Value>(&altered).is_err(), "bit {bit}");
        }
    }

    #[test]
    fn what_is_wrong_is_said() {
        let check = |bytes: &[u8], expected: &str| {
            assert_eq!(decode_snapshot::<Value>(bytes).unwrap_err().to_string(), expected);
        };
        check(b"MNPR\x01\0", "this is no snapshot: it does not begin with `MNPS`");
        check(
            b"MNPS\x09\0",
            "the snapshot's layout has version 9, this program reads 1; go on from the replay instead",
        );
        check(b"MNPS\x01\0\0\0", "the checksum does not match: the snapshot was cut or altered");
        let other = encode_snapshot(&(7u32, u64::MAX)).unwrap();
        check(&other, "byte 10 of the snapshot's body: the body ends 1 bytes too early");
    }
}
