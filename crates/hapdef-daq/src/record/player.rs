//! A recording that is looked at: it can be stopped, and gone to any time of.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use super::messages::Messages;
use super::recording::Recording;
use crate::source::{FrameSource, SourceStats, SourceStatus};
use crate::{DaqError, Message};

/// Frames handed out in one turn at most.
const N_AT_ONCE: u64 = 256;
/// What is handed out before a place that was gone to, without waiting, so that whoever follows
/// contacts has found them there.
const LEAD_NS: u64 = 300_000_000;
/// Longest sleep while it is stopped.
const NAP: Duration = Duration::from_millis(5);

/// Plays a recording at the pace of its frames' times, for people who look at it. Unlike
/// [`crate::source::ReplaySource`] it does not end: behind the last frame it waits to be sent back.
///
/// After going elsewhere it says [`Message::Restarted`], because times and numbers don't go on, then
/// what the device is, then the frames of the 0.3 s before that place at once.
pub struct Player {
    path: PathBuf,
    speed: f64,
    messages: Messages,
    next: Option<Timed>,
    /// Moment and time of the first frame since it goes on.
    start: Option<(Instant, u64)>,
    is_at_end: bool,
    shared: Arc<Shared>,
    stats: SourceStats,
}

/// Stops a [`Player`] and sends it elsewhere, from any thread.
#[derive(Clone)]
pub struct PlayerControl {
    shared: Arc<Shared>,
}

/// A message with its time on the wall clock, ns.
type Timed = (u64, Message);

struct Shared {
    /// Times of the first and the last frame on the wall clock, ns.
    span_ns: (u64, u64),
    is_paused: AtomicBool,
    seek_s: Mutex<Option<f64>>,
    /// Wall clock less host time of the frames.
    wall_offset_ns: AtomicU64,
}

impl Player {
    /// Opens a recording and looks through it for its length. `speed` is as with
    /// [`crate::source::ReplaySource`].
    ///
    /// # Errors
    /// A file that can't be read, or has no frame.
    pub fn open(path: &Path, speed: f64) -> Result<Self, DaqError> {
        Recording::open(path)?.with_first_chunk()?;
        let span = Recording::open(path)?.span_ns()?;
        let span_ns = span.ok_or_else(|| DaqError::NoFrames { path: path.to_owned() })?;
        Ok(Self {
            path: path.to_owned(),
            speed,
            messages: Messages::new(Recording::open(path)?),
            next: None,
            start: None,
            is_at_end: false,
            shared: Arc::new(Shared {
                span_ns,
                is_paused: AtomicBool::new(false),
                seek_s: Mutex::new(None),
                wall_offset_ns: AtomicU64::new(0),
            }),
            stats: SourceStats::default(),
        })
    }

    /// What stops it and sends it elsewhere.
    #[must_use]
    pub fn control(&self) -> PlayerControl {
        PlayerControl { shared: Arc::clone(&self.shared) }
    }

    fn next_message(&mut self) -> Option<Timed> {
        self.next.take().or_else(|| self.messages.next())
    }

    fn hand_out(&mut self, (time_ns, message): Timed, sink: &mut dyn FnMut(Message)) {
        if let Message::Frame(frame) = &message {
            self.stats.n_frames += 1;
            self.stats.losses.n_delivered += 1;
            self.stats.losses.n_lost += u64::from(frame.n_lost_before);
            let offset_ns = time_ns.wrapping_sub(frame.t_host_ns);
            let shared = &self.shared;
            shared.wall_offset_ns.store(offset_ns, Ordering::Relaxed);
        }
        sink(message);
    }

    /// Goes to a time from the first frame: what is handed out last is the last frame not after it.
    fn go_to(&mut self, position_s: f64, sink: &mut dyn FnMut(Message)) {
        let (first_ns, last_ns) = self.shared.span_ns;
        let target_ns = first_ns + (position_s.max(0.0) * 1e9).round() as u64;
        let target_ns = target_ns.min(last_ns);
        let from_ns = target_ns.saturating_sub(LEAD_NS);
        let opened = Recording::open(&self.path);
        let Ok(recording) = opened.map(|recording| recording.with_frames_from(from_ns)) else {
            self.is_at_end = true;
            return;
        };
        (self.messages, self.next, self.start) = (Messages::new(recording), None, None);
        self.is_at_end = false;
        sink(Message::Restarted);
        while let Some((time_ns, message)) = self.next_message() {
            match message {
                Message::Frame(_) if time_ns > target_ns => {
                    self.next = Some((time_ns, message));
                    return;
                }
                Message::Frame(_) | Message::Hello(_) => self.hand_out((time_ns, message), sink),
                _ if time_ns >= from_ns => sink(message),
                _ => {}
            }
        }
        self.is_at_end = true;
    }

    /// Time until a message is due.
    fn wait(&mut self, time_ns: u64, message: &Message) -> Duration {
        let is_paced = self.speed > 0.0 && self.speed.is_finite();
        if !is_paced || !matches!(message, Message::Frame(_)) {
            return Duration::ZERO;
        }
        let now = Instant::now();
        let (start, first_ns) = *self.start.get_or_insert((now, time_ns));
        let after_s = time_ns.saturating_sub(first_ns) as f64 * 1e-9 / self.speed;
        let due = Duration::try_from_secs_f64(after_s).unwrap_or(Duration::MAX);
        due.saturating_sub(now - start)
    }
}

impl FrameSource for Player {
    fn poll(&mut self, timeout: Duration, sink: &mut dyn FnMut(Message)) -> SourceStatus {
        if let Some(position_s) = self.shared.take_seek() {
            self.go_to(position_s, sink);
            return SourceStatus::Open;
        }
        if self.is_at_end || self.shared.is_paused.load(Ordering::Relaxed) {
            self.start = None;
            std::thread::sleep(timeout.min(NAP));
            return SourceStatus::Open;
        }
        let deadline = Instant::now() + timeout;
        for _ in 0..N_AT_ONCE {
            let Some((time_ns, message)) = self.next_message() else {
                self.is_at_end = true;
                break;
            };
            let wait = self.wait(time_ns, &message);
            let left = deadline.saturating_duration_since(Instant::now());
            std::thread::sleep(wait.min(left));
            if wait > left {
                self.next = Some((time_ns, message));
                break;
            }
            self.hand_out((time_ns, message), sink);
        }
        SourceStatus::Open
    }

    fn stats(&self) -> SourceStats {
        self.stats
    }

    fn name(&self) -> String {
        format!("replay:{}", self.path.display())
    }
}

impl PlayerControl {
    /// Stops it where it is, or lets it go on.
    pub fn pause(&self, on: bool) {
        self.shared.is_paused.store(on, Ordering::Relaxed);
    }

    /// Sends it to a time from the first frame, s, whether it is stopped or not; only the last of
    /// several wishes counts.
    pub fn seek(&self, position_s: f64) {
        *self.shared.lock_seek() = Some(position_s);
    }

    /// Time from the first frame to the last, s.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        let (first_ns, last_ns) = self.shared.span_ns;
        last_ns.saturating_sub(first_ns) as f64 * 1e-9
    }

    /// Where in the recording a frame that it handed out is, from the first one, s, by the frame's
    /// host time.
    #[must_use]
    pub fn position_s(&self, t_host_ns: u64) -> f64 {
        let offset_ns = self.shared.wall_offset_ns.load(Ordering::Relaxed);
        let time_ns = t_host_ns.wrapping_add(offset_ns);
        time_ns.saturating_sub(self.shared.span_ns.0) as f64 * 1e-9
    }
}

impl Shared {
    fn lock_seek(&self) -> std::sync::MutexGuard<'_, Option<f64>> {
        self.seek_s.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn take_seek(&self) -> Option<f64> {
        self.lock_seek().take()
    }
}
