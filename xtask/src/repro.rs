//! The paper's tables and figures, with everything they need.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};

use crate::pipeline::{PipelineArgs, common, finish};
use crate::tool::{release_binary, root, run};

/// Arguments of `repro`.
#[derive(clap::Args, Clone)]
pub(crate) struct ReproArgs {
    #[command(flatten)]
    pipeline: PipelineArgs,
    /// The paper's amounts of data; so without `--quick`, too.
    #[arg(long, conflicts_with = "quick")]
    full: bool,
    /// Leave out what trains nets of its own: figure 5A, and the ablations of figure 8.
    #[arg(long, conflicts_with_all = ["full", "write"])]
    tables: bool,
    /// Also writes docs/results.md, and docs/results.json in a full run; those of a scene other than
    /// the bundled one have its name, docs/results-NAME.md.
    #[arg(long)]
    write: bool,
}

const GOLDEN: &str = "crates/hapdef-repro/golden/quick.json";

/// `cargo xtask repro`: the report with every table and figure.
pub(crate) fn repro(args: &ReproArgs) -> Result<()> {
    let is_quick = args.pipeline.quick && !args.full;
    eprintln!("building (the first time takes some minutes) …");
    let program = release_binary("hapdef-repro")?;
    eprintln!("the paper's tables and figures: {}", expected_time(is_quick));
    let mut command = Command::new(program);
    let verb = if args.tables { "report" } else { "repro" };
    command.arg(verb).args(common(&args.pipeline));
    if args.write {
        let files = files(args.pipeline.scene.as_deref())?;
        let has_full_run = files[1].exists();
        command.args(written(is_quick, has_full_run, files)?);
    }
    finish(&mut command)
}

fn expected_time(is_quick: bool) -> &'static str {
    if is_quick {
        "minutes; what is made already is taken as it is"
    } else {
        "an hour or two, each stage with its bar; Ctrl-C ends it, and the same command goes on from there"
    }
}

/// The Markdown and the JSON that `--write` writes.
fn files(scene: Option<&Path>) -> Result<[PathBuf; 2]> {
    let of_scene = |scene| scene_name(scene).map(|name| format!("-{name}"));
    let suffix = scene.map(of_scene).transpose()?.unwrap_or_default();
    Ok(["md", "json"].map(|kind| root().join(format!("docs/results{suffix}.{kind}"))))
}

/// What `--write` adds to the command line.
fn written(
    is_quick: bool,
    has_full_run: bool,
    [text, metrics]: [PathBuf; 2],
) -> Result<Vec<PathBuf>> {
    if is_quick && has_full_run {
        bail!(
            "{} is from a full run and {} with it; write with --full",
            text.display(),
            metrics.display()
        );
    }
    let mut words = vec!["--page".into(), text];
    if !is_quick {
        words.extend(["--metrics".into(), metrics]);
    }
    Ok(words)
}

/// The name that a scene gives itself.
fn scene_name(scene: &Path) -> Result<String> {
    let text = std::fs::read_to_string(scene).with_context(|| scene.display().to_string())?;
    let scene_json: serde_json::Value =
        serde_json::from_str(&text).with_context(|| scene.display().to_string())?;
    let name = scene_json["name"].as_str();
    Ok(name.with_context(|| format!("{}: no name", scene.display()))?.to_owned())
}

/// Compares the report of a quick run of the bundled limb with the golden values.
pub(crate) fn check_golden(report: &Path) -> Result<()> {
    let program = release_binary("hapdef-repro")?;
    run(Command::new(program).arg("golden").arg(report).arg(root().join(GOLDEN)))
}

/// Fails where docs/results.md is not about what the code makes now, by the report of a quick run of the
/// bundled limb.
pub(crate) fn check_results(report: &Path) -> Result<()> {
    let program = release_binary("hapdef-repro")?;
    let mut command = Command::new(program);
    command
        .arg("check-results")
        .arg(root().join("fixtures/shin/scene.json"))
        .args(["--profile", "full", "--report"])
        .arg(report)
        .arg("--page")
        .arg(root().join("docs/results.md"));
    run(&mut command)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::{files, written};
    use crate::tool::root;

    #[test]
    fn a_quick_run_never_replaces_a_full_one() {
        let files = || ["r.md", "r.json"].map(Into::into);
        assert_eq!(written(true, false, files()).unwrap().len(), 2);
        assert_eq!(written(false, true, files()).unwrap().len(), 4);
        assert!(written(true, true, files()).is_err());
    }

    #[test]
    fn results_of_another_scene_have_its_name() {
        let of = |scene: &str| files(Some(Path::new(scene)));
        let scene = root().join("fixtures/paper-shin/scene.json");
        let [text, _] = of(&scene.display().to_string()).unwrap();
        assert_eq!(text, root().join("docs/results-paper-shin.md"));
        assert_eq!(files(None).unwrap()[1], root().join("docs/results.json"));
        assert!(of("no-such-scene.json").is_err());
    }
}
