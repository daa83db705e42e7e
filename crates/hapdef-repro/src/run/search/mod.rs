//! The program's part of the search for settings.

mod compare;
mod data;

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use clap::ValueEnum;
use hapdef::{HapdefError, Limb, Pipeline, Run, Until};
use hapdef_cli::{SceneArgs, TrainingArgs};
use hapdef_report::write_text;

use self::data::MethodData;
use crate::error::ReproError;
use crate::search::{
    Parameter, SearchMethod, Trial, TrialBudget, TrialHeader, best_trial, merge_trials,
    open_trials, propose, search_figures, search_markdown, values_in_words, write_trials,
};

pub(crate) use self::compare::{CompareArgs, compare};

/// Raise when a trial's outcome changes for an unchanged point.
const VERSION: u32 = 1;

/// Steps of an F_R's training in a trial, unless `--steps` says otherwise.
const MAP_STEPS: usize = 300;
/// The same for the smaller nets and `--other-steps`.
const SMALL_STEPS: usize = 1500;

/// Arguments of `search`.
#[derive(clap::Args)]
pub(crate) struct SearchArgs {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    training: TrainingArgs,
    /// The method: f_r, f_t, direct, lr, knn, svr.
    #[arg(long, default_value = "f_r")]
    method: SearchMethod,
    /// Trials in all, those of other shards and those that are there already included.
    #[arg(long, default_value_t = 20)]
    trials: usize,
    /// Runs every n-th trial only, from the i-th on: `1/3`, `2/3`, `3/3` on three machines.
    #[arg(long, value_parser = shard, default_value = "1/1")]
    shard: Shard,
    /// Begins no trial after so many minutes.
    #[arg(long)]
    minutes: Option<f64>,
    #[command(flatten)]
    patch: PatchArg,
}

/// Most virtual gauges per gauge.
#[derive(clap::Args, Clone, Copy)]
pub(crate) struct PatchArg {
    /// Most virtual gauges per gauge that a trial may use; every smaller patch is part of it.
    #[arg(long, default_value_t = 60)]
    max_patch: usize,
}

/// Arguments of `search-merge`.
#[derive(clap::Args)]
pub(crate) struct MergeArgs {
    /// Files of trials.
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// The file to write; a table and figures go beside it.
    #[arg(long)]
    into: PathBuf,
}

/// Which trials this run makes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Shard {
    index: usize,
    count: usize,
}

/// A scene prepared for a search: datasets with the largest patches.
pub(crate) struct Prepared {
    pub(crate) run: Run,
    pub(crate) done: Pipeline,
    pub(crate) max_patch: usize,
}

/// Runs the trials that are missing.
pub(crate) fn search(args: &SearchArgs) -> Result<()> {
    let prepared = prepare(&args.scene, &args.training, args.patch)?;
    let (run, method) = (&prepared.run, args.method);
    let data = MethodData::load(method, &prepared, false)?;
    let budget = budget(&args.training, run, method);
    let folder = folder(&args.scene, run, method);
    let path = folder.join(args.shard.file_name());
    let header = header(&prepared, method, &budget, &data)?;
    let parameters = method.parameters(prepared.max_patch);
    std::fs::create_dir_all(&folder).with_context(|| format!("making {}", folder.display()))?;
    let mut trials = open_trials(&path, &header)?;
    run.say(&format!("{}: {} trials are there", path.display(), trials.len()));
    let start = Instant::now();
    let limit = args.minutes.map(|m| Duration::from_secs_f64(m.max(0.0) * 60.0));
    for index in args.shard.indices(args.trials) {
        if trials.iter().any(|trial| trial.index == index) {
            continue;
        }
        if limit.is_some_and(|limit| start.elapsed() > limit) {
            run.say("the minutes are over");
            break;
        }
        let trial = try_point(run, method, &data, &budget, &parameters, &trials, index)?;
        run.say(&format!(
            "trial {index}: {} → {}",
            values_in_words(&trial.values),
            trial.objective.map_or_else(
                || trial.note.clone().unwrap_or_default(),
                |value| format!("{value:.4}")
            )
        ));
        trials.push(trial);
        write_trials(&path, &header, &trials)?;
    }
    write_report(&folder, &header, &parameters, &trials)
}

/// Joins shards.
pub(crate) fn merge(args: &MergeArgs) -> Result<()> {
    let (header, trials) = merge_trials(&args.files)?;
    let method = SearchMethod::from_str(&header.method, false).map_err(anyhow::Error::msg)?;
    let folder = args.into.parent().unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder).with_context(|| format!("making {}", folder.display()))?;
    write_trials(&args.into, &header, &trials)?;
    println!("{} trials in {}", trials.len(), args.into.display());
    write_report(folder, &header, &method.parameters(usize::MAX), &trials)
}

/// The datasets of a scene whose patches have `max_patch` virtual gauges.
pub(crate) fn prepare(
    scene: &SceneArgs,
    training: &TrainingArgs,
    patch: PatchArg,
) -> Result<Prepared> {
    let mut run = training.prepare(scene)?;
    run.scene.gauges.patch_nodes = patch.max_patch;
    run.set_seed(run.scene.seed)?;
    let limb = Limb::load(&run.scene, &run.scene_dir).with_context(|| {
        format!("patches of {} virtual gauges; --max-patch asks for fewer", patch.max_patch)
    })?;
    let done = Pipeline::run(&run, &limb, Until::Dataset)?;
    Ok(Prepared { run, done, max_patch: patch.max_patch })
}

/// What a trial may spend.
pub(crate) fn budget(args: &TrainingArgs, run: &Run, method: SearchMethod) -> TrialBudget {
    let steps = match method {
        SearchMethod::Reconstruction => args.steps.unwrap_or(MAP_STEPS),
        _ => args.other_steps.unwrap_or(SMALL_STEPS),
    };
    TrialBudget { steps: steps as u64, n_svr: run.profile.n_svr, seed: run.scene.seed }
}

/// Where a method's search lies.
pub(crate) fn folder(args: &SceneArgs, run: &Run, method: SearchMethod) -> PathBuf {
    args.results.join(&run.scene.name).join("search").join(method.name())
}

/// What a method's trials rest on.
fn header(
    prepared: &Prepared,
    method: SearchMethod,
    budget: &TrialBudget,
    data: &MethodData,
) -> Result<TrialHeader> {
    let budget = match method {
        SearchMethod::Svr => format!("at most {} training presses", budget.n_svr),
        SearchMethod::Linear | SearchMethod::Knn => "all training samples".to_owned(),
        _ => format!("{} steps of 100 samples", budget.steps),
    };
    Ok(TrialHeader {
        method: method.name().to_owned(),
        objective: method.objective().to_owned(),
        data: format!(
            "version {VERSION}, datasets {}, {} training and {} validation samples, patches up to {}",
            data.keys, data.train.n, data.validation.n, prepared.max_patch
        ),
        budget,
        seed: prepared.run.scene.seed,
    })
}

fn try_point(
    run: &Run,
    method: SearchMethod,
    data: &MethodData,
    budget: &TrialBudget,
    parameters: &[Parameter],
    trials: &[Trial],
    index: usize,
) -> Result<Trial> {
    let (values, source) = propose(parameters, trials, index, run.scene.seed)?;
    let start = Instant::now();
    let learner = method.learner(&values, budget)?;
    let fitted = data.fit(&learner, &values, &|| run.stopping());
    let outcome = match fitted {
        Ok(fitted) => {
            let error = data.error(&fitted, &values, &data.validation)?;
            error.main.is_finite().then_some(error.main).ok_or_else(|| "no finite error".to_owned())
        }
        Err(ReproError::Stopped) => {
            let stage = format!("trial {index}");
            return Err(HapdefError::Stopped { stage }.into());
        }
        Err(error) => Err(error.to_string()),
    };
    run.check_stop("the search")?;
    let n_train = match method {
        SearchMethod::Svr => data.train.n.min(budget.n_svr),
        _ => data.train.n,
    };
    Ok(Trial {
        index,
        source,
        values,
        objective: outcome.as_ref().ok().copied(),
        note: outcome.err(),
        n_train,
        elapsed_s: start.elapsed().as_secs_f64(),
    })
}

fn write_report(
    folder: &Path,
    header: &TrialHeader,
    parameters: &[Parameter],
    trials: &[Trial],
) -> Result<()> {
    let text = search_markdown(header, parameters, trials);
    write_text(&folder.join("search.md"), &text)?;
    println!("{text}");
    if best_trial(trials).is_some() {
        for (name, svg) in search_figures(header, parameters, trials)? {
            write_text(&folder.join(name), &svg)?;
        }
    }
    println!("{}", folder.join("search.md").display());
    Ok(())
}

fn shard(text: &str) -> Result<Shard, String> {
    let parse = || {
        let (index, count) = text.split_once('/')?;
        Some((index.parse().ok()?, count.parse().ok()?))
    };
    match parse() {
        Some((index, count)) if 1 <= index && index <= count => Ok(Shard { index, count }),
        _ => Err("expected i/n with 1 ≤ i ≤ n, such as 2/3".to_owned()),
    }
}

impl Shard {
    fn indices(self, n: usize) -> impl Iterator<Item = usize> {
        (self.index - 1..n).step_by(self.count)
    }

    fn file_name(self) -> String {
        match self.count {
            1 => "trials.jsonl".to_owned(),
            _ => format!("trials-{}-of-{}.jsonl", self.index, self.count),
        }
    }
}

/// Trials of a method's search, the whole one where there is one, else its shards.
pub(crate) fn found_trials(folder: &Path) -> Result<Option<(TrialHeader, Vec<Trial>)>> {
    let whole = folder.join("trials.jsonl");
    if whole.exists() {
        return Ok(Some(crate::search::read_trials(&whole)?));
    }
    let Ok(entries) = std::fs::read_dir(folder) else {
        return Ok(None);
    };
    let mut files: Vec<PathBuf> = entries
        .filter_map(|entry| entry.ok().map(|entry| entry.path()))
        .filter(|path| path.extension().is_some_and(|ending| ending == "jsonl"))
        .collect();
    files.sort();
    if files.is_empty() {
        return Ok(None);
    }
    if files.len() > 64 {
        bail!("{}: more than 64 shards; merge them", folder.display());
    }
    Ok(Some(merge_trials(&files)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_share_the_trials_out() {
        let all = |text: &str| shard(text).unwrap().indices(8).collect::<Vec<_>>();
        assert_eq!(all("1/1"), (0..8).collect::<Vec<_>>());
        assert_eq!(
            [all("1/3"), all("2/3"), all("3/3")],
            [vec![0, 3, 6], vec![1, 4, 7], vec![2, 5]]
        );
        for bad in ["0/2", "3/2", "1", "a/b"] {
            assert!(shard(bad).is_err(), "{bad}");
        }
        assert_eq!(shard("2/3").unwrap().file_name(), "trials-2-of-3.jsonl");
    }
}
