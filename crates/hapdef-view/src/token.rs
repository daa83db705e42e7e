//! The secret in the page's address.

use std::fmt;
use std::str::FromStr;

use crate::error::ViewError;

/// 128 bits that a page needs for commands, and for anything beyond loopback.
///
/// It travels in the fragment of the address, which browsers don't send, and in the first message of
/// the page. [`fmt::Display`] shows it as 32 hexadecimal digits, [`fmt::Debug`] doesn't.
#[derive(Clone, PartialEq, Eq)]
pub struct Token([u8; 16]);

impl Token {
    /// A new one from the system's randomness.
    ///
    /// # Errors
    /// [`ViewError::NoRandomness`].
    pub fn random() -> Result<Self, ViewError> {
        let mut bytes = [0; 16];
        getrandom::fill(&mut bytes)
            .map_err(|error| ViewError::NoRandomness { text: error.to_string() })?;
        Ok(Self(bytes))
    }

    /// Whether `text` is this token, in a time that does not depend on how much of it is right.
    pub(crate) fn is(&self, text: &str) -> bool {
        let expected = self.to_string();
        if text.len() != expected.len() {
            return false;
        }
        let pairs = text.bytes().zip(expected.bytes());
        pairs.fold(0, |differ, (a, b)| differ | (a ^ b)) == 0
    }
}

impl fmt::Display for Token {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(out, "{byte:02x}"))
    }
}

impl fmt::Debug for Token {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str("Token(…)")
    }
}

impl FromStr for Token {
    type Err = ViewError;

    fn from_str(text: &str) -> Result<Self, ViewError> {
        let bad = || ViewError::BadToken { found: text.chars().count() };
        if text.len() != 32 || !text.bytes().all(|byte| byte.is_ascii_hexdigit()) {
            return Err(bad());
        }
        let number = u128::from_str_radix(text, 16).map_err(|_| bad())?;
        Ok(Self(number.to_be_bytes()))
    }
}

#[cfg(test)]
mod tests {
    use super::Token;

    #[test]
    fn text_and_back() {
        let token = Token::random().unwrap();
        assert_eq!(token.to_string().parse::<Token>().unwrap(), token);
        assert!(token.is(&token.to_string()));
        assert!(!format!("{token:?}").contains(&token.to_string()));
    }

    #[test]
    fn two_are_never_the_same() {
        assert_ne!(Token::random().unwrap(), Token::random().unwrap());
    }

    #[test]
    fn one_wrong_digit_is_refused() {
        let token: Token = "00112233445566778899aabbccddeeff".parse().unwrap();
        for wrong in ["", "00112233445566778899aabbccddeefe", "0011"] {
            assert!(!token.is(wrong), "{wrong}");
        }
        for bad in ["", "+0112233445566778899aabbccddeeff", "0011"] {
            assert!(bad.parse::<Token>().is_err(), "{bad}");
        }
    }
}
