//! The command line.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};
use hapdef_cli::{SceneArgs, TrainingArgs};

use super::{robustness, search, tactile};
use crate::bench::{BenchNetsArgs, FrontierArgs};
use crate::compare::{BenchInverseArgs, CompareArgs};
use crate::frontier::ChainFrontierArgs;

/// The tables and figures of Sun & Martius 2019 for a scene.
#[derive(Parser)]
#[command(
    version,
    after_help = "Example:\n  \
    hapdef-repro report fixtures/shin/scene.json --profile quick"
)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(super) command: Command,
}

#[derive(Subcommand)]
pub(super) enum Command {
    /// Runs what is missing and writes the report: Markdown, JSON, HTML, figures.
    #[command(
        after_help = "Example:\n  hapdef-repro report fixtures/shin/scene.json --profile quick"
    )]
    Report(ReportArgs),
    /// The baselines and a net on a real tactile skin that nobody here built.
    #[command(after_help = "Example:\n  hapdef-repro tactile --steps 1000")]
    Tactile(tactile::TactileArgs),
    /// Settings of a method by Bayesian optimisation on validation samples; goes on where it was.
    #[command(
        after_help = "Example:\n  hapdef-repro search fixtures/shin/scene.json --profile quick \
        --method lr --trials 20"
    )]
    Search(search::SearchArgs),
    /// Joins the trials of several shards.
    #[command(after_help = "Example:\n  hapdef-repro search-merge a/trials-1-of-2.jsonl \
        b/trials-2-of-2.jsonl --into target/hapdef/shin/search/f_r/trials.jsonl")]
    SearchMerge(search::MergeArgs),
    /// The paper's settings beside the search's best, on test samples.
    #[command(after_help = "Example:\n  hapdef-repro search-compare fixtures/shin/scene.json \
        --profile quick")]
    SearchCompare(search::CompareArgs),
    /// Nets and baselines with data and settings at their extremes.
    #[command(
        alias = "stability",
        after_help = "Example:\n  hapdef-repro robustness --check docs/stability-nets.md"
    )]
    Robustness(robustness::TableArgs),
    /// Contacts by superposition with frames, layouts and presses at their extremes.
    #[command(
        alias = "stability-inverse",
        after_help = "Example:\n  hapdef-repro robustness-inverse fixtures/shin/placed.json \
            --check docs/stability-inverse.md"
    )]
    RobustnessInverse(robustness::InverseArgs),
    /// Meshes, datasets, k-Max, decoder, clock and recordings at their extremes.
    #[command(
        alias = "stability-parts",
        after_help = "Example:\n  hapdef-repro robustness-parts --check docs/stability-parts.md"
    )]
    RobustnessParts(robustness::TableArgs),
    /// The tables of all layers at their extremes as one, and what they come to
    #[command(alias = "stability-all", after_help = "Example:\n  hapdef-repro robustness-all")]
    RobustnessAll(robustness::AllArgs),
    /// Times of the networks on one core, against ONNX Runtime and PyTorch where Python has them.
    #[command(after_help = "Example:\n  hapdef-repro bench-nets --skip-trained --rounds 2")]
    BenchNets(BenchNetsArgs),
    /// Error against run time: every method, precision, rank and width in one table and plot.
    #[command(after_help = "Example:\n  hapdef-repro frontier-nets fixtures/shin/scene.json \
        --profile quick")]
    FrontierNets(FrontierArgs),
    /// Error against run time of the whole chain, its growth, and what leaving things out is worth.
    Frontier(ChainFrontierArgs),
    /// The same with what needs nets of its own: figure 5A and the ablations of figure 8.
    #[command(
        after_help = "Example:\n  hapdef-repro repro fixtures/shin/scene.json --profile quick"
    )]
    Repro(ReproArgs),
    /// Contacts by superposition against the paper's pipeline, the same frames of the same rig.
    #[command(after_help = "Example:\n  hapdef-repro compare fixtures/shin/placed.json --profile \
        quick --frames 100")]
    Compare(CompareArgs),
    /// Effort of the search against error, with the bound and the paper's nets beside it.
    #[command(after_help = "Example:\n  hapdef-repro frontier-inverse fixtures/shin/placed.json \
        --without-paper --frames 100")]
    FrontierInverse(CompareArgs),
    /// Time and allocations of a frame by superposition.
    #[command(after_help = "Example:\n  hapdef-repro bench-inverse fixtures/shin/placed.json")]
    BenchInverse(BenchInverseArgs),
    /// Compares the tables of a report with golden values, or writes those.
    #[command(
        after_help = "Example:\n  hapdef-repro golden target/hapdef/shin/report/report.json \
        crates/hapdef-repro/golden/quick.json"
    )]
    Golden(GoldenArgs),
    /// Fails where the results page of a full run is not about what the code makes now.
    #[command(
        after_help = "Example:\n  hapdef-repro check-results fixtures/shin/scene.json --report \
        target/hapdef/shin/report/report.json --page docs/results.md"
    )]
    CheckResults(CheckResultsArgs),
}

#[derive(Args)]
pub(super) struct ReportArgs {
    #[command(flatten)]
    pub(super) scene: SceneArgs,
    #[command(flatten)]
    pub(super) training: TrainingArgs,
}

#[derive(Args)]
pub(super) struct ReproArgs {
    #[command(flatten)]
    pub(super) run: ReportArgs,
    /// Also writes the tables and verdicts to this Markdown file.
    #[arg(long, value_name = "FILE")]
    pub(super) page: Option<PathBuf>,
    /// Also writes the metrics to this JSON file.
    #[arg(long)]
    pub(super) metrics: Option<PathBuf>,
    /// Leave out what needs nets of its own: figure 5A and the ablations of figure 8.
    #[arg(long)]
    pub(super) tables_only: bool,
}

#[derive(Args)]
pub(super) struct GoldenArgs {
    /// The report, `report.json`.
    pub(super) report: PathBuf,
    /// The golden values.
    pub(super) golden: PathBuf,
    /// Writes them instead of comparing.
    #[arg(long)]
    pub(super) write: bool,
}

#[derive(Args)]
pub(super) struct CheckResultsArgs {
    /// The scene and the amounts of the page's run.
    #[command(flatten)]
    pub(super) scene: SceneArgs,
    #[command(flatten)]
    pub(super) training: TrainingArgs,
    /// The report of a quick run of that scene, `report.json`.
    #[arg(long)]
    pub(super) report: PathBuf,
    /// The page.
    #[arg(long)]
    pub(super) page: PathBuf,
}

#[cfg(test)]
#[path = "../../../hapdef-cli/tests/it/support/help.rs"]
mod help;

#[cfg(test)]
mod tests {
    use super::{Cli, help};

    #[test]
    fn every_help_has_an_example_that_is_understood() {
        help::every_help_has_an_example_that_is_understood::<Cli>("hapdef-repro");
    }
}
