//! Notices that nothing comes, or nothing that readings can be had of.

use super::LinkState;
use super::reader::Reader;
use crate::Message;
use crate::hdp1::Rejected;

/// After that long without a reading the source says why, if it knows: garbage and a wrong baud rate have
/// to be reported within 3 s.
const PATIENCE_NS: u64 = 2_000_000_000;

#[derive(Default)]
pub(crate) struct Watch {
    since_ns: u64,
    /// Frames, and what else was understood, when this began.
    n_frames: u64,
    n_good: u64,
    n_bytes: u64,
    n_text: u64,
}

impl Watch {
    pub(crate) fn from(now_ns: u64) -> Self {
        Self { since_ns: now_ns, ..Self::default() }
    }

    pub(crate) fn look(
        &mut self,
        bytes: &[u8],
        now_ns: u64,
        reader: &mut Reader,
        sink: &mut dyn FnMut(Message),
    ) {
        let text = |b: &&u8| b.is_ascii_digit() || b",\r\n .-".contains(b);
        self.n_bytes += bytes.len() as u64;
        self.n_text += bytes.iter().filter(text).count() as u64;
        let (n_frames, n_good) = (reader.n_frames(), reader.n_good());
        let is_well = n_frames > self.n_frames;
        if !is_well && now_ns.saturating_sub(self.since_ns) < PATIENCE_NS {
            return;
        }
        let refused = reader.take_refused();
        if !is_well && let Some(state) = self.complaint(reader, refused) {
            sink(Message::Link(state));
        }
        *self = Self { n_frames, n_good, ..Self::from(now_ns) };
    }

    fn complaint(&self, reader: &Reader, refused: Option<(u64, Rejected)>) -> Option<LinkState> {
        if self.n_bytes == 0 {
            let for_s = PATIENCE_NS / 1_000_000_000;
            return Some(LinkState::Silent { for_s });
        }
        if let Some((n_packets, why)) = refused {
            return Some(LinkState::Refused { n_packets, why: why.to_string().into() });
        }
        if reader.n_good() > self.n_good {
            return None;
        }
        if let Some((expected, found)) = reader.other_channels() {
            return Some(LinkState::OtherChannels { expected, found });
        }
        let is_text = self.n_text * 10 > self.n_bytes * 9;
        let remedy = match (reader.has_commands(), is_text) {
            (true, true) => "they look like lines of numbers: read them as CSV",
            (true, false) => {
                "check the baud rate (115200 for a USB-serial chip, any for native \
                              USB), and that the firmware speaks HDP1"
            }
            (false, true) => "they are no lines of integers from 0 to 4095: flash the sketch",
            (false, false) => {
                "they are no text: check the baud rate (115200 for the sketch), or \
                               read HDP1"
            }
        };
        Some(LinkState::NotUnderstood { n_bytes: self.n_bytes, remedy: remedy.into() })
    }
}
