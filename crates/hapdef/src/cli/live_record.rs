//! Everything that a source says in a recording, while others use it, too.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver as Queue, RecvTimeoutError, SyncSender, sync_channel};
use std::time::Duration;

use anyhow::Result;
use hapdef_daq::record::{RecordParams, Recorder, TopicWriter, record};
use hapdef_daq::source::{FrameSource, SourceStats, SourceStatus};
use hapdef_daq::{AcquireParams, Acquisition, Message, acquire};
use hapdef_ros::{RosParams, topics};

/// Messages that wait for the recorder at most: 8 s at 1 kHz.
const QUEUE_LEN: usize = 8192;
/// Messages handed over in one turn at most.
const A_TURN: usize = 256;

/// A recording of everything that a source says, and of what is made of it.
pub(super) struct LiveRecording {
    recorder: Recorder,
    acquisition: Acquisition,
    n_missed: Arc<AtomicU64>,
}

/// A source whose messages go to a recording, too.
pub(super) struct Tee {
    inner: Box<dyn FrameSource>,
    sender: SyncSender<Message>,
    n_missed: Arc<AtomicU64>,
}

/// The recording's end of a [`Tee`].
struct TeeEnd {
    queue: Queue<Message>,
    name: String,
}

/// Records `source` to `path`: the source to use instead, and the recording, whose
/// [`LiveRecording::topics`] take what is made of the readings.
pub(super) fn recorded(
    source: Box<dyn FrameSource>,
    path: &Path,
    params: &RosParams,
    calibration: Option<Vec<u8>>,
) -> Result<(Tee, LiveRecording)> {
    let (sender, queue) = sync_channel(QUEUE_LEN);
    let name = source.name();
    let end = TeeEnd {
        queue,
        name: name.clone(),
    };
    let (acquisition, receivers) = acquire(end, AcquireParams::default())?;
    let record_params = RecordParams {
        calibration,
        source: name,
        topics: topics(params)?,
        ..RecordParams::default()
    };
    let receiver = receivers.into_iter().next();
    let receiver = receiver.ok_or_else(|| anyhow::anyhow!("one receiver was asked for"))?;
    let recorder = record(receiver, path, record_params)?;
    let n_missed = Arc::new(AtomicU64::new(0));
    let tee = Tee {
        inner: source,
        sender,
        n_missed: Arc::clone(&n_missed),
    };
    let recording = LiveRecording {
        recorder,
        acquisition,
        n_missed,
    };
    Ok((tee, recording))
}

impl LiveRecording {
    /// Takes messages of [`topics`].
    pub(super) fn topics(&self) -> TopicWriter {
        self.recorder.topics()
    }

    /// Ends the file when everything has been said, and says what is in it.
    pub(super) fn finish(self) -> Result<()> {
        // The source is gone by now: its last messages are on their way.
        while !self.acquisition.has_ended() {
            std::thread::sleep(Duration::from_millis(5));
        }
        let info = self.recorder.finish()?;
        let n_missed = info.n_dropped + self.n_missed.load(Ordering::Relaxed);
        eprintln!(
            "{}: {} readings, {} messages; missing because the disk was too slow: {n_missed}, {}",
            info.path.display(),
            info.n_frames,
            info.n_messages,
            info.n_messages_dropped,
        );
        Ok(())
    }
}

impl FrameSource for Tee {
    fn poll(&mut self, timeout: Duration, sink: &mut dyn FnMut(Message)) -> SourceStatus {
        let (sender, n_missed) = (&self.sender, &self.n_missed);
        self.inner.poll(timeout, &mut |message| {
            if sender.try_send(message.clone()).is_err() {
                n_missed.fetch_add(1, Ordering::Relaxed);
            }
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
