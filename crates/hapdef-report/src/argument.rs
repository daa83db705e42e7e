//! Arguments that can't be used, here and in the crates above.

/// What is wrong with an argument. Each variant carries what was found.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "a variant's message is its documentation")]
pub enum ArgumentError {
    #[error("{what}: expected {expected} values, found {found}; check the shape passed in")]
    Shape { what: &'static str, expected: usize, found: usize },
    #[error("{what} = {value}: must be {expected}")]
    Parameter { what: &'static str, value: f64, expected: &'static str },
    #[error("{what}: index {index} at position {position}, but there are only {len}")]
    Index { what: &'static str, index: usize, position: usize, len: usize },
    #[error("{what} {name:?}: {expected}")]
    Name { what: &'static str, name: String, expected: &'static str },
}

/// Refuses a slice whose length is not `expected`.
///
/// # Errors
/// [`ArgumentError::Shape`].
pub fn check_len(what: &'static str, expected: usize, found: usize) -> Result<(), ArgumentError> {
    if expected == found { Ok(()) } else { Err(ArgumentError::Shape { what, expected, found }) }
}
