//! What can go wrong.

use std::net::SocketAddr;

use thiserror::Error;

/// Why the page cannot be shown, or a frame not be handed on.
#[derive(Debug, Error)]
pub enum ViewError {
    /// The address is taken or not ours.
    #[error("cannot listen at {address}: {source}; give another port, or 0 for any free one")]
    Bind {
        /// Where.
        address: SocketAddr,
        /// What the system said.
        source: std::io::Error,
    },
    /// Listening everywhere without a name that the page may be asked by.
    #[error(
        "{address} listens on every network: name the host that browsers will use in `allowed_hosts`"
    )]
    NoHostNamed {
        /// Where.
        address: SocketAddr,
    },
    /// A host name with characters that no host has.
    #[error("{found:?} is no host: expected a name or an address without scheme, port or path")]
    BadHost {
        /// The name.
        found: String,
    },
    /// A page would be let go at once.
    #[error("a patience of 0 s would let every page go: expected some seconds")]
    NoPatience,
    /// A token of another form.
    #[error("a token has 32 hexadecimal digits, found {found} characters")]
    BadToken {
        /// Characters found.
        found: usize,
    },
    /// The system has no randomness for a token.
    #[error("no random numbers from the system for a token: {text}; give a token instead")]
    NoRandomness {
        /// What the system said.
        text: String,
    },
    /// The server's thread did not start.
    #[error("cannot start the page's thread: {source}")]
    Thread {
        /// What the system said.
        source: std::io::Error,
    },
    /// An offer of presses without a sensible force.
    #[error("a press of {default_n} N at first and {max_n} N at most: expected 0 < first ≤ most")]
    BadPressOffer {
        /// Force at first, N.
        default_n: f64,
        /// Largest force, N.
        max_n: f64,
    },
    /// A picture that cannot be drawn.
    #[error("the limb's picture has {found} {what}, expected {expected}")]
    Picture {
        /// What was counted.
        what: &'static str,
        /// What it should be.
        expected: String,
        /// What it is.
        found: usize,
    },
    /// A number of the picture is not finite.
    #[error("the limb's picture has a {what} that is not finite, number {index}")]
    PictureNumber {
        /// Which list.
        what: &'static str,
        /// Where in it.
        index: usize,
    },
    /// A frame of another shape than the picture.
    #[error("a frame has {found} {what}, the page was started with {expected}")]
    FrameShape {
        /// What was counted.
        what: &'static str,
        /// As started.
        expected: usize,
        /// In the frame.
        found: usize,
    },
    /// A contact that cannot be drawn.
    #[error("contact {index} of a frame has a {what} that is not finite")]
    ContactNumber {
        /// Which contact.
        index: usize,
        /// Which number.
        what: &'static str,
    },
}
