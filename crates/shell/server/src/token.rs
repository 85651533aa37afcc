//! What opens a seat.

use std::fmt;
use std::hint::black_box;
use std::str::FromStr;

use maniple_protocol::TOKEN_DIGITS;
use thiserror::Error;

/// 128 bits that open a seat; as text, 32 hex digits.
///
/// `Debug` does not show it, so that it does not get into a log by accident, and it has no `==`, because comparing
/// it has to take the same time whatever was guessed.
#[derive(Clone, Copy)]
pub struct Token(u128);

/// A text that is no token.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[error("a token has {TOKEN_DIGITS} hex digits")]
pub struct TokenError;

impl Token {
    /// Returns a token of random bits from the operating system.
    ///
    /// # Errors
    /// An operating system that has none.
    pub fn random() -> Result<Self, getrandom::Error> {
        let mut bytes = [0; 16];
        getrandom::fill(&mut bytes)?;
        Ok(Self(u128::from_le_bytes(bytes)))
    }

    /// Returns whether it is the same token, in a time that does not depend on how many bits differ.
    pub(crate) fn is_same(self, other: Self) -> bool {
        black_box(self.0 ^ other.0) == 0
    }
}

impl FromStr for Token {
    type Err = TokenError;

    fn from_str(text: &str) -> Result<Self, TokenError> {
        let is_token = text.len() == TOKEN_DIGITS && text.bytes().all(|byte| byte.is_ascii_hexdigit());
        match u128::from_str_radix(text, 16) {
            Ok(bits) if is_token => Ok(Self(bits)),
            Ok(_) | Err(_) => Err(TokenError),
        }
    }
}

impl fmt::Display for Token {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:032x}", self.0)
    }
}

impl fmt::Debug for Token {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Token")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_token_reads_back_from_its_text() {
        let token = Token::random().unwrap();
        let text = token.to_string();
        assert_eq!(text.len(), TOKEN_DIGITS);
        assert!(text.parse::<Token>().unwrap().is_same(token));
        assert!(text.to_uppercase().parse::<Token>().unwrap().is_same(token));
        assert!(!Token::random().unwrap().is_same(token));
    }

    #[test]
    fn a_token_has_32_hex_digits_and_nothing_else() {
        for text in
            ["", "0", &"0".repeat(31), &"0".repeat(33), &"g".repeat(32), &format!("+{}", "0".repeat(31))]
        {
            assert_eq!(text.parse::<Token>().err(), Some(TokenError), "{text:?}");
        }
    }

    #[test]
    fn debug_output_hides_a_token() {
        assert_eq!(format!("{:?}", Token(0x1234)), "Token");
    }
}
