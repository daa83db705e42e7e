//! Runs hapdef's pipeline, checks the layering, and runs what CI runs.
//!
//! Links no crate of the workspace: it starts their binaries.

#![expect(clippy::print_stdout, clippy::print_stderr, reason = "a command line program prints")]

mod bench;
mod book;
mod browser;
mod ci;
mod compare;
mod dist;
mod docs;
mod first_minute;
mod fixtures;
mod frontier;
mod fuzz;
mod limbs;
mod live;
#[path = "../../crates/hapdef-daq/examples/soak/metrics.rs"]
mod metrics;
mod package;
mod pictures;
mod pipeline;
mod python;
mod repro;
mod robustness;
mod soak;
mod test;
mod tidy;
mod tool;
mod verify;
mod wasm;
mod weight;

use std::process::ExitCode;

use anyhow::Result;
use clap::{Parser, Subcommand};

use crate::pipeline::DemoArgs;

/// hapdef's tasks. `cargo xtask demo` is the place to start.
#[derive(Parser)]
#[command(
    name = "cargo xtask",
    after_help = "Example:\n  cargo xtask demo\n  \
    cargo xtask demo --scene fixtures/shin/placed.json\n  \
    cargo xtask demo --live\n  cargo xtask test"
)]
struct Cli {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// From the limb to contacts in a minute: calibrated, scored, drawn; with `--live` on the live page.
    #[command(after_help = "Examples:\n  cargo xtask demo\n  cargo xtask demo --live\n  \
        cargo xtask demo --live --scene fixtures/shin/placed.json -- --seconds 60")]
    Demo(DemoArgs),
    /// The paper's tables and figures, with verdicts on its claims.
    #[command(
        after_help = "Examples:\n  cargo xtask repro --quick --tables\n  cargo xtask repro --full --write"
    )]
    Repro(repro::ReproArgs),
    /// Every unit, integration and documentation test.
    #[command(after_help = "Example:\n  cargo xtask test")]
    Test,
    /// What CI runs: the tests, format, lints, docs, each crate alone, tables, pages, the wheel, a quick run of the paper's tables.
    #[command(after_help = "Examples:\n  cargo xtask ci\n  cargo xtask ci --nightly")]
    Ci(ci::CiArgs),
    /// Is the elasticity solver right: the verification table, or one deck.
    #[command(after_help = "Examples:\n  cargo xtask verify\n  cargo xtask verify -- --only \
        solid.le10\n  cargo xtask verify --deck fixtures/shin/shin.inp.gz")]
    Verify(verify::VerifyArgs),
    /// Times against other programs, as ratios in one run.
    #[command(after_help = "Examples:\n  cargo xtask bench fe\n  cargo xtask bench nets -- \
        --skip-trained --rounds 2\n  cargo xtask bench live --seconds 10")]
    Bench(bench::BenchArgs),
    /// Contacts by superposition against the paper's pipeline, on the same frames of the same rig.
    #[command(
        after_help = "Examples:\n  cargo xtask compare\n  cargo xtask compare --quick -- --without-paper"
    )]
    Compare(compare::CompareArgs),
    /// Error against run time: every method and variant in one table and plot.
    #[command(
        after_help = "Examples:\n  cargo xtask frontier --minutes 20\n  cargo xtask frontier \
        nets --quick\n  cargo xtask frontier inverse"
    )]
    Frontier(frontier::FrontierArgs),
    /// Is a solver ever silently wrong: its extremes, against known solutions.
    #[command(
        alias = "stability",
        after_help = "Examples:\n  cargo xtask robustness\n  cargo xtask robustness inverse \
            --seed 1\n  cargo xtask robustness scenes --minutes 10 --seed 1"
    )]
    Robustness(robustness::RobustnessArgs),
    /// Which real limbs become one skin, which not and why, and how well touch is found on those that do.
    #[command(
        after_help = "Examples:\n  cargo xtask limbs\n  cargo xtask limbs --folder meshes --only --skins"
    )]
    Limbs(limbs::LimbsArgs),
    /// Damaged inputs for every reader; ends with exit code 1 if one panics.
    #[command(after_help = "Example:\n  cargo xtask fuzz --minutes 10")]
    Fuzz(fuzz::FuzzArgs),
    /// Are frames wrong, lost or uncounted: damaged wires, a device at 1 kHz on a pty, kill -9.
    #[command(
        after_help = "Examples:\n  cargo xtask soak --short\n  cargo xtask soak -- --seconds 600 --kills 200"
    )]
    Soak(soak::SoakArgs),
    /// The live page in a headless Chromium, which it installs as root: its tests.
    #[command(after_help = "Example:\n  cargo xtask browser")]
    Browser,
    /// The page with the whole program in the browser, as a folder of static files, tested in a headless Chromium.
    #[command(
        after_help = "Examples:\n  cargo xtask wasm\n  cargo xtask wasm --untested --out page"
    )]
    Wasm(wasm::WasmArgs),
    /// The pictures of the docs, from the pages that the other commands have written.
    #[command(
        after_help = "Example:\n  cargo xtask pictures report shin-rigidity --into target/pictures"
    )]
    Pictures(pictures::PicturesArgs),
    /// The Python module: its wheel, installed and tested; says so where there is no Python.
    #[command(after_help = "Example:\n  cargo xtask python")]
    Python,
    /// What somebody compiles who takes one layer alone: crates, seconds, bytes.
    #[command(after_help = "Examples:\n  cargo xtask weight --check\n  cargo xtask weight --build")]
    Weight(weight::WeightArgs),
    /// Runs the commands that the docs show.
    #[command(after_help = "Example:\n  cargo xtask docs")]
    Docs(docs::DocsArgs),
    /// The docs as a book with search.
    #[command(after_help = "Examples:\n  cargo xtask book\n  cargo xtask book -o target/site")]
    Book(book::BookArgs),
    /// A folder to give away: program, wheel, completions, manual, docs, checksums; and an archive of it.
    #[command(after_help = "Examples:\n  cargo xtask dist\n  cargo xtask dist --check")]
    Dist {
        /// Unpack the archive, too, and run what is in it.
        #[arg(long)]
        check: bool,
    },
    /// Checks that every crate can be published as it is.
    #[command(after_help = "Example:\n  cargo xtask packages")]
    Packages,
    /// Compares the tree with its own rules: layers, file lengths, leftovers, links of the docs.
    #[command(after_help = "Example:\n  cargo xtask tidy")]
    Tidy,
    /// Makes the bundled limb under fixtures/ again.
    #[command(after_help = "Example:\n  cargo xtask fixtures --check")]
    Fixtures {
        /// Write nothing; fail if what is there differs.
        #[arg(long)]
        check: bool,
    },
}

fn main() -> ExitCode {
    match run(Cli::parse().task) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run(task: Task) -> Result<()> {
    match task {
        Task::Demo(args) => pipeline::demo(&args),
        Task::Repro(args) => repro::repro(&args),
        Task::Test => test::run_all(),
        Task::Ci(args) => ci::run_everything(&args),
        Task::Verify(args) => verify::run(&args),
        Task::Bench(args) => bench::run(&args),
        Task::Compare(args) => compare::run(&args),
        Task::Frontier(args) => frontier::run(&args),
        Task::Robustness(args) => robustness::run(&args),
        Task::Limbs(args) => limbs::run(&args),
        Task::Fuzz(args) => fuzz::run(&args),
        Task::Soak(args) => soak::run(&args),
        Task::Browser => browser::test(),
        Task::Wasm(args) => wasm::make(&args),
        Task::Pictures(args) => pictures::run_some(&args),
        Task::Python => python::check(),
        Task::Weight(args) => weight::run(&args),
        Task::Docs(args) => docs::run_some(&args),
        Task::Book(args) => book::make(&args),
        Task::Dist { check: true } => dist::check(),
        Task::Dist { check: false } => dist::make(),
        Task::Packages => package::check(),
        Task::Tidy => tidy::run(),
        Task::Fixtures { check } => fixtures::make(check),
    }
}

#[cfg(test)]
#[path = "../../crates/hapdef-cli/tests/it/support/help.rs"]
mod help;

#[cfg(test)]
mod tests {
    use super::{Cli, help};

    #[test]
    fn every_help_has_an_example_that_is_understood() {
        help::every_help_has_an_example_that_is_understood::<Cli>("cargo xtask");
    }
}
