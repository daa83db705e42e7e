//! Lines of source outside tests.

use super::rust::{test_items, tokens};

/// Whether a file of the tree is source of ours and no test's: Rust of libraries, programs, examples and
/// fuzz targets, and the page's JavaScript.
pub(super) fn is_source(file: &str) -> bool {
    let parts: Vec<&str> = file.split('/').collect();
    let name = parts.last().copied().unwrap_or_default();
    let is_code = name.ends_with(".rs") || name.ends_with(".js");
    let is_elsewhere = ["tests", "benches", "vendor"].iter().any(|folder| parts.contains(folder));
    is_code && !is_elsewhere && name != "tests.rs" && !name.ends_with("_tests.rs")
}

/// Lines without those of items under `#[cfg(test)]`.
pub(super) fn count(file: &str, text: &str) -> usize {
    let all = text.lines().count();
    if !file.ends_with(".rs") {
        return all;
    }
    let tokens = tokens(text);
    let of_item = |range: &std::ops::RangeInclusive<usize>| {
        tokens[*range.end()].line - tokens[*range.start()].line + 1
    };
    all - test_items(&tokens).iter().map(of_item).sum::<usize>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tests_and_what_others_wrote_are_no_source() {
        let source =
            ["crates/a/src/b.rs", "crates/a/examples/c/main.rs", "crates/v/assets/js/d.js"];
        let others = [
            "crates/a/tests/it/b.rs",
            "crates/a/src/b/tests.rs",
            "crates/a/src/b_tests.rs",
            "crates/a/benches/b.rs",
            "crates/v/assets/vendor/three/e.js",
            "docs/f.md",
        ];
        assert!(source.iter().all(|file| is_source(file)));
        assert!(!others.iter().any(|file| is_source(file)));
    }

    #[test]
    fn lines_of_test_modules_are_not_counted() {
        let text = "//! A.\n\nfn a() {}\n\n#[cfg(test)]\nmod tests {\n    fn b() {}\n}\n";
        assert_eq!(count("a.rs", text), 4);
        assert_eq!(count("a.js", text), 8);
    }
}
