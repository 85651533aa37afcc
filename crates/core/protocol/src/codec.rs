//! The binary format: the only module that names bincode.
//!
//! Its byte layout is written down in `docs/PROTOCOL.md` and held by golden vectors, so that another codec can
//! take its place without a client noticing.

use bincode::config::{self, Configuration};
use bincode::de::read::Reader;
use bincode::error::DecodeError;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// bincode counts a varint against its limit with the size of the decoded type, at most 8 bytes, of which at
/// least 1 is in the body. So this many times the body's length refuses nothing that is whole.
const CLAIM_A_BYTE_MAX: usize = 8;

/// bincode reserves memory for a text before it reads it, up to its limit, which is a constant. Three of them keep
/// that memory near to the length of the body: this is the longest body for the first, a client's message.
const SMALL: usize = crate::limits::FRAME_FROM_CLIENT_MAX;

/// The longest body for the second limit: most messages of a server.
const MEDIUM: usize = 1024 * 1024;

/// The longest body for the third limit: the longest of all.
const LARGE: usize = crate::limits::REPLAY_RECORD_MAX;

/// Bytes that do not decode to a value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct CodecError {
    /// How many bytes had been read when it was noticed.
    pub(crate) offset: usize,
    /// What is wrong.
    pub(crate) problem: String,
}

/// Writes a value behind what `bytes` holds.
pub(crate) fn encode_onto<T: Serialize>(bytes: &mut Vec<u8>, value: &T) {
    bincode::serde::encode_into_std_write(value, bytes, config::standard())
        .expect("memory takes every byte, and every sequence of ours knows its length");
}

/// Returns the value of a whole body, of which no byte may be left.
pub(crate) fn decode<T: DeserializeOwned>(body: &[u8]) -> Result<T, CodecError> {
    if body.len() <= SMALL {
        decode_limited(body, config::standard().with_limit::<{ SMALL * CLAIM_A_BYTE_MAX }>())
    } else if body.len() <= MEDIUM {
        decode_limited(body, config::standard().with_limit::<{ MEDIUM * CLAIM_A_BYTE_MAX }>())
    } else {
        decode_limited(body, config::standard().with_limit::<{ LARGE * CLAIM_A_BYTE_MAX }>())
    }
}

fn decode_limited<T: DeserializeOwned, const LIMIT: usize>(
    body: &[u8],
    config: Configuration<config::LittleEndian, config::Varint, config::Limit<LIMIT>>,
) -> Result<T, CodecError> {
    let mut reader = Body { left: body };
    let decoded = bincode::serde::decode_from_reader(&mut reader, config);
    let offset = body.len() - reader.left.len();
    match decoded {
        Ok(value) if reader.left.is_empty() => Ok(value),
        Ok(_) => Err(CodecError { offset, problem: format!("{} bytes are left over", reader.left.len()) }),
        Err(error) => Err(CodecError { offset, problem: described(&error) }),
    }
}

fn described(error: &DecodeError) -> String {
    if let DecodeError::UnexpectedEnd { additional } = error {
        format!("the body ends {additional} bytes too early")
    } else if let DecodeError::LimitExceeded = error {
        "a length is larger than the body".to_owned()
    } else if let DecodeError::OtherString(text) = error {
        text.clone()
    } else {
        format!("{error:?}")
    }
}

/// A body that knows how far it was read.
struct Body<'a> {
    left: &'a [u8],
}

impl Reader for Body<'_> {
    fn read(&mut self, bytes: &mut [u8]) -> Result<(), DecodeError> {
        let Some((head, tail)) = self.left.split_at_checked(bytes.len()) else {
            return Err(DecodeError::UnexpectedEnd { additional: bytes.len() - self.left.len() });
        };
        bytes.copy_from_slice(head);
        self.left = tail;
        Ok(())
    }

    fn peek_read(&mut self, length: usize) -> Option<&[u8]> {
        self.left.get(..length)
    }

    fn consume(&mut self, length: usize) {
        self.left = self.left.get(length..).unwrap_or_default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_layout_is_the_documented_one() {
        check(&250u32, &[250]);
        check(&251u32, &[251, 251, 0]);
        check(&65_536u32, &[252, 0, 0, 1, 0]);
        check(&u64::MAX, &[253, 255, 255, 255, 255, 255, 255, 255, 255]);
        check(&1.5f64, &[0, 0, 0, 0, 0, 0, 0xf8, 0x3f]);
        check(&true, &[1]);
        check(&Some(7u16), &[1, 7]);
        check(&None::<u16>, &[0]);
        check(&'é', &[0xc3, 0xa9]);
        check(&"é".to_owned(), &[2, 0xc3, 0xa9]);
        check(&vec![1u16, 300], &[2, 1, 251, 44, 1]);
        check(&(1u8, 2u32), &[1, 2]);
    }

    #[test]
    fn a_long_form_of_a_small_number_is_read() {
        assert_eq!(decode::<u32>(&[251, 5, 0]), Ok(5));
        assert_eq!(decode::<u32>(&[252, 5, 0, 0, 0]), Ok(5));
    }

    #[test]
    fn bytes_that_are_left_over_are_an_error() {
        let error = decode::<u32>(&[5, 6]).unwrap_err();
        assert_eq!(error, CodecError { offset: 1, problem: "1 bytes are left over".to_owned() });
    }

    #[test]
    fn a_forged_length_is_an_error() {
        for length in [1u64 << 63, u64::MAX, 1 << 40, 1 << 28, 200] {
            let mut bytes = Vec::new();
            encode_onto(&mut bytes, &length);
            bytes.extend_from_slice(&[1; 20]);
            assert!(decode::<String>(&bytes).is_err(), "text of {length} bytes");
            assert!(decode::<Vec<u8>>(&bytes).is_err(), "list of {length} bytes");
            assert!(decode::<Vec<(f64, f64)>>(&bytes).is_err(), "list of {length} pairs");
            assert!(decode::<Vec<String>>(&bytes).is_err(), "list of {length} texts");
        }
    }

    #[test]
    fn a_body_of_one_byte_numbers_is_within_the_limit() {
        for count in [SMALL - 3, MEDIUM - 5] {
            let numbers = vec![0u64; count];
            let mut bytes = Vec::new();
            encode_onto(&mut bytes, &numbers);
            assert_eq!(decode(&bytes), Ok(numbers));
        }
    }

    fn check<T: Serialize + DeserializeOwned + PartialEq + std::fmt::Debug>(value: &T, expected: &[u8]) {
        let mut bytes = Vec::new();
        encode_onto(&mut bytes, value);
        assert_eq!(bytes, expected, "{value:?}");
        assert_eq!(decode::<T>(&bytes).as_ref(), Ok(value));
    }
}
