//! The paper's settings beside the search's best, on test samples.

use anyhow::{Result, bail};
use hapdef_bench::{terminal_table, text_table};
use hapdef_cli::{SceneArgs, TrainingArgs};
use hapdef_report::write_text;

use super::data::MethodData;
use super::{PatchArg, Prepared, budget, folder, found_trials, prepare};
use crate::search::{ParameterValues, SearchMethod, TrialSource, best_trial, values_in_words};

/// Arguments of `search-compare`.
#[derive(clap::Args)]
pub(crate) struct CompareArgs {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    training: TrainingArgs,
    #[command(flatten)]
    patch: PatchArg,
}

/// Fits every searched method with both settings, with the budget of its trials, and scores them.
pub(crate) fn compare(args: &CompareArgs) -> Result<()> {
    let prepared = prepare(&args.scene, &args.training, args.patch)?;
    let header = ["method", "settings", "from", "trials", "tested on", "error", "force, N"];
    let mut rows = Vec::new();
    for method in SearchMethod::ALL {
        let place = folder(&args.scene, &prepared.run, method);
        let Some((_, trials)) = found_trials(&place)? else {
            continue;
        };
        let paper = trials.iter().find(|t| t.source == TrialSource::Paper);
        let data = MethodData::load(method, &prepared, true)?;
        for (from, trial) in [("paper", paper), ("search", best_trial(&trials))] {
            let Some(trial) = trial else { continue };
            let n = trials.len();
            rows.extend(scored(args, &prepared, &data, method, (from, &trial.values, n))?);
        }
    }
    if rows.is_empty() {
        bail!("no search has been run for this scene: `hapdef-repro search --method …` first");
    }
    let table = text_table(header, rows);
    let text = format!(
        "# The paper's settings and the search's best\n\nOn test samples; every method has the \
         budget of its trials. Error: µm of map or virtual gauges, mm of contacts.\n\n{}",
        table.to_markdown()
    );
    let path = args.scene.results.join(&prepared.run.scene.name).join("search/comparison.md");
    write_text(&path, &text)?;
    println!("{}\n{}", terminal_table(&table), path.display());
    Ok(())
}

fn scored(
    args: &CompareArgs,
    prepared: &Prepared,
    data: &MethodData,
    method: SearchMethod,
    (from, values, n_trials): (&str, &ParameterValues, usize),
) -> Result<Vec<[String; 7]>> {
    let run = &prepared.run;
    run.say(&format!("{} with the settings of the {from}", method.name()));
    let learner = method.learner(values, &budget(&args.training, run, method))?;
    let fitted = data.fit(&learner, values, &|| run.stopping())?;
    let row = |(name, rows): &(String, crate::run::dataset::Rows)| {
        let error = data.error(&fitted, values, rows)?;
        Ok([
            method.name().to_owned(),
            values_in_words(values),
            from.to_owned(),
            n_trials.to_string(),
            name.clone(),
            format!("{:.3}", error.main),
            error.force_n.map_or(String::new(), |f| format!("{f:.3}")),
        ])
    };
    data.tests.iter().map(row).collect()
}
