//! The program's part of the outside check on a real tactile skin.

use std::path::PathBuf;

use anyhow::Result;
use hapdef_bench::{Column, table, terminal_table};
use hapdef_report::MetricLog;

use super::facts;
use crate::search::TrialBudget;
use crate::tactile::{
    TACTILE_METHODS, TactileRun, TactileScore, numpy_permutations, read_tactile_runs,
    seeded_permutation, tactile_folder, tactile_scores,
};

/// Mean distance that the reference's k-NN reaches on each run, mm.
const REFERENCE_KNN_MM: [f64; 2] = [0.95, 0.39];

/// Arguments of `tactile`.
#[derive(clap::Args)]
pub(crate) struct TactileArgs {
    /// Folder of the shared inputs; HAPDEF_SHARED, or shared beside the checkout, if absent.
    #[arg(long)]
    shared: Option<PathBuf>,
    /// Steps of each net's training, 100 presses each.
    #[arg(long, default_value_t = 3000)]
    steps: u64,
    /// Most presses that support vectors are trained on.
    #[arg(long, default_value_t = 2000)]
    svr_presses: usize,
    /// Seed of weights, batches and thinning.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Draw the test presses with this project's generator and this seed, instead of the
    /// reference's own draw.
    #[arg(long)]
    split_seed: Option<u64>,
    /// The metrics' file.
    #[arg(long, env = "HAPDEF_METRICS", default_value = "target/hapdef/metrics.json")]
    metrics: PathBuf,
}

/// Scores every method on both runs.
pub(crate) fn run(args: &TactileArgs) -> Result<()> {
    let from_environment = || std::env::var_os("HAPDEF_SHARED").map(PathBuf::from);
    let shared = args.shared.clone().or_else(from_environment);
    let folder = tactile_folder(&shared.unwrap_or_else(|| PathBuf::from("../shared")));
    let mut log = facts::log(args.seed);
    if !folder.exists() {
        let reason = format!("{} is absent", folder.display());
        log.skipped("tactile.knn_first_mm", &reason)?;
        return Ok(());
    }
    let runs = read_tactile_runs(&folder)?;
    let sizes: Vec<usize> = runs.iter().map(TactileRun::n).collect();
    let orders = match args.split_seed {
        None => numpy_permutations(0, &sizes),
        Some(seed) => sizes.iter().map(|&n| seeded_permutation(seed, n)).collect(),
    };
    let mut scores = Vec::new();
    for ((run, order), which) in runs.iter().zip(&orders).zip([0, 1]) {
        scores.extend(score_run(args, run, order, which, &mut log)?);
    }
    println!("\n{}", terminal_table(&table(&COLUMNS, &scores)));
    log.append_to(&args.metrics)?;
    Ok(())
}

/// Scores every method on one run, the reference's first or second.
fn score_run(
    args: &TactileArgs,
    run: &TactileRun,
    order: &[usize],
    which: usize,
    log: &mut MetricLog<std::io::Stdout>,
) -> Result<Vec<(&'static str, TactileScore)>> {
    let budget = TrialBudget { steps: args.steps, n_svr: args.svr_presses, seed: args.seed };
    let (name, progress) = (["first", "second"][which], hapdef_cli::on_stderr());
    let (mut knn_mm, mut all) = (f64::NAN, Vec::new());
    for (method, settings) in TACTILE_METHODS {
        progress.say(&format!("{name} run: {method}"));
        let scores = tactile_scores(run, order, (method, &settings(&budget)))?;
        let [paper, chosen] = scores.each_ref().map(|score| score.mean_mm);
        all.extend(scores.map(|score| (name, score)));
        let word = method.to_lowercase().replace('-', "");
        log.value(&format!("tactile.{word}_{name}_mm"), paper, "mm")?;
        log.value(&format!("tactile.{word}_{name}_chosen_mm"), chosen, "mm")?;
        if method == "k-NN" {
            knn_mm = paper;
            let ratio = paper / REFERENCE_KNN_MM[which];
            log.value(&format!("tactile.knn_{name}_vs_reference"), ratio, "1")?;
        }
        if method == "FNN" {
            log.value(&format!("tactile.fnn_{name}_over_knn"), chosen / knn_mm, "1")?;
        }
    }
    Ok(all)
}

const COLUMNS: [Column<(&str, TactileScore)>; 8] = [
    Column::new("run", |(run, _)| (*run).to_owned()),
    Column::new("method", |(_, s)| s.method.to_owned()),
    Column::new("settings", |(_, s)| s.settings.clone()),
    Column::new("from", |(_, s)| if s.is_chosen { "validation" } else { "paper" }.to_owned()),
    Column::new("mean, mm", |(_, s)| format!("{:.3}", s.mean_mm)),
    Column::new("median, mm", |(_, s)| format!("{:.3}", s.median_mm)),
    Column::new("presses", |(_, s)| format!("{} / {}", s.n_train, s.n_test)),
    Column::new("s", |(_, s)| format!("{:.1}", s.elapsed_s)),
];
