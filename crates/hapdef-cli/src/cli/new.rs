//! `hapdef new`: a limb from any mesh.

use std::io::{IsTerminal, stdin};
use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::builder::RangedU64ValueParser;
use clap::{Args, ValueEnum};
use hapdef::HapdefError;
use hapdef::new_limb::{Guess, NewLimb, NewLimbParams};
use hapdef::scene::{LimbEnd, WallSolver};
use hapdef_cli::{on_stderr, print_json, shown};
use serde_json::json;

use super::unit::Unit;

#[derive(Args)]
#[command(after_help = "Examples:\n  \
    hapdef new forearm.stl\n  \
    hapdef new robot.urdf --link forearm --gauges 12\n\n\
    Each guess is said with its reason, and has a flag. What can't be told is asked for at a terminal. \
    The folder has the skin, its wall and a short scene.json.")]
pub(crate) struct NewArgs {
    /// The limb: a surface (.glb, .gltf, .stl, .obj, .dae), a solid (.inp, .dat, .cdb, .msh), or a .urdf.
    file: PathBuf,
    /// Link of a .urdf; may be left out where only one has a mesh.
    #[arg(long)]
    link: Option<String>,
    /// Folder to be made; that of the link's or the file's name when not given.
    #[arg(short, long, alias = "folder", value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// Make that folder anew if a limb is in it.
    #[arg(long)]
    replace: bool,
    /// Unit of the file's lengths.
    #[arg(long)]
    unit: Option<Unit>,
    /// Direction of the long axis: x,y,z.
    #[arg(long, value_parser = direction, allow_hyphen_values = true)]
    axis: Option<[f64; 3]>,
    /// The end along the axis that is held: low is where the axis comes from.
    #[arg(long)]
    mount_end: Option<End>,
    /// The joint of a .urdf that holds the link, at the end nearer to it.
    #[arg(long, value_name = "NAME", conflicts_with = "mount_end")]
    mount_joint: Option<String>,
    /// How far from that end the limb is held, mm; 5 % of its length when not given.
    #[arg(long)]
    mount: Option<f64>,
    /// Thickness of the wall inward of a surface, mm.
    #[arg(long)]
    wall: Option<f64>,
    /// What the wall is solved as; auto is that of the two from which the smaller error is expected.
    #[arg(long, default_value = "auto")]
    solver: Solver,
    /// Edge length of the skin, mm.
    #[arg(long)]
    edge: Option<f64>,
    /// Gauges, placed where they tell most; ten, up to 16 where ten leave a place blind, when not given.
    #[arg(long, value_parser = RangedU64ValueParser::<usize>::new().range(1..))]
    gauges: Option<usize>,
    /// Take the likeliest of what can't be told, and ask nothing.
    #[arg(long)]
    yes: bool,
    /// Print guesses and what was made as JSON.
    #[arg(long)]
    json: bool,
    /// Threads; results don't depend on it.
    #[arg(long, default_value_t = std::thread::available_parallelism().map_or(1, usize::from))]
    threads: usize,
}

#[derive(Clone, Copy, ValueEnum)]
enum Solver {
    Auto,
    Shell,
    Solid,
}

#[derive(Clone, Copy, ValueEnum)]
pub(super) enum End {
    Low,
    High,
}

pub(crate) fn run(args: &NewArgs) -> Result<()> {
    let threads = rayon::ThreadPoolBuilder::new().num_threads(args.threads);
    threads.build_global().map_err(HapdefError::Threads)?;
    let limb = guess(args)?;
    if !args.json {
        for guess in &limb.guesses {
            println!("{:9} {:38} {}", guess.what, guess.value, guess.why);
        }
    }
    let made = limb.write(&args.folder(), args.replace, args.threads, on_stderr())?;
    if args.json {
        let guess = |g: &Guess| json!({ "what": g.what, "value": g.value, "why": g.why });
        let made = json!({
            "guesses": limb.guesses.iter().map(guess).collect::<Vec<_>>(),
            "made": made.said,
            "scene": made.scene,
        });
        return Ok(print_json(&made, false)?);
    }
    made.said.iter().for_each(|said| println!("made      {said}"));
    println!("scene     {}", shown(&made.scene));
    println!("next:     hapdef live {} --sim --view", shown(args.folder()));
    Ok(())
}

/// The limb; what can't be told is asked for where somebody sits at a terminal.
fn guess(args: &NewArgs) -> Result<NewLimb> {
    let mut params = args.params();
    loop {
        match NewLimb::guess(&args.file, &params) {
            Err(HapdefError::Unsure { what, why, flag, choices })
                if stdin().is_terminal() && !args.yes =>
            {
                eprintln!("{what}: {why}. {}?", choices.join(" or "));
                let mut answer = String::new();
                stdin().read_line(&mut answer).context("reading the answer")?;
                match flag {
                    "--unit" => params.unit = Some(Unit::parsed(&answer)?.into()),
                    _ => params.mount_end = Some(End::parsed(&answer)?.into()),
                }
            }
            result => return Ok(result?),
        }
    }
}

/// An answer is what the flag takes.
trait Answer: ValueEnum {
    fn parsed(text: &str) -> Result<Self> {
        Self::from_str(text.trim(), true).map_err(|cause| anyhow::anyhow!("{cause}"))
    }
}

impl Answer for Unit {}
impl Answer for End {}

impl From<End> for LimbEnd {
    fn from(end: End) -> Self {
        match end {
            End::Low => Self::Low,
            End::High => Self::High,
        }
    }
}

impl From<Solver> for WallSolver {
    fn from(solver: Solver) -> Self {
        match solver {
            Solver::Auto => Self::Auto,
            Solver::Shell => Self::Shell,
            Solver::Solid => Self::Solid,
        }
    }
}

impl NewArgs {
    fn params(&self) -> NewLimbParams {
        let metres = |mm: f64| mm * 1e-3;
        NewLimbParams {
            link: self.link.clone(),
            unit: self.unit.map(Into::into),
            axis: self.axis,
            mount_end: self.mount_end.map(Into::into),
            mount_joint: self.mount_joint.clone(),
            mount_m: self.mount.map(metres),
            wall_m: self.wall.map(metres),
            solver: self.solver.into(),
            edge_m: self.edge.map(metres),
            n_gauges: self.gauges,
            takes_likeliest: self.yes,
        }
    }

    fn folder(&self) -> PathBuf {
        let name = self.file.file_name().unwrap_or_default().to_string_lossy();
        let stem = name.split('.').next().unwrap_or_default();
        let by_name = || PathBuf::from(self.link.as_deref().unwrap_or(stem));
        self.out.clone().unwrap_or_else(by_name)
    }
}

fn direction(text: &str) -> Result<[f64; 3], String> {
    let numbers: Vec<f64> = text.split(',').filter_map(|part| part.trim().parse().ok()).collect();
    match <[f64; 3]>::try_from(numbers) {
        Ok(axis) if axis.iter().any(|x| *x != 0.0) && axis.iter().all(|x| x.is_finite()) => {
            Ok(axis)
        }
        _ => Err("expected x,y,z, not all 0".into()),
    }
}
