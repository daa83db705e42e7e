//! The recorder: threads that write what a receiver gets.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use arc_swap::ArcSwapOption;

use super::disk::{check_space, keep_syncing};
use super::file::{CHUNK_SPAN, RecordFile, check_unclaimed, claim, partial_path, rename};
use super::further::{Puts, QUEUE_LEN, TopicWriter, queue, topics_json};
use super::params::{RecordInfo, RecordParams, RecordStats};
use super::topics::{Topic, device_json, write_frame};
use crate::clock::HostClock;
use crate::{DaqError, Message, Receiver};

const SPACE_CHECK: Duration = Duration::from_secs(1);
const BROKEN_OFF: &str = "from a recording that was broken off: save what is in it with `hapdef \
                          recover`, record to another name, or say --force to overwrite it";

/// A recording under way. Dropping it finishes the file, and an error is lost then.
pub struct Recorder {
    path: PathBuf,
    shared: Arc<Shared>,
    topics: TopicWriter,
    /// A handle of the file: nobody else writes it until it has its name.
    _claim: File,
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
    n_events_dropped: AtomicU64,
    n_messages: AtomicU64,
    n_messages_dropped: AtomicU64,
    worst_flush_us: AtomicU64,
    fault: ArcSwapOption<String>,
}

/// What the writer's thread holds.
struct Writing {
    receiver: Receiver,
    puts: Puts,
    has_topics: bool,
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
    n_messages: u64,
}

/// Starts recording to `path`, named `….partial.mcap` until it is finished.
///
/// # Errors
/// A calibration that is no JSON object, too little room on the disk, a file or thread that can't
/// be made, [`DaqError::BeingWritten`] where another program records to that name, and
/// [`DaqError::AlreadyThere`] where a recording of that name was broken off.
pub fn record(receiver: Receiver, path: &Path, params: RecordParams) -> Result<Recorder, DaqError> {
    record_by(receiver, path, params, File::sync_data)
}

/// The same with another method of waiting for the disk.
pub(super) fn record_by(
    receiver: Receiver,
    path: &Path,
    params: RecordParams,
    sync: impl Fn(&File) -> io::Result<()> + Send + 'static,
) -> Result<Recorder, DaqError> {
    let partial = partial_path(path);
    let file_error = |source| DaqError::File { action: "writing", path: partial.clone(), source };
    check_calibration(params.calibration.as_deref())?;
    check_unclaimed(path)?;
    let folder = partial.parent().filter(|p| !p.as_os_str().is_empty());
    check_space(folder.unwrap_or(Path::new(".")), params.min_free_bytes)?;
    let file = claim(&partial, (!params.overwrites).then_some(BROKEN_OFF))?;
    let handle = file.try_clone().map_err(file_error)?;
    let _claim = file.try_clone().map_err(file_error)?;
    let wall_offset_ns = params.clock.wall_ns().wrapping_sub(params.clock.now_ns());
    let (topics, puts) = queue(wall_offset_ns);
    let begun = RecordFile::begin(file, &params.topics).and_then(|file| {
        let mut writing = Writing {
            receiver,
            puts,
            has_topics: !params.topics.is_empty(),
            file,
            partial: partial.clone(),
            min_free_bytes: params.min_free_bytes,
            wall_offset_ns,
            clock: Arc::clone(&params.clock),
            json: String::new(),
            sequence: 0,
            n_frames: 0,
            n_messages: 0,
        };
        writing.open(&params)?;
        Ok(writing)
    });
    let writing = begun.map_err(|source| {
        // Nothing is in it yet, and it would be in the way of the next attempt.
        let _ = std::fs::remove_file(&partial);
        file_error(source)
    })?;
    let shared = Arc::new(Shared::default());
    let (for_writer, for_syncer) = (Arc::clone(&shared), Arc::clone(&shared));
    let writer = thread("hapdef-record", move || writing.run(&for_writer))?;
    let syncer = thread("hapdef-sync", move || {
        keep_syncing(|| sync(&handle), &for_syncer.done, &for_syncer.fault);
    })?;
    Ok(Recorder {
        path: path.to_owned(),
        shared,
        topics,
        _claim,
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
            n_events_dropped: count(&self.shared.n_events_dropped),
            n_messages: count(&self.shared.n_messages),
            n_messages_dropped: count(&self.shared.n_messages_dropped),
            worst_flush: Duration::from_micros(count(&self.shared.worst_flush_us)),
            fault: self.shared.fault.load().as_deref().map(|s| s.as_str().into()),
        }
    }

    /// Writes the further topics of [`RecordParams::topics`].
    #[must_use]
    pub fn topics(&self) -> TopicWriter {
        self.topics.clone()
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
            n_events_dropped: stats.n_events_dropped,
            n_messages: stats.n_messages,
            n_messages_dropped: stats.n_messages_dropped,
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
    fn open(&mut self, params: &RecordParams) -> io::Result<()> {
        let now_ns = self.clock.now_ns();
        let mut session = serde_json::json!({
            "kind": "session",
            "source": params.source,
            "t_host_ns": now_ns,
            "t_wall_ns": now_ns.wrapping_add(self.wall_offset_ns),
        });
        if !params.topics.is_empty() {
            session["topics"] = topics_json(&params.topics);
        }
        self.put(Topic::Device, now_ns, session.to_string().as_bytes())?;
        if let Some(json) = params.calibration.as_deref() {
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
            let wait = CHUNK_SPAN.saturating_sub(flushed.elapsed());
            let mut next = self.receiver.recv(if is_last { Duration::ZERO } else { wait });
            let is_drained = next.is_none();
            while let Some(message) = next {
                self.message(&message)?;
                let is_due = flushed.elapsed() >= CHUNK_SPAN;
                next = if is_due { None } else { self.receiver.try_recv() };
            }
            // A source that has ended leaves whoever computes from its frames time to catch up.
            let is_idle = is_drained && has_ended && !is_last && self.has_topics;
            self.further(if is_idle { CHUNK_SPAN } else { Duration::ZERO })?;
            if flushed.elapsed() >= CHUNK_SPAN || is_last {
                self.file.flush()?;
                self.count(shared, flushed.elapsed());
                flushed = Instant::now();
            }
            if checked.elapsed() >= SPACE_CHECK {
                checked = Instant::now();
                check_space(&self.partial, self.min_free_bytes).map_err(io::Error::other)?;
            }
            if is_drained && (is_last || (has_ended && !self.has_topics)) {
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
            Some(json) => self.put(Topic::Device, self.clock.now_ns(), json.to_string().as_bytes()),
            None => Ok(()),
        }
    }

    /// The messages of further topics that wait.
    fn further(&mut self, wait: Duration) -> io::Result<()> {
        let mut next = match wait {
            Duration::ZERO => self.puts.receiver.try_recv().ok(),
            wait => self.puts.receiver.recv_timeout(wait).ok(),
        };
        for _ in 0..QUEUE_LEN {
            let Some(put) = next else { break };
            self.write(put.channel, put.log_time_ns, &put.message)?;
            self.n_messages += 1;
            next = self.puts.receiver.try_recv().ok();
        }
        Ok(())
    }

    fn put(&mut self, topic: Topic, t_host_ns: u64, json: &[u8]) -> io::Result<()> {
        let log_time = t_host_ns.wrapping_add(self.wall_offset_ns);
        self.write(topic.id(), log_time, json)
    }

    fn write(&mut self, channel: u16, log_time: u64, message: &[u8]) -> io::Result<()> {
        self.sequence = self.sequence.wrapping_add(1);
        self.file.write(channel, self.sequence, log_time, message)
    }

    fn count(&self, shared: &Shared, flush: Duration) {
        let us = u64::try_from(flush.as_micros()).unwrap_or(u64::MAX);
        shared.n_frames.store(self.n_frames, Ordering::Relaxed);
        shared.n_bytes.store(self.file.len(), Ordering::Relaxed);
        shared.n_dropped.store(self.receiver.n_dropped(), Ordering::Relaxed);
        shared.n_events_dropped.store(self.receiver.n_events_dropped(), Ordering::Relaxed);
        shared.n_messages.store(self.n_messages, Ordering::Relaxed);
        let n_dropped = self.puts.n_dropped.load(Ordering::Relaxed);
        shared.n_messages_dropped.store(n_dropped, Ordering::Relaxed);
        shared.worst_flush_us.fetch_max(us, Ordering::Relaxed);
    }
}

fn check_calibration(json: Option<&[u8]>) -> Result<(), DaqError> {
    let Some(json) = json else { return Ok(()) };
    let parsed = serde_json::from_slice::<serde_json::Map<String, serde_json::Value>>(json);
    parsed.map(|_| ()).map_err(|error| DaqError::BadCalibration { message: error.to_string() })
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
