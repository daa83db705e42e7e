//! `hapdef live`: contacts from a stream of frames.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::Receiver;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail, ensure};
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{ArgGroup, Args};
use hapdef::scene::Outputs;
use hapdef::touch::{
    EstimatorKind, SearchPlace, TouchEstimator, calibration_in_use, given_loads, live_estimator,
};
use hapdef::{Limb, Run, SOURCE_FORMS, SourceArg};
use hapdef_cli::{JsonLines, SceneArgs, StandardOutput, TrainingArgs, shown};
use hapdef_contact::printable;
use hapdef_daq::record::{Player, PlayerControl};
use hapdef_daq::source::FrameSource;
use hapdef_live::sinks::{CsvSink, JsonServer, JsonSink, TextSink};
use hapdef_live::{Bundle, GivenLoads, Live, LiveBuilder, LiveGauge, LiveParams, Retare};
use hapdef_rig::live::TruthFrame;

use super::files::new_file;
use super::lean::start_lean;
use super::live_alert::AlertArgs;
use super::live_end::{report, wait};
use super::live_record::LiveRecorder;
use super::live_ros::{Attached, Recordings, RosArgs};
use super::network::{IS_READ, check_reach};
use super::signals::stop_flag;
use super::sim::simulated;
use super::topic::TopicArgs;
use super::view::{FirstPaint, FirstPaintParams, Origin, Reach, Sim, View, ViewArgs};

#[derive(Args)]
#[command(after_help = "Example:\n  \
    hapdef bundle fixtures/shin/placed.json -o shin.hapdef\n  \
    hapdef live shin.hapdef --source serial:/dev/serial/by-id/usb-Arduino_Due\n  \
    hapdef live shin.hapdef --source replay:press.mcap@max --json | jq .contacts\n  \
    hapdef live shin.hapdef --source replay:bag.mcap --topic /strain\n  \
    hapdef live shin.hapdef --source ros2:0 --topic /strain\n  \
    hapdef live shin.hapdef --source tcp:10.0.0.7:7320 --alert udp:127.0.0.1:7400 --stop-n 5\n  \
    hapdef live fixtures/shin/placed.json --sim --seconds 10 --record press.mcap\n  \
    hapdef live fixtures/shin/placed.json --sim --view\n\n\
    Touch nothing while it tares. A device that goes away is waited for. Contacts go to the \
    terminal, one line that is refreshed (a line a frame where it is no terminal); each second a \
    line says how it is doing. Ctrl-C ends it cleanly. Exit code 0 when it ran, 2 when something \
    has to be corrected first.")]
#[command(
    group(ArgGroup::new("readings").required(true).args(["source", "sim"])),
    mut_arg("scene", |arg| arg.help("The bundle (.hapdef) or the scene (.json)"))
)]
pub(crate) struct LiveArgs {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    training: TrainingArgs,
    #[arg(long, help = format!("Where readings come from: {SOURCE_FORMS}"))]
    source: Option<SourceArg>,
    #[command(flatten)]
    topic: TopicArgs,
    /// Play the scene's simulated rig at 1 kHz, pressed at random; needs a scene.
    #[arg(long)]
    sim: bool,
    /// Seed of those presses.
    #[arg(long, default_value_t = 1, requires = "sim")]
    sim_seed: u64,
    #[command(flatten)]
    view: ViewArgs,
    /// Loads that are no contacts, as `hapdef loads` learned them, in place of the scene's.
    #[arg(long, value_name = "FILE")]
    loads: Option<PathBuf>,
    /// What finds contacts; the scene's estimator if not given.
    #[arg(long, value_parser = estimator_kind())]
    estimator: Option<EstimatorKind>,
    /// Print JSON lines.
    #[arg(long)]
    json: bool,
    /// Write a table, too: a new file.
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Send JSON lines to whoever connects, too: tcp:127.0.0.1:7650 or unix:PATH.
    #[arg(long, value_name = "ADDRESS")]
    serve: Option<String>,
    #[command(flatten)]
    alert: AlertArgs,
    #[command(flatten)]
    ros: RosArgs,
    /// Let --serve, --foxglove and --view-bind listen beyond this machine: whoever reaches the port
    /// of the first two, or reads on the way to the page, reads everything.
    #[arg(long)]
    insecure_bind: bool,
    /// Time whose mean is the tare, s; 0 for readings that come tared.
    #[arg(long, default_value_t = 1.0)]
    tare_s: f64,
    /// A tare that was taken while something pressed is found out when that lets go: ask for another one, or
    /// put the zero right at once.
    #[arg(long, value_enum, default_value_t = RetareArg::Ask)]
    retare: RetareArg,
    /// End after that many seconds.
    #[arg(long)]
    seconds: Option<f64>,
    /// A frame is late whose contacts come that many µs after its sample instant.
    #[arg(long, default_value_t = 1000)]
    deadline_us: u64,
    /// Real-time priority of the reader, 1 to 99, and one less of what finds contacts, where the system
    /// grants it; `hapdef doctor` says whether it does.
    #[arg(long, value_name = "PRIORITY")]
    realtime: Option<u8>,
}

/// [`Retare`] in words.
#[derive(Clone, Copy, clap::ValueEnum)]
enum RetareArg {
    Ask,
    Auto,
}

/// A model and a source, made ready.
struct Model {
    source: Source,
    estimator: Box<dyn TouchEstimator>,
    gauges: Vec<LiveGauge>,
    noise_ue: f64,
    /// What a recording keeps of the calibration in use.
    calibration: Option<String>,
    /// What the device measures of loads that are no contacts.
    given: GivenLoads,
    /// The middle of the mount, m.
    mount_m: Option<[f64; 3]>,
    stop: Arc<AtomicBool>,
    view: Option<View>,
}

/// Where frames come from, with what else is known of them.
struct Source {
    frames: Box<dyn FrameSource>,
    truth: Option<Receiver<TruthFrame>>,
    sim: Option<Sim>,
    player: Option<PlayerControl>,
}

pub(crate) fn run(args: &LiveArgs) -> Result<()> {
    let first = args.first(Instant::now());
    let path = &args.scene.scene;
    args.view.check_reach(args.insecure_bind)?;
    args.ros.params()?;
    let alert = args.alert.sink()?;
    let mut model = if is_bundle(path)? {
        Model::of_bundle(args, &Bundle::read(path)?)?
    } else {
        if args.realtime.is_some() {
            start_lean()?;
        }
        Model::of_scene(args)?
    };
    let stop = Arc::clone(&model.stop);
    let view = model.view.take();
    let (sim, player) = (model.source.sim.take(), model.source.player.take());
    let (mut builder, recorder) = model.builder(args)?;
    if let Some(view) = &view {
        builder = builder.sink(view.sink(args.is_recorded()));
    }
    if let Some(alert) = alert {
        builder = builder.sink(alert);
    }
    let live = builder.start()?;
    let reach = Reach { sim, recorder: recorder.clone(), player };
    let page_session = view.map(|view| view.attend(live.control(), reach, first));
    // The page tells of a recording that fails by itself.
    let recorder_to_watch = recorder.as_ref().filter(|_| page_session.is_none());
    wait(&live, args.seconds, recorder_to_watch, &stop);
    drop(page_session);
    let health = live.stop()?;
    if let Some(recorded) = recorder.map_or(Ok(None), |recorder| recorder.finish())? {
        eprintln!("{}", printable(&recorded.to_string()));
    }
    report(&health)
}

impl Model {
    fn of_bundle(args: &LiveArgs, bundle: &Bundle) -> Result<Self> {
        ensure!(
            args.loads.is_none(),
            "--loads: a bundle has its own; give the scene instead, or make it anew"
        );
        let estimator = bundle.estimator(args.estimator, args.place())?;
        let Some(source) = &args.source else {
            bail!("--sim: the simulated rig is made from a scene: give that instead of its bundle")
        };
        let gauges = bundle.info.gauges.iter();
        let out = &args.scene.results;
        let view = || args.view.of_bundle(bundle, args.origin(), out);
        let view = args.view.is_wanted().then(view).transpose()?;
        if let Some(view) = &view {
            view.say("no deformation: a bundle has none");
        }
        Ok(Self {
            source: Source::of(args, source, gauges.len())?,
            estimator,
            gauges: gauges.map(|g| gauge(&g.name, g.scale)).collect(),
            noise_ue: bundle.info.settings.noise_ue,
            calibration: bundle.calibration_json.clone(),
            given: bundle.given.clone(),
            mount_m: bundle.info.mount_m,
            stop: stop_flag()?,
            view,
        })
    }

    fn of_scene(args: &LiveArgs) -> Result<Self> {
        let mut run = args.training.prepare(&args.scene)?;
        if let Some(file) = &args.loads {
            let file =
                std::path::absolute(file).with_context(|| format!("--loads {}", shown(file)))?;
            run.scene.loads.get_or_insert_default().learned = Some(file);
        }
        let limb = Limb::load(&run.scene, &run.scene_dir)?;
        let kind = args.estimator.unwrap_or(run.scene.estimator.kind().in_stream());
        let out = &args.scene.results;
        let view = || args.view.of_scene(&run, &limb, args.origin(), out);
        let view = args.view.is_wanted().then(view).transpose()?;
        let source = match &args.source {
            Some(source) => Source::of(args, source, limb.gauges.len())?,
            None => Source::simulated(args, &run, &limb)?,
        };
        let sites = run.scene.gauges.sites.iter();
        let model = Self {
            source,
            estimator: live_estimator(&run, &limb, kind, args.place())?,
            gauges: sites.map(|site| gauge(&site.name, 1.0)).collect(),
            noise_ue: run.scene.estimator.superposition().noise_ue,
            calibration: calibration_in_use(&run, &limb)?,
            given: given_loads(&run)?,
            mount_m: Some(limb.mount_m().into()),
            stop: Arc::clone(&run.stop),
            view,
        };
        if let Some(view) = &model.view {
            match run.scene.outputs {
                Some(Outputs::Contacts) => view.say("no deformation: outputs is contacts"),
                Some(Outputs::Map) | None => view.solve_deformation(run, limb),
            }
        }
        Ok(model)
    }

    /// The runtime, and what is to be finished after it.
    fn builder(self, args: &LiveArgs) -> Result<(LiveBuilder, Option<LiveRecorder>)> {
        if let Some(seconds) = args.seconds {
            ensure!(seconds > 0.0, "--seconds: expected above 0, found {seconds}");
        }
        let params = LiveParams {
            tare_s: args.tare_s,
            noise_ue: Some(self.noise_ue),
            retare: match args.retare {
                RetareArg::Ask => Retare::Ask,
                RetareArg::Auto => Retare::Auto,
            },
            deadline: Duration::from_micros(args.deadline_us),
            is_recorded: args.is_recorded(),
            is_lossless: args.is_unpaced(),
            realtime_priority: args.realtime,
            ..LiveParams::default()
        };
        let recordings = Recordings {
            are_possible: args.view.is_wanted() && !args.is_recorded(),
            calibration: self.calibration,
            is_lossless: args.is_unpaced(),
        };
        let mount_m = self.mount_m;
        if let Some(address) = args.ros.foxglove {
            check_reach("--foxglove", address, IS_READ, args.insecure_bind)?;
        }
        let Source { frames, truth, .. } = self.source;
        let Attached { source, sink, recorder } =
            args.ros.attach(frames, truth, recordings, mount_m)?;
        let mut builder = Live::boxed_builder(source)
            .params(params)
            .gauges(self.gauges)
            .given(self.given)
            .boxed_estimator(self.estimator);
        if let Some(sink) = sink {
            builder = builder.sink(sink);
        }
        Ok((with_sinks(builder, args)?, recorder))
    }
}

impl Source {
    /// What `--source` names; a recording that is looked at can be stopped and gone to any time of.
    fn of(args: &LiveArgs, source: &SourceArg, n_gauges: usize) -> Result<Self> {
        let source = args.topic.of(source)?;
        let (frames, player): (Box<dyn FrameSource>, _) = match &source {
            SourceArg::Replay { file, speed, topic: None } if args.view.is_wanted() => {
                ensure!(
                    args.ros.record.is_none(),
                    "--record: a replay on the page can go back, which a recording can't: leave \
                     out --record or --view"
                );
                let player = Player::open(file, *speed)?;
                let control = player.control();
                (Box::new(player), Some(control))
            }
            source => (source.open_for(n_gauges)?, None),
        };
        Ok(Self { frames, truth: None, sim: None, player })
    }

    /// The scene's virtual rig.
    fn simulated(args: &LiveArgs, run: &Run, limb: &Limb) -> Result<Self> {
        let ((frames, truth), sim) = if args.view.is_wanted() {
            let (simulated, sim) = Sim::start(run, limb, args.sim_seed)?;
            (simulated, Some(sim))
        } else {
            (simulated(run, limb, args.sim_seed)?, None)
        };
        Ok(Self { frames, truth: Some(truth), sim, player: None })
    }
}

impl LiveArgs {
    /// The page's first pictures, counted from `start`, if that is wanted.
    fn first(&self, start: Instant) -> Option<FirstPaint> {
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
    fn place(&self) -> SearchPlace {
        if self.is_recorded() { SearchPlace::Here } else { SearchPlace::Background }
    }

    fn origin(&self) -> Origin {
        match &self.source {
            None => Origin::Sim,
            Some(source) if source.is_recorded() => Origin::Recording,
            Some(_) => Origin::Device,
        }
    }

    fn is_recorded(&self) -> bool {
        self.source.as_ref().is_some_and(SourceArg::is_recorded)
    }

    fn is_unpaced(&self) -> bool {
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

fn with_sinks(mut builder: LiveBuilder, args: &LiveArgs) -> Result<LiveBuilder> {
    if let Some(address) = &args.serve {
        if let Some(address) = address.strip_prefix("tcp:") {
            check_reach("--serve", address, IS_READ, args.insecure_bind)?;
        }
        let server = JsonServer::bind(address)?;
        eprintln!("JSON lines at {}", server.address());
        builder = builder.sink(server);
    }
    if let Some(path) = &args.csv {
        let file = new_file(path, "--csv")?;
        builder = builder.sink(CsvSink::new(BufWriter::new(file)));
    }
    Ok(if args.json {
        builder.sink(JsonSink::new(JsonLines(BufWriter::new(StandardOutput))))
    } else if StandardOutput.is_terminal() {
        builder.sink(TextSink::refreshed(StandardOutput))
    } else {
        builder.sink(TextSink::lines(BufWriter::new(StandardOutput)))
    })
}

/// A bundle begins with the length of a header and `{`; a scene is text.
pub(super) fn is_bundle(path: &Path) -> Result<bool> {
    use std::io::Read;
    let shown = || shown(path);
    let mut begin = [0; 9];
    let mut file = File::open(path).with_context(|| format!("{}: check the path", shown()))?;
    let n = file.read(&mut begin).with_context(shown)?;
    let has_its_name = path.extension().is_some_and(|e| e == "hapdef");
    Ok(has_its_name || (n == begin.len() && begin[8] == b'{' && begin[7] == 0))
}

fn gauge(name: &str, scale: f64) -> LiveGauge {
    LiveGauge { name: name.to_owned(), scale }
}
