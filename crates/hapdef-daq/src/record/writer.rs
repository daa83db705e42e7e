//! The recorder: threads that write what a receiver gets.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use arc_swap::ArcSwapOption;

use super::file::{RecordFile, partial_path, rename};
use super::topics::{Topic, device_json, write_frame};
use crate::clock::HostClock;
use crate::{DaqError, Message, Receiver};

/// Time from one flush to the next: with some for the flush itself, nothing older than 100 ms is
/// unwritten.
const FLUSH: Duration = Duration::from_millis(80);
/// Time from one `fdatasync` to the next. It has a thread of its own: a slow disk must not delay
/// flushes.
const SYNC: Duration = Duration::from_millis(100);
const SPACE_CHECK: Duration = Duration::from_secs(1);

/// How a recording is made.
#[derive(Clone)]
pub struct RecordParams {
    /// The calibration in use, a JSON object, kept as it is.
    pub calibration: Option<Vec<u8>>,
    /// What is recorded, in words: the name of the source.
    pub source: String,
    /// The clocks that the source uses, too.
    pub clock: Arc<dyn HostClock>,
    /// Bytes of the disk that have to stay free.
    pub min_free_bytes: u64,
}

impl Default for RecordParams {
    /// No calibration, the system's clocks, 64 MiB free.
    fn default() -> Self {
        Self {
            calibration: None,
            source: String::new(),
            clock: Arc::new(crate::clock::SystemClock),
            min_free_bytes: 64 << 20,
        }
    }
}

/// How a recording is going.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RecordStats {
    /// Frames handed to the operating system.
    pub n_frames: u64,
    /// Bytes handed to the operating system.
    pub n_bytes: u64,
    /// Frames that were dropped before they came here: the disk was too slow for too long.
    pub n_dropped: u64,
    /// Longest time from one flush to the next.
    pub worst_flush: Duration,
    /// Why the recording stopped, if it did.
    pub fault: Option<Arc<str>>,
}

/// A finished recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecordInfo {
    /// Its file.
    pub path: PathBuf,
    /// Frames in it.
    pub n_frames: u64,
    /// Bytes of it.
    pub n_bytes: u64,
    /// Frames that were dropped before they came here.
    pub n_dropped: u64,
}

/// A recording under way. Dropping it finishes the file, and an error is lost then.
pub struct Recorder {
    path: PathBuf,
    shared: Arc<Shared>,
    writer: Option<JoinHandle<io::Result<u64>>>,
    syncer: Option<JoinHandle<()>>,
}

#[derive(Default)]
struct Shared {
    stop: AtomicBool,
    done: AtomicBool,
    n_frames: AtomicU64,
    n_bytes: AtomicU64,
    n_dropped: AtomicU64,
    worst_flush_us: AtomicU64,
    fault: ArcSwapOption<String>,
}

/// What the writer's thread holds.
struct Writing {
    receiver: Receiver,
    file: RecordFile,
    partial: PathBuf,
    min_free_bytes: u64,
    /// Wall clock less monotonic clock at the start: a wall clock that is set does not make times
    /// jump.
    wall_offset_ns: u64,
    clock: Arc<dyn HostClock>,
    json: String,
    sequence: u32,
    n_frames: u64,
}

/// Starts recording to `path`, named `….partial.mcap` until it is finished.
///
/// # Errors
/// A calibration that is no JSON object, too little room on the disk, a file or thread that can't
/// be made.
pub fn record(receiver: Receiver, path: &Path, params: RecordParams) -> Result<Recorder, DaqError> {
    let partial = partial_path(path);
    let file_error = |source| DaqError::File {
        action: "writing",
        path: partial.clone(),
        source,
    };
    check_calibration(params.calibration.as_deref())?;
    let folder = partial.parent().filter(|p| !p.as_os_str().is_empty());
    check_space(folder.unwrap_or(Path::new(".")), params.min_free_bytes)?;
    let file = RecordFile::create(&partial).map_err(file_error)?;
    let handle = file.handle().map_err(file_error)?;
    let mut writing = Writing {
        receiver,
        file,
        partial: partial.clone(),
        min_free_bytes: params.min_free_bytes,
        wall_offset_ns: params.clock.wall_ns().wrapping_sub(params.clock.now_ns()),
        clock: params.clock,
        json: String::new(),
        sequence: 0,
        n_frames: 0,
    };
    writing
        .open(&params.source, params.calibration.as_deref())
        .map_err(file_error)?;
    let shared = Arc::new(Shared::default());
    let (for_writer, for_syncer) = (Arc::clone(&shared), Arc::clone(&shared));
    let writer = thread("hapdef-record", move || writing.run(&for_writer))?;
    let syncer = thread("hapdef-sync", move || keep_syncing(&handle, &for_syncer))?;
    Ok(Recorder {
        path: path.to_owned(),
        shared,
        writer: Some(writer),
        syncer: Some(syncer),
    })
}

impl Recorder {
    /// How it is going.
    #[must_use]
    pub fn stats(&self) -> RecordStats {
        let count = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        RecordStats {
            n_frames: count(&self.shared.n_frames),
            n_bytes: count(&self.shared.n_bytes),
            n_dropped: count(&self.shared.n_dropped),
            worst_flush: Duration::from_micros(count(&self.shared.worst_flush_us)),
            fault: self
                .shared
                .fault
                .load()
                .as_deref()
                .map(|s| s.as_str().into()),
        }
    }

    /// Writes what has been received, ends the file and gives it its name.
    ///
    /// # Errors
    /// The recording has stopped before, or can't be finished; the partial file stays and can be
    /// read.
    pub fn finish(mut self) -> Result<RecordInfo, DaqError> {
        let ended = self.join();
        let partial = partial_path(&self.path);
        let fault = |source: io::Error| DaqError::Recording {
            path: partial.clone(),
            fault: source.to_string(),
        };
        let n_bytes = ended.and_then(|n| rename(&partial, &self.path).map(|()| n));
        let stats = self.stats();
        Ok(RecordInfo {
            path: self.path.clone(),
            n_frames: stats.n_frames,
            n_bytes: n_bytes.map_err(fault)?,
            n_dropped: stats.n_dropped,
        })
    }

    fn join(&mut self) -> io::Result<u64> {
        self.shared.stop.store(true, Ordering::Release);
        let ended = self.writer.take().map(JoinHandle::join);
        self.shared.done.store(true, Ordering::Release);
        if let Some(syncer) = self.syncer.take() {
            let _ = syncer.join();
        }
        match ended {
            Some(Ok(result)) => result,
            _ => Err(io::Error::other("the recorder's thread has ended")),
        }
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        if self.writer.is_some() && self.join().is_ok() {
            let _ = rename(&partial_path(&self.path), &self.path);
        }
    }
}

impl Writing {
    /// The first records: what this is, and the calibration.
    fn open(&mut self, source: &str, calibration: Option<&[u8]>) -> io::Result<()> {
        let now_ns = self.clock.now_ns();
        let session = serde_json::json!({
            "kind": "session",
            "source": source,
            "t_host_ns": now_ns,
            "t_wall_ns": now_ns.wrapping_add(self.wall_offset_ns),
        });
        self.put(Topic::Device, now_ns, session.to_string().as_bytes())?;
        if let Some(json) = calibration {
            self.put(Topic::Calibration, now_ns, json)?;
        }
        self.file.flush()
    }

    fn run(mut self, shared: &Shared) -> io::Result<u64> {
        match self.record(shared) {
            Ok(()) => self.file.finish(),
            Err(error) => {
                shared.fault.store(Some(Arc::new(error.to_string())));
                self.file.abandon();
                Err(error)
            }
        }
    }

    fn record(&mut self, shared: &Shared) -> io::Result<()> {
        let (mut flushed, mut checked) = (Instant::now(), Instant::now());
        loop {
            let is_last = shared.stop.load(Ordering::Acquire);
            let has_ended = self.receiver.has_ended();
            let wait = FLUSH.saturating_sub(flushed.elapsed());
            let mut next = self
                .receiver
                .recv(if is_last { Duration::ZERO } else { wait });
            let is_drained = next.is_none();
            while let Some(message) = next {
                self.message(&message)?;
                let is_due = flushed.elapsed() >= FLUSH;
                next = if is_due {
                    None
                } else {
                    self.receiver.try_recv()
                };
            }
            if flushed.elapsed() >= FLUSH || is_last {
                self.file.flush()?;
                self.count(shared, flushed.elapsed());
                flushed = Instant::now();
            }
            if checked.elapsed() >= SPACE_CHECK {
                checked = Instant::now();
                check_space(&self.partial, self.min_free_bytes).map_err(io::Error::other)?;
            }
            if is_drained && (is_last || has_ended) {
                self.file.flush()?;
                self.count(shared, Duration::ZERO);
                return Ok(());
            }
            if let Some(fault) = shared.fault.load().as_deref() {
                return Err(io::Error::other(fault.clone()));
            }
        }
    }

    fn message(&mut self, message: &Message) -> io::Result<()> {
        if let Message::Frame(frame) = message {
            let mut json = std::mem::take(&mut self.json);
            write_frame(frame, &mut json);
            let done = self.put(Topic::Gauges, frame.t_host_ns, json.as_bytes());
            self.json = json;
            self.n_frames += 1;
            return done;
        }
        match device_json(message) {
            Some(json) => self.put(
                Topic::Device,
                self.clock.now_ns(),
                json.to_string().as_bytes(),
            ),
            None => Ok(()),
        }
    }

    fn put(&mut self, topic: Topic, t_host_ns: u64, json: &[u8]) -> io::Result<()> {
        let log_time = t_host_ns.wrapping_add(self.wall_offset_ns);
        self.sequence = self.sequence.wrapping_add(1);
        self.file.write(topic, self.sequence, log_time, json)
    }

    fn count(&self, shared: &Shared, flush: Duration) {
        let us = u64::try_from(flush.as_micros()).unwrap_or(u64::MAX);
        shared.n_frames.store(self.n_frames, Ordering::Relaxed);
        shared.n_bytes.store(self.file.len(), Ordering::Relaxed);
        shared
            .n_dropped
            .store(self.receiver.n_dropped(), Ordering::Relaxed);
        shared.worst_flush_us.fetch_max(us, Ordering::Relaxed);
    }
}

fn keep_syncing(file: &File, shared: &Shared) {
    while !shared.done.load(Ordering::Acquire) {
        let start = Instant::now();
        match file.sync_data() {
            // A pipe or a device that has nothing to sync.
            Err(error) if error.kind() == io::ErrorKind::InvalidInput => {}
            Err(error) => {
                shared.fault.store(Some(Arc::new(error.to_string())));
                return;
            }
            Ok(()) => {}
        }
        std::thread::sleep(
            SYNC.saturating_sub(start.elapsed())
                .max(Duration::from_millis(5)),
        );
    }
}

fn check_calibration(json: Option<&[u8]>) -> Result<(), DaqError> {
    let Some(json) = json else { return Ok(()) };
    let parsed = serde_json::from_slice::<serde_json::Map<String, serde_json::Value>>(json);
    parsed
        .map(|_| ())
        .map_err(|error| DaqError::BadCalibration {
            message: error.to_string(),
        })
}

fn check_space(path: &Path, needed_bytes: u64) -> Result<(), DaqError> {
    let stat = rustix::fs::statvfs(path).map_err(|error| DaqError::File {
        action: "asking for free space at",
        path: path.to_owned(),
        source: error.into(),
    })?;
    let free_bytes = stat.f_bavail.saturating_mul(stat.f_frsize);
    if free_bytes >= needed_bytes {
        return Ok(());
    }
    Err(DaqError::DiskFull {
        path: path.to_owned(),
        free_bytes,
        needed_bytes,
    })
}

fn thread<T: Send + 'static>(
    name: &str,
    run: impl FnOnce() -> T + Send + 'static,
) -> Result<JoinHandle<T>, DaqError> {
    std::thread::Builder::new()
        .name(name.to_owned())
        .spawn(run)
        .map_err(|source| DaqError::Thread { source })
}
