//! Other programs on the same weights: ONNX Runtime and PyTorch, by way of Python.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};
use hapdef_nets::{Activation, Net};
use serde::Deserialize;
use serde_json::json;

use super::clock::Times;
use super::python::Python;

/// The script, as it was when this program was built.
const SCRIPT: &str = include_str!("../../scripts/nets_peers.py");

/// A running Python that times its rows when asked to.
pub(super) struct Peers {
    python: Python,
    folder: PathBuf,
    /// Why rows are missing, by name.
    pub(super) missing: BTreeMap<String, String>,
    /// What each row is, its error and its times.
    pub(super) rows: BTreeMap<String, Peer>,
}

/// One row, as Python says it first.
#[derive(Deserialize)]
pub(super) struct Peer {
    /// Program and version.
    pub(super) program: String,
    /// Largest error over the largest output.
    pub(super) relative_error: f64,
    #[serde(skip)]
    pub(super) times: Times,
}

/// What Python says first.
#[derive(Deserialize)]
struct Ready {
    rows: BTreeMap<String, Peer>,
    missing: BTreeMap<String, String>,
}

impl Peers {
    /// [`Self::start`], or none, and why rows are missing.
    pub(super) fn if_there(
        python: &Path,
        folder: &Path,
        nets: [&Net; 2],
        x: &[f32],
        y: &[f32],
    ) -> (Option<Self>, String) {
        match Self::start(python, folder, nets, x, y) {
            Ok(peers) => {
                let missing = peers.missing.iter().map(|(row, why)| format!("{row}: {why}"));
                let missing = missing.collect::<Vec<_>>().join("; ");
                (Some(peers), missing)
            }
            Err(error) => (None, format!("{}: {error:#}", python.display())),
        }
    }

    /// Writes the nets' weights, an input and its outputs to `folder`, and starts Python there.
    fn start(python: &Path, folder: &Path, nets: [&Net; 2], x: &[f32], y: &[f32]) -> Result<Self> {
        std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
        export(folder, nets, x, y)?;
        let script = folder.join("nets_peers.py");
        std::fs::write(&script, SCRIPT).with_context(|| script.display().to_string())?;
        let mut python = Python::start(Command::new(python).arg(&script).arg(folder))?;
        let Ready { rows, missing } = serde_json::from_str(&python.line()?)?;
        Ok(Self { python, folder: folder.to_path_buf(), missing, rows })
    }

    /// Lets every row have its turn.
    pub(super) fn round(&mut self) -> Result<()> {
        let times: BTreeMap<String, Vec<f64>> = serde_json::from_str(&self.python.ask("round")?)?;
        for (name, micros) in &times {
            if let Some(row) = self.rows.get_mut(name) {
                row.times.extend(micros);
            }
        }
        Ok(())
    }

    /// Outputs `[n, outputs]` of a row for frames `[n, inputs]`.
    pub(super) fn outputs(&mut self, row: &str, frames: &[f32]) -> Result<Vec<f32>> {
        let path = self.folder.join("frames.f32");
        let bytes: Vec<u8> = frames.iter().flat_map(|v| v.to_le_bytes()).collect();
        std::fs::write(&path, bytes).with_context(|| path.display().to_string())?;
        let said = self.python.ask(&format!("frames {row}"))?;
        if said.trim() != "done" {
            bail!("{row}: {}", said.trim());
        }
        let path = self.folder.join("outputs.f32");
        let bytes = std::fs::read(&path).with_context(|| path.display().to_string())?;
        let values = bytes.as_chunks::<4>().0.iter();
        Ok(values.map(|bytes| f32::from_le_bytes(*bytes)).collect())
    }
}

/// `weights.f32` (little-endian, layer by layer: W row-major, then b) and `nets.json`. Between the
/// nets are no scales: they must be those that change nothing.
fn export(folder: &Path, nets: [&Net; 2], x: &[f32], y: &[f32]) -> Result<()> {
    let mut bytes = Vec::new();
    let mut layers = Vec::new();
    for net in nets {
        let mlp = net.mlp();
        let last = mlp.layers().len() - 1;
        let activation = match mlp.spec().activation {
            Activation::Relu => "relu",
            Activation::Tanh => "tanh",
        };
        for (i, layer) in mlp.layers().iter().enumerate() {
            for value in layer.weights.iter().chain(&layer.bias) {
                bytes.extend(value.to_le_bytes());
            }
            let n_out = layer.bias.len();
            layers.push(json!({
                "inputs": layer.weights.len() / n_out,
                "outputs": n_out,
                "activation": (i < last).then_some(activation),
            }));
        }
    }
    let about = json!({ "layers": layers, "x": x, "y": y });
    let path = folder.join("weights.f32");
    std::fs::write(&path, bytes).with_context(|| path.display().to_string())?;
    Ok(hapdef::write_json(&folder.join("nets.json"), &about)?)
}
