//! What the page asks to keep: recordings and snapshots, with names that are not taken yet.

use std::collections::VecDeque;
use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use hapdef_daq::clock::{HostClock, SystemClock};
use hapdef_live::LiveFrame;
use hapdef_live::sinks::json_line;
use hapdef_mesh::atomic_write;
use hapdef_view::DeviceState;
use serde_json::{Value, json};

/// Frames that were shown and can still be kept: as many as the page goes back.
const N_SHOWN: usize = 2400;

/// How far a frame that is asked for may be from one that is kept, s.
const SAME_FRAME_S: f64 = 0.02;

/// Where recordings and snapshots go, and what is in a snapshot beside the frame.
pub(super) struct Snapshots {
    folder: PathBuf,
    scene: String,
    gauges: Vec<String>,
}

/// Frames that were shown, by the page's time.
#[derive(Default)]
pub(super) struct Shown {
    frames: VecDeque<(f64, LiveFrame)>,
}

/// A scene's name as a name of files.
pub(super) fn stem(scene: &str) -> String {
    let word = |c: char| if c.is_ascii_alphanumeric() { c } else { '-' };
    scene.chars().map(word).collect()
}

impl Snapshots {
    pub(super) fn new(folder: &Path, scene: &str, gauges: Vec<String>) -> Self {
        Self { folder: folder.to_owned(), scene: scene.to_owned(), gauges }
    }

    /// A name for a recording, in a folder that is there.
    pub(super) fn recording(&self) -> Result<PathBuf> {
        self.free("", "mcap")
    }

    /// Writes a frame as it was shown; where.
    pub(super) fn snapshot(
        &self,
        (t_s, frame): &(f64, LiveFrame),
        device: &DeviceState,
        recording: Option<&Path>,
    ) -> Result<PathBuf> {
        let path = self.free("snapshot-", "json")?;
        let mut line = Vec::new();
        json_line(frame, &mut line).map_err(anyhow::Error::from_boxed)?;
        let shown: Value = serde_json::from_slice(&line)?;
        let snapshot = json!({
            "kind": "snapshot",
            "version": 1,
            "scene": self.scene,
            "simulated": device.is_simulated,
            "device_fault": device.fault,
            "kept_at_ns": SystemClock.wall_ns(),
            "t_s": t_s,
            "recording": recording.map(|path| path.display().to_string()),
            "gauges": self.gauges,
            "frame": shown,
        });
        let text = serde_json::to_string_pretty(&snapshot)?;
        atomic_write(&path, |file| writeln!(file, "{text}"))
            .with_context(|| format!("writing {}", path.display()))?;
        Ok(path)
    }

    /// `<scene>-<what><n>.<ending>` with the first number that is not taken; makes the folder.
    fn free(&self, what: &str, ending: &str) -> Result<PathBuf> {
        std::fs::create_dir_all(&self.folder)
            .with_context(|| format!("making {}", self.folder.display()))?;
        let stem = stem(&self.scene);
        let path = |n: u32, ending: &str| self.folder.join(format!("{stem}-{what}{n}.{ending}"));
        let is_taken =
            |n: &u32| path(*n, ending).exists() || path(*n, &format!("partial.{ending}")).exists();
        let n = (1..u32::MAX).find(|n| !is_taken(n)).unwrap_or(u32::MAX);
        Ok(path(n, ending))
    }
}

impl Shown {
    /// Adds the newest frame; a time that goes back begins anew.
    pub(super) fn add(&mut self, t_s: f64, frame: &LiveFrame) {
        if self.frames.back().is_some_and(|(last_s, _)| t_s < *last_s) {
            self.frames.clear();
        }
        let mut place = if self.frames.len() == N_SHOWN { self.frames.pop_front() } else { None }
            .unwrap_or_else(|| (t_s, LiveFrame::new(frame.raw_ue.len())));
        place.0 = t_s;
        place.1.copy_from(frame);
        self.frames.push_back(place);
    }

    /// The frame that was shown at a time, the newest without one.
    pub(super) fn at(&self, t_s: Option<f64>) -> Result<&(f64, LiveFrame)> {
        let (Some(oldest), Some(newest)) = (self.frames.front(), self.frames.back()) else {
            bail!("nothing was shown yet");
        };
        let Some(t_s) = t_s else {
            return Ok(newest);
        };
        let off = |frame: &&(f64, LiveFrame)| (frame.0 - t_s).abs();
        let nearest = self.frames.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
        nearest.filter(|frame| off(frame) <= SAME_FRAME_S).with_context(|| {
            let (from_s, to_s) = (oldest.0, newest.0);
            format!(
                "the frame at {t_s:.2} s is not there any more, frames from {from_s:.2} s to \
                     {to_s:.2} s are: go on, and snapshots the next sooner"
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_snapshot_has_what_was_shown_and_a_name_of_its_own() {
        let root = tempfile::tempdir().unwrap();
        let folder = root.path().join("not/there/yet");
        let snapshots = Snapshots::new(&folder, "my shin", vec!["a".into(), "b".into()]);
        let device = DeviceState { is_simulated: true, fault: Some("no port".into()) };
        let mut shown = Shown::default();
        assert!(shown.at(None).is_err());
        for seq in 0..2500_u32 {
            let mut frame = LiveFrame::new(2);
            (frame.seq, frame.tared_ue[1]) = (seq, f64::from(seq));
            shown.add(f64::from(seq) * 0.02, &frame);
        }
        assert_eq!(shown.at(None).unwrap().1.seq, 2499);
        assert_eq!(shown.at(Some(2.0)).unwrap().1.seq, 100);
        for gone_s in [0.0, 1.97, 50.01] {
            let refusal = shown.at(Some(gone_s)).unwrap_err().to_string();
            assert!(refusal.contains("from 2.00 s to 49.98 s"), "{refusal}");
        }
        let then = shown.at(Some(40.001)).unwrap();
        for n in 1..3 {
            let path = snapshots.snapshot(then, &device, Some(Path::new("x.mcap"))).unwrap();
            assert_eq!(path, folder.join(format!("my-shin-snapshot-{n}.json")));
            let text = std::fs::read_to_string(&path).unwrap();
            let value: Value = serde_json::from_str(&text).unwrap();
            assert_eq!(value["frame"]["seq"], 2000);
            assert_eq!(value["frame"]["tared_ue"], json!([0.0, 2000.0]));
            assert_eq!(value["gauges"], json!(["a", "b"]));
            assert_eq!(value["recording"], "x.mcap");
            assert_eq!(value["simulated"], true);
            assert_eq!(value["device_fault"], "no port");
        }
        std::fs::write(folder.join("my-shin-1.mcap"), []).unwrap();
        std::fs::write(folder.join("my-shin-2.partial.mcap"), []).unwrap();
        assert_eq!(snapshots.recording().unwrap(), folder.join("my-shin-3.mcap"));
        shown.add(1.0, &LiveFrame::new(2));
        assert!(shown.at(Some(49.0)).is_err());
        assert_eq!(shown.at(Some(1.0)).unwrap().0, 1.0);
    }
}
