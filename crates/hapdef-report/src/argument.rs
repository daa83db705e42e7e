//! Arguments that can't be used, here and in the crates above.

/// What is wrong with an argument. Each variant carries what was found.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ArgumentError {
    /// A slice does not have the length its documented shape asks for.
    #[error("{what}: expected {expected} values, found {found}; check the shape passed in")]
    Shape {
        /// The argument.
        what: &'static str,
        /// Values its shape asks for.
        expected: usize,
        /// Values it has.
        found: usize,
    },
    /// A parameter lies outside the range that it is defined for.
    #[error("{what} = {value}: must be {expected}")]
    Parameter {
        /// The parameter.
        what: &'static str,
        /// The value given.
        value: f64,
        /// The allowed range, in words.
        expected: &'static str,
    },
    /// An index points past the end of what it indexes.
    #[error("{what}: index {index} at position {position}, but there are only {len}")]
    Index {
        /// What is indexed.
        what: &'static str,
        /// The index.
        index: usize,
        /// Where the index was found.
        position: usize,
        /// Entries there are.
        len: usize,
    },
    /// A name is not fit for the place it goes to.
    #[error("{what} {name:?}: {expected}")]
    Name {
        /// Kind of name.
        what: &'static str,
        /// The name found.
        name: String,
        /// What is allowed, in words.
        expected: &'static str,
    },
}

/// Refuses a slice whose length is not `expected`.
///
/// # Errors
/// [`ArgumentError::Shape`].
pub fn check_len(what: &'static str, expected: usize, found: usize) -> Result<(), ArgumentError> {
    if expected == found { Ok(()) } else { Err(ArgumentError::Shape { what, expected, found }) }
}
