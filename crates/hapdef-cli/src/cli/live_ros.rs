//! From the runtime to what ROS tools read: one recording with everything, and a live view.

use std::path::{Path, PathBuf};
use std::sync::mpsc::Receiver;

use anyhow::{Context, Result, bail};
use clap::Args;
use hapdef_cli::shown;
use hapdef_daq::clock::{HostClock, SystemClock};
use hapdef_daq::source::FrameSource;
use hapdef_live::{
    AnyError, Delivery, GaugeHealth, Health, LiveEvent, LiveFrame, Sink, Touch, TouchPhase,
    UnknownReason, Wants,
};
use hapdef_rig::live::TruthFrame;
use hapdef_ros::{
    Health as Part, Known, Level, MessageSink, Readings, RobotBoard, RosEncoder, RosParams, Sinks,
};

use super::live_record::LiveRecorder;
use super::truth::Truth;

/// Frames that wait to be encoded at most: 8 s at 1 kHz.
const QUEUE_LEN: usize = 8192;

/// What ROS tools are given.
#[derive(Args, Clone, Debug)]
pub(crate) struct RosArgs {
    /// Record everything to one file: raw readings, contacts, wrenches, markers, diagnostics, as
    /// ROS tools read them; with --sim what really touches, too. Of several limbs a folder, with a file for
    /// each.
    #[arg(long, value_name = "FILE")]
    pub(super) record: Option<PathBuf>,
    /// Calibration to keep in the recording as it is, a JSON file; that of the bundle or scene if not
    /// given.
    #[arg(long, value_name = "FILE", requires = "record")]
    record_calibration: Option<PathBuf>,
    /// Ground truth of a simulated rig, a JSON line a frame as it writes them, for the recording.
    #[arg(long, value_name = "FILE", requires = "record", conflicts_with = "sim")]
    truth: Option<PathBuf>,
    /// Serve Foxglove at this address: 127.0.0.1:8765.
    #[arg(long, value_name = "ADDRESS")]
    pub(super) foxglove: Option<std::net::SocketAddr>,
    /// Publish on the topics of ROS 2 by rmw_zenoh, in this ROS_DOMAIN_ID.
    #[arg(long, value_name = "DOMAIN")]
    zenoh: Option<u32>,
    /// Before the names of the limb's topics, another for each limb: /left_arm/shin.
    #[arg(long, value_name = "NAME", default_value_t = RosParams::default().prefix)]
    prefix: String,
    /// Frame of the limb, that of the link in the robot's tf; its contacts' frames are below it.
    #[arg(long, value_name = "NAME", default_value_t = RosParams::default().frame_id)]
    frame: String,
    /// The robot that it is a limb of.
    #[arg(skip)]
    robot: Option<LimbOfRobot>,
}

/// What a limb of several has of its own, and in common with the others.
#[derive(Clone, Debug)]
pub(super) struct LimbOfRobot {
    /// Before the names of the limb's topics.
    pub(super) prefix: String,
    /// Frame of the limb.
    pub(super) frame: String,
    /// Before the names of the robot's topics.
    pub(super) robot: String,
    /// Where the contacts of all limbs are.
    pub(super) board: RobotBoard,
    /// The limb's number there.
    pub(super) number: usize,
}

/// A source that can be recorded on its way, and where what is made of it goes.
pub(super) struct Attached {
    /// The source to use.
    pub(super) source: Box<dyn FrameSource>,
    /// The sink to add.
    pub(super) sink: Option<RosSink>,
    /// What records, where that is wanted.
    pub(super) recorder: Option<LiveRecorder>,
}

/// What is known of recordings before one begins.
pub(super) struct Recordings {
    /// They can be asked for later.
    pub(super) are_possible: bool,
    /// The calibration in use, JSON.
    pub(super) calibration: Option<String>,
    /// The source waits for whatever is made of it, and so for the disk.
    pub(super) is_lossless: bool,
}

/// Frames of the runtime as messages of ROS.
pub(super) struct RosSink {
    name: String,
    encoder: RosEncoder<Sinks>,
    truth: Option<Truth>,
    recorder: Option<LiveRecorder>,
    /// Wall clock less monotonic clock.
    wall_offset_ns: u64,
    /// The limb's name in diagnostics.
    limb: String,
    /// What was said last of whether contacts can be known.
    known: Option<Known>,
}

impl RosArgs {
    /// Attaches what is asked for to a source. `truth` tells what a simulated rig is pressed by, `mount_m` is the
    /// middle of the limb's mount.
    pub(super) fn attach(
        &self,
        source: Box<dyn FrameSource>,
        truth: Option<Receiver<TruthFrame>>,
        recordings: Recordings,
        mount_m: Option<[f64; 3]>,
    ) -> Result<Attached> {
        let params = RosParams { mount_m, ..self.params()? };
        let mut sinks: Vec<Box<dyn MessageSink>> = Vec::new();
        let mut names = Vec::new();
        if let Some(address) = self.foxglove {
            sinks.push(foxglove(&params, address)?);
            names.push(format!("Foxglove at {address}"));
        }
        if let Some(domain_id) = self.zenoh {
            sinks.push(zenoh(&params, domain_id)?);
            names.push(format!("ROS 2 in domain {domain_id}"));
        }
        let (mut source, mut recorder) = (source, None);
        if recordings.are_possible || self.record.is_some() {
            let calibration = self.calibration(recordings.calibration)?;
            let is_lossless = recordings.is_lossless;
            let (tee, new) = LiveRecorder::new(source, &params, calibration, is_lossless)?;
            source = Box::new(tee);
            sinks.push(Box::new(new.sink()));
            names.push("recording".to_owned());
            if let Some(path) = &self.record {
                is_new(path)?;
                new.start(path)?;
            }
            recorder = Some(new);
        }
        let truth = match (&self.truth, truth) {
            (Some(path), _) => Some(Truth::in_file(path)?),
            (None, truth) => truth.map(Truth::of_rig),
        };
        let sink = match sinks.is_empty() {
            true => None,
            false => Some(RosSink {
                name: names.join(", "),
                limb: params.name(),
                encoder: self.encoder(params, sinks)?,
                truth,
                recorder: recorder.clone(),
                wall_offset_ns: SystemClock.wall_ns().wrapping_sub(SystemClock.now_ns()),
                known: None,
            }),
        };
        Ok(Attached { source, sink, recorder })
    }

    /// The same for a limb of several, with its own recording.
    pub(super) fn of_limb(&self, limb: LimbOfRobot, record: Option<PathBuf>) -> Self {
        let (prefix, frame) = (limb.prefix.clone(), limb.frame.clone());
        Self { prefix, frame, record, robot: Some(limb), ..self.clone() }
    }

    /// The first of the options that are one limb's, where there is one.
    pub(super) fn of_one_limb(&self) -> Option<&'static str> {
        let usual = RosParams::default();
        [
            ("--record-calibration", self.record_calibration.is_some()),
            ("--truth", self.truth.is_some()),
            ("--foxglove", self.foxglove.is_some()),
            ("--prefix", self.prefix != usual.prefix),
            ("--frame", self.frame != usual.frame_id),
        ]
        .into_iter()
        .find_map(|(option, is_given)| is_given.then_some(option))
    }

    /// How messages are named.
    pub(super) fn params(&self) -> Result<RosParams> {
        let params = RosParams {
            prefix: self.prefix.clone(),
            frame_id: self.frame.clone(),
            robot: self.robot.as_ref().map(|limb| limb.robot.clone()),
            ..RosParams::default()
        };
        params.check().context("--prefix and --frame")?;
        Ok(params)
    }

    fn encoder(
        &self,
        params: RosParams,
        sinks: Vec<Box<dyn MessageSink>>,
    ) -> Result<RosEncoder<Sinks>> {
        let encoder = RosEncoder::new(params, Sinks(sinks))?;
        Ok(match &self.robot {
            Some(limb) => encoder.beside(limb.board.clone(), limb.number),
            None => encoder,
        })
    }

    /// The file that was named, else what is in use.
    fn calibration(&self, in_use: Option<String>) -> Result<Option<Vec<u8>>> {
        let Some(path) = &self.record_calibration else {
            return Ok(in_use.map(String::into_bytes));
        };
        let json = std::fs::read(path);
        json.map(Some).with_context(|| format!("{}: reading", shown(path)))
    }
}

fn is_new(path: &Path) -> Result<()> {
    if path.exists() {
        bail!("--record: {} is there already; choose another name", shown(path));
    }
    Ok(())
}

#[cfg(feature = "foxglove")]
fn foxglove(params: &RosParams, address: std::net::SocketAddr) -> Result<Box<dyn MessageSink>> {
    let host = address.ip().to_string();
    let server = hapdef_ros::FoxgloveServer::start(params, &host, address.port())?;
    eprintln!("Foxglove: ws://{host}:{}", server.port());
    Ok(Box::new(server))
}

#[cfg(not(feature = "foxglove"))]
fn foxglove(_: &RosParams, _: std::net::SocketAddr) -> Result<Box<dyn MessageSink>> {
    bail!("--foxglove: this build has no such server; build with --features foxglove")
}

#[cfg(feature = "zenoh")]
fn zenoh(params: &RosParams, domain_id: u32) -> Result<Box<dyn MessageSink>> {
    let node = params.name();
    let zenoh = hapdef_ros::ZenohParams { domain_id, node, ..hapdef_ros::ZenohParams::default() };
    Ok(Box::new(hapdef_ros::ZenohSink::open(params, &zenoh)?))
}

#[cfg(not(feature = "zenoh"))]
fn zenoh(_: &RosParams, _: u32) -> Result<Box<dyn MessageSink>> {
    bail!("--zenoh: this build has no zenoh; build with --features zenoh")
}

impl RosSink {
    /// Says whether contacts can be known, where that has changed or is to be said again.
    fn know(&mut self, now: Known, is_again: bool) -> Result<(), AnyError> {
        let key = |known: &Known| (known.phase, known.is_stale, known.n_contacts);
        if is_again || self.known.as_ref().map(key) != Some(key(&now)) {
            self.encoder.status(&now)?;
        }
        self.known = Some(now);
        Ok(())
    }

    fn stamp_ns(&self, t_host_ns: u64) -> u64 {
        match &self.recorder {
            Some(recorder) => recorder.wall_ns(t_host_ns),
            None => t_host_ns.wrapping_add(self.wall_offset_ns),
        }
    }
}

impl Sink for RosSink {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn wants(&self) -> Wants {
        Wants::ALL
    }

    fn delivery(&self) -> Delivery {
        Delivery::Queue(QUEUE_LEN)
    }

    fn frame(&mut self, frame: &LiveFrame) -> Result<(), AnyError> {
        let stamp_ns = self.stamp_ns(frame.t_host_ns);
        self.encoder.readings(&Readings {
            stamp_ns,
            seq: frame.seq,
            n_lost_before: frame.n_lost_before,
            microstrain: &frame.tared_ue,
        })?;
        self.encoder.contacts(stamp_ns, frame.seq, &frame.touch)?;
        if let Ok(contacts) = frame.known_contacts() {
            self.encoder.net_wrench(stamp_ns, contacts)?;
        }
        let now = Known {
            stamp_ns,
            phase: frame.phase,
            is_stale: frame.is_stale,
            n_contacts: frame.touch.contacts.len(),
            smallest_seen_n: frame.smallest_seen_n,
        };
        self.know(now, false)?;
        if let Some(truth) = &mut self.truth {
            truth.frame(frame.seq, stamp_ns, &mut put_truth(&mut self.encoder))?;
        }
        Ok(())
    }

    fn event(&mut self, event: &LiveEvent) -> Result<(), AnyError> {
        match (event, &mut self.truth) {
            (LiveEvent::Health(health), _) => {
                let stamp_ns = self.stamp_ns(SystemClock.now_ns());
                self.encoder.health(&parts(&self.limb, health, stamp_ns))?;
                if let Some(known) = self.known {
                    self.know(Known { stamp_ns, ..known }, true)?;
                }
            }
            (LiveEvent::Phase(status), _) => {
                let now = Known {
                    stamp_ns: self.stamp_ns(SystemClock.now_ns()),
                    phase: status.phase,
                    is_stale: status.is_stale,
                    n_contacts: status.n_contacts,
                    smallest_seen_n: self.known.and_then(|known| known.smallest_seen_n),
                };
                self.know(now, true)?;
                if status.n_contacts == 0 {
                    self.encoder.release(now.stamp_ns)?;
                }
            }
            (LiveEvent::Restarted, Some(truth)) => truth.restarted()?,
            _ => {}
        }
        Ok(())
    }

    fn finish(&mut self) -> Result<(), AnyError> {
        self.encoder.leave();
        if let Some(truth) = &mut self.truth {
            truth.look(&mut put_truth(&mut self.encoder))?;
        }
        Ok(())
    }
}

/// Puts what is known to touch.
fn put_truth(encoder: &mut RosEncoder<Sinks>) -> impl FnMut(u64, u32, &Touch) -> Result<()> + '_ {
    |stamp_ns, seq, known| Ok(encoder.truth(stamp_ns, seq, known)?)
}

/// How the runtime of a limb is doing, part by part.
fn parts(limb: &str, health: &Health, stamp_ns: u64) -> Vec<Part> {
    let part = |name: &str, level, message: String, values: &[(&str, String)]| Part {
        stamp_ns,
        name: format!("{limb}: {name}"),
        level,
        message,
        hardware_id: health.source_name.clone(),
        values: values.iter().map(|(k, v)| ((*k).to_owned(), v.clone())).collect(),
    };
    let link = health.link.as_ref().map(ToString::to_string);
    let is_open = health.n_frames > 0 && health.rate_hz > 0.0;
    let acquisition = part(
        "acquisition",
        level(is_open, health.n_lost == 0),
        link.unwrap_or_else(|| "waiting".to_owned()),
        &[
            ("rate_hz", format!("{:.1}", health.rate_hz)),
            ("frames", health.n_frames.to_string()),
            ("lost", health.n_lost.to_string()),
            ("dropped", health.n_dropped.to_string()),
            ("restarts", health.n_restarts.to_string()),
            ("drift_ppm", format!("{:.1}", health.source.drift_ppm)),
        ],
    );
    let why = health.phase.and_then(TouchPhase::why_unknown).map_or("", UnknownReason::word);
    let compute = part(
        "contacts",
        level(
            health.device_fault.is_none() && health.phase.is_none_or(|p| p.why_unknown().is_none()),
            health.n_deadline_missed == 0 && !health.is_stale,
        ),
        health.to_string(),
        &[
            ("compute_p50_us", format!("{:.0}", health.second.compute.p50_us)),
            ("compute_p99_us", format!("{:.0}", health.second.compute.p99_us)),
            ("deadline_missed", health.n_deadline_missed.to_string()),
            ("refused", health.n_refused.to_string()),
            ("contacts", health.n_contacts.to_string()),
            ("phase", health.phase.map_or("waiting", TouchPhase::word).to_owned()),
            ("why_unknown", why.to_owned()),
            ("stale", health.is_stale.to_string()),
        ],
    );
    let bad = health.gauges.iter().enumerate();
    let bad: Vec<String> = bad
        .filter(|(_, state)| **state != GaugeHealth::Good)
        .map(|(i, state)| format!("{i} {state:?}"))
        .collect();
    let gauges = part(
        "gauges",
        level(true, bad.is_empty()),
        if bad.is_empty() { "all count".to_owned() } else { bad.join(", ") },
        &[],
    );
    vec![acquisition, compute, gauges]
}

fn level(works: bool, is_well: bool) -> Level {
    match (works, is_well) {
        (false, _) => Level::Error,
        (true, false) => Level::Warn,
        (true, true) => Level::Ok,
    }
}
