//! Settings by Bayesian optimisation, and the outside check on a tactile skin.

use std::path::PathBuf;
use std::process::Command;

use anyhow::Result;

use crate::pipeline::finish;
use crate::tool::{release_binary, results, root};

/// Arguments of `search`.
#[derive(clap::Args)]
#[command(args_conflicts_with_subcommands = true)]
pub(crate) struct SearchArgs {
    #[command(subcommand)]
    action: Option<Action>,
    #[command(flatten)]
    trials: TrialArgs,
}

/// What else can be done with trials.
#[derive(clap::Subcommand)]
enum Action {
    /// Joins the trials of several shards.
    #[command(after_help = "Example:\n  cargo xtask search merge a/trials-1-of-2.jsonl \
        b/trials-2-of-2.jsonl --into target/hapdef/shin/search/f_r/trials.jsonl")]
    Merge {
        /// Files of trials.
        #[arg(required = true)]
        files: Vec<PathBuf>,
        /// The file to write.
        #[arg(long)]
        into: PathBuf,
    },
    /// The paper's settings beside the search's best, on test samples.
    #[command(after_help = "Example:\n  cargo xtask search compare --quick")]
    Compare(SceneArgs),
}

/// A search's own arguments.
#[derive(clap::Args)]
struct TrialArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// The method: f_r, f_t, direct, lr, knn, svr.
    #[arg(long)]
    method: Option<String>,
    /// Trials in all.
    #[arg(long)]
    trials: Option<usize>,
    /// Runs every n-th trial only, from the i-th on: `1/3`, `2/3`, `3/3` on three machines.
    #[arg(long)]
    shard: Option<String>,
    /// Begins no trial after so many minutes.
    #[arg(long)]
    minutes: Option<f64>,
}

/// Which scene, how much of it.
#[derive(clap::Args)]
struct SceneArgs {
    /// The scene; the bundled shin if absent.
    #[arg(long)]
    scene: Option<PathBuf>,
    /// Fewer samples.
    #[arg(long)]
    quick: bool,
    /// Seed of the search and of the training side instead of the scene's.
    #[arg(long)]
    seed: Option<u64>,
    /// Everything else goes to `hapdef-repro` as it is, such as `--steps 300`.
    #[arg(last = true)]
    rest: Vec<String>,
}

/// Arguments of `tactile`.
#[derive(clap::Args)]
pub(crate) struct TactileArgs {
    /// Everything else goes to `hapdef-repro` as it is, such as `--steps 1000`.
    #[arg(last = true)]
    rest: Vec<String>,
}

/// `cargo xtask search`.
pub(crate) fn run(args: &SearchArgs) -> Result<()> {
    let mut command = Command::new(release_binary("hapdef-repro")?);
    match &args.action {
        Some(Action::Merge { files, into }) => {
            command.arg("search-merge").args(files).arg("--into").arg(into);
        }
        Some(Action::Compare(scene)) => {
            command.arg("search-compare");
            scene.add_to(&mut command);
        }
        None => {
            command.arg("search");
            args.trials.add_to(&mut command);
        }
    }
    finish(&mut command)
}

/// `cargo xtask tactile`.
pub(crate) fn tactile(args: &TactileArgs) -> Result<()> {
    let mut command = Command::new(release_binary("hapdef-repro")?);
    let shared = std::env::var_os("HAPDEF_SHARED").map_or(root().join("../shared"), PathBuf::from);
    command.arg("tactile").arg("--shared").arg(shared);
    command.arg("--metrics").arg(results().join("metrics.json"));
    finish(command.args(&args.rest))
}

impl TrialArgs {
    fn add_to(&self, command: &mut Command) {
        let pairs = [
            ("--method", self.method.clone()),
            ("--trials", self.trials.map(|n| n.to_string())),
            ("--shard", self.shard.clone()),
            ("--minutes", self.minutes.map(|m| m.to_string())),
        ];
        for (flag, value) in pairs {
            if let Some(value) = value {
                command.args([flag, &value]);
            }
        }
        self.scene.add_to(command);
    }
}

impl SceneArgs {
    fn add_to(&self, command: &mut Command) {
        let bundled = root().join("fixtures/shin/scene.json");
        command.arg(self.scene.clone().unwrap_or(bundled));
        command.args(["--profile", if self.quick { "quick" } else { "full" }]);
        if let Some(seed) = self.seed {
            command.args(["--seed", &seed.to_string()]);
        }
        command.args(&self.rest);
    }
}
