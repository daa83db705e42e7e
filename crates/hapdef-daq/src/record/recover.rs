//! A whole file from a damaged or unfinished one, and what was lost.

use std::path::Path;

use super::file::{RecordFile, partial_path, rename};
use super::recording::{Content, Recording};
use super::scan::DamageInfo;
use crate::{DaqError, Frame, Message};

/// What could be saved.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RecoverInfo {
    /// How whole the file was.
    pub damage: DamageInfo,
    /// Records saved.
    pub n_records: u64,
    /// Frames among them.
    pub n_frames: u64,
    /// Messages of further topics that are whole, but nothing says any more how to read them.
    pub n_undefined: u64,
    /// Packets that were recorded, going by the numbers, but are gone.
    pub n_missing: u64,
    /// Places where packets are gone.
    pub n_gaps: u64,
    /// Wall-clock time of the first and the last frame, ns since 1970 UTC.
    pub span_ns: Option<[u64; 2]>,
}

/// Copies every record of `from` that is whole to the new file `to`.
///
/// # Errors
/// Files that can't be read or written, and [`DaqError::NothingToRecover`] if there is not one
/// record: a program that gets any of them should end with an exit code other than 0.
pub fn recover(from: &Path, to: &Path) -> Result<RecoverInfo, DaqError> {
    let mut recording = Recording::open(from)?;
    let partial = partial_path(to);
    let file_error = |source| DaqError::File {
        action: "writing",
        path: partial.clone(),
        source,
    };
    let mut out = None;
    let mut info = RecoverInfo::default();
    let mut last: Option<Frame> = None;
    while let Some(record) = recording.next_record()? {
        let out = match &mut out {
            Some(out) => out,
            none => {
                let new = RecordFile::with_own_topics(&partial, recording.is_ros2());
                none.insert(new.map_err(file_error)?)
            }
        };
        if let Content::Further(topic) = &record.content {
            out.define(record.channel, topic).map_err(file_error)?;
        }
        let sequence = info.n_records as u32;
        out.write(record.channel, sequence, record.log_time_ns, &record.bytes)
            .map_err(file_error)?;
        info.n_records += 1;
        match record.content {
            Content::Message(Message::Frame(frame)) => {
                info.take(&frame, record.log_time_ns, last.as_ref());
                last = Some(frame);
            }
            Content::Message(Message::Restarted) => last = None,
            _ => {}
        }
    }
    info.damage = recording.damage();
    info.n_undefined = recording.n_undefined();
    let out = out.ok_or_else(|| DaqError::NothingToRecover {
        path: from.to_owned(),
        n_bytes: info.damage.n_bytes,
    })?;
    out.finish()
        .and_then(|_| rename(&partial, to))
        .map_err(file_error)?;
    Ok(info)
}

impl RecoverInfo {
    /// Exit code for a program that recovers: 0 if nothing is missing, 1 if something is.
    #[must_use]
    pub fn exit_code(&self) -> u8 {
        let is_whole = self.n_missing + self.n_undefined + self.damage.n_damaged == 0;
        u8::from(!is_whole)
    }

    fn take(&mut self, frame: &Frame, log_time_ns: u64, last: Option<&Frame>) {
        self.n_frames += 1;
        let first = self.span_ns.map_or(log_time_ns, |[first, _]| first);
        self.span_ns = Some([first, log_time_ns]);
        let Some(last) = last else { return };
        let step = frame.seq.wrapping_sub(last.seq);
        let known = frame.n_lost_before.saturating_add(frame.n_dropped_before);
        let n_missing = step.saturating_sub(1).saturating_sub(known);
        // A step of half the range and more is one back: a restart whose record is gone.
        if n_missing > 0 && step < 1 << 31 {
            self.n_missing += u64::from(n_missing);
            self.n_gaps += 1;
        }
    }
}

impl std::fmt::Display for RecoverInfo {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { damage, .. } = self;
        let seconds = self
            .span_ns
            .map_or(0.0, |[a, b]| b.saturating_sub(a) as f64 * 1e-9);
        let ending = if damage.is_finished { "has" } else { "lacks" };
        write!(
            f,
            "{} frames over {seconds:.3} s in {} whole chunks; lost: {} packets in {} gaps; {} \
             damaged stretches, {} bytes; the file {ending} its ending",
            self.n_frames,
            damage.n_chunks,
            self.n_missing,
            self.n_gaps,
            damage.n_damaged,
            damage.n_damaged_bytes,
        )
    }
}
