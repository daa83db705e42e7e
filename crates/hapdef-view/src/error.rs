//! What can go wrong.

#[cfg(feature = "server")]
use std::net::SocketAddr;

use thiserror::Error;

/// Why the page cannot be shown, or a frame not be handed on.
#[derive(Debug, Error)]
#[allow(missing_docs, reason = "a variant's message is its documentation")]
pub enum ViewError {
    #[cfg(feature = "server")]
    #[error("cannot listen at {address}: {source}; give another port, or 0 for any free one")]
    Bind { address: SocketAddr, source: std::io::Error },
    #[cfg(feature = "server")]
    #[error(
        "{address} listens on every network: name the host that browsers will use in `allowed_hosts`"
    )]
    NoHostNamed { address: SocketAddr },
    #[cfg(feature = "server")]
    #[error("{found:?} is no host: expected a name or an address without scheme, port or path")]
    BadHost { found: String },
    #[cfg(feature = "server")]
    #[error("a patience of 0 s would let every page go: expected some seconds")]
    NoPatience,
    #[cfg(feature = "server")]
    #[error("a token has 32 hexadecimal digits, found {found} characters")]
    BadToken { found: usize },
    #[cfg(feature = "server")]
    #[error("no random numbers from the system for a token: {text}; give a token instead")]
    NoRandomness { text: String },
    #[cfg(feature = "server")]
    #[error("cannot start the page's thread: {source}")]
    Thread { source: std::io::Error },
    #[cfg(feature = "server")]
    #[error(
        "a limb's page of {found:?}: expected a word of letters, digits and _ that no other limb has"
    )]
    LimbName { found: String },
    #[cfg(feature = "server")]
    #[error("{name:?} is no limb of this robot's page, or its page is there already")]
    NoSuchLimb { name: String },
    #[error("a press of {default_n} N at first and {max_n} N at most: expected 0 < first ≤ most")]
    BadPressOffer { default_n: f64, max_n: f64 },
    #[error("the limb's picture has {found} {what}, expected {expected}")]
    Picture { what: &'static str, expected: String, found: usize },
    #[error("the limb's picture has a {what} that is not finite, number {index}")]
    PictureNumber { what: &'static str, index: usize },
    #[error("a frame has {found} {what}, the page was started with {expected}")]
    FrameShape { what: &'static str, expected: usize, found: usize },
    #[error("contact {index} of a frame has a {what} that is not finite")]
    ContactNumber { index: usize, what: &'static str },
}
