//! Loads that are no contacts as frames showed them in which nothing touched, and the file they are kept in.
//!
//! Of what the device measures, each gauge's response is fitted: an inertial unit and a sensor of force need not be
//! placed, turned or scaled right for that. What they leave is learned as unknown.

use std::io::Write;
use std::path::Path;

use hapdef_inverse::OtherLoads;
use hapdef_live::{GivenLoads, LoadSignal};
use hapdef_mesh::atomic_write;
use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use crate::error::HapdefError;
use crate::run::Run;
use crate::scene::{LoadsSpec, Scene};
use crate::source::RawFrame;

/// Form of the file.
const VERSION: u32 = 1;

/// A direction of the signals counts where it moves so many times as much as their noise, squared: the response along it
/// is then off by 1 % for the signals' noise (attenuation, Fuller, Measurement Error Models, 1987, section 1.1).
const LEAST_EXCITED: f64 = 100.0;

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
    /// Signals of the device that loads are taken off by, in words `[n_signals]`; none where it has none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub signals: Vec<String>,
    /// What each gauge reads for one unit of each signal `[n_signals, n_gauges]`, µε.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub given_ue: Vec<f64>,
    /// Frames that they were learned from.
    pub n_frames: usize,
}

impl LearnedLoads {
    /// Learns from frames in which nothing touches, of which the first `n_still` are those of a robot that stands
    /// still: their mean is the zero. By the signals that the frames have, each gauge's response is fitted. Noise and
    /// converter of each gauge are what second differences from frame to frame show, which motion hardly has, at
    /// least `noise_ue`. Later loads may be `margin` times as strong.
    ///
    /// # Errors
    /// [`HapdefError::Inverse`] for fewer frames than gauges or values that can't be used.
    pub fn learn(
        scene: &Scene,
        frames: &[RawFrame],
        n_still: usize,
        noise_ue: f64,
        margin: f64,
    ) -> Result<Self, HapdefError> {
        let gauges: Vec<String> = scene.gauges.sites.iter().map(|site| site.name.clone()).collect();
        let n_still = n_still.min(frames.len());
        let mut readings = tared(frames, n_still, gauges.len(), &|frame| frame.readings_ue.clone());
        let signals: Vec<LoadSignal> =
            frames.first().map_or(Vec::new(), |f| f.signals.iter().map(|s| s.0).collect());
        let given = match signals.is_empty() || readings.nrows() == 0 {
            true => DMatrix::zeros(signals.len(), gauges.len()),
            false => {
                let amounts = |frame: &RawFrame| frame.signals.iter().map(|s| s.1).collect();
                let amounts = tared(frames, n_still, signals.len(), &amounts);
                let given = fitted(&amounts, &readings);
                readings -= amounts * &given;
                given
            }
        };
        let noise = readings.column_iter().map(|gauge| frame_noise(gauge.as_slice()).max(noise_ue));
        let noise_ue: Vec<f64> = noise.collect();
        let rest: Vec<f64> =
            readings.row_iter().flat_map(|row| row.iter().copied().collect::<Vec<_>>()).collect();
        let OtherLoads { response, sd } = OtherLoads::learned(&rest, &noise_ue, margin)?;
        Ok(Self {
            version: VERSION,
            gauges,
            response_ue: response,
            sd,
            noise_ue,
            signals: signals.iter().map(ToString::to_string).collect(),
            given_ue: given.transpose().as_slice().to_vec(),
            n_frames: readings.nrows(),
        })
    }

    /// What the device's signals say that the gauges read.
    ///
    /// # Errors
    /// [`HapdefError::LearnedLoads`] for a signal that is none, or a number too few; `path` is the file's.
    pub fn given(&self, path: &Path) -> Result<GivenLoads, HapdefError> {
        let refused = |what: String| HapdefError::LearnedLoads { path: path.to_owned(), what };
        let signals: Result<Vec<LoadSignal>, _> = self.signals.iter().map(|w| w.parse()).collect();
        let signals = signals.map_err(|e: hapdef_live::UnknownSignal| refused(e.to_string()))?;
        let (expected, found) = (signals.len() * self.gauges.len(), self.given_ue.len());
        if expected != found {
            return Err(refused(format!("{found} numbers in given_ue, expected {expected}")));
        }
        Ok(GivenLoads { signals, response_ue: self.given_ue.clone() })
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

/// Numbers of frames `[n_moving, width]` less their mean over the first `n_still`.
fn tared(
    frames: &[RawFrame],
    n_still: usize,
    width: usize,
    numbers: &dyn Fn(&RawFrame) -> Vec<f64>,
) -> DMatrix<f64> {
    let (still, moving) = frames.split_at(n_still);
    let mut zero = vec![0.0; width];
    for frame in still {
        zero.iter_mut().zip(numbers(frame)).for_each(|(sum, v)| *sum += v / n_still as f64);
    }
    let mut tared = DMatrix::zeros(moving.len(), width);
    for (mut row, frame) in tared.row_iter_mut().zip(moving) {
        row.iter_mut().zip(numbers(frame)).zip(&zero).for_each(|((to, v), z)| *to = v - z);
    }
    tared
}

/// Responses `[n_signals, n_gauges]` by which `amounts` `[n_frames, n_signals]` explain `readings` `[n_frames, n_gauges]`
/// best, in least squares, along the directions that `amounts` show above their noise; 0 along the others.
fn fitted(amounts: &DMatrix<f64>, readings: &DMatrix<f64>) -> DMatrix<f64> {
    let noise = amounts.column_iter().map(|signal| {
        // of numbers without noise, their rounding
        let rms = signal.norm() / (amounts.nrows() as f64).sqrt();
        frame_noise(signal.as_slice()).max(1e-6 * rms).max(f64::MIN_POSITIVE.sqrt())
    });
    let noise: Vec<f64> = noise.collect();
    let mut in_noise = amounts.clone();
    for (mut signal, noise) in in_noise.column_iter_mut().zip(&noise) {
        signal /= *noise;
    }
    let n = amounts.nrows() as f64;
    let seen = (in_noise.transpose() * &in_noise / n).symmetric_eigen();
    let along = in_noise.transpose() * readings / n;
    let mut response = DMatrix::zeros(amounts.ncols(), readings.ncols());
    for (variance, direction) in seen.eigenvalues.iter().zip(seen.eigenvectors.column_iter()) {
        if *variance > LEAST_EXCITED {
            response += direction * (direction.transpose() * &along) / *variance;
        }
    }
    for (mut row, noise) in response.row_iter_mut().zip(&noise) {
        row /= *noise;
    }
    response
}

/// Standard deviation of white noise behind the second differences of numbers in frames: their variance is six times its
/// own. A motion of 1 Hz and 1,000 µε has second differences of 0.04 µε at 1 kHz, first ones of 6 µε.
fn frame_noise(numbers: &[f64]) -> f64 {
    let second = |w: &[f64]| (w[0] - 2.0 * w[1] + w[2]).powi(2);
    let n = numbers.len().saturating_sub(2).max(1) as f64;
    (numbers.windows(3).map(second).sum::<f64>() / (6.0 * n)).sqrt()
}

/// What the device of a scene measures of the loads on its limb; none where the scene learned none of it.
///
/// # Errors
/// [`HapdefError::LearnedLoads`].
pub fn given_loads(run: &Run) -> Result<GivenLoads, HapdefError> {
    let Some(file) = run.scene.loads.as_ref().and_then(|loads| loads.learned.as_ref()) else {
        return Ok(GivenLoads::default());
    };
    let path = run.scene_dir.join(file);
    LearnedLoads::read(&path, &run.scene)?.given(&path)
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
