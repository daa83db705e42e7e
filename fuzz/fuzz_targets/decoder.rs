//! cargo +nightly fuzz run decoder
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| hapdef_fuzz::run("decoder", bytes));
