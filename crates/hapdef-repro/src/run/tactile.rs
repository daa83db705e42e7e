//! The program's part of the outside check on a real tactile skin.

use std::path::PathBuf;

use anyhow::Result;
use hapdef_report::{MetricLog, TextCell, TextTable};
use hapdef_repro::{
    TactileMethod, TactileParams, TactileRun, TactileScore, numpy_permutations, read_tactile_runs,
    seeded_permutation, tactile_folder, tactile_scores,
};

use super::facts;

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
    let mut log = MetricLog::new(std::io::stdout(), facts::metric_context_of(args.seed));
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
    let header = ["run", "method", "settings", "from", "mean, mm", "median, mm", "presses", "s"];
    let mut table = TextTable { header: header.map(str::to_owned).to_vec(), rows: Vec::new() };
    for ((run, order), which) in runs.iter().zip(&orders).zip([0, 1]) {
        score_run(args, run, order, which, &mut table, &mut log)?;
    }
    println!("\n{}", hapdef_bench::terminal_table(&table));
    log.append_to(&args.metrics)?;
    Ok(())
}

/// Scores every method on one run, the reference's first or second.
fn score_run(
    args: &TactileArgs,
    run: &TactileRun,
    order: &[usize],
    which: usize,
    table: &mut TextTable,
    log: &mut MetricLog<std::io::Stdout>,
) -> Result<()> {
    let params = TactileParams { steps: args.steps, n_svr: args.svr_presses, seed: args.seed };
    let (name, progress) = (["first", "second"][which], hapdef_cli::on_stderr());
    let mut knn_mm = f64::NAN;
    for method in TactileMethod::ALL {
        progress.say(&format!("{name} run: {}", method.name()));
        let scores = tactile_scores(run, order, method, &params)?;
        table.rows.extend(scores.iter().map(|score| row(name, score)));
        let [paper, chosen] = [scores[0].mean_mm, scores[1].mean_mm];
        let word = method.name().to_lowercase().replace('-', "");
        log.value(&format!("tactile.{word}_{name}_mm"), paper, "mm")?;
        log.value(&format!("tactile.{word}_{name}_chosen_mm"), chosen, "mm")?;
        match method {
            TactileMethod::Knn => {
                knn_mm = paper;
                let ratio = paper / REFERENCE_KNN_MM[which];
                log.value(&format!("tactile.knn_{name}_vs_reference"), ratio, "1")?;
            }
            TactileMethod::Fnn => {
                log.value(&format!("tactile.fnn_{name}_over_knn"), chosen / knn_mm, "1")?;
            }
            _ => {}
        }
    }
    Ok(())
}

fn row(run: &str, score: &TactileScore) -> Vec<TextCell> {
    let from = if score.is_chosen { "validation" } else { "paper" };
    let cells = [
        run.to_owned(),
        score.method.name().to_owned(),
        score.settings.clone(),
        from.to_owned(),
        format!("{:.3}", score.mean_mm),
        format!("{:.3}", score.median_mm),
        format!("{} / {}", score.n_train, score.n_test),
        format!("{:.1}", score.elapsed_s),
    ];
    cells.map(TextCell::plain).to_vec()
}
