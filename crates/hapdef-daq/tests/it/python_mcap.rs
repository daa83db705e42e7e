//! A recording read by Python's mcap, value for value.
//!
//! Skipped without it. HAPDEF_PYTHON names the interpreter; `pip install mcap` makes one that can.

use crate::support;

use std::process::Command;

use support::recorded::{frames, recorded};

const SCRIPT: &str = r#"
import json, sys
from mcap.reader import make_reader
with open(sys.argv[1], "rb") as stream:
    reader = make_reader(stream, validate_crcs=True)
    print("channels", sorted(c.topic for c in reader.get_summary().channels.values()))
    for schema, channel, message in reader.iter_messages(topics=["/gauges"]):
        assert schema.encoding == "jsonschema" and json.loads(schema.data)["type"] == "object"
        print(message.log_time, *json.loads(message.data)["values"])
"#;

#[test]
fn python_reads_what_was_recorded() {
    let python = std::env::var("HAPDEF_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let has_mcap = Command::new(&python).args(["-c", "import mcap"]).output();
    if !has_mcap.is_ok_and(|output| output.status.success()) {
        println!("skipped: {python} has no module mcap");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("press.mcap");
    recorded(&path, 1000);
    let output = Command::new(&python).args(["-c", SCRIPT]).arg(&path).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    let mut lines = text.lines();
    let channels = lines.next().unwrap();
    assert_eq!(channels, "channels ['/calibration', '/device', '/gauges']");
    let expected = frames(&path).into_iter().map(|(time, frame)| {
        let values = frame.bits().iter().map(ToString::to_string);
        format!("{time} {}", values.collect::<Vec<_>>().join(" "))
    });
    assert!(lines.eq(expected));
}
