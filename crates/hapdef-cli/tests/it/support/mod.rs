//! What several tests share.

pub mod page;
