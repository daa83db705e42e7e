//! What a run rests on, for the report's head and tail.

use std::collections::HashSet;
use std::io::Stdout;

use hapdef::{HapdefError, Limb, OutputScale, Pipeline, Profile, Run, Samples, Schedule, Stage};
use hapdef_nets::Loss;
use hapdef_report::{MetricContext, MetricLog, NamedText, Report, SkippedStage, StageTime};

use super::made::Made;

/// How names of scenes of the paper's limb begin.
const PAPERS_LIMB: &str = "paper-shin";

/// The lines at the head of the report.
pub(crate) fn facts(made: &Made<'_>) -> Vec<NamedText> {
    let (run, svr) = (made.run, &made.svr);
    let limb = &made.done.compliance.record.info;
    let rig = &made.done.rig.record.info;
    let [samples, training] = amounts(run);
    vec![
        named("simulated", "all readings come from the simulated rig; no hardware"),
        named("profile", format!("{}, seed {}", run.profile.name, run.scene.seed)),
        named(
            "limb",
            format!(
                "{} FE nodes, {} equations, nnz(L) {}, {} surface nodes",
                limb["n_fe_nodes"], limb["n_equations"], limb["nnz_l"], limb["n_loads"]
            ),
        ),
        named("mesh", made.mesh_check.in_words(made.limb)),
        named("rig", format!("its own mesh of {} FE nodes, perturbed", rig["n_fe_nodes"])),
        samples,
        training,
        named(
            "support vectors",
            format!("trained on {} of the {} training presses", svr.n_trained, svr.n_offered),
        ),
        named("machine", MetricContext::here(0).machine),
    ]
}

/// How many samples a run takes, and how long it trains.
pub(crate) fn amounts(run: &Run) -> [NamedText; 2] {
    let profile = &run.profile;
    let samples = format!(
        "simulated: {} of one contact, {} each of two to {}; rig: {} single and {} × {} double presses \
         (paper: 27,000; 6,000 each of two, three and four; 27,000; 270 × 25)",
        profile.n_single,
        profile.n_multi,
        run.scene.contact.max_contacts,
        profile.n_real_single,
        profile.n_pairs,
        profile.n_amplitudes
    );
    [named("samples", samples), named("training", training(profile))]
}

/// The page of a study over a run: its title, and what every such page has at head and tail.
pub(crate) fn study(run: &Run, title: &str, seed: u64) -> anyhow::Result<Report> {
    Ok(Report {
        title: format!("hapdef: {title}, {}", run.scene.name),
        scene: run.scene.name.clone(),
        seed,
        facts: of_run(run),
        hashes: input_hashes(run)?,
        ..Report::default()
    })
}

/// The lines that every page over a run has.
pub(crate) fn of_run(run: &Run) -> Vec<NamedText> {
    let profile = format!("{}, seed {}", run.profile.name, run.scene.seed);
    vec![
        named("profile", profile),
        named("training", training(&run.profile)),
        named("machine", MetricContext::here(0).machine),
    ]
}

/// Steps, batch, learning rate and L2 weight of every net, and where F_R's samples come from.
fn training(profile: &Profile) -> String {
    let nets = [
        ("F_R", profile.reconstruction),
        ("F_T", profile.transfer),
        ("F_S", profile.sensitivity),
        ("direct", profile.direct),
    ];
    let each = nets.map(|(name, schedule)| {
        let Schedule { steps, batch, learning_rate, final_learning_rate, loss, l2, .. } = schedule;
        let loss = match loss {
            Loss::RootMeanSquare => "√MSE",
            Loss::MeanOfSamples => "mean of the samples' √MSE",
        };
        format!(
            "{name} {steps} steps of {batch} from {learning_rate} to {final_learning_rate:.0e}, \
             {loss} + L2 {l2}"
        )
    });
    let scale = match profile.output_scale {
        OutputScale::Each => "their own deviations",
        OutputScale::One => "one deviation",
    };
    let modes = match profile.output_modes {
        0 => String::new(),
        n => format!(", in {n} modes"),
    };
    let samples = match profile.samples {
        Samples::Fixed => "F_R trained on the fixed sets",
        Samples::Drawn => "F_R trained on samples drawn as they are needed, none twice",
    };
    format!(
        "Adam, learning rate along a cosine, best validation loss kept; {samples}, its outputs \
         divided by {scale}{modes}: {} (paper: √MSE + L2, 1,000,000 steps of 100 at 1e-4, fixed \
         sets, each output divided by its own deviation)",
        each.join("; ")
    )
}

/// Time of every stage, from the run that made it, once where two parts need it.
pub(crate) fn stage_times(done: &Pipeline, more: &[Stage]) -> Vec<StageTime> {
    let stages = done.stages().into_iter().chain(more);
    let mut seen = HashSet::new();
    stages
        .filter(|stage| seen.insert(&stage.dir))
        .map(|stage| {
            let record = &stage.record;
            let inputs = &record.inputs;
            let what = [&record.info["net"], &inputs["kind"], &inputs["size"]]
                .into_iter()
                .find(|value| !value.is_null())
                .map_or(String::new(), |value| format!(" {}", plain(value)));
            let name = format!("{}{what}", record.stage);
            StageTime { name, elapsed_s: record.elapsed_s, cached: stage.cached }
        })
        .collect()
}

fn plain(value: &serde_json::Value) -> String {
    value.to_string().replace(['"', '{', '}'], "").replace(':', " ")
}

/// What the scene does not need, and what only the whole reproduction makes.
pub(crate) fn skipped(run: &Run, with_nets: bool) -> Vec<SkippedStage> {
    let skip = |name: &str, reason: &str| SkippedStage { name: name.into(), reason: reason.into() };
    let mut skipped = vec![
        skip("tangential loads", "the scene's contacts press in one direction: one column a node"),
        skip("loads outside the contact region", "the scene can't be touched there"),
        skip("displacements inside the solid", "only surface nodes and virtual gauges are read"),
    ];
    if !with_nets {
        let reason = "need nets of their own: cargo xtask repro";
        skipped.push(skip("figure 5A, ablations with nets of their own", reason));
    }
    if run.scene.contact.max_contacts < 4 {
        let reason = format!("the scene has {} contacts at most", run.scene.contact.max_contacts);
        skipped.push(skip("datasets of more contacts", &reason));
    }
    skipped
}

/// Hashes of what went in and of the stages.
pub(crate) fn hashes(run: &Run, limb: &Limb, done: &Pipeline) -> Vec<NamedText> {
    let mut hashes =
        vec![named("scene", run.scene_hash.as_str()), named("deck", limb.deck_hash.as_str())];
    hashes.extend(done.stages().iter().map(|stage| named(&stage.record.stage, stage.key.as_str())));
    hashes
}

/// Hashes of the scene and its deck.
pub(crate) fn input_hashes(run: &Run) -> Result<Vec<NamedText>, HapdefError> {
    Ok(run.input_hashes()?.map(|(name, text)| named(name, text)).to_vec())
}

/// A log of metrics on standard output, of a run with this seed.
pub(crate) fn log(seed: u64) -> MetricLog<Stdout> {
    MetricLog::new(std::io::stdout(), MetricContext::here(seed))
}

/// The same for a study of the scene's limb: metrics of the paper's limb end in `_paper`, so that those of the bundled
/// limb stay beside them.
pub(crate) fn log_of(run: &Run, seed: u64) -> MetricLog<Stdout> {
    let is_papers = run.scene.name.starts_with(PAPERS_LIMB);
    log(seed).with_suffix(if is_papers { "_paper" } else { "" })
}

/// A fact of a page.
pub(crate) fn named(name: &str, text: impl Into<String>) -> NamedText {
    NamedText { name: name.into(), text: text.into() }
}
