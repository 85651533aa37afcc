//! Numbers of as many bytes as they need: LEB128, with zigzag for negative ones.

use super::PackedProblem;

/// Writes seven bits a byte, the lowest first; all bytes but the last have their highest bit set.
pub(super) fn write_unsigned(bytes: &mut Vec<u8>, mut number: u64) {
    while number >= 0x80 {
        bytes.push(low_bits(number) | 0x80);
        number >>= 7;
    }
    bytes.push(low_bits(number));
}

/// Writes `2 n`, or `-2 n - 1` where n is negative.
pub(super) fn write_signed(bytes: &mut Vec<u8>, number: i64) {
    write_unsigned(bytes, ((number << 1) ^ (number >> 63)).cast_unsigned());
}

fn low_bits(number: u64) -> u8 {
    number.to_le_bytes()[0] & 0x7f
}

/// Bytes that are read from their start on.
pub(super) struct Reader<'a> {
    bytes: &'a [u8],
    offset: usize,
}

impl<'a> Reader<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, offset: 0 }
    }

    /// Returns how many bytes have been read.
    pub(super) fn offset(&self) -> usize {
        self.offset
    }

    pub(super) fn is_at_end(&self) -> bool {
        self.offset == self.bytes.len()
    }

    pub(super) fn byte(&mut self) -> Result<u8, PackedProblem> {
        let byte = *self.bytes.get(self.offset).ok_or(PackedProblem::End)?;
        self.offset += 1;
        Ok(byte)
    }

    pub(super) fn unsigned(&mut self) -> Result<u64, PackedProblem> {
        let mut number = 0;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            let bits = u64::from(byte & 0x7f);
            if shift == 63 && bits > 1 {
                return Err(PackedProblem::TooLarge);
            }
            number |= bits << shift;
            if byte < 0x80 {
                return Ok(number);
            }
        }
        Err(PackedProblem::TooLarge)
    }

    pub(super) fn signed(&mut self) -> Result<i64, PackedProblem> {
        let number = self.unsigned()?;
        Ok((number >> 1).cast_signed() ^ -(number & 1).cast_signed())
    }

    pub(super) fn small(&mut self) -> Result<u32, PackedProblem> {
        u32::try_from(self.unsigned()?).map_err(|_| PackedProblem::TooLarge)
    }

    pub(super) fn double(&mut self) -> Result<f64, PackedProblem> {
        let rest = self.bytes.get(self.offset..).unwrap_or_default();
        let bytes = rest.first_chunk::<8>().ok_or(PackedProblem::End)?;
        self.offset += 8;
        Ok(f64::from_le_bytes(*bytes))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_the_documented_bytes() {
        let check = |number: u64, expected: &[u8]| {
            let mut bytes = Vec::new();
            write_unsigned(&mut bytes, number);
            assert_eq!(bytes, expected, "{number}");
            assert_eq!(Reader::new(&bytes).unsigned(), Ok(number));
        };
        check(0, &[0]);
        check(127, &[0x7f]);
        check(128, &[0x80, 1]);
        check(300, &[0xac, 2]);
        check(u64::MAX, &[0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 1]);
        for (number, expected) in
            [(0, 0), (-1, 1), (1, 2), (-2, 3), (i64::MAX, u64::MAX - 1), (i64::MIN, u64::MAX)]
        {
            let (mut signed, mut unsigned) = (Vec::new(), Vec::new());
            write_signed(&mut signed, number);
            write_unsigned(&mut unsigned, expected);
            assert_eq!(signed, unsigned, "{number}");
            assert_eq!(Reader::new(&signed).signed(), Ok(number));
        }
    }

    #[test]
    fn what_is_cut_short_or_too_large_is_an_error() {
        assert_eq!(Reader::new(&[0x80]).unsigned(), Err(PackedProblem::End));
        assert_eq!(Reader::new(&[0xff; 9]).unsigned(), Err(PackedProblem::End));
        assert_eq!(Reader::new(&[0xff; 11]).unsigned(), Err(PackedProblem::TooLarge));
        assert_eq!(Reader::new(&[0; 7]).double(), Err(PackedProblem::End));
        assert_eq!(Reader::new(&[0xff, 0xff, 0xff, 0xff, 0x10]).small(), Err(PackedProblem::TooLarge));
    }
}
