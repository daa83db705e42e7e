//! Other programs on the same weights: ONNX Runtime and PyTorch, by way of Python.

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use anyhow::{Context, Result, bail};
use hapdef_nets::{Activation, Net};
use serde::Deserialize;
use serde_json::json;

use super::clock::Times;

/// The script, as it was when this program was built.
const SCRIPT: &str = include_str!("../../scripts/nets_peers.py");

/// A running Python that times its rows when told to.
pub(super) struct Peers {
    child: Child,
    folder: PathBuf,
    to: ChildStdin,
    from: BufReader<ChildStdout>,
    /// Why rows are missing, by name.
    pub(super) missing: BTreeMap<String, String>,
    /// What each row is, its error and its times.
    pub(super) rows: BTreeMap<String, Peer>,
}

/// One row.
pub(super) struct Peer {
    /// Program and version.
    pub(super) program: String,
    /// Largest error over the largest output.
    pub(super) relative_error: f64,
    pub(super) times: Times,
}

/// What Python says first.
#[derive(Deserialize)]
struct Ready {
    rows: BTreeMap<String, ReadyRow>,
    missing: BTreeMap<String, String>,
}

#[derive(Deserialize)]
struct ReadyRow {
    program: String,
    relative_error: f64,
}

impl Peers {
    /// Writes the nets' weights, an input and its outputs to `folder`, and starts Python there.
    pub(super) fn start(
        python: &Path,
        folder: &Path,
        nets: [&Net; 2],
        x: &[f32],
        y: &[f32],
    ) -> Result<Self> {
        std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
        export(folder, nets, x, y)?;
        let script = folder.join("nets_peers.py");
        std::fs::write(&script, SCRIPT).with_context(|| script.display().to_string())?;
        let mut child = Command::new(python)
            .arg(&script)
            .arg(folder)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .with_context(|| format!("starting {}", python.display()))?;
        let to = child.stdin.take().context("Python's input")?;
        let from = BufReader::new(child.stdout.take().context("Python's output")?);
        let mut peers = Self {
            child,
            folder: folder.to_path_buf(),
            to,
            from,
            missing: BTreeMap::new(),
            rows: BTreeMap::new(),
        };
        let ready: Ready = serde_json::from_str(&peers.line()?)?;
        peers.missing = ready.missing;
        peers.rows = ready
            .rows
            .into_iter()
            .map(|(name, row)| {
                let peer = Peer {
                    program: row.program,
                    relative_error: row.relative_error,
                    times: Times::default(),
                };
                (name, peer)
            })
            .collect();
        Ok(peers)
    }

    /// Lets every row have its turn.
    pub(super) fn round(&mut self) -> Result<()> {
        writeln!(self.to, "round").context("telling Python")?;
        let times: BTreeMap<String, Vec<f64>> = serde_json::from_str(&self.line()?)?;
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
        writeln!(self.to, "frames {row}").context("telling Python")?;
        let said = self.line()?;
        if said.trim() != "done" {
            bail!("{row}: {}", said.trim());
        }
        let path = self.folder.join("outputs.f32");
        let bytes = std::fs::read(&path).with_context(|| path.display().to_string())?;
        let values = bytes.as_chunks::<4>().0.iter();
        Ok(values.map(|bytes| f32::from_le_bytes(*bytes)).collect())
    }

    fn line(&mut self) -> Result<String> {
        let mut line = String::new();
        if self.from.read_line(&mut line).context("hearing Python")? == 0 {
            bail!("Python ended: {}", self.child.wait()?);
        }
        Ok(line)
    }
}

impl Drop for Peers {
    /// Python ends when its input does.
    fn drop(&mut self) {
        let _ = writeln!(self.to, "end");
        let _ = self.child.wait();
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
