//! `hapdef demo`: the whole job in a minute, from the limb to contacts with their errors.

mod page;

use std::time::Instant;

use anyhow::{Context, Result};
use clap::Args;
use clap::builder::RangedU64ValueParser;
use hapdef::touch::{
    CALIBRATION_SITES, Calibration, PressQuality, ProbeParams, ProbedPress, ProbedRig, SearchPlace,
    Superposition, TouchScore, Tracking, touchable_skin, tracker_params,
};
use hapdef::{Limb, Run, StepBar};
use hapdef_bench::{table, terminal_table};
use hapdef_cli::{SceneArgs, StandardOutput, print_json, shown};
use hapdef_inverse::{ContactEstimator, Press};
use hapdef_report::{MetricContext, MetricLog};
use nalgebra::Point3;
use serde::Serialize;

/// Farthest a place that is pressed may be from the skin, m.
const OFF_SKIN_M: f64 = 0.5e-3;

/// Frames, at 1 kHz, in which each contact of those that are followed comes.
const N_RISING: usize = 50;

/// Contacts at a time that are looked for.
const COUNTS: [usize; 3] = [1, 2, 4];

#[derive(Args)]
#[command(after_help = "Example:\n  hapdef demo fixtures/shin/demo.json\n\n\
    Simulated: the scene's rig is pressed, not hardware. One and two contacts are looked for in single \
    frames; four come one after another and are followed.")]
pub(crate) struct DemoArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Presses that calibrate the limb.
    #[arg(long, default_value_t = 300, value_parser = RangedU64ValueParser::<usize>::new().range(20..))]
    presses: usize,
    /// Presses that are looked for, of one contact, of two, and of four.
    #[arg(long, default_value_t = 100, value_parser = RangedU64ValueParser::<usize>::new().range(1..))]
    scored: usize,
    /// Print the errors as JSON.
    #[arg(long)]
    json: bool,
}

/// What the demo finds.
#[derive(Serialize)]
struct Found {
    scene: String,
    simulated: bool,
    n_gauges: usize,
    n_presses: usize,
    /// Relative error of the calibrated map at presses that were not used.
    map_error: f64,
    scores: Vec<TouchScore>,
    elapsed_s: f64,
}

/// Calibrates, looks for contacts, writes the page and says how well it went.
pub(crate) fn run(args: &DemoArgs) -> Result<()> {
    let start = Instant::now();
    let run = args.scene.prepare()?;
    let stages = Stages::new(&run);
    stages.begin(0, "reading the limb");
    let limb = Limb::load(&run.scene, &run.scene_dir)?;
    stages.begin(1, "solving the simulated real limb");
    let rig = ProbedRig::new(&run, &limb)?;
    stages.begin(2, "calibrating");
    let calibrated = calibrate(args, &run, &limb, &rig)?;
    let mut scores = Vec::new();
    for (i, n_contacts) in COUNTS.into_iter().enumerate() {
        if n_contacts > run.scene.contact.max_contacts {
            continue;
        }
        run.check_stop("looking for contacts")?;
        stages.begin(3 + i as u64, &format!("looking for {}", in_words(n_contacts)));
        scores.push(score(&run, &rig, &calibrated.estimator, n_contacts, args.scored)?);
    }
    stages.begin(6, "drawing");
    let found = Found {
        scene: run.scene.name.clone(),
        simulated: true,
        n_gauges: limb.gauges.len(),
        n_presses: args.presses,
        map_error: calibrated.map_error,
        scores,
        elapsed_s: start.elapsed().as_secs_f64(),
    };
    let page = page::write(args, &run, &limb, &calibrated.estimator, &found)?;
    let picture_s = start.elapsed().as_secs_f64();
    drop(stages);
    if args.json {
        return Ok(print_json(&found, true)?);
    }
    println!("{}\n", terminal_table(&table(&page::COLUMNS, &found.scores)));
    println!("{}", page::sentence(&found));
    println!("page: {}", shown(&page));
    println!("next: {}", page::live_command(args));
    let context = MetricContext::here(run.scene.seed);
    let mut log = MetricLog::new(StandardOutput, context);
    log.value("first.picture_s", picture_s, "s")?;
    Ok(log.value("first.demo_s", start.elapsed().as_secs_f64(), "s")?)
}

/// A bar with a step for each stage, and a line for each where there is no terminal.
struct Stages<'a> {
    run: &'a Run,
    bar: StepBar,
}

impl<'a> Stages<'a> {
    fn new(run: &'a Run) -> Self {
        Self { run, bar: run.progress.bar("demo", 7) }
    }

    fn begin(&self, stage: u64, text: &str) {
        self.run.say(text);
        self.bar.set(stage, text.to_owned());
    }
}

/// The limb after its presses.
struct CalibratedLimb {
    estimator: ContactEstimator,
    map_error: f64,
}

fn calibrate(
    args: &DemoArgs,
    run: &Run,
    limb: &Limb,
    rig: &ProbedRig<'_>,
) -> Result<CalibratedLimb> {
    let params = ProbeParams { n_presses: args.presses, n_contacts: 1, seed: 1, n_rising: 0 };
    let skin = touchable_skin(limb)?;
    let press = |press: ProbedPress| {
        let (place_m, force_n) = *press.contacts.first().context("a press without a contact")?;
        let readings_ue = press.frames_ue.into_iter().next().context("a press without a frame")?;
        let place_m = Point3::from(place_m);
        Ok(Press::at_position(&skin, &place_m, OFF_SKIN_M, force_n, readings_ue)?)
    };
    let presses: Vec<Press> =
        rig.presses(&params)?.into_iter().map(press).collect::<Result<_>>()?;
    let spec = run.scene.estimator.superposition();
    let quality = PressQuality { noise_ue: spec.noise_ue, position_sd_m: 0.0, force_sd_n: 0.0 };
    let (calibration, info) = Calibration::fit(run, limb, &presses, &quality, CALIBRATION_SITES)?;
    let estimator = calibration.estimator(&run.scene, &spec, limb)?;
    Ok(CalibratedLimb { estimator, map_error: info.relative_error })
}

/// Presses that the calibration has not seen: as many as the gauges decide in a single frame, more by
/// following them.
fn score(
    run: &Run,
    rig: &ProbedRig<'_>,
    estimator: &ContactEstimator,
    n_contacts: usize,
    n_presses: usize,
) -> Result<TouchScore> {
    let seed = 1 + n_contacts as u64;
    let params = ProbeParams { n_presses, n_contacts, seed, n_rising: 0 };
    if n_contacts <= 2 {
        let presses = rig.presses(&params)?;
        return Ok(TouchScore::of(&presses, || Ok(Superposition::new(estimator.clone())))?);
    }
    let presses = rig.presses(&ProbeParams { n_rising: N_RISING, ..params })?;
    let params = tracker_params(&run.scene);
    Ok(TouchScore::of(&presses, || {
        Ok(Tracking::new(estimator.clone(), params, SearchPlace::Here)?)
    })?)
}

fn in_words(n_contacts: usize) -> String {
    match n_contacts {
        1 => "one contact".into(),
        2 => "two contacts".into(),
        4 => "four contacts".into(),
        n => format!("{n} contacts"),
    }
}
