//! cargo +nightly fuzz run gltf
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| hapdef_fuzz::run("gltf", bytes));
