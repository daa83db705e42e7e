//! What a recording asks of the disk: room, and that it keeps what it was given.

use std::io;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use arc_swap::ArcSwapOption;

use crate::DaqError;

/// Time from one `fdatasync` to the next. It has a thread of its own: a slow disk must not delay
/// flushes. Without it a kill after 5 s at 1 kHz loses everything in chunks of 768 KiB and more, and
/// 304 to 403 frames in chunks of 64 KiB; with it at most 99, for a file 0.7 % larger.
const SYNC: Duration = Duration::from_millis(100);

/// Syncs until it is `done`; what fails goes to `fault`, which ends the recording.
pub(super) fn keep_syncing(
    sync: impl Fn() -> io::Result<()>,
    done: &AtomicBool,
    fault: &ArcSwapOption<String>,
) {
    while !done.load(Ordering::Acquire) {
        let start = Instant::now();
        match sync() {
            // A pipe or a device that has nothing to sync.
            Err(error) if error.kind() == io::ErrorKind::InvalidInput => {}
            Err(error) => {
                fault.store(Some(Arc::new(error.to_string())));
                return;
            }
            Ok(()) => {}
        }
        std::thread::sleep(SYNC.saturating_sub(start.elapsed()).max(Duration::from_millis(5)));
    }
}

/// Refuses a disk that has less than `needed_bytes` free.
pub(super) fn check_space(path: &Path, needed_bytes: u64) -> Result<(), DaqError> {
    let stat = rustix::fs::statvfs(path).map_err(|error| DaqError::File {
        action: "asking for free space at",
        path: path.to_owned(),
        source: error.into(),
    })?;
    let free_bytes = stat.f_bavail.saturating_mul(stat.f_frsize);
    if free_bytes >= needed_bytes {
        return Ok(());
    }
    Err(DaqError::DiskFull { path: path.to_owned(), free_bytes, needed_bytes })
}

#[cfg(test)]
mod tests {
    use super::super::RecordParams;
    use super::super::recording::{Content, Recording};
    use super::super::writer::record_by;
    use super::*;
    use crate::hdp1::SampleFormat;
    use crate::source::{FrameSource, SourceStats, SourceStatus};
    use crate::{AcquireParams, Frame, Message, acquire};

    /// A frame each millisecond, for ever.
    struct Endless(u32);

    impl FrameSource for Endless {
        fn poll(&mut self, _: Duration, sink: &mut dyn FnMut(Message)) -> SourceStatus {
            std::thread::sleep(Duration::from_millis(1));
            sink(Message::Frame(Frame::new(self.0, SampleFormat::I16, [1, 2])));
            self.0 += 1;
            SourceStatus::Open
        }

        fn stats(&self) -> SourceStats {
            SourceStats { n_frames: u64::from(self.0), ..SourceStats::default() }
        }

        fn name(&self) -> String {
            "endless".to_owned()
        }
    }

    #[test]
    fn a_disk_that_fails_is_reported_at_once_and_the_file_can_be_read() {
        const EIO: i32 = 5;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.mcap");
        let (acquisition, mut receivers) = acquire(Endless(0), AcquireParams::default()).unwrap();
        let params = RecordParams { min_free_bytes: 0, ..RecordParams::default() };
        let fails = Arc::new(AtomicBool::new(false));
        let theirs = Arc::clone(&fails);
        let sync = move |_: &std::fs::File| match theirs.load(Ordering::Acquire) {
            true => Err(io::Error::from_raw_os_error(EIO)),
            false => Ok(()),
        };
        let recorder = record_by(receivers.remove(0), &path, params, sync).unwrap();
        while recorder.stats().n_frames < 200 {
            assert_eq!(recorder.stats().fault, None);
            std::thread::sleep(Duration::from_millis(5));
        }
        let n_before = recorder.stats().n_frames;
        fails.store(true, Ordering::Release);
        let start = Instant::now();
        while recorder.stats().fault.is_none() {
            assert!(start.elapsed() < Duration::from_secs(1));
            std::thread::sleep(Duration::from_millis(1));
        }
        let n_acquired = acquisition.stats().source.n_frames;
        let ended = recorder.finish().unwrap_err();
        assert!(ended.to_string().contains("os error 5"), "{ended}");
        std::thread::sleep(Duration::from_millis(300));
        assert!(acquisition.stop().source.n_frames > n_acquired + 10);
        let mut recording = Recording::open(&folder.path().join("x.partial.mcap")).unwrap();
        let mut n_frames = 0;
        while let Some(record) = recording.next_record().unwrap() {
            let is_frame = matches!(record.content, Content::Message(Message::Frame(_)));
            n_frames += u64::from(is_frame);
        }
        assert!(n_frames >= n_before, "{n_frames} of {n_before}");
        assert_eq!(recording.damage().n_damaged, 0);
    }
}
