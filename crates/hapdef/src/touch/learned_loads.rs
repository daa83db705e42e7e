//! Loads that are no contacts as frames showed them in which nothing touched, and the file they are kept in.

use std::io::Write;
use std::path::Path;

use hapdef_inverse::OtherLoads;
use hapdef_mesh::atomic_write;
use serde::{Deserialize, Serialize};

use crate::error::HapdefError;
use crate::run::Run;
use crate::scene::{LoadsSpec, Scene};

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
    /// Standard deviation of each gauge's noise from frame to frame, at least what was assumed `[n_gauges]`, µε.
    pub noise_ue: Vec<f64>,
    /// Frames that they were learned from.
    pub n_frames: usize,
}

impl LearnedLoads {
    /// Learns from frames in which nothing touches `[n_frames][n_gauges]`, µε, of which the first `n_still` are
    /// those of a robot that stands still: their mean is the zero. Noise and converter of each gauge are what
    /// second differences from frame to frame show, which motion hardly has, at least `noise_ue`. Later loads may be
    /// `margin` times as strong.
    ///
    /// # Errors
    /// [`HapdefError::Inverse`] for fewer frames than gauges or values that can't be used.
    pub fn learn(
        scene: &Scene,
        frames_ue: &[Vec<f64>],
        n_still: usize,
        noise_ue: f64,
        margin: f64,
    ) -> Result<Self, HapdefError> {
        let gauges: Vec<String> = scene.gauges.sites.iter().map(|site| site.name.clone()).collect();
        let (still, moving) = frames_ue.split_at(n_still.min(frames_ue.len()));
        let n = still.len().max(1) as f64;
        let of = |gauge: usize| still.iter().map(move |frame| frame[gauge]);
        let zero: Vec<f64> = (0..gauges.len()).map(|g| of(g).sum::<f64>() / n).collect();
        let noise = |g: usize| frame_noise_ue(moving, g).max(noise_ue);
        let noise_ue: Vec<f64> = (0..gauges.len()).map(noise).collect();
        let tared =
            |frame: &Vec<f64>| frame.iter().zip(&zero).map(|(v, z)| v - z).collect::<Vec<_>>();
        let tared: Vec<f64> = moving.iter().flat_map(tared).collect();
        let OtherLoads { response, sd } = OtherLoads::learned(&tared, &noise_ue, margin)?;
        let (n_frames, response_ue) = (moving.len(), response);
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

/// Standard deviation of white noise behind the second differences of a gauge: their variance is six times its own. A
/// motion of 1 Hz and 1,000 µε has second differences of 0.04 µε at 1 kHz, first ones of 6 µε.
fn frame_noise_ue(frames_ue: &[Vec<f64>], gauge: usize) -> f64 {
    let second = |w: &[Vec<f64>]| (w[0][gauge] - 2.0 * w[1][gauge] + w[2][gauge]).powi(2);
    let n = frames_ue.len().saturating_sub(2).max(1) as f64;
    (frames_ue.windows(3).map(second).sum::<f64>() / (6.0 * n)).sqrt()
}

impl From<LearnedLoads> for OtherLoads {
    fn from(LearnedLoads { response_ue, sd, .. }: LearnedLoads) -> Self {
        Self { response: response_ue, sd }
    }
}

/// The loads of a scene that are no contacts: those it learned, else as they are `computed` with the map's relative
/// error.
pub(super) fn scene_loads(
    run: &Run,
    computed: impl FnOnce(&LoadsSpec, f64) -> Result<OtherLoads, HapdefError>,
) -> Result<OtherLoads, HapdefError> {
    let Some(spec) = &run.scene.loads else {
        return Ok(OtherLoads::default());
    };
    match &spec.learned {
        Some(file) => Ok(LearnedLoads::read(&run.scene_dir.join(file), &run.scene)?.into()),
        None => computed(spec, run.scene.estimator.superposition().map_error),
    }
}
