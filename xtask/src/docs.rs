//! The commands that the docs show, run as a reader would.

use std::collections::{BTreeMap, VecDeque};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::Instant;

use anyhow::{Context, Error, Result, bail};
use serde_json::{Value, json};

use crate::browser;
use crate::tool::{root, run};

/// Commands that a step of its own runs.
const LEFT_OUT: [&str; 2] = ["cargo xtask test", "cargo xtask repro --quick --tables"];

/// Commands that take long as they are shown, and what is run in their place; some on [`COARSE`].
const SMALLER: [(&str, &str); 13] = [
    ("cargo xtask bench nets", "cargo xtask bench nets -- --skip-trained --rounds 2"),
    (
        "cargo xtask frontier nets --quick",
        "cargo xtask frontier nets --quick -- --rounds 1 --steps 100 --other-steps 200 --singles 2000 --multis 500",
    ),
    ("cargo bench --bench infer", "cargo bench --bench infer -- --test"),
    ("cargo xtask bench view", "cargo xtask bench view -- --seconds 2"),
    (
        "cargo xtask compare -- --diagnose",
        "cargo xtask compare --quick --scene target/docs/coarse.json -- --without-paper --own-gauges --frames 10 --scripts 10 --presses 300 --diagnose",
    ),
    (
        "cargo xtask compare -- --without-paper --loads",
        "cargo xtask compare --quick --scene target/docs/coarse.json -- --without-paper --own-gauges --loads --frames 4 --presses 300",
    ),
    (
        "cargo xtask frontier inverse",
        "cargo xtask frontier inverse --scene target/docs/coarse.json -- --without-paper --frames 10 --presses 300",
    ),
    ("cargo xtask bench inverse", "cargo xtask bench inverse -- --scripts 2 --pairs 10"),
    (
        "cargo hapdef-repro search fixtures/shin/scene.json --profile quick --method lr --trials 20",
        "cargo hapdef-repro search fixtures/shin/scene.json --profile quick --method lr --trials 2",
    ),
    (
        "cargo hapdef-repro search-compare fixtures/shin/scene.json --profile quick",
        "cargo hapdef-repro search-compare fixtures/shin/scene.json --profile quick",
    ),
    ("cargo hapdef-repro tactile", "cargo hapdef-repro tactile --steps 100 --svr-presses 200"),
    (
        "cargo hapdef calibrate fixtures/shin/placed.json target/live-presses.csv \
         target/live-calibration.json --live virtual --presses 24",
        "rm -f target/few-presses.csv target/few-calibration.json && cargo hapdef calibrate fixtures/shin/placed.json \
         target/few-presses.csv target/few-calibration.json --live virtual --presses 12",
    ),
    ("cargo xtask pictures", "cargo xtask pictures report shin-rigidity --into target/pictures"),
];

/// The bundled limb with its gauges placed, whose rig and map have the limb's own elements: solving finer ones
/// would take most of a comparison of few frames, and its figures are not looked at here.
const COARSE: &str = "target/docs/coarse.json";

/// Words that begin a command.
const PROGRAMS: [&str; 8] =
    ["cargo ", "hapdef ", "python ", "python3 ", "pip ", "maturin ", "target/", "import hapdef"];

/// Arguments of `docs`.
#[derive(clap::Args)]
pub(crate) struct DocsArgs {
    /// These pages only.
    pages: Vec<PathBuf>,
}

/// `cargo xtask docs`.
pub(crate) fn run_some(args: &DocsArgs) -> Result<()> {
    match args.pages.as_slice() {
        [] => Commands::of_docs()?.run(),
        pages => Commands::of(pages.to_vec())?.run(),
    }
}

/// What became of a line; nothing while it runs.
type Outcome = OnceLock<Result<(), String>>;

/// The commands of pages, for any number of threads: each takes a page at a time.
pub(crate) struct Commands {
    pages: Mutex<VecDeque<PathBuf>>,
    /// What several pages show is run once, and who comes second waits for it.
    lines: Mutex<BTreeMap<String, Arc<Outcome>>>,
    has_browser: bool,
}

impl Commands {
    /// Every line of every `sh` block in README.md and docs/.
    pub(crate) fn of_docs() -> Result<Self> {
        Self::of(pages()?)
    }

    fn of(pages: Vec<PathBuf>) -> Result<Self> {
        let texts: Vec<String> = pages.iter().map(|page| read(page)).collect::<Result<_>>()?;
        if texts.iter().all(|text| commands(text).is_empty()) {
            bail!("the docs show no command: expected ```sh blocks in README.md and docs/");
        }
        write_coarse_scene()?;
        let has_browser = browser::wish()? != "skip";
        Ok(Self { pages: Mutex::new(pages.into()), lines: Mutex::default(), has_browser })
    }

    /// Runs those of the pages that nobody has taken.
    pub(crate) fn run(&self) -> Result<()> {
        while let Some(page) = self.next_page() {
            let text = read(&page)?;
            for line in commands(&text).into_iter().filter(|line| !LEFT_OUT.contains(line)) {
                let outcome = self.outcome(line);
                let outcome = outcome.get_or_init(|| self.run_line(line));
                outcome.clone().map_err(Error::msg).with_context(|| page.display().to_string())?;
            }
        }
        Ok(())
    }

    fn next_page(&self) -> Option<PathBuf> {
        self.pages.lock().unwrap_or_else(PoisonError::into_inner).pop_front()
    }

    fn outcome(&self, line: &str) -> Arc<Outcome> {
        let mut lines = self.lines.lock().unwrap_or_else(PoisonError::into_inner);
        Arc::clone(lines.entry(line.to_owned()).or_default())
    }

    fn run_line(&self, line: &str) -> Result<(), String> {
        if line.starts_with("cargo xtask pictures") && !self.has_browser {
            println!("skipped: {line}: no Chromium");
            return Ok(());
        }
        eprintln!("   $ {line}");
        let start = Instant::now();
        run(Command::new("sh").args(["-c", line]).current_dir(root()))
            .map_err(|error| format!("{line}: {error:#}"))?;
        eprintln!("   {:.1} s  {line}", start.elapsed().as_secs_f64());
        Ok(())
    }
}

/// Writes [`COARSE`].
fn write_coarse_scene() -> Result<()> {
    let bundled = root().join("fixtures/shin");
    let mut scene: Value = serde_json::from_str(&read(&bundled.join("placed.json"))?)?;
    let deck = bundled.join(scene["geometry"]["solid_deck"].as_str().context("solid_deck")?);
    scene["name"] = "shin-coarse".into();
    scene["geometry"]["solid_deck"] = json!(deck);
    scene["rig"]["mesh"] = json!({"kind": "deck", "solid_deck": deck, "refinements": 0});
    scene["estimator"]["map_refinements"] = 0.into();
    let path = root().join(COARSE);
    fs::create_dir_all(path.parent().context("a folder")?)?;
    fs::write(&path, scene.to_string()).with_context(|| path.display().to_string())
}

/// README.md and the pages of docs/.
fn pages() -> Result<Vec<PathBuf>> {
    let mut files = vec![root().join("README.md")];
    let folder = fs::read_dir(root().join("docs")).context("reading docs/")?;
    for entry in folder {
        files.push(entry.context("reading docs/")?.path());
    }
    files.retain(|file| file.extension().is_some_and(|e| e == "md"));
    files.sort();
    Ok(files)
}

fn read(page: &Path) -> Result<String> {
    fs::read_to_string(page).with_context(|| page.display().to_string())
}

/// A fenced block: what stands behind the fence, and its lines.
pub(crate) struct Block<'a> {
    pub(crate) fence: &'a str,
    pub(crate) lines: Vec<&'a str>,
}

/// Files that a text leads to by links, in order; those to other sites and within the page are passed over.
pub(crate) fn links(text: &str) -> impl Iterator<Item = &str> {
    let links = text.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    let paths = links.filter_map(|link| link.split('#').next());
    paths.filter(|path| !path.is_empty() && !path.contains("://"))
}

/// The fenced blocks of a page.
pub(crate) fn blocks(text: &str) -> Vec<Block<'_>> {
    let mut found: Vec<Block<'_>> = Vec::new();
    let mut is_inside = false;
    for line in text.lines() {
        if let Some(fence) = line.trim_start().strip_prefix("```") {
            is_inside = !is_inside;
            if is_inside {
                let (fence, lines) = (fence.trim_end(), Vec::new());
                found.push(Block { fence, lines });
            }
        } else if is_inside && let Some(block) = found.last_mut() {
            block.lines.push(line);
        }
    }
    found
}

impl<'a> Block<'a> {
    /// `reason` of a fence `language (reason)`.
    pub(crate) fn reason(&self) -> Option<&'a str> {
        let (_, rest) = self.fence.split_once(" (")?;
        let reason = rest.strip_suffix(')')?.trim();
        (!reason.is_empty()).then_some(reason)
    }

    fn commands(&self) -> Vec<&'a str> {
        let lines = self.trimmed();
        match self.fence {
            "sh" => lines.filter(|line| !line.is_empty() && !line.starts_with('#')).collect(),
            _ => lines.filter_map(smaller).collect(),
        }
    }

    fn trimmed(&self) -> impl Iterator<Item = &'a str> {
        self.lines.iter().map(|line| line.trim())
    }
}

/// Lines of the fenced `sh` blocks, and what stands in for lines of blocks that say why they are not run.
fn commands(text: &str) -> Vec<&str> {
    blocks(text).iter().flat_map(Block::commands).collect()
}

/// What is run in place of a line.
fn smaller(line: &str) -> Option<&'static str> {
    let command = without_remark(line);
    let mut pairs = SMALLER.iter();
    pairs.find_map(|(shown, small)| (*shown == command).then_some(*small))
}

fn without_remark(line: &str) -> &str {
    line.split(" #").next().unwrap_or_default().trim_end()
}

/// Commands in blocks that are neither run, ```sh, nor say why not, ```sh (a device).
pub(crate) fn unexplained(text: &str) -> Vec<&str> {
    let blocks = blocks(text);
    let silent = blocks.iter().filter(|block| block.fence != "sh" && block.reason().is_none());
    let is_command = |line: &&str| PROGRAMS.iter().any(|program| line.starts_with(program));
    silent.flat_map(Block::trimmed).filter(is_command).collect()
}

#[cfg(test)]
mod tests {
    use super::{LEFT_OUT, SMALLER, blocks, commands, pages, unexplained, without_remark};

    #[test]
    fn the_docs_show_every_command_that_is_left_out_or_run_in_small() {
        let texts = pages().unwrap().into_iter().map(|page| std::fs::read_to_string(page).unwrap());
        let text: String = texts.collect();
        let smaller = SMALLER.iter().map(|(shown, _)| shown);
        for command in smaller.chain(&LEFT_OUT) {
            let is_shown = text.lines().any(|line| without_remark(line.trim()) == *command);
            assert!(is_shown, "{command}: take it out of docs.rs");
        }
    }

    #[test]
    fn a_command_is_run_or_says_why_not() {
        let text = "```sh\ncargo a\n```\n```sh (a device)\nhapdef b\n```\n```text\nhapdef c\nwords\n\
                    ```\n```sh ()\npip d\n```\n```rust\nlet cargo = 1;\n```\ncargo e\n";
        assert_eq!(unexplained(text), ["hapdef c", "pip d"]);
        assert_eq!(commands(text), ["cargo a"]);
    }

    #[test]
    fn blocks_have_their_fence_and_lines() {
        let text = "words\n```rust (src/a.rs)\nfn f() {\n    1\n}\n```\nwords\n```\nx\n```\n";
        let found = blocks(text);
        assert_eq!(found.len(), 2);
        assert_eq!(found[0].reason(), Some("src/a.rs"));
        assert_eq!(found[0].lines, ["fn f() {", "    1", "}"]);
        assert_eq!((found[1].fence, found[1].reason()), ("", None));
    }

    #[test]
    fn a_long_command_is_run_in_small() {
        let text = "```sh (an hour)\ncargo hapdef-repro tactile   # remark\nhapdef b\n```\n";
        let [small] = commands(text)[..] else {
            panic!("{:?}", commands(text));
        };
        assert!(small.starts_with("cargo hapdef-repro tactile --steps"), "{small}");
    }

    #[test]
    fn only_sh_blocks_count() {
        let text = "```sh\na b\n\n# note\nc\n```\nd\n```text\ne\n```\n";
        assert_eq!(commands(text), ["a b", "c"]);
    }
}
