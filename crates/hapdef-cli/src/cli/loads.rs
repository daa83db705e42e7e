//! `hapdef loads`: what a robot's own motion does to the gauges, learned while nothing touches.

use std::path::PathBuf;

use anyhow::{Context, Result, ensure};
use clap::Args;
use hapdef::touch::LearnedLoads;
use hapdef::{Limb, RawFrame, Run, SOURCE_FORMS, Source, SourceArg};
use hapdef_cli::{SceneArgs, print_json, shown};

use super::table::{Row, read_table};
use super::topic::TopicArgs;

/// Numbers of a frame that a contact takes: its place on the skin and its force.
const LEAST_LEFT: usize = 3;

/// Time for which the simulated rig moves, s.
const SIM_S: f64 = 60.0;

#[derive(Args)]
#[command(
    after_help = "Example:\n  hapdef loads my-limb --source replay:moving.mcap@max -o my-limb/loads.json\n\n\
    Record while the robot moves as it will in use, with and without what it carries, and nothing touches the \
    limb; it stands still in the first fifth of a second. Then put \"loads\": {\"learned\": \"loads.json\"} into the \
    scene: contacts are found beside whatever moves the gauges so."
)]
pub(crate) struct LoadsArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// A table of readings in µε, a column for each gauge.
    #[arg(required_unless_present_any = ["source", "sim"])]
    table: Option<PathBuf>,
    #[arg(
        long,
        conflicts_with = "table",
        help = format!("A device or a recording in place of a table: {SOURCE_FORMS}")
    )]
    source: Option<SourceArg>,
    /// The scene's simulated rig, moved by the scene's loads and touched by nothing.
    #[arg(long, conflicts_with_all = ["table", "source"])]
    sim: bool,
    /// Read a source for so long, s; until it ends if absent. The rig moves for a minute.
    #[arg(long, conflicts_with = "table")]
    seconds: Option<f64>,
    /// File for the loads.
    #[arg(short, long, value_name = "FILE", default_value = "loads.json")]
    out: PathBuf,
    #[command(flatten)]
    topic: TopicArgs,
    /// First frames, in which the robot stands still: their mean is the zero.
    #[arg(long, default_value_t = 200)]
    tare_frames: usize,
    /// How many times as strong later loads may be.
    #[arg(long, default_value_t = 2.0)]
    margin: f64,
    /// Standard deviation of a reading's noise at least, µε; the scene's if absent.
    #[arg(long)]
    noise_ue: Option<f64>,
    /// Learn from the gauges alone, also where the device has an inertial unit or a sensor of force.
    #[arg(long)]
    without_signals: bool,
    /// Print what was learned as JSON.
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: &LoadsArgs) -> Result<()> {
    let run = args.scene.prepare()?;
    let (from, mut frames) = frames(args, &run)?;
    if args.without_signals {
        frames.iter_mut().for_each(|frame| frame.signals.clear());
    }
    ensure!(
        frames.len() > args.tare_frames && args.tare_frames > 0,
        "{from}: expected more than the {} frames of --tare-frames (1 or more), found {}",
        args.tare_frames,
        frames.len()
    );
    let noise_ue = args.noise_ue.unwrap_or(run.scene.estimator.superposition().noise_ue);
    let learned =
        LearnedLoads::learn(&run.scene, &frames, args.tare_frames, noise_ue, args.margin)?;
    let n_left = learned.gauges.len() - learned.sd.len();
    ensure!(
        n_left >= LEAST_LEFT,
        "{from}: {} loads move {} gauges, which leaves {n_left} numbers of a frame, and a contact takes \
         {LEAST_LEFT}: did something touch, or is the noise larger than {noise_ue} µε (--noise-ue)?",
        learned.sd.len(),
        learned.gauges.len()
    );
    learned.write(&args.out)?;
    if args.json {
        print_json(&learned, true)?;
    } else {
        print(args, &learned);
    }
    Ok(())
}

/// Where they come from, and the frames.
fn frames(args: &LoadsArgs, run: &Run) -> Result<(String, Vec<RawFrame>)> {
    let scene = &run.scene;
    if args.sim {
        ensure!(
            scene.loads.as_ref().is_some_and(|loads| !loads.loads().is_empty()),
            "--sim: the scene's loads say of nothing that moves its rig; docs/scene.md lists them"
        );
        let limb = Limb::load(scene, &run.scene_dir)?;
        let source = Source::untouched_rig(Some(args.seconds.unwrap_or(SIM_S)), run, &limb)?;
        return Ok((source.name(), source.raw_frames(None)?));
    }
    if let Some(source) = &args.source {
        let source = Source::open(&args.topic.of(source)?, scene)?;
        return Ok((source.name(), source.raw_frames(args.seconds)?));
    }
    let table = args.table.as_deref().context("a table, --source or --sim")?;
    let names: Vec<&str> = scene.gauges.sites.iter().map(|site| site.name.as_str()).collect();
    let rows = read_table(table, &args.topic, &[], &names)?;
    let frame = |row: Row| RawFrame { readings_ue: row.values, signals: Vec::new() };
    Ok((shown(table).to_string(), rows.into_iter().map(frame).collect()))
}

fn print(args: &LoadsArgs, learned: &LearnedLoads) {
    let n = learned.gauges.len();
    if !learned.signals.is_empty() {
        println!("taken off by what the device measures: {}", learned.signals.join(", "));
    }
    println!("{} unknown loads in {} frames of {n} gauges", learned.sd.len(), learned.n_frames);
    for (i, strength_ue) in learned.strengths_ue().iter().enumerate() {
        println!("  {}: {strength_ue:.1} µε rms", i + 1);
    }
    println!(
        "{} numbers of a frame are left for contacts, of which each takes three\n{}",
        n - learned.sd.len(),
        shown(&args.out)
    );
}
