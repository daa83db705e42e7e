//! A whole file from a damaged or unfinished one, and what was lost.

use std::fs::File;
use std::io;
use std::path::Path;

use super::file::{
    CHUNK_SPAN, RecordFile, check_unclaimed, claim, is_same_file, recovering_path, rename,
};
use super::recording::{Content, Recording};
use super::scan::DamageInfo;
use crate::{DaqError, Frame, Message};

const LEFT_OVER: &str = "from a recovery that goes on or was broken off: wait for it, or remove it";

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
    /// Stretches of damage before the first frame, or the first after a restart: what they held
    /// can't be counted, as nothing says where the numbers began.
    pub n_uncounted: u64,
    /// Wall-clock time of the first and the last frame, ns since 1970 UTC.
    pub span_ns: Option<[u64; 2]>,
}

/// Copies every record of `from` that is whole to the file `to`, named `….recovering.mcap` until it is
/// complete. `from` is never written to.
///
/// # Errors
/// Files that can't be read or written, [`DaqError::BeingWritten`], [`DaqError::AlreadyThere`] where `to` is `from` or another
/// recovery is under way, and [`DaqError::NothingToRecover`] if there is not one record: a program
/// that gets any of them should end with an exit code other than 0.
pub fn recover(from: &Path, to: &Path) -> Result<RecoverInfo, DaqError> {
    let recording = Recording::open(from)?;
    let data = |path: &Path| std::fs::metadata(path);
    if matches!((data(from), data(to)), (Ok(from), Ok(to)) if is_same_file(&from, &to)) {
        return Err(DaqError::AlreadyThere {
            path: to.to_owned(),
            remedy: "and is the recording itself: give what is saved another name",
        });
    }
    let new = recovering_path(to);
    check_unclaimed(to)?;
    let file = claim(&new, Some(LEFT_OVER))?;
    let _claim = file.try_clone().map_err(writing(&new))?;
    let saved = copy(recording, from, file, &new).and_then(|info| {
        rename(&new, to).map_err(writing(&new))?;
        Ok(info)
    });
    if saved.is_err() {
        let _ = std::fs::remove_file(&new);
    }
    saved
}

fn writing(path: &Path) -> impl Fn(io::Error) -> DaqError {
    |source| DaqError::File { action: "writing", path: path.to_owned(), source }
}

/// Copies the whole records to a file that was made for them.
fn copy(
    mut recording: Recording,
    from: &Path,
    file: File,
    path: &Path,
) -> Result<RecoverInfo, DaqError> {
    let file_error = writing(path);
    let (mut file, mut out) = (Some(file), None);
    let mut info = RecoverInfo::default();
    let mut last_seq = None;
    let mut n_damaged = 0;
    let mut chunk = None;
    while let Some(record) = recording.next_record()? {
        if let Some(file) = file.take() {
            let new = RecordFile::with_own_topics(file, recording.is_ros2());
            out = Some(new.map_err(&file_error)?);
        }
        let Some(out) = &mut out else { continue };
        if let Content::Further(topic) = &record.content {
            out.define(record.channel, topic).map_err(&file_error)?;
        }
        let (now_ns, n_chunks) = (record.log_time_ns, recording.damage().n_chunks);
        let (since_ns, n_before) = *chunk.get_or_insert((now_ns, n_chunks));
        let passed_ns = u128::from(now_ns.abs_diff(since_ns));
        // As small as the recorder's: what a flipped bit costs doesn't grow by being saved.
        if n_chunks != n_before || passed_ns >= CHUNK_SPAN.as_nanos() {
            out.flush().map_err(&file_error)?;
            chunk = Some((now_ns, n_chunks));
        }
        let sequence = info.n_records as u32;
        out.write(record.channel, sequence, record.log_time_ns, &record.bytes)
            .map_err(&file_error)?;
        info.n_records += 1;
        match record.content {
            Content::Message(Message::Frame(frame)) => {
                let n_now = recording.damage().n_damaged;
                if last_seq.is_none() {
                    info.n_uncounted += n_now - n_damaged;
                }
                n_damaged = n_now;
                info.take(&frame, record.log_time_ns, last_seq);
                last_seq = Some(frame.seq);
            }
            Content::Message(Message::Restarted) => last_seq = None,
            _ => {}
        }
    }
    info.damage = recording.damage();
    if last_seq.is_none() {
        info.n_uncounted += info.damage.n_damaged - n_damaged;
    }
    info.n_undefined = recording.n_undefined();
    let out = out.ok_or_else(|| DaqError::NothingToRecover {
        path: from.to_owned(),
        n_bytes: info.damage.n_bytes,
    })?;
    out.finish().map_err(file_error)?;
    Ok(info)
}

impl RecoverInfo {
    /// Exit code for a program that recovers: 0 if nothing is missing, 1 if something is.
    #[must_use]
    pub fn exit_code(&self) -> u8 {
        let is_whole = self.n_missing + self.n_undefined + self.damage.n_damaged == 0;
        u8::from(!is_whole)
    }

    fn take(&mut self, frame: &Frame, log_time_ns: u64, last_seq: Option<u32>) {
        self.n_frames += 1;
        let first = self.span_ns.map_or(log_time_ns, |[first, _]| first);
        self.span_ns = Some([first, log_time_ns]);
        let n_missing = last_seq.map_or(0, |last| frame.n_missing_since(last));
        self.n_missing += u64::from(n_missing);
        self.n_gaps += u64::from(n_missing > 0);
    }
}

impl std::fmt::Display for RecoverInfo {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { damage, .. } = self;
        let seconds = self.span_ns.map_or(0.0, |[a, b]| b.saturating_sub(a) as f64 * 1e-9);
        let ending = if damage.is_finished { "has" } else { "lacks" };
        write!(
            f,
            "{} frames over {seconds:.3} s in {} whole chunks; lost: {} packets in {} gaps",
            self.n_frames, damage.n_chunks, self.n_missing, self.n_gaps,
        )?;
        if self.n_uncounted > 0 {
            write!(f, ", and an unknown number before the first that is left")?;
        }
        write!(
            f,
            "; {} damaged stretches, {} bytes; the file {ending} its ending",
            damage.n_damaged, damage.n_damaged_bytes,
        )
    }
}
