//! Frames in words, for people.

use std::fmt::Write as _;
use std::io::Write;
use std::time::{Duration, Instant};

use hapdef_contact::{Contact, TouchPhase, printable};

use crate::error::AnyError;
use crate::frame::LiveFrame;
use crate::sink::{Delivery, LiveEvent, Sink, Wants};

/// Time between two refreshes of the line.
const REFRESH: Duration = Duration::from_millis(50);

/// Time between two lines of a limb where a person reads those of several.
const READABLE: Duration = Duration::from_millis(500);

/// Frames that wait for a slow reader of lines.
const N_QUEUED: usize = 4096;

/// Frames in words: one line that is refreshed, or a line a frame; what happens beside frames on
/// lines of its own.
pub struct TextSink<W> {
    out: W,
    pace: Pace,
    /// What lines begin with.
    begin: String,
    line: String,
    /// Letters of the line that is shown.
    n_shown: usize,
    shown: Option<Instant>,
}

/// Which frames have a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Pace {
    /// The newest, on a line that is refreshed.
    Refreshed,
    /// The newest, as often as a person reads on.
    Readable,
    /// All.
    Each,
}

impl<W: Write + Send> TextSink<W> {
    /// One line that is refreshed 20 times a second, for a terminal.
    pub fn refreshed(out: W) -> Self {
        Self {
            out,
            pace: Pace::Refreshed,
            begin: String::new(),
            line: String::with_capacity(256),
            n_shown: 0,
            shown: None,
        }
    }

    /// A line a frame, for files and pipes.
    pub fn lines(out: W) -> Self {
        Self { pace: Pace::Each, ..Self::refreshed(out) }
    }

    /// The same for a limb of several, whose lines begin with its name; a terminal gets two lines a second in place
    /// of one that is refreshed.
    #[must_use]
    pub fn of_limb(self, name: &str) -> Self {
        let pace = match self.pace {
            Pace::Refreshed => Pace::Readable,
            pace => pace,
        };
        Self { pace, begin: format!("{name}: "), ..self }
    }

    /// A line that stays.
    fn say(&mut self, words: std::fmt::Arguments<'_>) -> Result<(), AnyError> {
        self.wipe()?;
        writeln!(self.out, "{}{}", self.begin, printable(&words.to_string()))?;
        Ok(self.out.flush()?)
    }

    /// Takes the refreshed line away.
    fn wipe(&mut self) -> Result<(), AnyError> {
        if self.n_shown > 0 {
            write!(self.out, "\r{:1$}\r", "", self.n_shown)?;
            self.n_shown = 0;
        }
        Ok(())
    }
}

impl<W: Write + Send> Sink for TextSink<W> {
    fn name(&self) -> String {
        "text".to_owned()
    }

    fn wants(&self) -> Wants {
        Wants { uncertainty: true, health: true, ..Wants::CONTACTS }
    }

    fn delivery(&self) -> Delivery {
        if self.pace == Pace::Each { Delivery::Queue(N_QUEUED) } else { Delivery::Latest }
    }

    fn frame(&mut self, frame: &LiveFrame) -> Result<(), AnyError> {
        let least = match self.pace {
            Pace::Refreshed => REFRESH,
            Pace::Readable => READABLE,
            Pace::Each => Duration::ZERO,
        };
        if self.shown.is_some_and(|shown| shown.elapsed() < least) {
            return Ok(());
        }
        self.line.clear();
        self.line.push_str(&self.begin);
        in_words(frame, &mut self.line)?;
        if self.pace == Pace::Each {
            writeln!(self.out, "{}", self.line)?;
            return Ok(());
        }
        self.shown = Some(Instant::now());
        if self.pace == Pace::Readable {
            writeln!(self.out, "{}", self.line)?;
            return Ok(self.out.flush()?);
        }
        let n = self.line.chars().count();
        write!(self.out, "\r{:1$}", self.line, self.n_shown.max(n))?;
        self.n_shown = n;
        Ok(self.out.flush()?)
    }

    fn event(&mut self, event: &LiveEvent) -> Result<(), AnyError> {
        match event {
            LiveEvent::Hello(hello) => {
                let (n, hz) = (hello.channels.len(), f64::from(hello.rate_mhz) * 1e-3);
                self.say(format_args!("device: {n} channels, {hz} Hz"))
            }
            LiveEvent::Restarted => self.say(format_args!("the device started anew")),
            LiveEvent::Link(state) => self.say(format_args!("link: {state}")),
            LiveEvent::Log(text) => self.say(format_args!("device says: {text}")),
            LiveEvent::Tared => self.say(format_args!("tared")),
            LiveEvent::TareFault(fault) => self.say(format_args!("{fault}")),
            LiveEvent::Health(health) => self.say(format_args!("{health}")),
            LiveEvent::Phase(status) => {
                let (phase, s) = (status.phase, status.silent_s);
                self.say(format_args!(
                    "{phase}, {} contacts, no readings for {s:.1} s",
                    status.n_contacts
                ))
            }
            LiveEvent::Status(_) => Ok(()),
        }
    }

    fn finish(&mut self) -> Result<(), AnyError> {
        self.wipe()?;
        Ok(self.out.flush()?)
    }
}

fn in_words(frame: &LiveFrame, out: &mut String) -> std::fmt::Result {
    write!(out, "{:10.3} s ", frame.t_device_us as f64 * 1e-6)?;
    match frame.phase {
        TouchPhase::Taring | TouchPhase::Unknown(_) => return write!(out, "{}", frame.phase),
        _ if frame.touch.contacts.is_empty() => return write!(out, "nothing touches"),
        _ => {}
    }
    for (i, contact) in frame.touch.contacts.iter().enumerate() {
        out.push_str(if i == 0 { "" } else { " · " });
        contact_in_words(contact, out)?;
    }
    match frame.touch.quality {
        Some(quality) if !quality.is_identified() => write!(out, " (not decided)"),
        _ => Ok(()),
    }
}

fn contact_in_words(contact: &Contact, out: &mut String) -> std::fmt::Result {
    if let Some(id) = contact.id {
        write!(out, "#{id} ")?;
    }
    let [x, y, z] = (contact.position_m.coords * 1e3).into();
    write!(out, "{:.2} N at ({x:.1}, {y:.1}, {z:.1}) mm", contact.force_n)?;
    match &contact.uncertainty {
        Some(sure) => {
            write!(out, " ±{:.1} mm ±{:.2} N", sure.position_sd_m() * 1e3, sure.force_sd_n())
        }
        None => Ok(()),
    }
}
