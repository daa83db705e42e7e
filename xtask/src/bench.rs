//! Times against other programs.

use std::path::PathBuf;
use std::process::Command;

use anyhow::{Result, bail};

use crate::pipeline::finish;
use crate::tool::{release_binary, root};
use crate::verify::deck_of;
use crate::{browser, live};

/// Arguments of `bench`.
#[derive(clap::Args)]
pub(crate) struct BenchArgs {
    /// What is timed.
    what: Subject,
    /// The solid deck; the authors' limb where the shared inputs are, else the bundled limb.
    #[arg(long)]
    deck: Option<PathBuf>,
    /// Of this scene: its solid deck, or its nets.
    #[arg(long, conflicts_with = "deck")]
    scene: Option<PathBuf>,
    /// The seed the metrics carry. With `nets` it also draws the random weights; with `fe` nothing
    /// is drawn at random.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// How long is measured in all, s; 40 if not given.
    #[arg(long)]
    seconds: Option<u64>,
    /// Everything else goes to the program as it is: `--skip-large` to `hapdef-verify`, `--rounds 20`
    /// to `hapdef-repro` (see `hapdef-repro bench-nets --help`).
    #[arg(last = true)]
    rest: Vec<String>,
}

/// What `bench` can time.
#[derive(Clone, Copy, clap::ValueEnum)]
enum Subject {
    /// The elasticity solver against faer's plain call and, where they are installed, CHOLMOD
    /// (libsuitesparse-dev) and CalculiX (calculix-ccx).
    Fe,
    /// The networks, inference and training, against PyTorch and ONNX Runtime where Python has them.
    Nets,
    /// A frame by superposition: tracking, a cold pair, allocations.
    Inverse,
    /// From a frame to its contacts through a pseudo-terminal at 1 kHz, against a bare reader.
    Live,
    /// The same with a busy loop for each core beside it, with `--realtime` and without, and the memory that
    /// `--realtime` takes; where SCHED_FIFO is refused, it says so.
    Realtime,
    /// The live page in a headless Chromium: its main thread's time for a picture, pictures a second.
    View,
}

/// `cargo xtask bench`.
pub(crate) fn run(args: &BenchArgs) -> Result<()> {
    if args.seconds.is_some() && !matches!(args.what, Subject::Live | Subject::Realtime) {
        bail!("--seconds is for `bench live` and `realtime`: the others take as long as they need");
    }
    let bundled = |name: &str| root().join("fixtures/shin").join(name);
    let scene_or = |scene: PathBuf| args.scene.clone().unwrap_or(scene);
    let (scene, seed, rest) = (args.scene.as_deref(), args.seed, &args.rest);
    match args.what {
        Subject::Fe => fe(args),
        Subject::Nets => {
            let mut command = repro("bench-nets")?;
            command.arg("--scene").arg(scene_or(bundled("scene.json")));
            finish(command.args(["--seed", &seed.to_string()]).args(rest))
        }
        Subject::Live => live::bench(scene, seed, args.seconds, rest),
        Subject::Realtime => live::bench_realtime(scene, seed, args.seconds, rest),
        Subject::View => browser::bench(scene, seed, rest),
        Subject::Inverse => {
            let mut command = repro("bench-inverse")?;
            command.arg(scene_or(bundled("placed.json")));
            finish(command.args(["--test-seed", &seed.to_string()]).args(rest))
        }
    }
}

fn repro(verb: &str) -> Result<Command> {
    let mut command = Command::new(release_binary("hapdef-repro")?);
    command.arg(verb);
    Ok(command)
}

fn fe(args: &BenchArgs) -> Result<()> {
    let deck = match (&args.deck, &args.scene) {
        (Some(deck), _) => deck.clone(),
        (None, Some(scene)) => deck_of(scene)?,
        (None, None) => default_deck(),
    };
    let mut command = Command::new(release_binary("hapdef-verify")?);
    command.arg("bench").arg("--deck").arg(deck);
    command.args(["--seed", &args.seed.to_string()]).args(&args.rest);
    finish(&mut command)
}

fn default_deck() -> PathBuf {
    let shared = std::env::var_os("HAPDEF_SHARED").map_or(root().join("../shared"), PathBuf::from);
    let authors = shared.join("inputs/hapdef-shin/02_skin_ds.dat.gz");
    if authors.exists() { authors } else { root().join("fixtures/shin/shin.inp.gz") }
}
