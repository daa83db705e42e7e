//! What Python's readers say of a recording.

use std::fmt::Write;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

/// Runs the script, if the interpreter has the modules; says why not otherwise. One that
/// HAPDEF_PYTHON names has to have them.
pub fn read_back(modules: &str, arguments: &[&Path]) -> Option<Output> {
    let named = std::env::var("HAPDEF_PYTHON").ok();
    let is_named = named.is_some();
    let python = named.unwrap_or_else(|| "python3".to_owned());
    let import = format!("import {modules}");
    let has_modules = Command::new(&python).args(["-c", &import]).output();
    if !has_modules.is_ok_and(|output| output.status.success()) {
        assert!(!is_named, "HAPDEF_PYTHON: {python} can't {import}");
        println!("skipped: {python} can't {import}");
        return None;
    }
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../hapdef-ros/scripts/read_back.py");
    let output = Command::new(python).arg(script).args(arguments).output();
    let output = output.unwrap();
    let fault = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{fault}");
    Some(output)
}

/// Appends a value as the script prints it: fields by name, bits of floats.
pub fn flat(value: &Value, out: &mut String) {
    match value {
        Value::Null => out.push_str(" null"),
        Value::Bool(b) => write!(out, " {}", u8::from(*b)).unwrap(),
        Value::Number(n) if n.is_f64() => {
            write!(out, " {:016x}", n.as_f64().unwrap().to_bits()).unwrap();
        }
        Value::Number(n) => write!(out, " {n}").unwrap(),
        Value::String(_) => write!(out, " {value}").unwrap(),
        Value::Array(items) => items.iter().for_each(|item| flat(item, out)),
        Value::Object(fields) => {
            let mut names: Vec<_> = fields.keys().collect();
            names.sort();
            names.iter().for_each(|name| flat(&fields[*name], out));
        }
    }
}
