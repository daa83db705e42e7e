//! `hapdef live`: contacts from a stream of frames, of one limb or of all limbs of a robot.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use anyhow::Result;
use hapdef::{Robot, error_text, is_robot_file, read_robot};
use hapdef_live::sinks::JsonServer;

use super::files::is_bundle;
use super::lean::start_lean;
use super::live_args::LiveArgs;
use super::live_limb::{Beside, RunningLimb, StoppedLimb};
use super::live_model::Model;
use super::live_robot::limbs_of;
use super::network::{IS_READ, check_reach};
use super::signals::stop_flag;
use super::view::RobotPage;

/// How often it looks whether to end.
const LOOK: Duration = Duration::from_millis(20);

pub(crate) fn run(args: &LiveArgs) -> Result<()> {
    let mut first = args.first(Instant::now());
    let path = &args.scene.scene;
    args.view.check_reach(args.insecure_bind)?;
    let robot = is_robot_file(path).then(|| read_robot(path)).transpose()?;
    let limbs = match &robot {
        Some(robot) => limbs_of(args, robot)?,
        None => vec![args.clone()],
    };
    for limb in &limbs {
        limb.check()?;
    }
    let mut alert = args.alert.sink()?;
    let stop = prepare(&limbs)?;
    let page = robot.as_ref().map_or(Ok(None), |robot| robot_page(args, robot))?;
    let model = |limb: &LiveArgs| limb.named(Model::of(limb, &stop, page.as_ref()));
    let models: Vec<Model> = limbs.iter().map(model).collect::<Result<_>>()?;
    let server = json_server(args)?;
    let start = |(limb, model): (&LiveArgs, Model)| {
        let (alert, first) = (alert.take(), first.take());
        let beside = Beside { server: server.clone(), alert, first };
        limb.named(RunningLimb::start(limb, model, beside))
    };
    let mut running: Vec<RunningLimb> =
        limbs.iter().zip(models).map(start).collect::<Result<_>>()?;
    wait(&mut running, args.seconds, &stop);
    end(running, &limbs)
}

/// The process with its threads, where scenes are solved; the flag that Ctrl-C sets.
fn prepare(limbs: &[LiveArgs]) -> Result<Arc<AtomicBool>> {
    for limb in limbs {
        if !is_bundle(&limb.scene.scene)? {
            if limb.realtime.is_some() {
                start_lean()?;
            }
            limb.scene.start_threads()?;
            break;
        }
    }
    stop_flag()
}

/// The page of all limbs, if that is wanted.
fn robot_page(args: &LiveArgs, robot: &Robot) -> Result<Option<RobotPage>> {
    let page = || RobotPage::start(&args.view, robot, &args.scene.results);
    args.view.is_wanted().then(page).transpose()
}

/// Who sends JSON lines to whoever connects, if that is wanted.
fn json_server(args: &LiveArgs) -> Result<Option<JsonServer>> {
    let Some(address) = &args.serve else {
        return Ok(None);
    };
    if let Some(address) = address.strip_prefix("tcp:") {
        check_reach("--serve", address, IS_READ, args.insecure_bind)?;
    }
    let server = JsonServer::bind(address)?;
    eprintln!("JSON lines at {}", server.address());
    Ok(Some(server))
}

/// Until no limb goes on, or the person or `seconds` ends it. A recording that stops is reported at once; the rest
/// goes on without it.
fn wait(limbs: &mut [RunningLimb], seconds: Option<f64>, stop: &AtomicBool) {
    let start = Instant::now();
    let is_over = || seconds.is_some_and(|s| start.elapsed().as_secs_f64() >= s);
    while !stop.load(Ordering::Relaxed) && !is_over() && limbs.iter().any(RunningLimb::goes_on) {
        limbs.iter_mut().for_each(RunningLimb::look);
        std::thread::sleep(LOOK);
    }
}

/// Ends all limbs at once, then their recordings; the first fault of one is the program's, the others are told.
fn end(running: Vec<RunningLimb>, limbs: &[LiveArgs]) -> Result<()> {
    let stopped: Vec<StoppedLimb> = running.into_iter().map(RunningLimb::stop).collect();
    let mut first = Ok(());
    for (limb, stopped) in limbs.iter().zip(stopped) {
        let ended = limb.named(stopped.end());
        if let (Err(_), Err(further)) = (&first, &ended) {
            eprintln!("error: {}", error_text(further.as_ref()));
        }
        first = first.and(ended);
    }
    first
}
