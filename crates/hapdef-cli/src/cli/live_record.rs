//! Everything that a source says in recordings, while others use it, too.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver as Queue, RecvTimeoutError, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use anyhow::{Result, anyhow, bail};
use hapdef_cli::shown;
use hapdef_daq::clock::{HostClock, SystemClock};
use hapdef_daq::hdp1::Hello;
use hapdef_daq::record::{RecordInfo, RecordParams, Recorder, TopicDef, TopicWriter, record};
use hapdef_daq::source::{FrameSource, SourceStats, SourceStatus};
use hapdef_daq::{AcquireParams, Acquisition, Message, acquire};
use hapdef_ros::{MessageSink, RosParams, TopicKind, topics};

/// Messages that wait for the recorder at most: 8 s at 1 kHz.
const QUEUE_LEN: usize = 8192;
/// Messages handed over in one turn at most.
const A_TURN: usize = 256;
/// What is made of the last readings is waited for so long while the source goes on.
const GRACE: Duration = Duration::from_millis(200);

/// Records a source and what is made of it, once or several times, each to a file of its own.
#[derive(Clone)]
pub(super) struct LiveRecorder {
    shared: Arc<Shared>,
}

/// A source whose messages go to a recorder, too.
pub(super) struct Tee {
    inner: Box<dyn FrameSource>,
    shared: Arc<Shared>,
}

/// Messages of ROS for a recorder.
pub(super) struct LiveRecorderSink {
    shared: Arc<Shared>,
}

/// State of a recorder.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum LiveRecorderState {
    /// Nothing is recorded.
    Off,
    /// Readings of so many seconds are recorded.
    On { recorded_s: f64 },
    /// The recording stopped, and why.
    Failed { why: String },
}

struct Shared {
    source: String,
    topics: Vec<TopicDef>,
    calibration: Option<Vec<u8>>,
    /// The disk is waited for.
    is_lossless: bool,
    /// Wall clock less monotonic clock while nothing is recorded.
    wall_offset_ns: u64,
    /// For the threads that read and that make messages: held for a moment only.
    feed: Mutex<Feed>,
    running: Mutex<Option<Running>>,
}

/// What the source's thread and the messages' thread hand over to.
#[derive(Default)]
struct Feed {
    /// What the device said it is.
    hello: Option<Arc<Hello>>,
    /// None when a recording ends: it takes messages for the readings that it has then.
    sender: Option<SyncSender<Message>>,
    topics: Option<TopicWriter>,
    /// Host times of the first and the last reading, ns.
    span_ns: Option<(u64, u64)>,
    n_missed: u64,
}

enum Running {
    On { path: PathBuf, recorder: Recorder, acquisition: Acquisition },
    Ending(JoinHandle<Result<String>>),
}

/// The recording's end of a [`Tee`].
struct TeeEnd {
    queue: Queue<Message>,
    name: String,
}

impl LiveRecorder {
    /// A recorder for `source`, with the source to use instead. Where it `is_lossless`, messages wait for the disk.
    pub(super) fn new(
        source: Box<dyn FrameSource>,
        params: &RosParams,
        calibration: Option<Vec<u8>>,
        is_lossless: bool,
    ) -> Result<(Tee, Self)> {
        let shared = Arc::new(Shared {
            source: source.name(),
            topics: topics(params)?,
            calibration,
            is_lossless,
            wall_offset_ns: SystemClock.wall_ns().wrapping_sub(SystemClock.now_ns()),
            feed: Mutex::default(),
            running: Mutex::default(),
        });
        let tee = Tee { inner: source, shared: Arc::clone(&shared) };
        Ok((tee, Self { shared }))
    }

    /// Begins a recording.
    pub(super) fn start(&self, path: &Path) -> Result<()> {
        let mut running = lock(&self.shared.running);
        if running.is_some() {
            bail!("the last recording is still being written: try again");
        }
        let (sender, queue) = sync_channel(QUEUE_LEN);
        let name = self.shared.source.clone();
        let (acquisition, receivers) = acquire(TeeEnd { queue, name }, AcquireParams::default())?;
        let receiver = receivers.into_iter().next();
        let receiver = receiver.ok_or_else(|| anyhow!("one receiver was asked for"))?;
        let params = RecordParams {
            calibration: self.shared.calibration.clone(),
            source: self.shared.source.clone(),
            topics: self.shared.topics.clone(),
            ..RecordParams::default()
        };
        let recorder = record(receiver, path, params)?;
        let mut feed = lock(&self.shared.feed);
        if let Some(hello) = &feed.hello {
            // It was said before the recording began; the queue is empty.
            let _ = sender.try_send(Message::Hello(Arc::clone(hello)));
        }
        *feed = Feed {
            hello: feed.hello.take(),
            sender: Some(sender),
            topics: Some(recorder.topics()),
            span_ns: None,
            n_missed: 0,
        };
        *running = Some(Running::On { path: path.to_owned(), recorder, acquisition });
        Ok(())
    }

    /// Ends the recording on a thread of its own; [`Self::ended`] has what became of it.
    pub(super) fn stop(&self) {
        let mut running = lock(&self.shared.running);
        *running = match running.take() {
            Some(Running::On { recorder, acquisition, .. }) => {
                lock(&self.shared.feed).sender = None;
                let shared = Arc::clone(&self.shared);
                let end = move || {
                    std::thread::sleep(GRACE);
                    shared.finish(recorder, &acquisition)
                };
                Some(Running::Ending(std::thread::spawn(end)))
            }
            other => other,
        };
    }

    /// What is in a recording that was stopped, once it is complete; or why it is not.
    pub(super) fn ended(&self) -> Option<Result<String>> {
        let mut running = lock(&self.shared.running);
        match running.take() {
            Some(Running::Ending(thread)) if thread.is_finished() => Some(joined(thread)),
            other => {
                *running = other;
                None
            }
        }
    }

    /// Ends what is recorded when everything has been said: what is in it, where there is one.
    pub(super) fn finish(&self) -> Result<Option<String>> {
        let running = lock(&self.shared.running).take();
        running
            .map(|running| match running {
                Running::Ending(thread) => joined(thread),
                Running::On { recorder, acquisition, .. } => {
                    // Whoever makes messages has ended by now: those it made are on their way.
                    lock(&self.shared.feed).sender = None;
                    self.shared.finish(recorder, &acquisition)
                }
            })
            .transpose()
    }

    pub(super) fn state(&self) -> LiveRecorderState {
        let running = lock(&self.shared.running);
        let Some(Running::On { recorder, .. }) = &*running else {
            return LiveRecorderState::Off;
        };
        if let Some(why) = recorder.stats().fault {
            let why = why.to_string();
            return LiveRecorderState::Failed { why };
        }
        let span_ns = lock(&self.shared.feed).span_ns;
        let recorded_ns = span_ns.map_or(0, |(first, last)| last.saturating_sub(first));
        LiveRecorderState::On { recorded_s: recorded_ns as f64 * 1e-9 }
    }

    /// The file that is recorded to.
    pub(super) fn path(&self) -> Option<PathBuf> {
        match &*lock(&self.shared.running) {
            Some(Running::On { path, .. }) => Some(path.clone()),
            _ => None,
        }
    }

    /// What takes messages of [`topics`] for it.
    pub(super) fn sink(&self) -> LiveRecorderSink {
        LiveRecorderSink { shared: Arc::clone(&self.shared) }
    }

    /// The wall clock at a moment of the monotonic clock, ns, as the recording maps it.
    pub(super) fn wall_ns(&self, t_host_ns: u64) -> u64 {
        let feed = lock(&self.shared.feed);
        match &feed.topics {
            Some(topics) => topics.wall_ns(t_host_ns),
            None => t_host_ns.wrapping_add(self.shared.wall_offset_ns),
        }
    }
}

impl Shared {
    fn finish(&self, recorder: Recorder, acquisition: &Acquisition) -> Result<String> {
        while !acquisition.has_ended() {
            std::thread::sleep(Duration::from_millis(5));
        }
        let n_missed = {
            let mut feed = lock(&self.feed);
            feed.topics = None;
            feed.n_missed
        };
        let info = recorder.finish()?;
        Ok(in_words(&info, info.n_dropped + n_missed))
    }
}

fn in_words(info: &RecordInfo, n_missed: u64) -> String {
    format!(
        "{}: {} readings, {} messages; missing because the disk was too slow: {n_missed}, {}",
        shown(&info.path),
        info.n_frames,
        info.n_messages,
        info.n_messages_dropped,
    )
}

fn joined(thread: JoinHandle<Result<String>>) -> Result<String> {
    let ended = thread.join();
    ended.unwrap_or_else(|_| Err(anyhow!("the thread that ends a recording has panicked")))
}

impl Feed {
    fn take(&mut self, message: &Message) {
        if let Message::Hello(hello) = message {
            self.hello = Some(Arc::clone(hello));
        }
        let Some(sender) = &self.sender else { return };
        if let Message::Frame(frame) = message {
            let t_ns = frame.t_host_ns;
            self.span_ns = Some(self.span_ns.map_or((t_ns, t_ns), |(first, _)| (first, t_ns)));
        }
        if sender.try_send(message.clone()).is_err() {
            self.n_missed += 1;
        }
    }

    /// Whether a message belongs to the readings that are recorded.
    fn has(&self, topics: &TopicWriter, stamp_ns: u64) -> bool {
        self.span_ns.is_some_and(|(first_ns, last_ns)| {
            let is_over = self.sender.is_none() && stamp_ns > topics.wall_ns(last_ns);
            stamp_ns >= topics.wall_ns(first_ns) && !is_over
        })
    }
}

impl FrameSource for Tee {
    fn poll(&mut self, timeout: Duration, sink: &mut dyn FnMut(Message)) -> SourceStatus {
        let shared = &self.shared;
        self.inner.poll(timeout, &mut |message| {
            lock(&shared.feed).take(&message);
            sink(message);
        })
    }

    fn stats(&self) -> SourceStats {
        self.inner.stats()
    }

    fn name(&self) -> String {
        self.inner.name()
    }
}

impl MessageSink for LiveRecorderSink {
    fn put(&mut self, topic: TopicKind, stamp_ns: u64, message: &[u8]) {
        let feed = lock(&self.shared.feed);
        let Some(topics) = feed.topics.as_ref().filter(|t| feed.has(t, stamp_ns)).cloned() else {
            return;
        };
        // who reads the source takes this lock for each reading
        drop(feed);
        let message = message.to_vec();
        match self.shared.is_lossless {
            true => topics.put_waiting(topic.number(), stamp_ns, message),
            false => topics.put(topic.number(), stamp_ns, message),
        };
    }

    fn wants(&self, _topic: TopicKind) -> bool {
        lock(&self.shared.feed).topics.is_some()
    }
}

impl FrameSource for TeeEnd {
    fn poll(&mut self, timeout: Duration, sink: &mut dyn FnMut(Message)) -> SourceStatus {
        match self.queue.recv_timeout(timeout) {
            Ok(message) => sink(message),
            Err(RecvTimeoutError::Timeout) => return SourceStatus::Open,
            Err(RecvTimeoutError::Disconnected) => return SourceStatus::Ended,
        }
        self.queue.try_iter().take(A_TURN).for_each(sink);
        SourceStatus::Open
    }

    fn stats(&self) -> SourceStats {
        SourceStats::default()
    }

    fn name(&self) -> String {
        self.name.clone()
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
