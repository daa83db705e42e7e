//! The virtual limb, its runtime and its page in one program without threads or clocks, as for a browser.
//!
//! A [`PageModel`] is one file with everything about a limb and its virtual rig; `hapdef page` writes it. A
//! [`Session`] presses that limb frame by frame, finds the contacts by the runtime of [`hapdef_live`], hears what the
//! page says and has the messages for it, the same as those of `hapdef live --view`. Time is counted in frames: the
//! same model, words and steps give the same messages.
//!
//! Built for `wasm32-unknown-unknown` it is a module with plain functions, see `exports.rs`; `cargo xtask wasm` makes
//! a folder of static files with it.

mod error;
#[cfg(target_family = "wasm")]
mod exports;
mod model;
mod newest;
mod session;

pub use error::PageError;
pub use model::{ElectronicsHeader, PageModel, RigHeader};
pub use session::{PageMessage, Session};
