//! Frames as JSON, one a line.

use std::io::Write;

use hapdef_contact::{Contact, GaugeHealth, Phase, TouchPhase, UnknownReason, WhyNot, Wrench};
use nalgebra::Point3;
use serde::Serialize;
use serde_json::{Value, json};

use crate::error::AnyError;
use crate::frame::LiveFrame;
use crate::health::{Health, Latency};
use crate::sink::{Delivery, LiveEvent, Sink, Wants};
use crate::tare_fault::TareFault;

/// Frames that wait for a slow file or pipe.
const N_QUEUED: usize = 4096;

/// Writes frames as JSON lines; docs/live.md has the fields.
pub struct JsonSink<W> {
    out: W,
    limb: Option<String>,
    line: Vec<u8>,
    n_unflushed: usize,
}

#[derive(Serialize)]
struct Line<'a> {
    /// Which of several limbs.
    #[serde(skip_serializing_if = "Option::is_none")]
    limb: Option<&'a str>,
    seq: u32,
    scan: u8,
    t_device_us: u64,
    t_host_ns: u64,
    t_done_ns: u64,
    lost_before: u32,
    dropped_before: u32,
    skipped_before: u32,
    phase: &'static str,
    why_unknown: Option<&'static str>,
    is_stale: bool,
    smallest_seen_n: Option<f64>,
    temperature: Option<f64>,
    raw_ue: &'a [f64],
    tared_ue: &'a [f64],
    /// Gauges that don't count, and why.
    bad_gauges: Vec<(usize, &'static str)>,
    contacts: Vec<ContactLine>,
    released: &'a [u64],
    wrench: Option<WrenchLine>,
    quality: Option<QualityLine>,
    alternatives: Vec<AlternativeLine>,
}

#[derive(Serialize)]
struct ContactLine {
    id: Option<u64>,
    phase: Option<&'static str>,
    position_m: [f64; 3],
    direction: Option<[f64; 3]>,
    force_n: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    radius_m: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    radius_sd_m: Option<f64>,
    position_sd_m: Option<f64>,
    force_sd_n: Option<f64>,
}

/// About the origin of the limb's frame.
#[derive(Serialize)]
struct WrenchLine {
    force_n: [f64; 3],
    moment_nm: [f64; 3],
    /// Row by row.
    covariance: Option<[[f64; 6]; 6]>,
}

#[derive(Serialize)]
struct QualityLine {
    is_identified: bool,
    why_not: Option<&'static str>,
    chi2: f64,
    n_dof: usize,
    p_value: f64,
    n_alternatives: usize,
}

#[derive(Serialize)]
struct AlternativeLine {
    #[serde(rename = "delta_evidence")]
    delta_cost: f64,
    contacts: Vec<([f64; 3], f64)>,
}

impl<W: Write + Send> JsonSink<W> {
    /// A sink that writes to `out`.
    pub fn new(out: W) -> Self {
        Self { out, limb: None, line: Vec::with_capacity(4096), n_unflushed: 0 }
    }

    /// The same for a limb of several, whose lines have its name as `"limb"`.
    #[must_use]
    pub fn of_limb(self, name: &str) -> Self {
        Self { limb: Some(name.to_owned()), ..self }
    }
}

impl<W: Write + Send> Sink for JsonSink<W> {
    fn name(&self) -> String {
        "json".to_owned()
    }

    fn wants(&self) -> Wants {
        Wants { health: true, ..Wants::ALL }
    }

    fn delivery(&self) -> Delivery {
        Delivery::Queue(N_QUEUED)
    }

    fn frame(&mut self, frame: &LiveFrame) -> Result<(), AnyError> {
        frame_line(self.limb.as_deref(), frame, &mut self.line)?;
        self.out.write_all(&self.line)?;
        self.n_unflushed += 1;
        if self.n_unflushed >= 50 {
            self.n_unflushed = 0;
            self.out.flush()?;
        }
        Ok(())
    }

    fn event(&mut self, event: &LiveEvent) -> Result<(), AnyError> {
        if event_line(self.limb.as_deref(), event, &mut self.line)? {
            self.out.write_all(&self.line)?;
        }
        Ok(self.out.flush()?)
    }

    fn finish(&mut self) -> Result<(), AnyError> {
        Ok(self.out.flush()?)
    }
}

/// A frame as a line of JSON with its line break, into `line`.
///
/// # Errors
/// None that a frame can cause.
pub fn json_line(frame: &LiveFrame, line: &mut Vec<u8>) -> Result<(), AnyError> {
    frame_line(None, frame, line)
}

/// The same of a limb of several.
pub(super) fn frame_line(
    limb: Option<&str>,
    frame: &LiveFrame,
    line: &mut Vec<u8>,
) -> Result<(), AnyError> {
    line.clear();
    serde_json::to_writer(&mut *line, &Line { limb, ..Line::of(frame) })?;
    line.push(b'\n');
    Ok(())
}

/// An event in the same way; false for one that has no line.
pub(super) fn event_line(
    limb: Option<&str>,
    event: &LiveEvent,
    line: &mut Vec<u8>,
) -> Result<bool, AnyError> {
    let mut value = match event {
        LiveEvent::Hello(hello) => json!({
            "event": "device",
            "n_channels": hello.channels.len(),
            "rate_hz": f64::from(hello.rate_mhz) * 1e-3,
        }),
        LiveEvent::Restarted => json!({"event": "restarted"}),
        LiveEvent::Link(state) => json!({"event": "link", "text": state.to_string()}),
        LiveEvent::Log(text) => json!({"event": "log", "text": &**text}),
        LiveEvent::Tared => json!({"event": "tared"}),
        LiveEvent::TareFault(fault) => tare_fault_value(fault),
        LiveEvent::Phase(status) => json!({
            "event": "phase",
            "phase": status.phase.word(),
            "why_unknown": status.phase.why_unknown().map(UnknownReason::word),
            "is_stale": status.is_stale,
            "n_contacts": status.n_contacts,
            "silent_s": status.silent_s,
        }),
        LiveEvent::Health(health) => health_value(health),
        LiveEvent::Status(_) => return Ok(false),
    };
    if let Some(limb) = limb {
        value["limb"] = limb.into();
    }
    line.clear();
    serde_json::to_writer(&mut *line, &value)?;
    line.push(b'\n');
    Ok(true)
}

fn tare_fault_value(fault: &TareFault) -> Value {
    let contacts = fault.contacts.iter().map(|contact| {
        let position_m: [f64; 3] = contact.position_m.into();
        json!({"position_m": position_m, "force_n": contact.force_n})
    });
    json!({
        "event": "tare_fault",
        "kind": fault.kind.word(),
        "outcome": fault.outcome.word(),
        "contacts": contacts.collect::<Vec<_>>(),
        "text": fault.to_string(),
    })
}

fn health_value(health: &Health) -> Value {
    let times = |of: &Latency| json!({"p50": of.p50_us, "p99": of.p99_us, "max": of.max_us});
    let second = &health.second;
    json!({
        "event": "health",
        "text": health.to_string(),
        "phase": health.phase.map(TouchPhase::word),
        "why_unknown": health.phase.and_then(TouchPhase::why_unknown).map(UnknownReason::word),
        "is_stale": health.is_stale,
        "smallest_seen_n": health.smallest_seen_n,
        "n_contacts": health.n_contacts,
        "rate_hz": health.rate_hz,
        "n_frames": health.n_frames,
        "n_lost": health.n_lost,
        "n_dropped": health.n_dropped,
        "n_refused": health.n_refused,
        "n_restarts": health.n_restarts,
        "n_reconnects": health.n_reconnects,
        "n_deadline_missed": health.n_deadline_missed,
        "n_late_searches": health.n_late_searches,
        "latency_us": {
            "queue": times(&second.queue),
            "conditioning": times(&second.conditioning),
            "estimate": times(&second.estimate),
            "sinks": times(&second.sinks),
            "compute": times(&second.compute),
        },
    })
}

impl<'a> Line<'a> {
    fn of(frame: &'a LiveFrame) -> Self {
        let touch = &frame.touch;
        let numbered = frame.gauges.iter().copied().enumerate();
        let quality = touch.quality.as_ref().map(|quality| QualityLine {
            is_identified: quality.is_identified(),
            why_not: quality.why_not().map(WhyNot::word),
            chi2: quality.chi2,
            n_dof: quality.n_dof,
            p_value: quality.p_value,
            n_alternatives: quality.n_alternatives,
        });
        let alternatives = touch.alternatives.iter().map(|other| AlternativeLine {
            delta_cost: other.delta_cost,
            contacts: other.contacts().map(|(x, force_n)| (x.coords.into(), force_n)).collect(),
        });
        Self {
            limb: None,
            seq: frame.seq,
            scan: frame.scan,
            t_device_us: frame.t_device_us,
            t_host_ns: frame.t_host_ns,
            t_done_ns: frame.t_done_ns,
            lost_before: frame.n_lost_before,
            dropped_before: frame.n_dropped_before,
            skipped_before: frame.n_skipped_before,
            phase: frame.phase.word(),
            why_unknown: frame.phase.why_unknown().map(UnknownReason::word),
            is_stale: frame.is_stale,
            smallest_seen_n: frame.smallest_seen_n,
            temperature: frame.temperature,
            raw_ue: &frame.raw_ue,
            tared_ue: &frame.tared_ue,
            bad_gauges: numbered
                .filter(|(_, health)| *health != GaugeHealth::Good)
                .map(|(gauge, health)| (gauge, health.word()))
                .collect(),
            contacts: touch.contacts.iter().map(ContactLine::of).collect(),
            released: &touch.released,
            wrench: WrenchLine::of_frame(frame),
            quality,
            alternatives: alternatives.collect(),
        }
    }
}

impl WrenchLine {
    /// None where a controller may not act on it; without contacts no covariance.
    fn of_frame(frame: &LiveFrame) -> Option<Self> {
        let contacts = frame.known_contacts().ok()?;
        let wrench = Wrench::of(contacts, Point3::origin())?;
        let covariance = wrench.covariance.filter(|_| !contacts.is_empty());
        Some(Self {
            force_n: wrench.force_n.into(),
            moment_nm: wrench.moment_nm.into(),
            // symmetric: columns are rows
            covariance: covariance.map(Into::into),
        })
    }
}

impl ContactLine {
    fn of(contact: &Contact) -> Self {
        let sure = contact.uncertainty.as_ref();
        Self {
            id: contact.id,
            phase: contact.phase.map(Phase::word),
            position_m: contact.position_m.coords.into(),
            direction: contact.direction.map(Into::into),
            force_n: contact.force_n,
            radius_m: contact.radius.map(|radius| radius.radius_m),
            radius_sd_m: contact.radius.and_then(|radius| radius.sd_m),
            position_sd_m: sure.map(|sure| sure.position_sd_m()),
            force_sd_n: sure.map(|sure| sure.force_sd_n()),
        }
    }
}
