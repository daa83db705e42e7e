//! A response map corrected by presses, and the file it is kept in.

use std::io::{Read, Write};
use std::path::Path;
use std::sync::Arc;

use flate2::Compression;
use flate2::read::MultiGzDecoder;
use flate2::write::GzEncoder;
use hapdef_inverse::{
    Calibrated, CalibrationInfo, CalibrationParams, ContactEstimator, GainChange, ModelError,
    NoiseParams, Press, ResponseMap, ScanSites, tip_ring_m,
};
use hapdef_mesh::atomic_write;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::modes::{UncertainParams, UncertainResponse};
use super::response::touchable_skin;
use super::superposition::{estimator_params, friction_rms};
use crate::error::HapdefError;
use crate::limb::Limb;
use crate::run::Run;
use crate::scene::{Scene, SuperpositionSpec};

/// Form of the file.
const VERSION: u32 = 1;

/// Stiffness modes.
pub(crate) const N_STIFFNESS: usize = 32;

/// Scan sites at which `hapdef calibrate` tells the error, as many as a scene's scan has by default.
pub const CALIBRATION_SITES: usize = 800;

/// A calibrated map with what it rests on.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Calibration {
    /// Form of the file; 1.
    pub version: u32,
    /// Name of the scene.
    pub scene: String,
    /// Hash of the limb's deck.
    pub deck_hash: String,
    /// Hash of the presses as they were given.
    pub presses_hash: String,
    /// Presses given, and of these used.
    pub n_presses: usize,
    /// See [`Calibration::n_presses`].
    pub n_used: usize,
    /// Relative error at presses that were not used, their noise included.
    pub relative_error: f64,
    /// The same before calibration.
    pub relative_error_before: f64,
    /// Standard deviation of a reading's noise that was assumed, µε.
    pub noise_ue: f64,
    /// Number of gauges.
    pub n_gauges: usize,
    /// Scan sites at which the error is reported, spread over the skin.
    pub n_sites: usize,
    /// Reading per newton along x, y, z `[n_values, n_gauges]`, µε/N, at the nodes of the surface or at the
    /// [`hapdef_inverse::Skin::subdivided_points`] of its faces, to six digits; the tip is in it.
    pub adjoint_ue_per_n: Vec<[f32; 3]>,
    /// Covariance of the map at each site `[n_sites, n_gauges, n_gauges]`, µε²/N².
    pub site_error: Vec<f32>,
    /// Factor of a place's reported covariance, from presses that were held out; 1 in files without it.
    #[serde(default = "unchanged")]
    pub place_factor: f64,
    /// What known touches have shown of the gains since; none in files without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub since: Option<GainsSince>,
}

/// How the gauges' gains have changed since a calibration, by known touches in use.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct GainsSince {
    /// Touches that this rests on.
    pub n_touches: usize,
    /// Relative change of each gauge's gain `[n_gauges]`.
    pub gains: Vec<f64>,
    /// Its covariance `[n_gauges, n_gauges]`.
    pub covariance: Vec<f64>,
}

fn unchanged() -> f64 {
    1.0
}

/// What is known of the presses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PressQuality {
    /// Standard deviation of a reading's noise, µε.
    pub noise_ue: f64,
    /// Of a press's position along each tangent, m.
    pub position_sd_m: f64,
    /// Of its force, N.
    pub force_sd_n: f64,
}

impl Calibration {
    /// Corrects the response of the scene's gauges by presses; it is solved where the run's cache does not have it.
    ///
    /// # Errors
    /// [`HapdefError::Inverse`] for presses that can't be used; [`HapdefError::Sim`].
    pub fn fit(
        run: &Run,
        limb: &Limb,
        presses: &[Press],
        quality: &PressQuality,
        n_sites: usize,
    ) -> Result<(Self, CalibrationInfo), HapdefError> {
        let params = UncertainParams::of_scene(run, N_STIFFNESS);
        let (response, _) = UncertainResponse::kept(run, limb, &limb.sites, &limb.gauges, &params)?;
        Self::of_response(run, limb, &response, presses, quality, n_sites)
    }

    /// The same where the response is solved.
    pub(crate) fn of_response(
        run: &Run,
        limb: &Limb,
        response: &UncertainResponse,
        presses: &[Press],
        quality: &PressQuality,
        n_sites: usize,
    ) -> Result<(Self, CalibrationInfo), HapdefError> {
        let sites = ScanSites::farthest(response.map.skin(), n_sites)?;
        let n_gauges = limb.gauges.len();
        let params = CalibrationParams {
            position_sd_m: quality.position_sd_m,
            force_sd_n: quality.force_sd_n,
            n_threads: run.threads,
            ..CalibrationParams::new(vec![quality.noise_ue; n_gauges])
        };
        let modes = response.modes();
        let fitted = Calibrated::fit(&response.map, &sites, &modes, presses, &params)?;
        let adjoint = fitted.map.nodal().into_iter();
        let adjoint = adjoint.map(|v| <[f64; 3]>::from(v).map(six_digits));
        let site_error = fitted.model_error.per_site.iter().copied();
        let calibration = Self {
            version: VERSION,
            scene: run.scene.name.clone(),
            deck_hash: limb.deck_hash.clone(),
            presses_hash: hash_of(presses),
            n_presses: presses.len(),
            n_used: fitted.info.n_used,
            relative_error: fitted.info.relative_error,
            relative_error_before: fitted.info.relative_error_before,
            noise_ue: quality.noise_ue,
            n_gauges,
            n_sites: sites.len(),
            adjoint_ue_per_n: adjoint.collect(),
            site_error: site_error.map(six_digits).collect(),
            place_factor: fitted.model_error.place_factor,
            since: None,
        };
        Ok((calibration, fitted.info))
    }

    /// Writes the file, gzipped where its name ends in `.gz`.
    ///
    /// # Errors
    /// [`HapdefError::File`] when it can't be written.
    pub fn write(&self, path: &Path) -> Result<(), HapdefError> {
        let json = serde_json::to_vec(self).map_err(|e| HapdefError::file(path)(e.into()))?;
        let write = |file: &mut dyn Write| {
            if !is_gzip(path) {
                return file.write_all(&json);
            }
            let mut packed = GzEncoder::new(file, Compression::best());
            packed.write_all(&json)?;
            packed.finish().map(drop)
        };
        atomic_write(path, |file| write(file)).map_err(HapdefError::file(path))
    }

    /// Reads the calibration of a limb, gzipped or not as its name says.
    ///
    /// # Errors
    /// [`HapdefError::Calibration`] when it can't be read, or is of another form, limb or layout.
    pub fn read(path: &Path, limb: &Limb) -> Result<Self, HapdefError> {
        let refused = |what: String| HapdefError::Calibration { path: path.to_path_buf(), what };
        let bytes = read_bytes(path).map_err(|e| refused(e.to_string()))?;
        let read: Self =
            serde_json::from_slice(&bytes).map_err(|e| refused(format!("no calibration: {e}")))?;
        let (n_nodes, n_gauges) = (limb.n_surface_nodes(), limb.gauges.len());
        let subdivided = touchable_skin(limb)?.subdivided_points().len();
        let n_values = match read.adjoint_ue_per_n.len() == subdivided * n_gauges {
            true => subdivided,
            false => n_nodes,
        };
        let [n_gains, n_covariance] =
            read.since.as_ref().map_or([n_gauges, n_gauges * n_gauges], |since| {
                [since.gains.len(), since.covariance.len()]
            });
        let checks = [
            ("version", VERSION as usize, read.version as usize),
            ("n_gauges", n_gauges, read.n_gauges),
            ("adjoint_ue_per_n", n_values * n_gauges, read.adjoint_ue_per_n.len()),
            ("site_error", read.n_sites * n_gauges * n_gauges, read.site_error.len()),
            ("since.gains", n_gauges, n_gains),
            ("since.covariance", n_gauges * n_gauges, n_covariance),
        ];
        for (name, expected, found) in checks {
            if expected != found {
                return Err(refused(format!(
                    "of another scene: {name}: expected {expected}, found {found}"
                )));
            }
        }
        if read.deck_hash != limb.deck_hash {
            return Err(refused("of another limb: the deck's hash differs".into()));
        }
        Ok(read)
    }

    /// The map as the presses corrected it, and the covariance of its error at each site.
    ///
    /// # Errors
    /// [`HapdefError::Inverse`] for values that can't be used.
    pub(super) fn as_pressed(&self, limb: &Limb) -> Result<(ResponseMap, Vec<f64>), HapdefError> {
        let values = self.adjoint_ue_per_n.iter();
        let values: Vec<_> = values.map(|v| Vector3::from(*v).cast::<f64>()).collect();
        let skin = touchable_skin(limb)?;
        let map = ResponseMap::from_values(skin, self.n_gauges, &values)?;
        Ok((map, self.site_error.iter().map(|value| f64::from(*value)).collect()))
    }

    /// The same with the gains as they are now.
    ///
    /// # Errors
    /// [`HapdefError::Inverse`] for values that can't be used.
    pub(super) fn as_now(&self, limb: &Limb) -> Result<(ResponseMap, Vec<f64>), HapdefError> {
        let (map, site_error) = self.as_pressed(limb)?;
        let Some(since) = &self.since else {
            return Ok((map, site_error));
        };
        let GainsSince { gains, covariance, .. } = since.clone();
        let change = GainChange { gains, covariance };
        let sites = ScanSites::farthest(map.skin(), self.n_sites)?;
        Ok((change.map(&map)?, change.site_error(&map, &sites, &site_error)?))
    }

    /// The estimator on this map.
    ///
    /// # Errors
    /// [`HapdefError::Inverse`] for values that can't be used.
    pub fn estimator(
        &self,
        scene: &Scene,
        spec: &SuperpositionSpec,
        limb: &Limb,
    ) -> Result<ContactEstimator, HapdefError> {
        let (map, per_site) = self.as_now(limb)?;
        let sites = ScanSites::farthest(map.skin(), self.n_sites)?;
        let noise = NoiseParams {
            model_error: ModelError {
                friction_rms: friction_rms(spec.friction),
                tip_ring_m: tip_ring_m(spec.widest_tip_m, scene.contact.tip_radius_m),
                per_site,
                place_factor: self.place_factor,
                ..ModelError::default()
            },
            ..NoiseParams::uniform(self.n_gauges, spec.noise_ue)
        };
        let params = estimator_params(scene);
        Ok(ContactEstimator::new(Arc::new(map), Arc::new(sites), noise, params)?)
    }
}

/// Far beyond what presses tell, and a smaller file.
fn six_digits(value: f64) -> f32 {
    let rounded = format!("{value:.5e}").parse();
    rounded.unwrap_or(value as f32)
}

/// What is in a file, unpacked where its name ends in `.gz`.
fn read_bytes(path: &Path) -> std::io::Result<Vec<u8>> {
    let bytes = std::fs::read(path)?;
    if !is_gzip(path) {
        return Ok(bytes);
    }
    let mut unpacked = Vec::new();
    MultiGzDecoder::new(bytes.as_slice()).read_to_end(&mut unpacked)?;
    Ok(unpacked)
}

fn is_gzip(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending == "gz")
}

fn hash_of(presses: &[Press]) -> String {
    let mut hasher = blake3::Hasher::new();
    for press in presses {
        hasher.update(&(press.point.face() as u64).to_le_bytes());
        let numbers = press.point.bary();
        for value in numbers.iter().chain([&press.force_n]).chain(&press.readings) {
            hasher.update(&value.to_le_bytes());
        }
    }
    hasher.finalize().to_hex().to_string()
}
