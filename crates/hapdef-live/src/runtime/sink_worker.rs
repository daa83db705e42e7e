//! From the computing thread to a sink on its own thread, without locks that last and without heap.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{JoinHandle, Thread};
use std::time::{Duration, Instant};

use rtrb::{Consumer, Producer, RingBuffer};

use super::outlet::Outlet;
use super::spawn;
use crate::error::{AnyError, LiveError};
use crate::frame::{LiveFrame, Missed};
use crate::health::SinkHealth;
use crate::histogram::Histogram;
use crate::sink::{Clients, Delivery, LiveEvent, Sink, Wants};

/// Events that wait for a sink at most.
const N_EVENTS: usize = 256;

/// Longest sleep of a sink's thread, so that the end is seen whatever happens.
const NAP: Duration = Duration::from_millis(100);

/// How often a lossless runtime looks whether a sink has room, or has ended.
const LOOK: Duration = Duration::from_micros(50);

/// A sink, seen from the computing thread.
pub(super) struct SinkWorker {
    path: Path,
    wants: Wants,
    events: Option<SyncSender<LiveEvent>>,
    thread: Option<Thread>,
    counts: Arc<Counts>,
    is_lossless: bool,
}

/// A sink's thread.
pub(super) struct SinkThread {
    handle: JoinHandle<()>,
    counts: Arc<Counts>,
}

enum Path {
    Direct(Box<dyn Sink>),
    Latest {
        slot: Arc<Mutex<Slot>>,
        spare: Box<LiveFrame>,
    },
    Queue {
        ring: Producer<Box<LiveFrame>>,
        free: Consumer<Box<LiveFrame>>,
        missed: Missed,
    },
    /// It failed.
    Closed,
}

/// The other end of a path.
enum Inlet {
    Latest { slot: Arc<Mutex<Slot>>, mine: Box<LiveFrame> },
    Queue { ring: Consumer<Box<LiveFrame>>, free: Producer<Box<LiveFrame>> },
}

struct Slot {
    frame: Box<LiveFrame>,
    is_fresh: bool,
}

struct Counts {
    name: String,
    n_frames: AtomicU64,
    n_skipped: AtomicU64,
    n_events_dropped: AtomicU64,
    busy: Mutex<Histogram>,
    failure: Mutex<Option<Arc<str>>>,
    clients: Option<Clients>,
    /// There will be no more.
    end: AtomicBool,
}

impl SinkWorker {
    /// Starts the sink's thread, unless it is called directly.
    pub(super) fn start(
        sink: Box<dyn Sink>,
        n_gauges: usize,
        is_lossless: bool,
    ) -> Result<(Self, Option<SinkThread>), LiveError> {
        let (name, wants) = (sink.name(), sink.wants());
        let counts = Arc::new(Counts::new(&*sink));
        let frame = || Box::new(LiveFrame::new(n_gauges));
        let (path, inlet) = match sink.delivery() {
            Delivery::Direct => {
                let worker = Self {
                    path: Path::Direct(sink),
                    wants,
                    events: None,
                    thread: None,
                    counts,
                    is_lossless,
                };
                return Ok((worker, None));
            }
            Delivery::Latest => latest(&frame),
            Delivery::Queue(len) => queue(len.max(1), &frame),
        };
        let (events, theirs) = sync_channel(N_EVENTS);
        let in_thread = Arc::clone(&counts);
        let thread_name = format!("sink {name}");
        let handle = spawn(&thread_name, move || run(sink, inlet, &theirs, &in_thread))?;
        let worker = Self {
            path,
            wants,
            events: Some(events),
            thread: Some(handle.thread().clone()),
            counts: Arc::clone(&counts),
            is_lossless,
        };
        Ok((worker, Some(SinkThread { handle, counts })))
    }

    fn wake(&self) {
        self.thread.iter().for_each(Thread::unpark);
    }
}

impl Outlet for SinkWorker {
    fn frame(&mut self, frame: &LiveFrame, stop: &AtomicBool) {
        let is_shown = match &mut self.path {
            Path::Closed => return,
            Path::Direct(sink) => {
                let start = Instant::now();
                let taken = sink.frame(frame);
                self.counts.took(start.elapsed());
                if let Err(error) = taken {
                    self.counts.fail(&error);
                    self.path = Path::Closed;
                }
                return;
            }
            Path::Latest { slot, spare } => offer(slot, spare, frame),
            Path::Queue { ring, free, missed } => {
                if self.is_lossless {
                    let is_over = || ring.is_abandoned() || stop.load(Ordering::Relaxed);
                    while free.is_empty() && !is_over() {
                        std::thread::sleep(LOOK);
                    }
                }
                push(ring, free, missed, frame)
            }
        };
        if !is_shown {
            self.counts.n_skipped.fetch_add(1, Ordering::Relaxed);
        }
        self.wake();
    }

    fn event(&mut self, event: &LiveEvent) {
        if matches!(event, LiveEvent::Health(_)) && !self.wants.health {
            return;
        }
        if let Path::Direct(sink) = &mut self.path
            && let Err(error) = sink.event(event)
        {
            self.counts.fail(&error);
            self.path = Path::Closed;
        }
        if let Some(events) = &self.events
            && events.try_send(event.clone()).is_err()
        {
            self.counts.n_events_dropped.fetch_add(1, Ordering::Relaxed);
        }
        self.wake();
    }

    fn end(&mut self) {
        if let Path::Direct(sink) = &mut self.path
            && let Err(error) = sink.finish()
        {
            self.counts.fail(&error);
        }
        self.counts.end.store(true, Ordering::Release);
        self.wake();
    }

    fn health(&self) -> SinkHealth {
        self.counts.health()
    }
}

impl SinkThread {
    /// Waits until `deadline` for the thread to take what waits and end; how it went.
    pub(super) fn end(self, deadline: Option<Instant>) -> SinkHealth {
        // said already, unless the computing thread panicked
        self.counts.end.store(true, Ordering::Release);
        self.handle.thread().unpark();
        let is_late = || deadline.is_some_and(|deadline| Instant::now() >= deadline);
        while !self.handle.is_finished() && !is_late() {
            std::thread::sleep(Duration::from_millis(1));
        }
        if !self.handle.is_finished() {
            return SinkHealth { is_stuck: true, ..self.counts.health() };
        }
        if self.handle.join().is_err() {
            self.counts.fail(&"it panicked".into());
        }
        self.counts.health()
    }
}

impl Counts {
    fn new(sink: &dyn Sink) -> Self {
        Self {
            name: sink.name(),
            clients: sink.clients(),
            n_frames: AtomicU64::new(0),
            n_skipped: AtomicU64::new(0),
            n_events_dropped: AtomicU64::new(0),
            busy: Mutex::new(Histogram::new()),
            failure: Mutex::new(None),
            end: AtomicBool::new(false),
        }
    }

    fn took(&self, time: Duration) {
        self.n_frames.fetch_add(1, Ordering::Relaxed);
        let ns = u64::try_from(time.as_nanos()).unwrap_or(u64::MAX);
        lock(&self.busy).add(ns);
    }

    fn fail(&self, error: &AnyError) {
        *lock(&self.failure) = Some(error.to_string().into());
    }

    fn health(&self) -> SinkHealth {
        SinkHealth {
            name: self.name.clone(),
            n_frames: self.n_frames.load(Ordering::Relaxed),
            n_skipped: self.n_skipped.load(Ordering::Relaxed),
            n_events_dropped: self.n_events_dropped.load(Ordering::Relaxed),
            busy: lock(&self.busy).latency(),
            failure: lock(&self.failure).clone(),
            is_stuck: false,
            clients: self.clients.as_deref().map_or(Vec::new(), |c| lock(c).clone()),
        }
    }
}

impl Inlet {
    /// Shows the next frame to `see`, if there is one.
    fn next<T>(&mut self, see: impl FnOnce(&LiveFrame) -> T) -> Option<T> {
        match self {
            Self::Latest { slot, mine } => {
                let mut slot = lock(slot);
                if !std::mem::take(&mut slot.is_fresh) {
                    return None;
                }
                std::mem::swap(&mut slot.frame, mine);
                drop(slot);
                Some(see(mine))
            }
            Self::Queue { ring, free } => {
                let frame = ring.pop().ok()?;
                let seen = see(&frame);
                // there are as many boxes as places
                let _ = free.push(frame);
                Some(seen)
            }
        }
    }
}

fn latest(frame: &dyn Fn() -> Box<LiveFrame>) -> (Path, Inlet) {
    let slot = Arc::new(Mutex::new(Slot { frame: frame(), is_fresh: false }));
    let path = Path::Latest { slot: Arc::clone(&slot), spare: frame() };
    (path, Inlet::Latest { slot, mine: frame() })
}

fn queue(len: usize, frame: &dyn Fn() -> Box<LiveFrame>) -> (Path, Inlet) {
    let (to_sink, from_compute) = RingBuffer::new(len);
    let (mut to_compute, free) = RingBuffer::new(len);
    for _ in 0..len {
        // there are as many boxes as places
        let _ = to_compute.push(frame());
    }
    let path = Path::Queue { ring: to_sink, free, missed: Missed::default() };
    let inlet = Inlet::Queue { ring: from_compute, free: to_compute };
    (path, inlet)
}

/// Puts `frame` in place of the one in the slot; false if that one was not looked at.
fn offer(slot: &Mutex<Slot>, spare: &mut Box<LiveFrame>, frame: &LiveFrame) -> bool {
    spare.copy_from(frame);
    let mut slot = lock(slot);
    let was_fresh = std::mem::replace(&mut slot.is_fresh, true);
    if was_fresh {
        spare.add_missed(slot.frame.left_out());
    }
    std::mem::swap(&mut slot.frame, spare);
    !was_fresh
}

/// Adds `frame` to the queue; false if there is no room.
fn push(
    ring: &mut Producer<Box<LiveFrame>>,
    free: &mut Consumer<Box<LiveFrame>>,
    missed: &mut Missed,
    frame: &LiveFrame,
) -> bool {
    let Ok(mut place) = free.pop() else {
        missed.add(frame.left_out());
        return false;
    };
    place.copy_from(frame);
    place.add_missed(std::mem::take(missed));
    ring.push(place).is_ok()
}

fn run(mut sink: Box<dyn Sink>, inlet: Inlet, events: &Receiver<LiveEvent>, counts: &Counts) {
    if let Err(error) = serve(sink.as_mut(), inlet, events, counts) {
        counts.fail(&error);
    }
}

fn serve(
    sink: &mut dyn Sink,
    mut inlet: Inlet,
    events: &Receiver<LiveEvent>,
    counts: &Counts,
) -> Result<(), AnyError> {
    loop {
        let is_last = counts.end.load(Ordering::Acquire);
        let mut is_idle = true;
        while let Ok(event) = events.try_recv() {
            is_idle = false;
            sink.event(&event)?;
        }
        let start = Instant::now();
        if let Some(taken) = inlet.next(|frame| sink.frame(frame)) {
            is_idle = false;
            counts.took(start.elapsed());
            taken?;
        }
        if is_idle && is_last {
            return sink.finish();
        }
        if is_idle {
            std::thread::park_timeout(NAP);
        }
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
