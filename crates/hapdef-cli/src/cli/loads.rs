//! `hapdef loads`: what a robot's own motion does to the gauges, learned while nothing touches.

use std::path::PathBuf;

use anyhow::{Result, ensure};
use clap::Args;
use hapdef::touch::LearnedLoads;
use hapdef_cli::{SceneArgs, print_json, shown};

use super::table::read_table;
use super::topic::TopicArgs;

#[derive(Args)]
#[command(
    after_help = "Example:\n  hapdef loads my-limb untouched.csv --loads my-limb/loads.json\n\n\
    Record while the robot moves as it will in use, with and without what it carries, and nothing touches the \
    limb; it stands still in the first fifth of a second. Then put \"loads\": {\"learned\": \"loads.json\"} into the \
    scene: contacts are found beside whatever moves the gauges so."
)]
pub(crate) struct LoadsArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Readings in µε, a column for each gauge: a table, or a recording with --topic.
    table: PathBuf,
    /// File for the loads.
    #[arg(long, value_name = "FILE", default_value = "loads.json")]
    loads: PathBuf,
    #[command(flatten)]
    topic: TopicArgs,
    /// First frames, whose mean is the zero: the robot stands still.
    #[arg(long, default_value_t = 200)]
    tare_frames: usize,
    /// How many times as strong later loads may be.
    #[arg(long, default_value_t = 2.0)]
    margin: f64,
    /// Standard deviation of a reading's noise, µε; the scene's if absent.
    #[arg(long)]
    noise_ue: Option<f64>,
    /// Print what was learned as JSON.
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: &LoadsArgs) -> Result<()> {
    let run = args.scene.prepare()?;
    let names: Vec<&str> = run.scene.gauges.sites.iter().map(|site| site.name.as_str()).collect();
    let rows = read_table(&args.table, &args.topic, &[], &names)?;
    ensure!(
        rows.len() > args.tare_frames && args.tare_frames > 0,
        "{}: expected more than the {} frames of --tare-frames (1 or more), found {}",
        shown(&args.table),
        args.tare_frames,
        rows.len()
    );
    let (still, moving) = rows.split_at(args.tare_frames);
    let mean =
        |gauge: usize| still.iter().map(|row| row.values[gauge]).sum::<f64>() / still.len() as f64;
    let zero: Vec<f64> = (0..names.len()).map(mean).collect();
    let tared = moving.iter().flat_map(|row| row.values.iter().zip(&zero).map(|(v, z)| v - z));
    let tared: Vec<f64> = tared.collect();
    let noise_ue = args.noise_ue.unwrap_or(run.scene.estimator.superposition().noise_ue);
    let learned = LearnedLoads::learn(&run.scene, &tared, noise_ue, args.margin)?;
    learned.write(&args.loads)?;
    if args.json {
        print_json(&learned, true)?;
    } else {
        print(args, &learned);
    }
    Ok(())
}

fn print(args: &LoadsArgs, learned: &LearnedLoads) {
    let n = learned.gauges.len();
    println!("{} loads in {} frames of {n} gauges", learned.sd.len(), learned.n_frames);
    for (i, strength_ue) in learned.strengths_ue().iter().enumerate() {
        println!("  {}: {strength_ue:.1} µε rms", i + 1);
    }
    println!(
        "{} numbers of a frame are left for contacts, of which each takes three\n{}",
        n - learned.sd.len(),
        shown(&args.loads)
    );
}
