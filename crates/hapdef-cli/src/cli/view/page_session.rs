//! Who sits at the page: shows what is newest, does what people ask for.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use anyhow::Result;
use hapdef_cli::shown;
use hapdef_contact::printable;
use hapdef_daq::record::PlayerControl;
use hapdef_live::{LiveControl, LiveFrame};
use hapdef_view::{Ranges, ViewCommand, ViewHandle};

use super::Shared;
use super::first_paint::FirstPaint;
use super::opener::PageOpener;
use super::show::Show;
use super::sink::lock;
use super::snapshots::{Shown, Snapshots};
use super::virtual_press::VirtualPress;
use crate::cli::live_record::{LiveRecorder, LiveRecorderState};

/// How often it looks for commands and presses anew.
const LOOK: Duration = Duration::from_millis(5);
/// Between frames of the page.
const PERIOD: Duration = Duration::from_millis(15);
/// Between frames of the page where nothing new came: its health goes on.
const SLOW_PERIOD: Duration = Duration::from_millis(250);

/// The page with frames; it ends when this is dropped.
pub(crate) struct PageSession {
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

/// What the page's thread works with.
pub(super) struct Attendant {
    pub(super) handle: ViewHandle,
    pub(super) shared: Arc<Shared>,
    pub(super) show: Show,
    pub(super) snapshots: Snapshots,
    pub(super) control: LiveControl,
    pub(super) virtual_press: Option<VirtualPress>,
    pub(super) recorder: Option<LiveRecorder>,
    pub(super) player: Option<PlayerControl>,
    /// Where the page's first pictures are reported.
    pub(super) first: Option<FirstPaint>,
    pub(super) pace: Pace,
    /// What lines on the terminal begin with.
    pub(super) begin: String,
    /// The page's way in for a program that opens it.
    pub(super) _opener: Option<PageOpener>,
}

/// What was shown when.
#[derive(Default)]
pub(super) struct Pace {
    at: Option<Instant>,
    n_frames: u64,
    is_failure_told: bool,
    /// The next recording begins when the one that failed is put away.
    starts_next: bool,
    frame: Option<LiveFrame>,
    shown: Shown,
}

impl PageSession {
    pub(super) fn start(mut attendant: Attendant) -> Self {
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = Arc::clone(&stop);
        let attend = move || {
            while !stopped.load(Ordering::Relaxed) {
                attendant.step();
                std::thread::sleep(LOOK);
            }
        };
        Self { stop, thread: Some(std::thread::spawn(attend)) }
    }
}

impl Drop for PageSession {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

impl Attendant {
    fn step(&mut self) {
        let commands: Vec<ViewCommand> = self.handle.commands().try_iter().collect();
        for command in commands {
            self.obey(command);
        }
        if let Some(virtual_press) = &mut self.virtual_press {
            virtual_press.step(self.shared.is_tared.load(Ordering::Relaxed));
        }
        self.tell_of_recordings();
        if let Err(error) = self.show_newest() {
            self.say(&error.to_string());
        }
        if let Some(first) = &mut self.first
            && let Err(error) = first.look(&self.handle.clients())
        {
            self.say(&format!("{error:#}"));
        }
    }

    /// Shows the newest frame; the same one again, with what became of everything else, where none
    /// comes.
    fn show_newest(&mut self) -> Result<()> {
        let pace = &mut self.pace;
        let since = pace.at.map_or(Duration::MAX, |at| at.elapsed());
        if since < PERIOD {
            return Ok(());
        }
        let (is_new, ranges, health, device, silence) = {
            let mut newest = lock(&self.shared.newest);
            let is_new = newest.n_frames != pace.n_frames;
            let n_frames = newest.n_frames;
            let ranges =
                if is_new { std::mem::take(&mut newest.ranges) } else { Ranges::default() };
            if let Some(frame) = newest.frame.as_ref().filter(|_| is_new) {
                pace.n_frames = n_frames;
                pace.frame
                    .get_or_insert_with(|| LiveFrame::new(frame.raw_ue.len()))
                    .copy_from(frame);
            }
            (is_new, ranges, newest.health.clone(), newest.device.clone(), newest.silence)
        };
        self.handle.set_device(&device);
        let Some(frame) = &pace.frame else {
            return Ok(());
        };
        if !is_new && since < SLOW_PERIOD {
            return Ok(());
        }
        pace.at = Some(Instant::now());
        if is_new {
            let t_s = self.show.take(frame, &ranges);
            if let Some(virtual_press) = &self.virtual_press {
                self.show.take_truth(&virtual_press.truth(frame.seq));
            }
            pace.shown.add(t_s, frame);
        }
        if let Some(status) = silence {
            self.show.take_silence(status);
        }
        if device.fault.is_some() {
            self.show.lose();
        }
        if let Some(health) = health {
            self.show.take_health(&health);
        }
        let state = self.recorder.as_ref().map_or(LiveRecorderState::Off, LiveRecorder::state);
        self.show.take_recording(&state);
        let number = self.show.push()?;
        let (has_contact, has_colours) = self.show.has_contact_and_colours();
        if let Some(first) = &mut self.first {
            first.shown(number, has_contact, has_colours);
        }
        Ok(())
    }

    /// What became of recordings that were asked for.
    fn tell_of_recordings(&mut self) {
        let Some(recorder) = self.recorder.clone() else {
            return;
        };
        let failure = match recorder.state() {
            LiveRecorderState::Failed { why } if !self.pace.is_failure_told => Some(why),
            _ => None,
        };
        if let Some(why) = failure {
            self.pace.is_failure_told = true;
            self.say(&format!("The recording stopped: {why}"));
        }
        let Some(ended) = recorder.ended() else { return };
        if std::mem::take(&mut self.pace.starts_next) {
            self.record_anew(&recorder);
            return;
        }
        match ended {
            Ok(found) => self.say(&found),
            Err(error) => self.say(&error.to_string()),
        }
    }

    /// Tells the page and the terminal; lost where nobody reads it any more.
    fn say(&self, text: &str) {
        self.handle.say(text);
        eprintln!("{}{}", self.begin, printable(text));
    }

    fn obey(&mut self, command: ViewCommand) {
        match command {
            ViewCommand::Tare => {
                self.shared.is_tared.store(false, Ordering::Relaxed);
                // the virtual hand lets go before, not somewhere within the tare
                if let Some(virtual_press) = &mut self.virtual_press {
                    virtual_press.step(false);
                }
                self.control.tare();
                self.handle.say("Taring: touch nothing");
            }
            ViewCommand::Press { finger, point_m, force_n, .. } => {
                if let Some(virtual_press) = &mut self.virtual_press {
                    virtual_press.press(finger, point_m, force_n);
                }
            }
            ViewCommand::Lift { finger } => {
                if let Some(virtual_press) = &mut self.virtual_press {
                    virtual_press.lift(finger);
                }
            }
            ViewCommand::Random(on) => {
                if let Some(virtual_press) = &mut self.virtual_press {
                    virtual_press.set_random(on);
                }
            }
            ViewCommand::Release => {
                if let Some(virtual_press) = &mut self.virtual_press {
                    virtual_press.release();
                }
            }
            ViewCommand::Record(on) => self.record(on),
            ViewCommand::Snapshot { t_s } => self.snapshot(t_s),
            ViewCommand::Pause(on) => {
                if let Some(player) = &self.player {
                    player.pause(on);
                    self.show.take_pause(on);
                    self.pace.at = None;
                }
            }
            ViewCommand::Seek { position_s } => {
                if let Some(player) = &self.player {
                    player.seek(position_s);
                }
            }
        }
    }

    fn record(&mut self, on: bool) {
        let Some(recorder) = self.recorder.clone() else {
            return;
        };
        match (on, recorder.state()) {
            (true, LiveRecorderState::On { .. }) => {}
            (true, LiveRecorderState::Off) => self.record_anew(&recorder),
            (_, state) => {
                // One that failed has to be put away before the next.
                self.pace.starts_next = on && matches!(state, LiveRecorderState::Failed { .. });
                recorder.stop();
            }
        }
    }

    fn record_anew(&mut self, recorder: &LiveRecorder) {
        self.pace.is_failure_told = false;
        let started = self.snapshots.recording().and_then(|path| {
            recorder.start(&path)?;
            Ok(path)
        });
        match started {
            Ok(path) => self.say(&format!("Recording to {}", shown(&path))),
            Err(error) => self.say(&format!("Not recording: {error:#}")),
        }
    }

    fn snapshot(&self, t_s: Option<f64>) {
        let recording = self.recorder.as_ref().and_then(LiveRecorder::path);
        let shown = self.pace.shown.at(t_s);
        let device = lock(&self.shared.newest).device.clone();
        let kept =
            shown.and_then(|shown| self.snapshots.snapshot(shown, &device, recording.as_deref()));
        let text = match kept {
            Ok(path) => format!("Kept in {}", Path::display(&path)),
            Err(error) => format!("Not kept: {error:#}"),
        };
        self.say(&text);
    }
}
