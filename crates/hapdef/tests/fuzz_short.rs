//! Every reader on some hundred damaged inputs; `cargo xtask fuzz` takes as long as you like.
#![expect(clippy::unwrap_used, reason = "a test that can't prepare itself fails")]
#![expect(clippy::print_stderr, reason = "says where a failing input is")]

#[path = "../examples/fuzz/driver.rs"]
mod driver;
#[path = "../examples/fuzz/mutate.rs"]
mod mutate;
#[path = "../../../fuzz/src/targets.rs"]
mod targets;

use std::path::Path;

use driver::{corpus, fuzz};

#[test]
fn no_reader_panics() {
    let home = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus");
    let failures = Path::new(env!("CARGO_TARGET_TMPDIR")).join("fuzz");
    for target in targets::TARGETS {
        let seeds = corpus(&home.join(target.name));
        let outcome = fuzz(target, &seeds, 1, |n, _| n >= 400, &failures);
        println!("{}: {outcome:?}", target.name);
        assert_eq!(outcome.n_panics, 0, "{}", target.name);
    }
}
