//! What a recording says to whoever plays it, with what is missing in it.

use super::recording::{Content, Recording};
use crate::source::{LinkFault, LinkState};
use crate::{DaqError, Message};

/// The messages of a recording with their times on the wall clock, ns. Packets that are missing because
/// the file is damaged are added to the next frame's `n_lost_before`; damage and a file that can't be
/// read on are reported at the end, as [`Message::Link`].
pub(crate) struct Messages {
    recording: Recording,
    /// Number of the last frame's packet, unless the device started anew since.
    last_seq: Option<u32>,
    last_ns: u64,
    is_over: bool,
}

impl Recording {
    /// The messages of the sources, for a replay. Packets that are missing because the file is damaged
    /// are among the next frame's `n_lost_before`; in the end [`Message::Link`] reports damage, and
    /// of a file that can't be read on.
    pub fn messages(self) -> impl Iterator<Item = Message> + Send {
        Messages::new(self).map(|(_, message)| message)
    }
}

impl Messages {
    pub(crate) fn new(recording: Recording) -> Self {
        Self { recording, last_seq: None, last_ns: 0, is_over: false }
    }

    fn next_message(&mut self) -> Result<Option<(u64, Message)>, DaqError> {
        while let Some(record) = self.recording.next_record()? {
            let Content::Message(mut message) = record.content else {
                continue;
            };
            match &mut message {
                Message::Frame(frame) => {
                    let last_seq = self.last_seq.replace(frame.seq);
                    let n_missing = last_seq.map_or(0, |seq| frame.n_missing_since(seq));
                    frame.n_lost_before = frame.n_lost_before.saturating_add(n_missing);
                }
                Message::Restarted => self.last_seq = None,
                _ => {}
            }
            self.last_ns = record.log_time_ns;
            return Ok(Some((record.log_time_ns, message)));
        }
        Ok(None)
    }

    /// What is to be said of the file when nothing more comes of it.
    fn last_words(&self, fault: Option<DaqError>) -> Option<LinkState> {
        if let Some(DaqError::File { path, source, .. }) = fault {
            return Some(LinkState::Away(LinkFault::Io {
                name: path.display().to_string(),
                message: format!("can't be read on: {source}"),
            }));
        }
        let damage = self.recording.damage();
        (damage.n_damaged > 0 || damage.n_chunks == 0).then_some(LinkState::Damaged {
            n_chunks: damage.n_chunks,
            n_damaged: damage.n_damaged,
            n_bytes: damage.n_damaged_bytes,
        })
    }
}

impl Iterator for Messages {
    type Item = (u64, Message);

    fn next(&mut self) -> Option<Self::Item> {
        if self.is_over {
            return None;
        }
        let fault = match self.next_message() {
            Ok(Some(message)) => return Some(message),
            Ok(None) => None,
            Err(fault) => Some(fault),
        };
        self.is_over = true;
        let words = self.last_words(fault);
        words.map(|state| (self.last_ns, Message::Link(state)))
    }
}
