//! Messages to the page, byte by byte as `docs/view.md` has them. Little-endian.

use hapdef_contact::{GaugeHealth, TouchPhase, UnknownReason};
use nalgebra::Vector3;
use serde::Serialize;

use crate::device::DeviceState;
use crate::frame::{ContactMark, Displacement, Recording, ViewFrame};
use crate::offers::Offers;
use crate::picture::LimbPicture;

/// Version of the messages.
const VERSION: u8 = 4;
/// First byte of the limb's surface.
const KIND_SURFACE: u8 = 1;
/// First byte of a frame.
const KIND_FRAME: u8 = 2;

/// First message to a page.
#[derive(Serialize)]
pub(crate) struct Hello<'a> {
    #[serde(rename = "type")]
    kind: &'static str,
    version: u8,
    title: &'a str,
    up: Option<[f64; 3]>,
    view_from: Option<[f64; 3]>,
    gauges: Vec<HelloGauge<'a>>,
    offers: HelloOffers,
}

#[derive(Serialize)]
struct HelloGauge<'a> {
    name: &'a str,
    position_m: [f64; 3],
    axis: [f64; 3],
}

#[derive(Serialize)]
struct HelloOffers {
    commands: bool,
    tare: bool,
    record: bool,
    press: Option<HelloPress>,
}

#[derive(Serialize)]
struct HelloPress {
    default_n: f64,
    max_n: f64,
}

impl<'a> Hello<'a> {
    /// What a page may know at first; without `may_command` it is offered nothing.
    pub(crate) fn new(picture: &'a LimbPicture, offers: &Offers, may_command: bool) -> Self {
        let press = offers.press.filter(|_| may_command);
        Self {
            kind: "hello",
            version: VERSION,
            title: &picture.title,
            up: picture.up,
            view_from: picture.view_from,
            gauges: picture.gauges.iter().map(HelloGauge::new).collect(),
            offers: HelloOffers {
                commands: may_command,
                tare: offers.tare && may_command,
                record: offers.record && may_command,
                press: press
                    .map(|press| HelloPress { default_n: press.default_n, max_n: press.max_n }),
            },
        }
    }
}

impl<'a> HelloGauge<'a> {
    fn new(gauge: &'a crate::picture::GaugeSite) -> Self {
        Self { name: &gauge.name, position_m: gauge.position_m, axis: gauge.axis }
    }
}

/// Where readings come from.
pub(crate) fn device(state: &DeviceState) -> String {
    let DeviceState { is_simulated, fault } = state;
    let fault = fault.as_deref().map(hapdef_contact::printable);
    serde_json::json!({"type": "device", "simulated": is_simulated, "fault": fault}).to_string()
}

/// Words for whoever sees the page.
pub(crate) fn notice(words: &str) -> String {
    serde_json::json!({"type": "notice", "text": words}).to_string()
}

/// Why a message of the page is not obeyed.
pub(crate) fn refusal(why: &str) -> String {
    serde_json::json!({"type": "refused", "text": why}).to_string()
}

/// The surface: 16 bytes, vertices, normals, triangles.
pub(crate) fn surface(picture: &LimbPicture) -> Vec<u8> {
    let (n, m) = (picture.vertices_m.len(), picture.triangles.len());
    let mut out = Vec::with_capacity(16 + 24 * n + 12 * m);
    out.extend([KIND_SURFACE, VERSION, 0, 0]);
    put_u32(&mut out, n as u64);
    put_u32(&mut out, m as u64);
    put_u32(&mut out, 0);
    for vector in picture.vertices_m.iter().chain(&picture.normals) {
        put_f32s(&mut out, vector);
    }
    for node in picture.triangles.as_flattened() {
        out.extend(node.to_le_bytes());
    }
    out
}

/// A frame that was checked: 76 bytes, readings and their ranges, states, contacts, alternatives, truths,
/// displacement.
pub(crate) fn frame(frame: &ViewFrame, seq: u64) -> Vec<u8> {
    let n_gauges = frame.readings_ue.len();
    let mut out = Vec::with_capacity(256 + 8 * n_gauges + displacement_bytes(&frame.displacement));
    put_header(&mut out, frame, seq);
    for &reading in &frame.readings_ue {
        put_f32(&mut out, reading);
    }
    for (gauge, &reading) in frame.readings_ue.iter().enumerate() {
        let range = frame.ranges_ue.get(gauge).copied().unwrap_or([reading; 2]);
        range.iter().for_each(|&end| put_f32(&mut out, end));
    }
    for gauge in 0..n_gauges {
        out.push(gauge_code(frame.gauge_health.get(gauge).copied().unwrap_or_default()));
    }
    out.resize(out.len().next_multiple_of(4), 0);
    for (place, mark) in marks(&frame.contacts).iter().enumerate() {
        put_mark(&mut out, mark, mark.contact.number(place), 1.0);
    }
    for (index, probability, mark) in alternative_marks(frame) {
        put_mark(&mut out, mark, index, probability);
    }
    for (place, mark) in marks(&frame.truths).iter().enumerate() {
        put_mark(&mut out, mark, mark.contact.number(place), 1.0);
    }
    match &frame.displacement {
        Displacement::None => {}
        Displacement::Magnitude(lengths) => put_f32s(&mut out, lengths),
        Displacement::Vector(vectors) => put_f32s(&mut out, vectors.as_flattened()),
    }
    out
}

fn put_header(out: &mut Vec<u8>, frame: &ViewFrame, seq: u64) {
    let (components, n_nodes) = match &frame.displacement {
        Displacement::None => (0, 0),
        Displacement::Magnitude(lengths) => (1, lengths.len()),
        Displacement::Vector(vectors) => (3, vectors.len()),
    };
    let health = &frame.health;
    let (recording, recorded_s) = match health.recording {
        Recording::Off => (0, f64::NAN),
        Recording::On { recorded_s } => (1, recorded_s),
        Recording::Failed => (2, f64::NAN),
    };
    out.extend([KIND_FRAME, VERSION, components, recording]);
    out.extend((seq as u32).to_le_bytes());
    out.extend(frame.t_s.to_le_bytes());
    put_u16(out, frame.readings_ue.len());
    put_u16(out, marks(&frame.contacts).len());
    put_u16(out, alternative_marks(frame).count());
    put_u16(out, flags(frame));
    put_u32(out, n_nodes as u64);
    put_f32(out, health.rate_hz);
    put_u32(out, health.n_lost);
    put_u32(out, health.n_crc_errors);
    put_f32(out, health.latency_p50_us);
    put_f32(out, health.latency_p99_us);
    put_f32(out, health.clock_residual_us);
    put_f32(out, recorded_s);
    put_f32(out, frame.replay.map_or(f64::NAN, |replay| replay.position_s));
    put_f32(out, frame.replay.map_or(f64::NAN, |replay| replay.duration_s));
    put_u32(out, health.n_dropped);
    put_f32(out, frame.p_value);
    put_u16(out, marks(&frame.truths).len());
    put_u16(out, 0);
}

/// Bit 0: a replay stands still, bit 1: the contacts are old; bits 4 to 6 the phase, 8 to 10 why it is
/// unknown.
fn flags(frame: &ViewFrame) -> usize {
    let is_paused = frame.replay.is_some_and(|replay| replay.is_paused);
    let phase = match frame.phase {
        TouchPhase::Taring => 0,
        TouchPhase::Untouched => 1,
        TouchPhase::Touched => 2,
        TouchPhase::Unknown(_) => 3,
    };
    let why = match frame.phase.why_unknown() {
        None => 0,
        Some(UnknownReason::TooFewGauges) => 1,
        Some(UnknownReason::StreamStalled) => 2,
        Some(UnknownReason::TareInvalid) => 3,
        Some(UnknownReason::Misfit) => 4,
        Some(UnknownReason::Drift) => 5,
    };
    usize::from(is_paused) | usize::from(frame.is_stale) << 1 | phase << 4 | why << 8
}

/// 0 good, 1 at an end of its range, 2 gives nothing, 3 not counted at the moment.
fn gauge_code(health: GaugeHealth) -> u8 {
    match health {
        GaugeHealth::Good => 0,
        GaugeHealth::Saturated => 1,
        GaugeHealth::Dead | GaugeHealth::NotFinite => 2,
        GaugeHealth::Spike | GaugeHealth::Recovering => 3,
    }
}

/// 80 bytes: number, weight, position, normal, force, its deviation, two half axes, range of the force.
fn put_mark(out: &mut Vec<u8>, mark: &ContactMark, number: u32, weight: f64) {
    out.extend(number.to_le_bytes());
    put_f32(out, weight);
    let unknown = ([Vector3::from_element(f64::NAN); 2], f64::NAN);
    let sure = mark.contact.uncertainty;
    let (axes, force_sd_n) = sure.map_or(unknown, |sure| (sure.semi_axes_m(), sure.force_sd_n()));
    let position = mark.contact.position_m.coords;
    for vector in [position, mark.normal, mark.force_vector_n()] {
        put_vector(out, &vector);
    }
    put_f32(out, force_sd_n);
    axes.iter().for_each(|axis| put_vector(out, axis));
    let force_n = mark.force_vector_n().norm();
    mark.force_range_n.unwrap_or([force_n; 2]).iter().for_each(|&end| put_f32(out, end));
}

fn put_vector(out: &mut Vec<u8>, vector: &Vector3<f64>) {
    vector.iter().for_each(|&c| put_f32(out, c));
}

/// As many contacts as the header can count.
fn marks(contacts: &[ContactMark]) -> &[ContactMark] {
    &contacts[..contacts.len().min(usize::from(u16::MAX))]
}

fn alternative_marks(frame: &ViewFrame) -> impl Iterator<Item = (u32, f64, &ContactMark)> {
    let marks = (0..).zip(&frame.alternatives).flat_map(|(index, (probability, contacts))| {
        contacts.iter().map(move |contact| (index, *probability, contact))
    });
    marks.take(usize::from(u16::MAX))
}

fn displacement_bytes(displacement: &Displacement) -> usize {
    match displacement {
        Displacement::None => 0,
        Displacement::Magnitude(lengths) => size_of_val(lengths.as_slice()),
        Displacement::Vector(vectors) => size_of_val(vectors.as_slice()),
    }
}

fn put_u16(out: &mut Vec<u8>, count: usize) {
    out.extend(u16::try_from(count).unwrap_or(u16::MAX).to_le_bytes());
}

/// Counts beyond 32 bits stay at the largest.
fn put_u32(out: &mut Vec<u8>, count: u64) {
    out.extend(u32::try_from(count).unwrap_or(u32::MAX).to_le_bytes());
}

fn put_f32(out: &mut Vec<u8>, value: f64) {
    out.extend((value as f32).to_le_bytes());
}

fn put_f32s(out: &mut Vec<u8>, values: &[f32]) {
    for value in values {
        out.extend(value.to_le_bytes());
    }
}

#[cfg(test)]
mod tests {
    use hapdef_contact::{Contact, GaugeHealth as H, TouchPhase, Uncertainty, UnknownReason};
    use nalgebra::{Matrix3, Point3, Vector3};
    use serde_json::json;

    use super::{device, frame, gauge_code, surface};
    use crate::device::DeviceState;
    use crate::frame::{ContactMark, Displacement, Recording, ReplayPosition, ViewFrame};
    use crate::picture::LimbPicture;

    fn f32_at(bytes: &[u8], at: usize) -> f32 {
        f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap())
    }

    fn u16_at(bytes: &[u8], at: usize) -> u16 {
        u16::from_le_bytes(bytes[at..at + 2].try_into().unwrap())
    }

    #[test]
    fn surface_is_where_the_docs_say() {
        let picture = LimbPicture {
            vertices_m: vec![[0.0; 3], [0.25, 0.0, 0.0], [0.0, 0.5, 0.0]],
            normals: vec![[0.0, 0.0, 1.0]; 3],
            triangles: vec![[0, 1, 2]],
            ..LimbPicture::default()
        };
        let bytes = surface(&picture);
        assert_eq!(bytes.len(), 16 + 3 * 24 + 12);
        assert_eq!(bytes[..12], [1, 4, 0, 0, 3, 0, 0, 0, 1, 0, 0, 0]);
        assert_eq!(f32_at(&bytes, 16 + 12), 0.25);
        assert_eq!(f32_at(&bytes, 16 + 36 + 8), 1.0);
        assert_eq!(bytes[16 + 72 + 8], 2);
    }

    #[test]
    fn device_is_as_the_docs_say() {
        let message = |is_simulated, fault: Option<&str>| -> serde_json::Value {
            let fault = fault.map(str::to_owned);
            let text = device(&DeviceState { is_simulated, fault });
            serde_json::from_str(&text).unwrap()
        };
        assert_eq!(
            message(true, Some("no port")),
            json!({"type": "device", "simulated": true, "fault": "no port"})
        );
        assert_eq!(
            message(false, None),
            json!({"type": "device", "simulated": false, "fault": null})
        );
    }

    #[test]
    fn only_gauges_that_count_are_shown_as_good() {
        for left_out in [H::Saturated, H::Dead, H::Spike, H::NotFinite, H::Recovering] {
            assert_ne!(gauge_code(left_out), gauge_code(H::Good), "{left_out:?}");
        }
    }

    #[test]
    fn frame_is_where_the_docs_say() {
        let contact = ContactMark {
            contact: Contact {
                id: Some(7),
                direction: Some(-Vector3::y()),
                uncertainty: Some(Uncertainty {
                    tangents: [Vector3::x(), Vector3::z()],
                    covariance: Matrix3::from_diagonal(&Vector3::new(0.25, 0.0625, 0.015_625)),
                }),
                ..Contact::new(Point3::new(0.5, 0.0, 0.0), 4.0)
            },
            normal: Vector3::y(),
            force_range_n: Some([3.5, 4.5]),
        };
        let mut other = contact;
        other.contact.uncertainty = None;
        let mut shown = ViewFrame {
            t_s: 1.5,
            readings_ue: vec![3.0, -8.0, 0.0, 1.0],
            ranges_ue: vec![[2.0, 5.0], [-9.0, -8.0], [0.0; 2], [1.0; 2]],
            gauge_health: vec![H::Good, H::Saturated, H::Dead, H::Spike],
            phase: TouchPhase::Unknown(UnknownReason::Misfit),
            is_stale: true,
            p_value: 0.125,
            contacts: vec![contact],
            alternatives: vec![(0.25, vec![other])],
            truths: vec![ContactMark { force_range_n: None, ..other }],
            displacement: Displacement::Vector(vec![[1.0, 2.0, 3.0]; 2]),
            ..ViewFrame::default()
        };
        shown.health.n_lost = u64::MAX;
        shown.health.n_dropped = 513;
        shown.health.rate_hz = 997.5;
        shown.health.n_crc_errors = 258;
        shown.health.latency_p50_us = 182.5;
        shown.health.latency_p99_us = 950.25;
        shown.health.clock_residual_us = 4.25;
        shown.health.recording = Recording::On { recorded_s: 2.0 };
        let bytes = frame(&shown, 258);
        assert_eq!(bytes.len(), 76 + 16 + 32 + 4 + 3 * 80 + 24);
        assert_eq!(bytes[..8], [2, 4, 3, 1, 2, 1, 0, 0]);
        assert_eq!(f64::from_le_bytes(bytes[8..16].try_into().unwrap()), 1.5);
        assert_eq!([16, 18, 20].map(|at| u16_at(&bytes, at)), [4, 1, 1]);
        assert_eq!(bytes[24..28], [2, 0, 0, 0]);
        assert_eq!(bytes[32..36], [255; 4]);
        assert_eq!(f32_at(&bytes, 28), 997.5);
        assert_eq!(bytes[36..40], [2, 1, 0, 0]);
        assert_eq!([40, 44, 48, 52].map(|at| f32_at(&bytes, at)), [182.5, 950.25, 4.25, 2.0]);
        assert!(f32_at(&bytes, 56).is_nan());
        assert_eq!(bytes[64..68], [1, 2, 0, 0]);
        assert_eq!([68, 76, 80].map(|at| f32_at(&bytes, at)), [0.125, 3.0, -8.0]);
        assert_eq!(bytes[72..76], [1, 0, 0, 0]);
        assert_eq!([92, 96, 100].map(|at| f32_at(&bytes, at)), [2.0, 5.0, -9.0]);
        assert_eq!(bytes[124..128], [0, 1, 2, 3]);
        assert_eq!(bytes[128], 7);
        assert_eq!([132, 136, 152, 164].map(|at| f32_at(&bytes, at)), [1.0, 0.5, 1.0, -4.0]);
        assert_eq!([172, 176, 196].map(|at| f32_at(&bytes, at)), [0.125, 0.5, 0.25]);
        assert_eq!([200, 204].map(|at| f32_at(&bytes, at)), [3.5, 4.5]);
        assert_eq!(f32_at(&bytes, 208 + 4), 0.25);
        assert!(f32_at(&bytes, 208 + 44).is_nan());
        assert_eq!([288 + 4, 288 + 72].map(|at| f32_at(&bytes, at)), [1.0, 4.0]);
        assert_eq!(f32_at(&bytes, 368 + 20), 3.0);
        assert_eq!(u16_at(&bytes, 22), 4 << 8 | 3 << 4 | 2);
        shown.replay = Some(ReplayPosition { position_s: 4.0, duration_s: 8.0, is_paused: true });
        let bytes = frame(&shown, 259);
        assert_eq!(u16_at(&bytes, 22) & 1, 1);
        assert_eq!([56, 60].map(|at| f32_at(&bytes, at)), [4.0, 8.0]);
    }
}
