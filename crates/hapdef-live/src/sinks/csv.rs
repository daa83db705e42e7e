//! Frames as a table.

use std::fmt::Write as _;
use std::io::Write;

use hapdef_contact::{UnknownReason, WhyNot};

use crate::error::AnyError;
use crate::frame::LiveFrame;
use crate::sink::{Delivery, Sink, Wants};

/// Contacts that have columns.
const N_CONTACTS: usize = 4;

/// Frames that wait for a slow disk.
const N_QUEUED: usize = 4096;

/// Writes a row a frame: number, time, phase with why it is unknown, whether the contacts are stale, how good
/// the explanation is, tared readings, then id, place and force of up to four contacts; their number is
/// that of all.
pub struct CsvSink<W> {
    out: W,
    row: String,
    has_names: bool,
}

impl<W: Write + Send> CsvSink<W> {
    /// A sink that writes to `out`.
    pub fn new(out: W) -> Self {
        Self { out, row: String::with_capacity(1024), has_names: false }
    }
}

impl<W: Write + Send> Sink for CsvSink<W> {
    fn name(&self) -> String {
        "csv".to_owned()
    }

    fn wants(&self) -> Wants {
        Wants::CONTACTS
    }

    fn delivery(&self) -> Delivery {
        Delivery::Queue(N_QUEUED)
    }

    fn frame(&mut self, frame: &LiveFrame) -> Result<(), AnyError> {
        self.row.clear();
        if !std::mem::replace(&mut self.has_names, true) {
            names(frame.tared_ue.len(), &mut self.row)?;
        }
        row(frame, &mut self.row)?;
        Ok(self.out.write_all(self.row.as_bytes())?)
    }

    fn finish(&mut self) -> Result<(), AnyError> {
        Ok(self.out.flush()?)
    }
}

fn names(n_gauges: usize, out: &mut String) -> std::fmt::Result {
    out.push_str("seq,t_device_us,t_host_ns,phase,why_unknown,is_stale,why_not_identified,p_value");
    for gauge in 0..n_gauges {
        write!(out, ",g{gauge}_ue")?;
    }
    out.push_str(",n_contacts");
    for i in 1..=N_CONTACTS {
        write!(out, ",id{i},x{i}_m,y{i}_m,z{i}_m,force{i}_n")?;
    }
    out.push('\n');
    Ok(())
}

fn row(frame: &LiveFrame, out: &mut String) -> std::fmt::Result {
    let why_unknown = frame.phase.why_unknown().map_or("", UnknownReason::word);
    let (phase, is_stale) = (frame.phase.word(), u8::from(frame.is_stale));
    let (seq, device_us, host_ns) = (frame.seq, frame.t_device_us, frame.t_host_ns);
    write!(out, "{seq},{device_us},{host_ns},{phase},{why_unknown},{is_stale}")?;
    match &frame.touch.quality {
        Some(quality) => {
            let why_not = quality.why_not().map_or("", WhyNot::word);
            write!(out, ",{why_not},{}", quality.p_value)?;
        }
        None => out.push_str(",,"),
    }
    for reading in &frame.tared_ue {
        write!(out, ",{reading}")?;
    }
    write!(out, ",{}", frame.touch.contacts.len())?;
    for i in 0..N_CONTACTS {
        match frame.touch.contacts.get(i) {
            Some(contact) => {
                let [x, y, z] = contact.position_m.coords.into();
                let id = contact.id.map_or(String::new(), |id| id.to_string());
                write!(out, ",{id},{x},{y},{z},{}", contact.force_n)?;
            }
            None => out.push_str(",,,,,"),
        }
    }
    out.push('\n');
    Ok(())
}
