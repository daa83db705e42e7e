//! Recordings as text.

use std::io::Write;
use std::sync::Arc;

use serde_json::{Value, json};

use super::recording::{Content, Record, Recording};
use super::topics::hex;
use crate::hdp1::{Hello, SampleFormat};
use crate::{DaqError, Message};

/// Writes every record as a line of JSON ([`Record::json_line`]). Returns the lines.
///
/// # Errors
/// The recording can't be read on, or `out` not be written.
pub fn export_json_lines(recording: &mut Recording, out: &mut impl Write) -> Result<u64, DaqError> {
    let mut n_lines = 0;
    while let Some(record) = recording.next_record()? {
        writeln!(out, "{}", record.json_line()).map_err(write_error)?;
        n_lines += 1;
    }
    Ok(n_lines)
}

impl Record {
    /// The record as a line of JSON: topic, time and what it says; of a further topic whose messages
    /// are no JSON the name of its schema and its bytes in hexadecimal.
    #[must_use]
    pub fn json_line(&self) -> String {
        let json = match &self.content {
            Content::Further(topic) if topic.message_encoding != "json" => {
                let bytes = json!({"schema": topic.schema_name, "hex": hex(&self.bytes)});
                bytes.to_string()
            }
            // The calibration may have been written over several lines.
            _ => String::from_utf8_lossy(&self.bytes).replace(['\n', '\r'], " "),
        };
        let (topic, time) = (Value::from(self.topic()), self.log_time_ns);
        format!("{{\"topic\":{topic},\"log_time_ns\":{time},\"message\":{json}}}")
    }
}

/// Writes the frames as a table: time, number, what is missing before, and a column a channel, as
/// sent (counts, or the device's unit for f32). A new head is written when the device changes.
/// Returns the rows.
///
/// # Errors
/// The recording can't be read on, or `out` not be written.
pub fn export_csv(recording: &mut Recording, out: &mut impl Write) -> Result<u64, DaqError> {
    let mut n_rows = 0;
    let mut hello: Option<Arc<Hello>> = None;
    let mut n_columns = None;
    while let Some(record) = recording.next_record()? {
        match record.content {
            Content::Message(Message::Hello(new)) => {
                let is_same = hello.as_ref().is_some_and(|old| old.channels == new.channels);
                n_columns = n_columns.filter(|_| is_same);
                hello = Some(new);
            }
            Content::Message(Message::Frame(frame)) => {
                let n = frame.bits().len();
                if n_columns != Some(n) {
                    n_columns = Some(n);
                    head(out, hello.as_deref(), n).map_err(write_error)?;
                }
                write!(
                    out,
                    "{},{},{},{},{},{},{}",
                    record.log_time_ns,
                    frame.t_device_us,
                    frame.seq,
                    frame.scan,
                    frame.flags.bits(),
                    frame.n_lost_before,
                    frame.n_dropped_before
                )
                .map_err(write_error)?;
                for value in frame.values() {
                    match frame.format {
                        SampleFormat::F32 => write!(out, ",{value:?}"),
                        _ => write!(out, ",{value}"),
                    }
                    .map_err(write_error)?;
                }
                writeln!(out).map_err(write_error)?;
                n_rows += 1;
            }
            _ => {}
        }
    }
    Ok(n_rows)
}

fn head(out: &mut impl Write, hello: Option<&Hello>, n: usize) -> std::io::Result<()> {
    write!(out, "log_time_ns,t_device_us,seq,scan,flags,lost_before,dropped_before")?;
    for i in 0..n {
        let channel = hello.and_then(|h| h.channels.get(i));
        match channel.map(|c| c.name_text()).filter(|name| !name.is_empty()) {
            Some(name) => write!(out, ",{}", name.replace([',', '"'], "_"))?,
            None => write!(out, ",ch{i}")?,
        }
    }
    writeln!(out)
}

fn write_error(source: std::io::Error) -> DaqError {
    DaqError::File { action: "writing", path: "the export".into(), source }
}
