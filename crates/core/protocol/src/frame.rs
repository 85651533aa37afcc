//! Cuts a stream of bytes into the bodies of messages.

use std::ops::Range;

use thiserror::Error;

use crate::encoding::Encoding;

/// Bytes of the length before a binary body.
const LENGTH_SIZE: usize = 4;

/// A stream that is not made of messages; nothing after it can be read.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum FrameError {
    /// A message that is longer than allowed.
    #[error("a message is longer than the {limit} bytes that are allowed here")]
    TooLarge {
        /// The largest length in bytes, without length or line end.
        limit: usize,
    },
    /// A frame of length 0: there is no such message.
    #[error("a frame has length 0, but every message has at least 1 byte")]
    Empty,
}

/// Collects the bytes of one direction of a connection and gives out the bodies of its messages.
///
/// How the bytes are split when they come in makes no difference. It keeps one message and what came in the same
/// [`Self::handle_bytes`] behind it, and never sets memory aside for a length that was only announced.
#[derive(Clone, Debug)]
pub struct FrameDecoder {
    encoding: Encoding,
    limit: usize,
    bytes: Vec<u8>,
    /// Where in `bytes` the next message begins.
    start: usize,
    /// How many bytes from `start` on are known to hold no line end.
    scanned: usize,
    /// Bytes of a message that is dropped and has not come in whole: of a line, how many more it may have.
    skipping: Option<usize>,
}

impl FrameDecoder {
    /// Returns a decoder of messages of at most `limit` bytes, without length or line end.
    #[must_use]
    pub fn new(encoding: Encoding, limit: usize) -> Self {
        Self { encoding, limit, bytes: Vec::new(), start: 0, scanned: 0, skipping: None }
    }

    /// Changes the largest length, for the messages that were not given out yet.
    pub fn change_limit(&mut self, limit: usize) {
        self.limit = limit;
    }

    /// Takes bytes that came in.
    ///
    /// # Panics
    /// When [`Self::poll`] was not called until it gave `None` since the last bytes, or gave an error: then the
    /// decoder would grow without limit.
    pub fn handle_bytes(&mut self, bytes: &[u8]) {
        self.bytes.drain(..self.start);
        self.start = 0;
        assert!(
            self.bytes.len() <= self.limit + LENGTH_SIZE,
            "all messages are taken out before more bytes come in"
        );
        let bytes = self.skipped(bytes);
        self.bytes.extend_from_slice(bytes);
    }

    /// Drops the message that was found to be too large, as it comes in, and goes on with the next.
    ///
    /// # Errors
    /// A frame of more than `skip_max` bytes. Of a line that is longer the rest is taken for another message.
    ///
    /// # Panics
    /// When [`Self::poll`] did not give [`FrameError::TooLarge`] just before.
    pub fn skip(&mut self, skip_max: usize) -> Result<(), FrameError> {
        assert!(self.skipping.is_none(), "a message was found to be too large");
        let rest = &self.bytes[self.start..];
        let (at, length) = match self.encoding {
            Encoding::Binary => {
                let length = rest.first_chunk().map_or(0, |length| u32::from_le_bytes(*length));
                (LENGTH_SIZE, usize::try_from(length).unwrap_or(usize::MAX))
            }
            Encoding::Json => (0, skip_max),
        };
        if length > skip_max {
            return Err(FrameError::TooLarge { limit: self.limit });
        }
        let come_in = self.bytes.split_off(self.start + at);
        self.bytes.clear();
        (self.start, self.scanned, self.skipping) = (0, 0, Some(length));
        let rest = self.skipped(&come_in);
        self.bytes.extend_from_slice(rest);
        Ok(())
    }

    /// Returns the body of the next message; `None` until more bytes have come in. Empty lines are skipped.
    ///
    /// # Errors
    /// A stream that is not made of messages; every later call gives the same error.
    pub fn poll(&mut self) -> Result<Option<&[u8]>, FrameError> {
        let body = match self.encoding {
            Encoding::Binary => self.next_frame()?,
            Encoding::Json => self.next_line()?,
        };
        if body.is_none() && self.buffered() == 0 {
            // Who says nothing takes no memory.
            (self.bytes, self.start) = (Vec::new(), 0);
        }
        Ok(body.map(|range| &self.bytes[range]))
    }

    /// Returns the encoding of the messages.
    #[must_use]
    pub fn encoding(&self) -> Encoding {
        self.encoding
    }

    /// Returns how many bytes wait.
    #[must_use]
    pub fn buffered(&self) -> usize {
        self.bytes.len() - self.start
    }

    /// Returns what is left behind the message that is dropped.
    fn skipped<'a>(&mut self, bytes: &'a [u8]) -> &'a [u8] {
        let Some(left) = self.skipping else { return bytes };
        let end = match self.encoding {
            Encoding::Binary => (bytes.len() >= left).then_some(left),
            // Not behind the limit, however the bytes are split.
            Encoding::Json => bytes.iter().take(left).position(|&byte| byte == b'\n').map(|place| place + 1),
        };
        if let Some(end) = end {
            self.skipping = None;
            return &bytes[end..];
        }
        // Of a line that goes on for longer, the rest is taken for another message.
        let (_, rest) = bytes.split_at_checked(left).unwrap_or((bytes, &[]));
        self.skipping = left.checked_sub(bytes.len()).filter(|&left| left > 0);
        rest
    }

    fn next_frame(&mut self) -> Result<Option<Range<usize>>, FrameError> {
        let Some((length, rest)) = self.bytes[self.start..].split_first_chunk::<LENGTH_SIZE>() else {
            return Ok(None);
        };
        let length = usize::try_from(u32::from_le_bytes(*length)).unwrap_or(usize::MAX);
        if length == 0 {
            return Err(FrameError::Empty);
        }
        if length > self.limit {
            return Err(FrameError::TooLarge { limit: self.limit });
        }
        if rest.len() < length {
            return Ok(None);
        }
        let body_start = self.start + LENGTH_SIZE;
        self.start = body_start + length;
        Ok(Some(body_start..self.start))
    }

    fn next_line(&mut self) -> Result<Option<Range<usize>>, FrameError> {
        loop {
            let rest = &self.bytes[self.start..];
            let end = rest[self.scanned..].iter().position(|&byte| byte == b'\n');
            let length = end.map_or(rest.len(), |end| self.scanned + end);
            if length > self.limit {
                return Err(FrameError::TooLarge { limit: self.limit });
            }
            if end.is_none() {
                self.scanned = length;
                return Ok(None);
            }
            let is_empty = rest[..length].trim_ascii().is_empty();
            let line_start = self.start;
            self.start += length + 1;
            self.scanned = 0;
            if !is_empty {
                return Ok(Some(line_start..line_start + length));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arbitrary::Random;

    #[test]
    fn a_frame_comes_out_when_its_last_byte_has_come_in() {
        check(Encoding::Binary, b"\x03\0\0\0ab", Ok(&[]));
        check(Encoding::Binary, b"\x03\0\0\0abc", Ok(&["abc"]));
        check(Encoding::Binary, b"\x01\0\0\0a\x02\0\0\0bc\x03", Ok(&["a", "bc"]));
        check(Encoding::Binary, b"\x08\0\0\0abcdefgh", Ok(&["abcdefgh"]));
    }

    #[test]
    fn a_line_comes_out_when_its_end_has_come_in() {
        check(Encoding::Json, b"{}", Ok(&[]));
        check(Encoding::Json, b"{}\n", Ok(&["{}"]));
        check(Encoding::Json, b"{}\r\n[]\n", Ok(&["{}\r", "[]"]));
        check(Encoding::Json, b"\n\r\n  \n{}\n\n", Ok(&["{}"]));
        check(Encoding::Json, b"abcdefgh\nab", Ok(&["abcdefgh"]));
    }

    #[test]
    fn a_length_out_of_range_is_refused_before_the_body_comes() {
        check(Encoding::Binary, b"\0\0\0\0", Err(FrameError::Empty));
        check(Encoding::Binary, b"\x09\0\0\0", Err(FrameError::TooLarge { limit: 8 }));
        check(Encoding::Binary, b"\xff\xff\xff\xff", Err(FrameError::TooLarge { limit: 8 }));
        check(Encoding::Json, b"abcdefghi", Err(FrameError::TooLarge { limit: 8 }));
        check(Encoding::Json, b"abcdefghi\n", Err(FrameError::TooLarge { limit: 8 }));
    }

    #[test]
    fn no_memory_is_set_aside_for_a_length_that_was_only_announced() {
        for length in [1 << 20, (1 << 20) + 1, u32::MAX] {
            let mut decoder = FrameDecoder::new(Encoding::Binary, 1 << 20);
            decoder.handle_bytes(&length.to_le_bytes());
            assert_eq!(decoder.poll().is_ok(), length == 1 << 20);
            assert!(decoder.bytes.capacity() < 1 << 10, "{length}: {}", decoder.bytes.capacity());
        }
    }

    #[test]
    fn a_message_that_is_too_large_can_be_dropped_however_it_is_split() {
        for (encoding, stream, expected) in [
            (Encoding::Binary, &b"\x09\0\0\0abcdefghi\x01\0\0\0b"[..], &b"b"[..]),
            (Encoding::Json, b"abcdefghij\nb\n", b"b"),
        ] {
            for size in 1..=stream.len() {
                let (mut decoder, mut bodies, mut dropped) = (FrameDecoder::new(encoding, 8), vec![], 0);
                for bytes in stream.chunks(size) {
                    decoder.handle_bytes(bytes);
                    loop {
                        match decoder.poll() {
                            Ok(Some(body)) => bodies.push(body.to_vec()),
                            Ok(None) => break,
                            Err(_) => {
                                dropped += 1;
                                decoder.skip(12).unwrap();
                            }
                        }
                    }
                    assert!(decoder.buffered() <= 12, "{encoding:?} by {size}");
                }
                assert_eq!((bodies, dropped), (vec![expected.to_vec()], 1), "{encoding:?} by {size}");
            }
        }
    }

    #[test]
    fn what_is_dropped_has_a_limit_too() {
        let too_large = Err(FrameError::TooLarge { limit: 8 });
        let mut decoder = FrameDecoder::new(Encoding::Binary, 8);
        decoder.handle_bytes(b"\x0d\0\0\0");
        assert_eq!((decoder.poll().map(|_| ()), decoder.skip(12)), (too_large, too_large));
        let mut decoder = FrameDecoder::new(Encoding::Json, 8);
        decoder.handle_bytes(b"abcdefghi");
        assert_eq!((decoder.poll().map(|_| ()), decoder.skip(12)), (too_large, Ok(())));
        decoder.handle_bytes(b"jklmn\n");
        assert_eq!(decoder.poll(), Ok(Some(&b"mn"[..])));
    }

    #[test]
    fn an_error_stays() {
        let mut decoder = FrameDecoder::new(Encoding::Binary, 8);
        decoder.handle_bytes(b"\x09\0\0\0");
        assert_eq!(decoder.poll(), Err(FrameError::TooLarge { limit: 8 }));
        assert_eq!(decoder.poll(), Err(FrameError::TooLarge { limit: 8 }));
    }

    #[test]
    fn how_bytes_are_split_makes_no_difference() {
        for seed in 0..300 {
            let mut random = Random::new(seed);
            for encoding in [Encoding::Binary, Encoding::Json] {
                let stream = stream(&mut random, encoding);
                let whole = collect(encoding, &[&stream]);
                let single: Vec<&[u8]> = stream.chunks(1).collect();
                assert_eq!(collect(encoding, &single), whole, "byte by byte, seed {seed}");
                assert_eq!(collect(encoding, &random.split(&stream)), whole, "seed {seed}");
            }
        }
    }

    #[test]
    fn what_waits_never_grows_beyond_one_message() {
        for encoding in [Encoding::Binary, Encoding::Json] {
            let mut decoder = FrameDecoder::new(encoding, 8);
            for _ in 0..1000 {
                decoder.handle_bytes(b"\x01\0\0\0\n");
                while decoder.poll().unwrap().is_some() {}
                assert!(decoder.buffered() <= 12);
            }
        }
    }

    fn check(encoding: Encoding, stream: &[u8], expected: Result<&[&str], FrameError>) {
        let (bodies, error) = collect(encoding, &[stream]);
        match expected {
            Ok(expected) => {
                let expected: Vec<Vec<u8>> = expected.iter().map(|body| body.as_bytes().to_vec()).collect();
                assert_eq!((bodies, error), (expected, None));
            }
            Err(expected) => assert_eq!(error, Some(expected)),
        }
    }

    fn collect(encoding: Encoding, chunks: &[&[u8]]) -> (Vec<Vec<u8>>, Option<FrameError>) {
        let mut decoder = FrameDecoder::new(encoding, 8);
        let mut bodies = Vec::new();
        for chunk in chunks {
            decoder.handle_bytes(chunk);
            loop {
                match decoder.poll() {
                    Ok(Some(body)) => bodies.push(body.to_vec()),
                    Ok(None) => break,
                    Err(error) => return (bodies, Some(error)),
                }
            }
        }
        (bodies, None)
    }

    /// Whole messages, at times followed by nonsense.
    fn stream(random: &mut Random, encoding: Encoding) -> Vec<u8> {
        let mut stream = Vec::new();
        for _ in 0..random.below(6) {
            let length = 1 + random.below(8);
            if encoding == Encoding::Binary {
                stream.extend_from_slice(&u32::try_from(length).unwrap().to_le_bytes());
            }
            stream.extend((0..length).map(|_| b'a'));
            if encoding == Encoding::Json {
                stream.push(b'\n');
            }
        }
        stream.extend(random.bytes(12));
        stream
    }
}
