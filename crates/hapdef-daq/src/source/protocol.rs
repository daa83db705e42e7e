//! The protocols that a link may carry.

/// What the bytes of a link mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Protocol {
    /// HDP1.
    Hdp1,
    /// Lines of that many integers, as the authors' sketch prints them (10).
    Csv {
        /// Integers in a line.
        n_channels: usize,
    },
}
