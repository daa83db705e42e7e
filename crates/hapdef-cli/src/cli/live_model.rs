//! What `hapdef live` runs: a limb's model with the source of its readings.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::Receiver;

use anyhow::{Context, Result, bail, ensure};
use hapdef::scene::Outputs;
use hapdef::touch::{TouchEstimator, calibration_in_use, given_loads, live_estimator};
use hapdef::{Limb, Run, SourceArg};
use hapdef_cli::shown;
use hapdef_daq::record::{Player, PlayerControl};
use hapdef_daq::source::FrameSource;
use hapdef_live::{Bundle, GivenLoads, Live, LiveBuilder, LiveGauge};
use hapdef_rig::live::TruthFrame;

use super::files::is_bundle;
use super::live_args::LiveArgs;
use super::live_record::LiveRecorder;
use super::live_ros::{Attached, Recordings};
use super::sim::simulated;
use super::view::{Place, RobotPage, Sim, View};

/// A model and a source, made ready.
pub(super) struct Model {
    pub(super) source: Source,
    estimator: Box<dyn TouchEstimator>,
    gauges: Vec<LiveGauge>,
    noise_ue: f64,
    /// What a recording keeps of the calibration in use.
    calibration: Option<String>,
    /// What the device measures of loads that are no contacts.
    given: GivenLoads,
    /// The middle of the mount, m.
    mount_m: Option<[f64; 3]>,
    pub(super) view: Option<View>,
}

/// Where frames come from, with what else is known of them.
pub(super) struct Source {
    frames: Box<dyn FrameSource>,
    truth: Option<Receiver<TruthFrame>>,
    pub(super) sim: Option<Sim>,
    pub(super) player: Option<PlayerControl>,
}

impl Model {
    /// What the arguments say of a limb. `stop` stops the solving of its scene; its page is part of `robot`'s where
    /// there is one.
    pub(super) fn of(
        args: &LiveArgs,
        stop: &Arc<AtomicBool>,
        robot: Option<&RobotPage>,
    ) -> Result<Self> {
        let place = Place {
            origin: args.origin(),
            out: &args.scene.results,
            robot: robot.zip(args.limb.as_deref()),
        };
        let path = &args.scene.scene;
        match is_bundle(path)? {
            true => Self::of_bundle(args, &Bundle::read(path)?, &place),
            false => Self::of_scene(args, stop, &place),
        }
    }

    fn of_bundle(args: &LiveArgs, bundle: &Bundle, place: &Place<'_>) -> Result<Self> {
        ensure!(
            args.loads.is_none(),
            "--loads: a bundle has its own; give the scene instead, or make it anew"
        );
        let estimator = bundle.estimator(args.estimator, args.place())?;
        let Some(source) = &args.source else {
            bail!("--sim: the simulated rig is made from a scene: give that instead of its bundle")
        };
        let gauges = bundle.info.gauges.iter();
        let view = || args.view.of_bundle(bundle, place);
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
            view,
        })
    }

    fn of_scene(args: &LiveArgs, stop: &Arc<AtomicBool>, place: &Place<'_>) -> Result<Self> {
        let mut run = args.training.read(&args.scene, Arc::clone(stop))?;
        if let Some(file) = &args.loads {
            let file =
                std::path::absolute(file).with_context(|| format!("--loads {}", shown(file)))?;
            run.scene.loads.get_or_insert_default().learned = Some(file);
        }
        let limb = Limb::load(&run.scene, &run.scene_dir)?;
        let kind = args.estimator.unwrap_or(run.scene.estimator.kind().in_stream());
        let view = || args.view.of_scene(&run, &limb, place);
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
    pub(super) fn builder(self, args: &LiveArgs) -> Result<(LiveBuilder, Option<LiveRecorder>)> {
        let params = args.params(self.noise_ue);
        let recordings = Recordings {
            are_possible: args.view.is_wanted() && !args.is_recorded(),
            calibration: self.calibration,
            is_lossless: args.is_unpaced(),
        };
        let Source { frames, truth, .. } = self.source;
        let Attached { source, sink, recorder } =
            args.ros.attach(frames, truth, recordings, self.mount_m)?;
        let mut builder = Live::boxed_builder(source)
            .params(params)
            .gauges(self.gauges)
            .given(self.given)
            .boxed_estimator(self.estimator);
        if let Some(sink) = sink {
            builder = builder.sink(sink);
        }
        Ok((builder, recorder))
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

fn gauge(name: &str, scale: f64) -> LiveGauge {
    LiveGauge { name: name.to_owned(), scale }
}
