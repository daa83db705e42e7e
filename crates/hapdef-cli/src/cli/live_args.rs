//! Arguments of `hapdef live`.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, ensure};
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{ArgGroup, Args};
use hapdef::touch::{EstimatorKind, SearchPlace};
use hapdef::{SOURCE_FORMS, SourceArg};
use hapdef_cli::{SceneArgs, StandardOutput, TrainingArgs};
use hapdef_live::{LiveParams, Retare};

use super::live_alert::AlertArgs;
use super::live_ros::RosArgs;
use super::network::{IS_READ, check_reach};
use super::topic::TopicArgs;
use super::view::{FirstPaint, FirstPaintParams, Origin, ViewArgs};

#[derive(Args, Clone)]
#[command(after_help = "Example:\n  \
    hapdef bundle fixtures/shin/placed.json -o shin.hapdef\n  \
    hapdef live shin.hapdef --source serial:/dev/serial/by-id/usb-Arduino_Due\n  \
    hapdef live shin.hapdef --source replay:press.mcap@max --json | jq .contacts\n  \
    hapdef live shin.hapdef --source replay:bag.mcap --topic /strain\n  \
    hapdef live shin.hapdef --source ros2:0 --topic /strain\n  \
    hapdef live shin.hapdef --source tcp:10.0.0.7:7320 --alert udp:127.0.0.1:7400 --stop-n 5\n  \
    hapdef live fixtures/shin/placed.json --sim --seconds 10 --record press.mcap\n  \
    hapdef live fixtures/shin/placed.json --sim --view\n  \
    hapdef live fixtures/shin/robot.json --view --record recordings\n\n\
    Touch nothing while it tares. A device that goes away is waited for. Contacts go to the \
    terminal, one line that is refreshed (a line a frame where it is no terminal); each second a \
    line says how it is doing. Ctrl-C ends it cleanly. Exit code 0 when it ran, 2 when something \
    has to be corrected first.")]
#[command(
    group(ArgGroup::new("readings").args(["source", "sim"])),
    mut_arg("scene", |arg| {
        arg.help("The bundle (.hapdef) or the scene (.json); of several limbs the robot file (robot.json)")
    })
)]
pub(crate) struct LiveArgs {
    #[command(flatten)]
    pub(super) scene: SceneArgs,
    #[command(flatten)]
    pub(super) training: TrainingArgs,
    #[arg(long, help = format!("Where readings come from: {SOURCE_FORMS}"))]
    pub(super) source: Option<SourceArg>,
    #[command(flatten)]
    pub(super) topic: TopicArgs,
    /// Play the scene's simulated rig at 1 kHz, pressed at random; needs a scene.
    #[arg(long)]
    pub(super) sim: bool,
    /// Seed of those presses.
    #[arg(long, default_value_t = 1, requires = "sim")]
    pub(super) sim_seed: u64,
    #[command(flatten)]
    pub(super) view: ViewArgs,
    /// Loads that are no contacts, as `hapdef loads` learned them, in place of the scene's.
    #[arg(long, value_name = "FILE")]
    pub(super) loads: Option<PathBuf>,
    /// What finds contacts; the scene's estimator if not given.
    #[arg(long, value_parser = estimator_kind())]
    pub(super) estimator: Option<EstimatorKind>,
    /// Print JSON lines.
    #[arg(long)]
    pub(super) json: bool,
    /// Write a table, too: a new file.
    #[arg(long, value_name = "FILE")]
    pub(super) csv: Option<PathBuf>,
    /// Send JSON lines to whoever connects, too: tcp:127.0.0.1:7650 or unix:PATH.
    #[arg(long, value_name = "ADDRESS")]
    pub(super) serve: Option<String>,
    #[command(flatten)]
    pub(super) alert: AlertArgs,
    #[command(flatten)]
    pub(super) ros: RosArgs,
    /// Let --serve, --foxglove and --view-bind listen beyond this machine: whoever reaches the port
    /// of the first two, or reads on the way to the page, reads everything.
    #[arg(long)]
    pub(super) insecure_bind: bool,
    /// Time whose mean is the tare, s; 0 for readings that come tared.
    #[arg(long, default_value_t = 1.0)]
    pub(super) tare_s: f64,
    /// A tare that was taken while something pressed is found out when that lets go: ask for another one, or
    /// put the zero right at once.
    #[arg(long, value_enum, default_value_t = RetareArg::Ask)]
    pub(super) retare: RetareArg,
    /// End after that many seconds.
    #[arg(long)]
    pub(super) seconds: Option<f64>,
    /// A frame is late whose contacts come that many µs after its sample instant.
    #[arg(long, default_value_t = 1000)]
    pub(super) deadline_us: u64,
    /// Real-time priority of the reader, 1 to 99, and one less of what finds contacts, where the system
    /// grants it; `hapdef doctor` says whether it does.
    #[arg(long, value_name = "PRIORITY")]
    pub(super) realtime: Option<u8>,
    /// Which limb of several it is.
    #[arg(skip)]
    pub(super) limb: Option<String>,
}

/// [`Retare`] in words.
#[derive(Clone, Copy, clap::ValueEnum)]
pub(super) enum RetareArg {
    Ask,
    Auto,
}

impl LiveArgs {
    /// Refuses what can't be before anything begins.
    pub(super) fn check(&self) -> Result<()> {
        ensure!(
            self.sim || self.source.is_some(),
            "expected --source SOURCE or --sim, found neither: say where readings come from, {SOURCE_FORMS}"
        );
        if let Some(seconds) = self.seconds {
            ensure!(seconds > 0.0, "--seconds: expected above 0, found {seconds}");
        }
        if let Some(address) = self.ros.foxglove {
            check_reach("--foxglove", address, IS_READ, self.insecure_bind)?;
        }
        self.ros.params().map(drop)
    }

    /// How the runtime works.
    pub(super) fn params(&self, noise_ue: f64) -> LiveParams {
        LiveParams {
            tare_s: self.tare_s,
            noise_ue: Some(noise_ue),
            retare: match self.retare {
                RetareArg::Ask => Retare::Ask,
                RetareArg::Auto => Retare::Auto,
            },
            deadline: Duration::from_micros(self.deadline_us),
            is_recorded: self.is_recorded(),
            is_lossless: self.is_unpaced(),
            realtime_priority: self.realtime,
            ..LiveParams::default()
        }
    }

    /// What lines on the terminal begin with: of several limbs the name.
    pub(super) fn begin(&self) -> String {
        self.limb.as_ref().map_or(String::new(), |name| format!("{name}: "))
    }

    /// A fault of several limbs' says whose it is.
    pub(super) fn named<T>(&self, result: Result<T>) -> Result<T> {
        match &self.limb {
            Some(name) => result.with_context(|| format!("limb {name}")),
            None => result,
        }
    }

    /// The page's first pictures, counted from `start`, if that is wanted.
    pub(super) fn first(&self, start: Instant) -> Option<FirstPaint> {
        let params = || FirstPaintParams {
            start,
            // What is taken by JSON would be damaged by figures.
            out: match self.json {
                true => || Box::new(std::io::stderr()),
                false => || Box::new(StandardOutput),
            },
            metrics: std::env::var_os("HAPDEF_METRICS")
                .map_or_else(|| self.scene.results.join("metrics.json"), std::path::PathBuf::from),
            seed: self.sim_seed,
        };
        let is_measured = self.view.is_first_measured();
        is_measured.then(|| FirstPaint::new(params()))
    }

    /// A replay gives the same contacts each time.
    pub(super) fn place(&self) -> SearchPlace {
        if self.is_recorded() { SearchPlace::Here } else { SearchPlace::Background }
    }

    pub(super) fn origin(&self) -> Origin {
        match &self.source {
            None => Origin::Sim,
            Some(source) if source.is_recorded() => Origin::Recording,
            Some(_) => Origin::Device,
        }
    }

    pub(super) fn is_recorded(&self) -> bool {
        self.source.as_ref().is_some_and(SourceArg::is_recorded)
    }

    pub(super) fn is_unpaced(&self) -> bool {
        self.source.as_ref().is_some_and(SourceArg::is_unpaced)
    }
}

/// An estimator by its name, with a word on each in the help.
fn estimator_kind() -> impl TypedValueParser<Value = EstimatorKind> {
    let values = EstimatorKind::ALL.map(|kind| {
        PossibleValue::new(kind.name()).help(match kind {
            EstimatorKind::Tracking => "By superposition, contacts followed from frame to frame",
            EstimatorKind::Superposition => "By superposition, each frame on its own",
            EstimatorKind::Hapdefx => "The paper's chain of nets; a bundle needs them in it",
        })
    });
    PossibleValuesParser::new(values).try_map(|name| name.parse::<EstimatorKind>())
}
