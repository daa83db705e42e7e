//! A scene as a dozen lines of JSON, and text files.

use std::path::Path;

use hapdef_mesh::atomic_write;
use serde_json::Value;

use crate::error::HapdefError;

/// A JSON object whose fields have a line each, and of `gauges.sites` each gauge.
pub(super) fn scene_text(fields: &[(&str, Value)], sites: &[Value]) -> String {
    let mut lines: Vec<String> =
        fields.iter().map(|(name, value)| format!("  \"{name}\": {}", on_a_line(value))).collect();
    let sites: Vec<String> = sites.iter().map(|site| format!("    {}", on_a_line(site))).collect();
    lines.push(format!("  \"gauges\": {{\"sites\": [\n{}\n  ]}}", sites.join(",\n")));
    format!("{{\n{}\n}}\n", lines.join(",\n"))
}

fn on_a_line(value: &Value) -> String {
    match value {
        Value::Array(items) => {
            format!("[{}]", items.iter().map(on_a_line).collect::<Vec<_>>().join(", "))
        }
        Value::Object(fields) => {
            let field =
                |(name, value): (&String, &Value)| format!("\"{name}\": {}", on_a_line(value));
            format!("{{{}}}", fields.iter().map(field).collect::<Vec<_>>().join(", "))
        }
        other => other.to_string(),
    }
}

pub(super) fn write_text(path: &Path, text: &str) -> Result<(), HapdefError> {
    atomic_write(path, |file| std::io::Write::write_all(file, text.as_bytes()))
        .map_err(HapdefError::file(path))
}
