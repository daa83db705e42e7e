//! Nothing: without a build script Cargo passes over this crate's build-dependencies.

fn main() {}
