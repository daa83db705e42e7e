//! `frontier`: the whole chain's error against its run time, over meshes, layouts, presses, efforts
//! and precisions; how times grow; what leaving things out is worth; what was planned.

mod lab;
mod limits;
mod map_error;
mod measure;
mod page;
mod planned;
mod point;
mod scaling;
mod skips;
mod tube;
mod way;

use std::path::PathBuf;
use std::time::{Duration, Instant};

use anyhow::Result;
use clap::Args;
use hapdef::{HapdefError, Limb, Run, SceneArgs};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::json;

use self::lab::{Amounts, Lab};
use self::planned::Planned;
use self::point::Point;
use self::scaling::Growth;
use self::skips::Skips;
use self::way::{LAYOUTS, Way};

/// Changes with what is measured: points of another version are measured again.
const VERSION: u32 = 2;

/// Largest tubes of the scaling, nodes, below and from so many minutes.
const SOME_NODES: usize = 31_000;
const MANY_NODES: usize = 310_000;
const MINUTES_FOR_MANY: f64 = 15.0;

/// Arguments of `frontier`.
#[derive(Args, Clone, Debug)]
#[command(
    after_help = "Example:\n  hapdef-repro frontier fixtures/shin/placed.json --minutes 20\n\n\
    Points that were measured are kept: the same command with more minutes goes on."
)]
pub(crate) struct ChainFrontierArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// No new point is begun after so many minutes; the usual way and everything that is measured
    /// once always is.
    #[arg(long, default_value_t = 20.0)]
    minutes: f64,
    /// Frames of one and of two contacts.
    #[arg(long, default_value_t = 200)]
    frames: usize,
    /// Seed of presses and frames; nothing was tuned on the default.
    #[arg(long, default_value_t = 9400)]
    test_seed: u64,
    /// Leave the paper's chain out: no datasets, no nets.
    #[arg(long)]
    without_nets: bool,
    /// Also writes the tables to this Markdown file, with what the tables of extremes beside it come to,
    /// and what `--check` needs to a JSON file beside it.
    #[arg(long)]
    write: Option<PathBuf>,
    /// Measures the usual way alone and fails where this file's JSON says something else.
    #[arg(long, conflicts_with = "write")]
    check: Option<PathBuf>,
}

impl ChainFrontierArgs {
    fn amounts(&self) -> Amounts {
        Amounts {
            test_seed: self.test_seed,
            n_frames: self.frames,
            n_scripts: self.frames.div_ceil(10),
        }
    }
}

/// Everything that was measured.
#[derive(Clone, Debug, Serialize)]
struct Measured {
    points: Vec<Point>,
    n_ways: usize,
    growths: Vec<Growth>,
    skips: Skips,
    planned: Vec<Planned>,
}

/// Measures, prints and writes the frontier.
pub(crate) fn run(args: &ChainFrontierArgs) -> Result<()> {
    let start = Instant::now();
    let run = args.scene.prepare()?;
    let limb = Limb::load(&run.scene, &run.scene_dir)?;
    if let Some(path) = &args.check {
        return limits::check(path, args, &run, &limb);
    }
    let mut lab = Lab::build(&run, &limb, args.amounts(), &LAYOUTS)?;
    let skips = skips::measure(&mut lab)?;
    let folder = args.scene.out.join(&run.scene.name);
    let planned = match args.without_nets {
        true => Vec::new(),
        false => planned::measure(
            &run,
            &limb,
            &args.scene.out.join("machine.json"),
            &folder.join("frontier-plan"),
        )?,
    };
    let most_nodes = if args.minutes < MINUTES_FOR_MANY {
        SOME_NODES
    } else {
        MANY_NODES
    };
    let growths = scaling::measure(&run, most_nodes, args.test_seed)?;
    let deadline = start + Duration::from_secs_f64(60.0 * args.minutes);
    let ways = Way::in_order(args.test_seed);
    let measured = Measured {
        n_ways: ways.len(),
        points: points(args, &run, &mut lab, &ways, deadline)?,
        growths,
        skips,
        planned,
    };
    page::write(args, &run, &measured)
}

/// The usual way, the paper's chain, and as many others as there is time for.
fn points(
    args: &ChainFrontierArgs,
    run: &Run,
    lab: &mut Lab<'_>,
    ways: &[Way],
    deadline: Instant,
) -> Result<Vec<Point>> {
    let mut points = Vec::new();
    for (i, way) in ways.iter().enumerate() {
        if i > 0 && Instant::now() > deadline {
            break;
        }
        run.check_stop("the frontier")?;
        let what = json!({ "way": way });
        points.push(kept(args, run, lab, &what, |lab| {
            measure::superposed(lab, way)
        })?);
        if i == 0 && !args.without_nets {
            let what = json!({ "chain": run.profile });
            let usual = lab.ready(way)?;
            let chain: Vec<Point> = kept(args, run, lab, &what, |lab| measure::chain(lab, &usual))?;
            points.extend(chain);
        }
    }
    Ok(point::on_one_footing(&points))
}

/// From the cache, or measured and put there.
fn kept<T: Serialize + DeserializeOwned>(
    args: &ChainFrontierArgs,
    run: &Run,
    lab: &mut Lab<'_>,
    what: &serde_json::Value,
    measure: impl FnOnce(&mut Lab<'_>) -> Result<T>,
) -> Result<T> {
    let inputs = json!({
        "version": VERSION, "scene": run.scene, "deck": lab.limb.deck_hash, "what": what,
        "frames": args.frames, "seed": args.test_seed,
    });
    let stage = run.cache.stage("frontier-point", &inputs, |_| {
        let value = measure(lab).and_then(|value| Ok(serde_json::to_value(value)?));
        value.map_err(|error| match error.downcast::<HapdefError>() {
            Ok(error) => error,
            Err(error) => HapdefError::Stale {
                path: "the frontier".into(),
                what: format!("{error:#}"),
            },
        })
    })?;
    Ok(T::deserialize(&stage.record.info)?)
}
