//! Notices that nothing comes, or nothing that is understood.

use super::LinkState;
use super::reader::Reader;
use crate::Message;

/// After that long without anything understood, the source says so: garbage and a wrong baud rate have
/// to be reported within 3 s.
const PATIENCE_NS: u64 = 2_000_000_000;

#[derive(Default)]
pub(crate) struct Watch {
    since_ns: u64,
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
        reader: &Reader,
        sink: &mut dyn FnMut(Message),
    ) {
        let text = |b: &&u8| b.is_ascii_digit() || b",\r\n .-".contains(b);
        self.n_bytes += bytes.len() as u64;
        self.n_text += bytes.iter().filter(text).count() as u64;
        let n_good = reader.n_good();
        if n_good > self.n_good {
            *self = Self::from(now_ns);
            self.n_good = n_good;
        } else if now_ns.saturating_sub(self.since_ns) >= PATIENCE_NS {
            if let Some(state) = self.complaint(reader) {
                sink(Message::Link(state));
            }
            *self = Self::from(now_ns);
            self.n_good = n_good;
        }
    }

    fn complaint(&self, reader: &Reader) -> Option<LinkState> {
        if self.n_bytes == 0 {
            let for_s = PATIENCE_NS / 1_000_000_000;
            return Some(LinkState::Silent { for_s });
        }
        let is_text = self.n_text * 10 > self.n_bytes * 9;
        let remedy = match (reader.version_fault(), reader.has_commands(), is_text) {
            (Some(fault), ..) => fault,
            (None, true, true) => "they look like lines of numbers: read them as CSV".to_owned(),
            (None, true, false) => "check the baud rate (115200 for a USB-serial chip, any for \
                                    native USB), and that the firmware speaks HDP1"
                .to_owned(),
            (None, false, true) => "they are lines of another number of integers: set the number \
                                    of channels"
                .to_owned(),
            (None, false, false) => "they are no text: check the baud rate (115200 for the \
                                     sketch), or read HDP1"
                .to_owned(),
        };
        Some(LinkState::NotUnderstood { n_bytes: self.n_bytes, remedy: remedy.into() })
    }
}
