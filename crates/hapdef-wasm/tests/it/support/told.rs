//! What the page is told, as `docs/view.md` has it.

use hapdef_wasm::{PageMessage, Session};
use nalgebra::{Point3, Vector3};
use serde_json::Value;

/// A contact or truth of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mark {
    pub number: u32,
    pub at: Point3<f64>,
    pub force_n: Vector3<f64>,
}

/// A frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    pub t_s: f64,
    pub readings_ue: Vec<f64>,
    /// Phase, staleness and reasons.
    pub flags: u16,
    pub contacts: Vec<Mark>,
    pub n_others: usize,
    pub truths: Vec<Mark>,
}

/// Everything that waits.
pub fn all(session: &mut Session) -> Vec<PageMessage> {
    std::iter::from_fn(|| session.next_message()).collect()
}

/// The newest frame that waits.
pub fn newest(session: &mut Session) -> Frame {
    let messages = all(session);
    messages.iter().rev().find_map(frame).expect("a frame")
}

/// The texts among messages.
pub fn texts(messages: &[PageMessage]) -> Vec<Value> {
    let text = |message: &PageMessage| match message {
        PageMessage::Text(text) => Some(serde_json::from_str(text).unwrap()),
        PageMessage::Bytes(_) => None,
    };
    messages.iter().filter_map(text).collect()
}

/// The frame in a message, if it is one.
pub fn frame(message: &PageMessage) -> Option<Frame> {
    match message {
        PageMessage::Bytes(bytes) if bytes[0] == 2 => Some(Frame::read(bytes)),
        _ => None,
    }
}

impl Frame {
    fn read(bytes: &[u8]) -> Self {
        let n_gauges = usize::from(u16_at(bytes, 16));
        let [n_contacts, n_others] = [18, 20].map(|at| usize::from(u16_at(bytes, at)));
        let contacts_at = 76 + 12 * n_gauges + n_gauges.next_multiple_of(4);
        let truths_at = contacts_at + 80 * (n_contacts + n_others);
        Self {
            t_s: f64::from_le_bytes(bytes[8..16].try_into().unwrap()),
            readings_ue: (0..n_gauges).map(|i| f32_at(bytes, 76 + 4 * i)).collect(),
            flags: u16_at(bytes, 22),
            contacts: marks(bytes, contacts_at, n_contacts),
            n_others,
            truths: marks(bytes, truths_at, usize::from(u16_at(bytes, 72))),
        }
    }

    /// Whether something touches, is known not to, or is not known.
    pub fn phase(&self) -> &'static str {
        ["taring", "untouched", "touched", "unknown"][usize::from(self.flags >> 4 & 3)]
    }
}

fn marks(bytes: &[u8], at: usize, n: usize) -> Vec<Mark> {
    let mark = |i: usize| {
        let start = at + 80 * i;
        let vector = |at: usize| Vector3::from_fn(|axis, _| f32_at(bytes, start + at + 4 * axis));
        Mark {
            number: u32::from_le_bytes(bytes[start..start + 4].try_into().unwrap()),
            at: vector(8).into(),
            force_n: vector(32),
        }
    };
    (0..n).map(mark).collect()
}

fn u16_at(bytes: &[u8], at: usize) -> u16 {
    u16::from_le_bytes(bytes[at..at + 2].try_into().unwrap())
}

fn f32_at(bytes: &[u8], at: usize) -> f64 {
    f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()).into()
}
