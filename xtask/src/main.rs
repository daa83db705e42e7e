//! Runs hapdef's pipeline, checks the layering, and runs what CI runs.
//!
//! Links no crate of the workspace: it starts their binaries.

#![expect(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "a command line program prints"
)]

mod bench;
mod bench_nets;
mod browser;
mod ci;
mod compare;
mod design;
mod docs;
mod first_minute;
mod fixtures;
mod frontier;
mod fuzz;
mod live;
mod pictures;
mod pipeline;
mod python;
mod readers;
mod repro;
mod rig;
mod search;
mod soak;
mod stability;
mod tidy;
mod tool;
mod verify;
mod weight;

use std::process::ExitCode;

use anyhow::Result;
use clap::{Parser, Subcommand};

use crate::pipeline::{DemoArgs, PipelineArgs};

/// hapdef's tasks. `cargo xtask demo --quick` is the place to start.
#[derive(Parser)]
#[command(
    name = "cargo xtask",
    after_help = "Example:\n  cargo xtask demo --quick\n  \
    cargo xtask demo --scene fixtures/shin/scene.json\n  \
    cargo xtask demo --live\n  cargo xtask ci"
)]
struct Cli {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Everything from the limb to the report with the paper's tables; with `--live` the live page.
    Demo(DemoArgs),
    /// The paper's tables and figures in full, with verdicts on its claims.
    Repro(repro::ReproArgs),
    /// The limb's compliance and the datasets only.
    Dataset(PipelineArgs),
    /// Everything up to the trained nets.
    Train(PipelineArgs),
    /// Everything up to the scores of the trained nets.
    Eval(PipelineArgs),
    /// What CI runs: format, lints, tests, docs, each crate alone, layering, a quick demo.
    Ci,
    /// Is the elasticity solver right: the verification table, or one deck.
    Verify(verify::VerifyArgs),
    /// Times against other programs, as ratios in one run.
    Bench(bench::BenchArgs),
    /// Contacts by superposition against the paper's pipeline, on the same frames of the same rig.
    Compare(compare::CompareArgs),
    /// Error against run time: every method and variant in one table and plot.
    Frontier(frontier::FrontierArgs),
    /// What a scene's gauges can tell about contacts: bounds on the limb, blind spots.
    Limits(design::DesignArgs),
    /// Where on the inner wall to put gauges.
    Place(design::DesignArgs),
    /// Is a solver ever silently wrong: its extremes, against known solutions.
    Stability(stability::StabilityArgs),
    /// Settings of a net or a baseline by Bayesian optimisation.
    Search(search::SearchArgs),
    /// The baselines and a net on a real tactile skin that nobody here built.
    Tactile(search::TactileArgs),
    /// Damaged inputs for every reader; ends with exit code 1 if one panics.
    Fuzz(fuzz::FuzzArgs),
    /// Are frames wrong, lost or uncounted: damaged wires, a device at 1 kHz on a pty, kill -9.
    Soak(soak::SoakArgs),
    /// The virtual limb as a device on a port: a pseudo-terminal, or TCP.
    Rig(rig::RigArgs),
    /// The live page in a headless Chromium, which it installs as root: its tests.
    Browser,
    /// The pictures of the docs, from the pages that the other commands have written.
    Pictures(pictures::PicturesArgs),
    /// The Python module: its wheel, installed and tested; says so where there is no Python.
    Python,
    /// What somebody compiles who takes one layer alone: crates, seconds, bytes.
    Weight(weight::WeightArgs),
    /// Runs the commands that the docs show.
    Docs(docs::DocsArgs),
    /// Compares the tree with its own rules: layers, file lengths, leftovers, links of the docs.
    Tidy,
    /// Makes the bundled limb under fixtures/ again.
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
        Task::Dataset(args) => pipeline::stage("dataset", &args),
        Task::Train(args) => pipeline::stage("train", &args),
        Task::Eval(args) => pipeline::stage("eval", &args),
        Task::Ci => ci::run_everything(),
        Task::Verify(args) => verify::run(&args),
        Task::Bench(args) => bench::run(&args),
        Task::Compare(args) => compare::run(&args),
        Task::Frontier(args) => frontier::run(&args),
        Task::Limits(args) => design::run("limits", &args),
        Task::Place(args) => design::run("place", &args),
        Task::Stability(args) => stability::run(&args),
        Task::Search(args) => search::run(&args),
        Task::Tactile(args) => search::tactile(&args),
        Task::Fuzz(args) => fuzz::run(&args),
        Task::Soak(args) => soak::run(&args),
        Task::Rig(args) => rig::run(&args),
        Task::Browser => browser::test(),
        Task::Pictures(args) => pictures::run_some(&args),
        Task::Python => python::check(),
        Task::Weight(args) => weight::run(&args),
        Task::Docs(args) => docs::run_some(&args),
        Task::Tidy => tidy::run(),
        Task::Fixtures { check } => fixtures::make(check),
    }
}
