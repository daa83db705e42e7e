//! What is written under which topic, as JSON that other tools read.

use std::fmt::Write;
use std::sync::Arc;

use serde_json::{Value, json};

use crate::hdp1::{FrameFlags, Hello, SampleFormat, Status};
use crate::{Frame, Message};

/// A topic. Its number is the channel's and the schema's, in every recording the same, so that
/// messages can be distinguished even where the definitions are damaged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Topic {
    /// Readings.
    Gauges = 1,
    /// The device: HELLO, STATUS, restarts, its log, the link.
    Device = 2,
    /// The calibration record.
    Calibration = 3,
}

pub(crate) const TOPICS: [Topic; 3] = [Topic::Gauges, Topic::Device, Topic::Calibration];

const GAUGES_SCHEMA: &str = r#"{
  "title": "hapdef.Gauges",
  "description": "One reading of all channels, as sent: counts, or the device's unit for f32",
  "type": "object",
  "properties": {
    "seq": {"type": "integer", "description": "number of the packet"},
    "scan": {"type": "integer", "description": "place in the packet"},
    "flags": {"type": "integer", "description": "1 overrun before, 2 saturated, 4 bridge fault, 8 first after boot, 16 time of arrival as the device's clock was not believed"},
    "format": {"type": "string", "enum": ["i16", "u16", "i24", "i32", "f32"]},
    "lost_before": {"type": "integer", "description": "packets missing directly before, on the link or in the device"},
    "dropped_before": {"type": "integer", "description": "frames directly before that the host dropped"},
    "t_device_us": {"type": "integer", "description": "device time, us"},
    "t_host_ns": {"type": "integer", "description": "host time on its monotonic clock, ns"},
    "values": {"type": "array", "items": {"type": "number"}, "description": "one a channel; a string holds the bits of an f32 that is not finite"}
  }
}"#;

const DEVICE_SCHEMA: &str = r#"{
  "title": "hapdef.Device",
  "description": "What the device and the link to it say",
  "type": "object",
  "properties": {
    "kind": {"type": "string", "enum": ["session", "hello", "status", "restarted", "log", "link", "round_trip"]}
  }
}"#;

const CALIBRATION_SCHEMA: &str = r#"{
  "title": "hapdef.Calibration",
  "description": "The calibration that was in use, as it was given",
  "type": "object"
}"#;

impl Topic {
    pub(crate) fn id(self) -> u16 {
        self as u16
    }

    pub(crate) fn of(id: u16) -> Option<Self> {
        TOPICS.into_iter().find(|topic| topic.id() == id)
    }

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Gauges => "/gauges",
            Self::Device => "/device",
            Self::Calibration => "/calibration",
        }
    }

    pub(crate) fn schema(self) -> (&'static str, &'static str) {
        match self {
            Self::Gauges => ("hapdef.Gauges", GAUGES_SCHEMA),
            Self::Device => ("hapdef.Device", DEVICE_SCHEMA),
            Self::Calibration => ("hapdef.Calibration", CALIBRATION_SCHEMA),
        }
    }
}

const FORMATS: [(SampleFormat, &str); 5] = [
    (SampleFormat::I16, "i16"),
    (SampleFormat::U16, "u16"),
    (SampleFormat::I24, "i24"),
    (SampleFormat::I32, "i32"),
    (SampleFormat::F32, "f32"),
];

/// Writes a frame's JSON; every bit comes back.
pub(crate) fn write_frame(frame: &Frame, out: &mut String) {
    let name = FORMATS.iter().find(|(format, _)| *format == frame.format);
    out.clear();
    // Writing to a String does not fail.
    let _ = write!(
        out,
        "{{\"seq\":{},\"scan\":{},\"flags\":{},\"format\":\"{}\",\"lost_before\":{},\
         \"dropped_before\":{},\"t_device_us\":{},\"t_host_ns\":{},\"values\":[",
        frame.seq,
        frame.scan,
        frame.flags.bits(),
        name.map_or("", |(_, name)| name),
        frame.n_lost_before,
        frame.n_dropped_before,
        frame.t_device_us,
        frame.t_host_ns,
    );
    for (i, &bits) in frame.bits().iter().enumerate() {
        let comma = if i > 0 { "," } else { "" };
        let value = f64::from(f32::from_bits(bits.cast_unsigned()));
        let _ = match frame.format {
            SampleFormat::F32 if value.is_finite() => write!(out, "{comma}{value:?}"),
            SampleFormat::F32 => write!(out, "{comma}\"{:08x}\"", bits.cast_unsigned()),
            _ => write!(out, "{comma}{bits}"),
        };
    }
    out.push_str("]}");
}

/// A frame from its JSON; `None` if it is none of ours.
pub(crate) fn read_frame(json: &[u8]) -> Option<Frame> {
    let value: Value = serde_json::from_slice(json).ok()?;
    let name = value["format"].as_str()?;
    let (format, _) = FORMATS.iter().find(|(_, n)| *n == name)?;
    let number = |key: &str| value[key].as_u64();
    let small = |key: &str| u32::try_from(number(key)?).ok();
    let samples: Option<Vec<i32>> =
        value["values"].as_array()?.iter().map(|v| bits(*format, v)).collect();
    let samples = samples.filter(|s| s.len() <= crate::hdp1::MAX_CHANNELS)?;
    let mut frame = Frame::new(small("seq")?, *format, samples);
    frame.scan = u8::try_from(number("scan")?).ok()?;
    frame.flags = FrameFlags::from_bits(u8::try_from(number("flags")?).ok()?);
    frame.n_lost_before = small("lost_before")?;
    frame.n_dropped_before = small("dropped_before")?;
    frame.t_device_us = number("t_device_us")?;
    frame.t_host_ns = number("t_host_ns")?;
    Some(frame)
}

fn bits(format: SampleFormat, value: &Value) -> Option<i32> {
    match (format, value) {
        (SampleFormat::F32, Value::String(hex)) => {
            Some(u32::from_str_radix(hex, 16).ok()?.cast_signed())
        }
        (SampleFormat::F32, _) => Some((value.as_f64()? as f32).to_bits().cast_signed()),
        _ => i32::try_from(value.as_i64()?).ok(),
    }
}

/// What a message other than a frame says on the device's topic.
pub(crate) fn device_json(message: &Message) -> Option<Value> {
    Some(match message {
        Message::Frame(_) => return None,
        Message::Hello(hello) => json!({
            "kind": "hello",
            "rate_hz": f64::from(hello.rate_mhz) / 1e3,
            "firmware": hello.firmware,
            "boot_id": hello.boot_id,
            "uid": hex(&hello.uid),
            "channels": hello.channels.iter().map(|c| c.name_text()).collect::<Vec<_>>(),
            "payload": hex(&hello.to_payload()),
        }),
        Message::Status(status) => json!({
            "kind": "status",
            "sent": status.n_sent,
            "tx_dropped": status.n_tx_dropped,
            "adc_overruns": status.n_adc_overruns,
            "rx_crc_errors": status.n_rx_crc_errors,
            "uptime_s": status.uptime_s,
            "temperature_c": f64::from(status.temperature_centi_c) / 100.0,
            "supply_v": f64::from(status.supply_mv) / 1000.0,
            "saturated": status.saturated,
            "worst_loop_us": status.worst_loop_us,
            "payload": hex(&status.to_payload()),
        }),
        Message::Restarted => json!({"kind": "restarted"}),
        Message::RoundTrip(ns) => json!({"kind": "round_trip", "ns": ns}),
        Message::Log(text) => json!({"kind": "log", "text": **text}),
        Message::Link(state) => json!({"kind": "link", "text": state.to_string()}),
    })
}

/// A message from its JSON; the link's state comes back as text.
pub(crate) fn read_device(json: &[u8]) -> Option<Message> {
    let value: Value = serde_json::from_slice(json).ok()?;
    let payload = || unhex(value["payload"].as_str()?);
    let text = || Some(Arc::<str>::from(value["text"].as_str()?));
    Some(match value["kind"].as_str()? {
        "hello" => Message::Hello(Arc::new(Hello::from_payload(&payload()?).ok()?)),
        "status" => Message::Status(Status::from_payload(&payload()?)?),
        "restarted" => Message::Restarted,
        "round_trip" => Message::RoundTrip(value["ns"].as_u64()?),
        "log" | "link" => Message::Log(text()?),
        _ => return None,
    })
}

pub(crate) fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        // Writing to a String does not fail.
        let _ = write!(text, "{byte:02x}");
        text
    })
}

fn unhex(text: &str) -> Option<Vec<u8>> {
    let pairs = text.as_bytes().chunks(2);
    pairs.map(|pair| u8::from_str_radix(std::str::from_utf8(pair).ok()?, 16).ok()).collect()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[track_caller]
    fn check(frame: &Frame) {
        let mut json = String::new();
        write_frame(frame, &mut json);
        assert_eq!(read_frame(json.as_bytes()).as_ref(), Some(frame), "{json}");
    }

    #[test]
    fn messages_come_back() {
        let mut hello = Hello::plain(3, SampleFormat::I24, 2000);
        hello.minor = 0;
        let status = Status {
            n_sent: 7,
            temperature_centi_c: -50,
            saturated: u64::MAX,
            ..Status::default()
        };
        let messages = [
            Message::Hello(Arc::new(hello)),
            Message::Status(status),
            Message::Restarted,
            Message::RoundTrip(12),
            Message::Log("a \"quoted\" µ".into()),
        ];
        for message in messages {
            let json = device_json(&message).unwrap().to_string();
            let back = read_device(json.as_bytes()).unwrap();
            assert_eq!(format!("{back:?}"), format!("{message:?}"));
        }
    }

    #[test]
    fn schemas_are_json() {
        for topic in TOPICS {
            let (name, schema) = topic.schema();
            let schema: Value = serde_json::from_str(schema).unwrap();
            assert_eq!(schema["title"], name);
            assert_eq!(Topic::of(topic.id()), Some(topic));
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(128))]

        #[test]
        fn frames_come_back_bit_for_bit(
            samples in prop::collection::vec(any::<i32>(), 0..65),
            code in 3u8..5,
            numbers in (any::<u32>(), any::<u8>(), 0u8..16, any::<u32>(), any::<u32>()),
            times in (any::<u64>(), any::<u64>()),
        ) {
            let format = SampleFormat::from_code(code).unwrap_or(SampleFormat::I32);
            let mut frame = Frame::new(numbers.0, format, samples);
            frame.scan = numbers.1;
            frame.flags = FrameFlags::from_bits(numbers.2);
            (frame.n_lost_before, frame.n_dropped_before) = (numbers.3, numbers.4);
            (frame.t_device_us, frame.t_host_ns) = times;
            check(&frame);
        }

        #[test]
        fn any_bytes_are_no_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            prop_assert!(read_frame(&bytes).is_none() && read_device(&bytes).is_none());
        }
    }
}
