//! Loads that are no contacts as frames showed them in which nothing touched, and the file they are kept in.

use std::io::Write;
use std::path::Path;

use hapdef_inverse::OtherLoads;
use hapdef_mesh::atomic_write;
use serde::{Deserialize, Serialize};

use crate::error::HapdefError;
use crate::run::Run;
use crate::scene::Scene;

/// Form of the file.
const VERSION: u32 = 1;

/// Loads that untouched frames showed.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct LearnedLoads {
    /// Form of the file; 1.
    pub version: u32,
    /// Names of the gauges `[n_gauges]`.
    pub gauges: Vec<String>,
    /// What each gauge reads for one unit of each load `[n_loads, n_gauges]`, µε: as strong as in the frames.
    pub response_ue: Vec<f64>,
    /// Standard deviation of each load that is reckoned with `[n_loads]`, in those units.
    pub sd: Vec<f64>,
    /// Standard deviation of a reading's noise that was assumed, µε.
    pub noise_ue: f64,
    /// Frames that they were learned from.
    pub n_frames: usize,
}

impl LearnedLoads {
    /// Learns from tared frames in which nothing touches `[n_frames, n_gauges]`, µε; later loads may be `margin`
    /// times as strong.
    ///
    /// # Errors
    /// [`HapdefError::Inverse`] for fewer frames than gauges or values that can't be used.
    pub fn learn(
        scene: &Scene,
        frames_ue: &[f64],
        noise_ue: f64,
        margin: f64,
    ) -> Result<Self, HapdefError> {
        let gauges: Vec<String> = scene.gauges.sites.iter().map(|site| site.name.clone()).collect();
        let n_gauges = gauges.len();
        let learned = OtherLoads::learned(frames_ue, &vec![noise_ue; n_gauges], margin)?;
        let OtherLoads { response: response_ue, sd } = learned;
        let n_frames = frames_ue.len() / n_gauges.max(1);
        Ok(Self { version: VERSION, gauges, response_ue, sd, noise_ue, n_frames })
    }

    /// How strongly each load moved the gauges: root mean square over time of the readings' length `[n_loads]`, µε.
    #[must_use]
    pub fn strengths_ue(&self) -> Vec<f64> {
        let rows = self.response_ue.chunks_exact(self.gauges.len().max(1));
        rows.map(|row| row.iter().map(|v| v * v).sum::<f64>().sqrt()).collect()
    }

    /// Writes the file.
    ///
    /// # Errors
    /// [`HapdefError::File`] when it can't be written.
    pub fn write(&self, path: &Path) -> Result<(), HapdefError> {
        let json =
            serde_json::to_vec_pretty(self).map_err(|e| HapdefError::file(path)(e.into()))?;
        atomic_write(path, |file| file.write_all(&json)).map_err(HapdefError::file(path))
    }

    /// Reads the loads of a scene.
    ///
    /// # Errors
    /// [`HapdefError::LearnedLoads`] when the file can't be read, or is of another form or layout.
    pub fn read(path: &Path, scene: &Scene) -> Result<Self, HapdefError> {
        let refused = |what: String| HapdefError::LearnedLoads { path: path.to_owned(), what };
        let bytes = std::fs::read(path).map_err(|e| refused(e.to_string()))?;
        let read: Self = serde_json::from_slice(&bytes).map_err(|e| refused(e.to_string()))?;
        let names = scene.gauges.sites.iter().map(|site| &site.name);
        if !names.eq(&read.gauges) {
            let found = read.gauges.join(", ");
            return Err(refused(format!("of other gauges than the scene's: {found}")));
        }
        let (expected, found) = (read.sd.len() * read.gauges.len(), read.response_ue.len());
        if read.version != VERSION || expected != found {
            let version = read.version;
            return Err(refused(format!(
                "version {version} with {found} numbers; expected version {VERSION} with {expected}"
            )));
        }
        Ok(read)
    }
}

impl From<LearnedLoads> for OtherLoads {
    fn from(LearnedLoads { response_ue, sd, .. }: LearnedLoads) -> Self {
        Self { response: response_ue, sd }
    }
}

/// The loads in the file that the scene names, if it does.
pub(super) fn learned_loads(run: &Run) -> Result<Option<OtherLoads>, HapdefError> {
    let file = run.scene.loads.as_ref().and_then(|loads| loads.learned.as_ref());
    let read = |file| LearnedLoads::read(&run.scene_dir.join(file), &run.scene);
    Ok(file.map(read).transpose()?.map(Into::into))
}
