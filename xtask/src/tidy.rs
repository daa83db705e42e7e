//! The tree against its own rules.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;

use anyhow::{Context, Result, bail};

mod circles;
mod lines;
mod modules;
mod rust;

use crate::docs::{blocks, links, unexplained};
use crate::metrics;
use crate::tool::{metadata, results, root};

/// Longest a source file may be, lines.
const MAX_LINES: usize = 600;

/// Circles between files that are still allowed.
const MAX_CIRCLES: usize = 0;

type Arrows = BTreeMap<String, BTreeSet<String>>;

/// `cargo xtask tidy`: layers, names of files, file lengths, circles, leftovers, links, commands and code of
/// the docs.
pub(crate) fn run() -> Result<()> {
    let mut faults = Vec::new();
    let architecture = read("ARCHITECTURE.md")?;
    layer_faults(&drawn_arrows(&architecture)?, &manifest_arrows()?, &mut faults);
    let files = tracked_files()?;
    let is_there = |path: &str| is_in_crates(&files, path);
    name_faults(&architecture, is_there, &mut faults);
    for file in &files {
        if file.ends_with(".rs") {
            source_faults(file, &read(file)?, &mut faults);
        } else if file.ends_with(".md") {
            let (folder, text) = (root().join(file), read(file)?);
            let folder = folder.parent().unwrap_or(root());
            let is_there = |link: &str| folder.join(link).exists();
            link_faults(file, &text, is_there, &mut faults);
            if file == "README.md" || file.starts_with("docs/") {
                command_faults(file, &text, &mut faults);
                snippet_faults(file, &text, |source| read(source).ok(), &mut faults);
            }
        }
    }
    order_faults(&read("docs/README.md")?, &files, &mut faults);
    house_faults(&files, &mut faults)?;
    if faults.is_empty() {
        return Ok(());
    }
    bail!("tidy found {} faults:\n  {}", faults.len(), faults.join("\n  "))
}

/// Prints how large the tree is, and lists its circles.
fn house_faults(files: &[String], faults: &mut Vec<String>) -> Result<()> {
    let mut n_lines = 0;
    for file in files.iter().filter(|file| lines::is_source(file)) {
        n_lines += lines::count(file, &read(file)?);
    }
    let circles = circles::all(files, |file| read(file).ok());
    for circle in &circles {
        println!("circle: {circle}");
    }
    if circles.len() > MAX_CIRCLES {
        faults.push(format!(
            "{} circles between files, {MAX_CIRCLES} are allowed: let one of the two import from the \
             other, or both from a third",
            circles.len()
        ));
    }
    let figures = [
        ("house.src_lines", n_lines as f64, "lines"),
        ("house.circles", circles.len() as f64, "1"),
        ("house.test_programs", test_programs()? as f64, "1"),
    ];
    metrics::report(&figures, 0, Some(&results().join("metrics.json")));
    Ok(())
}

/// Integration-test programs of the workspace.
fn test_programs() -> Result<usize> {
    let metadata = metadata()?;
    let packages = metadata["packages"].as_array().context("cargo metadata: packages")?;
    let targets = packages.iter().filter_map(|package| package["targets"].as_array()).flatten();
    let is_test = |target: &&serde_json::Value| target["kind"][0] == "test";
    Ok(targets.filter(is_test).count())
}

/// Arrows of the `layers` block: `crate -> crate, crate` a line.
fn drawn_arrows(architecture: &str) -> Result<Arrows> {
    let (_, rest) = architecture.split_once("```layers\n").context("no layers block")?;
    let (block, _) = rest.split_once("```").context("the layers block does not end")?;
    let arrow = |line: &str| {
        let (from, to) = line.split_once("->").with_context(|| format!("no arrow in {line:?}"))?;
        let to = to.split(',').map(|name| name.trim().to_owned());
        Ok((from.trim().to_owned(), to.filter(|name| !name.is_empty()).collect()))
    };
    block.lines().filter(|line| !line.trim().is_empty()).map(arrow).collect()
}

/// Arrows of the manifests, development dependencies left out.
fn manifest_arrows() -> Result<Arrows> {
    let metadata = metadata()?;
    let packages = metadata["packages"].as_array().context("cargo metadata: packages")?;
    let name_of = |package: &serde_json::Value| package["name"].as_str().map(str::to_owned);
    let own: BTreeSet<String> = packages.iter().filter_map(name_of).collect();
    let mut arrows = Arrows::new();
    for package in packages {
        let from = name_of(package).context("a package without a name")?;
        let dependencies = package["dependencies"].as_array().context("dependencies")?;
        let to = dependencies.iter().filter(|d| d["kind"].is_null()).filter_map(name_of);
        arrows.insert(from, to.filter(|name| own.contains(name)).collect());
    }
    Ok(arrows)
}

fn layer_faults(drawn: &Arrows, manifest: &Arrows, faults: &mut Vec<String>) {
    let nothing = BTreeSet::new();
    let crates: BTreeSet<&String> = drawn.keys().chain(manifest.keys()).collect();
    for from in crates {
        if drawn.contains_key(from) != manifest.contains_key(from) {
            faults.push(format!("{from}: only in one of ARCHITECTURE.md's layers and Cargo.toml"));
        }
        let in_drawing = drawn.get(from).unwrap_or(&nothing);
        let in_manifest = manifest.get(from).unwrap_or(&nothing);
        for to in in_drawing.symmetric_difference(in_manifest) {
            let place = if in_drawing.contains(to) { "ARCHITECTURE.md" } else { "Cargo.toml" };
            faults.push(format!("{from} -> {to}: only in {place}"));
        }
    }
}

/// Paths in backticks that no file or folder in crates/ ends with.
fn name_faults(architecture: &str, is_there: impl Fn(&str) -> bool, faults: &mut Vec<String>) {
    let in_backticks = architecture.split('`').skip(1).step_by(2);
    let is_path = |text: &&str| {
        let is_named = text.contains('/') || text.ends_with(".rs") || text.ends_with(".js");
        is_named && !text.contains(char::is_whitespace)
    };
    for path in in_backticks.filter(is_path) {
        if !is_there(path) {
            faults.push(format!("ARCHITECTURE.md: no {path} in crates/"));
        }
    }
}

/// Whether a file in crates/, or a folder of one, ends with these parts.
fn is_in_crates(files: &[String], path: &str) -> bool {
    let wanted = format!("/{}/", path.trim_end_matches('/'));
    let mut inside = files.iter().filter(|file| file.starts_with("crates/"));
    inside.any(|file| format!("/{file}/").contains(&wanted))
}

fn source_faults(file: &str, text: &str, faults: &mut Vec<String>) {
    let n_lines = text.lines().count();
    if n_lines > MAX_LINES {
        faults.push(format!("{file}: {n_lines} lines, {MAX_LINES} are allowed"));
    }
    let leftovers = ["todo", "unimplemented", "dbg"].map(|name| format!("{name}!("));
    for (i, line) in text.lines().enumerate() {
        if leftovers.iter().any(|word| line.contains(word.as_str())) {
            faults.push(format!("{file}:{}: left over: {}", i + 1, line.trim()));
        }
    }
    let documented = text.trim_start().starts_with("//!") || text.starts_with("// ");
    if !documented {
        faults.push(format!("{file}: does not open with a line saying what it is"));
    }
}

/// Links to files that are not there.
fn link_faults(file: &str, text: &str, is_there: impl Fn(&str) -> bool, faults: &mut Vec<String>) {
    for (i, line) in text.lines().enumerate() {
        for path in links(line) {
            if !is_there(path) {
                faults.push(format!("{file}:{}: no file {path}", i + 1));
            }
        }
    }
}

/// Every command of the docs is run, or its block says why not.
fn command_faults(file: &str, text: &str, faults: &mut Vec<String>) {
    for line in unexplained(text) {
        faults.push(format!(
            "{file}: `{line}` is not run: expected it in a ```sh block, or the reason behind the language, \
             as in ```sh (a device)"
        ));
    }
}

/// Rust that the docs show and that is not, line by line, in the compiled file that its fence names;
/// its name is in brackets after `rust`.
fn snippet_faults(
    file: &str,
    text: &str,
    source: impl Fn(&str) -> Option<String>,
    faults: &mut Vec<String>,
) {
    let blocks = blocks(text).into_iter();
    for block in blocks.filter(|block| block.fence.starts_with("rust")) {
        let Some(compiled) = block.reason().and_then(&source) else {
            faults.push(format!("{file}: {}: names no file that is there", block.fence));
            continue;
        };
        let wanted: Vec<&str> = block.lines.iter().map(|line| line.trim()).collect();
        let shown = compiled.lines().map(shown_line);
        let shown: Vec<&str> = shown.filter(|line| !line.starts_with("# ")).collect();
        if !shown.windows(wanted.len().max(1)).any(|lines| lines == wanted) {
            let first = wanted.first().unwrap_or(&"");
            faults.push(format!("{file}: {}: other lines than `{first}` and on", block.fence));
        }
    }
}

/// A line of code, or of an example in a documentation comment.
fn shown_line(line: &str) -> &str {
    let line = line.trim();
    let comment = line.strip_prefix("//!").or_else(|| line.strip_prefix("///"));
    comment.map_or(line, str::trim)
}

/// Pages of the docs that the reading order leaves out.
fn order_faults(order: &str, files: &[String], faults: &mut Vec<String>) {
    let pages = files.iter().filter_map(|file| file.strip_prefix("docs/"));
    let pages = pages.filter(|page| page.ends_with(".md") && *page != "README.md");
    for page in pages.filter(|page| !order.contains(&format!("]({page})"))) {
        faults.push(format!("docs/README.md: the page {page} has no place in it"));
    }
}

fn tracked_files() -> Result<Vec<String>> {
    let output = std::process::Command::new("git")
        .args(["ls-files", "--cached", "--others", "--exclude-standard"])
        .current_dir(root())
        .output()
        .context("starting git ls-files")?;
    let text = String::from_utf8(output.stdout).context("git ls-files")?;
    Ok(text.lines().map(str::to_owned).collect())
}

fn read(file: &str) -> Result<String> {
    fs::read_to_string(root().join(file)).with_context(|| format!("reading {file}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn faults(drawn: &str, manifest: &str) -> Vec<String> {
        let arrows = |block: &str| drawn_arrows(&format!("```layers\n{block}\n```")).unwrap();
        let mut faults = Vec::new();
        layer_faults(&arrows(drawn), &arrows(manifest), &mut faults);
        faults
    }

    #[test]
    fn equal_arrows_are_fine_in_any_order() {
        assert!(faults("a -> b, c\nb ->\nc ->", "c ->\nb ->\na -> c, b").is_empty());
    }

    #[test]
    fn an_arrow_in_one_place_only_is_named() {
        assert_eq!(faults("a -> b\nb ->", "a ->\nb -> a").len(), 2);
    }

    #[test]
    fn a_crate_that_is_not_drawn_is_named() {
        assert_eq!(faults("a ->", "a ->\nb ->").len(), 1);
    }

    #[test]
    fn a_file_that_is_not_there_is_named() {
        let files = ["crates/a/src/skin.rs", "crates/a/src/deck/inp.rs", "docs/gone.rs"];
        let files = files.map(str::to_owned);
        let is_there = |path: &str| is_in_crates(&files, path);
        let text = "`a/src/skin.rs`, `skin.rs`, `deck/`, `src/deck`, `a eval`, `deck`";
        let mut faults = Vec::new();
        name_faults(text, is_there, &mut faults);
        assert_eq!(faults, Vec::<String>::new());
        let text = "`gone.rs`, `a/src/gone.rs`, `kin.rs`, `dec/`, `a/skin.rs`";
        name_faults(text, is_there, &mut faults);
        assert_eq!(faults.len(), 5, "{faults:?}");
    }

    #[test]
    fn links_and_pages_that_lead_nowhere_are_named() {
        let mut faults = Vec::new();
        let text = "[a](a.md) [b](b.md#part) [here](#part) [far](https://a.org/c.md)";
        link_faults("x.md", text, |path| path == "a.md", &mut faults);
        assert_eq!(faults, ["x.md:1: no file b.md"]);
        let files = ["docs/README.md", "docs/a.md", "docs/c.md", "d.md"].map(str::to_owned);
        order_faults(text, &files, &mut faults);
        assert_eq!(faults.len(), 2, "{faults:?}");
    }

    #[test]
    fn rust_that_is_not_in_its_file_is_named() {
        let source = |file: &str| {
            let text =
                "//! ```\n//! # hidden();\n//! let a = f(\n//!     1,\n//! # more();\n//! );\n";
            (file == "a.rs").then(|| text.to_owned())
        };
        let found = |fence: &str, lines: &str| {
            let mut faults = Vec::new();
            let text = format!("```{fence}\n{lines}\n```\n");
            snippet_faults("x.md", &text, source, &mut faults);
            faults.len()
        };
        assert_eq!(found("rust (a.rs)", "let a = f(\n    1,\n);"), 0);
        assert_eq!(found("rust (a.rs)", "let a = f(\n    2,\n);"), 1);
        assert_eq!(found("rust (b.rs)", "let a = f("), 1);
        assert_eq!(found("rust", "let a = f("), 1);
        assert_eq!(found("text", "let b;"), 0);
    }

    #[test]
    fn long_files_and_leftovers_are_named() {
        let mut faults = Vec::new();
        let text = format!("//! Doc.\nfn f() {{ {}!() }}\n{}", "todo", "\n".repeat(MAX_LINES));
        source_faults("a.rs", &text, &mut faults);
        assert_eq!(faults.len(), 2, "{faults:?}");
    }
}
