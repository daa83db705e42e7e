//! cargo +nightly fuzz run recover
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| hapdef_fuzz::run("recover", bytes));
