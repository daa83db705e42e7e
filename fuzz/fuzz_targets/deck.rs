//! cargo +nightly fuzz run deck
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| hapdef_fuzz::run("deck", bytes));
