//! What several tests share.

pub mod chrome;
pub mod film;
pub mod look;
pub mod page;
pub mod pixels;
pub mod synthetic;
