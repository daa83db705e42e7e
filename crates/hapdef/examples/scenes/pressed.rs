//! A trial's scene made and pressed: readings solved forwards, load by load, and the estimator that
//! is to explain them, which stands on adjoint solves.

use std::path::Path;

use hapdef::touch::{response_map, superposition};
use hapdef::{HapdefError, Limb, Run};
use hapdef_inverse::{ContactEstimator, EstimatorParams, Skin, SkinPoint};
use hapdef_sim::{ElasticModel, ElasticParams, IsotropicMaterial, NodalLoad};
use nalgebra::{Point3, Vector3};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

use super::limb::prepared;
use super::trial::{Place, Trial};

/// Young's modulus of the forward solves, Pa: displacements go with 1/E, so that the modulus of the
/// scene comes in by that law alone.
const SOLVED_E_PA: f64 = 1e9;

/// χ² with 1 to 10 degrees of freedom that [`EstimatorParams::touch_p`] = 1e-3 and
/// [`EstimatorParams::misfit_p`] = 1e-6 of noise exceed (Abramowitz and Stegun, table 26.8, carried
/// on).
const CHI2_TOUCH: [f64; 10] =
    [10.828, 13.816, 16.266, 18.467, 20.515, 22.458, 24.322, 26.124, 27.877, 29.588];
const CHI2_MISFIT: [f64; 10] =
    [23.928, 27.631, 30.665, 33.377, 35.888, 38.258, 40.522, 42.701, 44.811, 46.863];

/// χ² of `n_dof` readings below which the estimator takes them for untouched.
pub(crate) fn chi2_touch(n_dof: usize) -> f64 {
    let touch_p = EstimatorParams::default().touch_p;
    assert!((touch_p - 1e-3).abs() < 1e-15, "another table for {touch_p}");
    CHI2_TOUCH[n_dof - 1]
}

/// χ² with `n_dof` degrees of freedom above which the estimator calls a misfit what it found.
pub(crate) fn chi2_misfit(n_dof: usize) -> f64 {
    let misfit_p = EstimatorParams::default().misfit_p;
    assert!((misfit_p - 1e-6).abs() < 1e-15, "another table for {misfit_p}");
    CHI2_MISFIT[n_dof - 1]
}

/// One press as it is.
#[derive(Clone, Debug)]
pub(crate) struct Press {
    /// m.
    pub(crate) position_m: Point3<f64>,
    /// N.
    pub(crate) force_n: f64,
    /// What it alone adds to the readings `[n_gauges]`, µε.
    pub(crate) adds_ue: Vec<f64>,
}

/// A scene's estimator and a frame of it.
pub(crate) struct Pressed {
    pub(crate) estimator: ContactEstimator,
    pub(crate) presses: Vec<Press>,
    /// `[n_gauges]`, µε.
    pub(crate) readings_ue: Vec<f64>,
    /// Standard deviation of a reading's noise, µε.
    pub(crate) noise_ue: f64,
    /// Relative error of the response map that the estimator assumes.
    pub(crate) map_error: f64,
    /// Least distance of two contacts that the scene allows, m.
    pub(crate) min_spacing_m: f64,
}

impl Pressed {
    /// Makes the scene's files in `folder`, solves it both ways, and presses it.
    pub(crate) fn new(folder: &Path, trial: &Trial) -> Result<Self, HapdefError> {
        let run = prepared(folder, trial)?;
        let limb = Limb::load(&run.scene, &run.scene_dir)?;
        let map = response_map(&limb, run.scene.contact.tip_radius_m, 1)?;
        let spec = run.scene.estimator.superposition();
        let skin = map.skin().clone();
        let estimator = superposition(&run.scene, &spec, map)?.into_estimator();
        let presses = presses(&run, &limb, &skin, trial)?;
        let noise_ue = spec.noise_ue;
        let mut readings_ue = noise(limb.gauges.len(), noise_ue, trial.seed);
        for press in &presses {
            for (reading, adds) in readings_ue.iter_mut().zip(&press.adds_ue) {
                *reading += adds;
            }
        }
        Ok(Self {
            estimator,
            presses,
            readings_ue,
            noise_ue,
            map_error: spec.map_error,
            min_spacing_m: run.scene.contact.min_spacing_m,
        })
    }
}

/// Σ (v/s)².
pub(crate) fn chi2(values: &[f64], sd: f64) -> f64 {
    values.iter().map(|v| (v / sd).powi(2)).sum()
}

/// White noise, drawn again where it is what the estimator takes for a touch: that one frame in a
/// thousand is shown by `touch_p`.
fn noise(n_gauges: usize, sd_ue: f64, seed: u64) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    loop {
        let draw = (0..n_gauges).map(|_| StandardNormal.sample(&mut rng));
        let unit: Vec<f64> = draw.collect();
        if chi2(&unit, 1.0) < chi2_touch(n_gauges) {
            return unit.into_iter().map(|v| v * sd_ue).collect();
        }
    }
}

/// The trial's presses, each with a solve of its own: the tip's pressure on the solid, the gauges'
/// strain of the displacement.
fn presses(run: &Run, limb: &Limb, skin: &Skin, trial: &Trial) -> Result<Vec<Press>, HapdefError> {
    let material = IsotropicMaterial::new(SOLVED_E_PA, trial.nu, 1000.0)?;
    let params =
        ElasticParams { n_threads: 1, ..ElasticParams::new(material, limb.clamped.clone()) };
    let model = ElasticModel::build(&limb.mesh, &params)?;
    let softer = SOLVED_E_PA / 10f64.powf(trial.log10_e_pa);
    let pressed = |place: &Place, force_n: f64| {
        let face = (place.face * skin.n_faces() as f64) as usize;
        let point = SkinPoint::new(skin, face, place.bary())?;
        let position_m = skin.position(&point);
        let (tip_m, inward) = (run.scene.contact.tip_radius_m, -skin.normal(&point));
        let load = NodalLoad::patch(&limb.mesh, &limb.skin, &position_m, tip_m, &inward)?;
        let (displacement, _) = model.solve(&load)?;
        Ok(Press {
            position_m,
            force_n,
            adds_ue: strains_ue(limb, &displacement, softer * force_n),
        })
    };
    let force_n = 10f64.powf(trial.log10_force_n);
    let second = trial.second.as_ref();
    let second = second.map(|s| pressed(&s.place, force_n * 10f64.powf(s.log10_share)));
    let first = pressed(&trial.place, force_n);
    [first].into_iter().chain(second).collect()
}

fn strains_ue(limb: &Limb, displacement: &[Vector3<f64>], scale: f64) -> Vec<f64> {
    let strains = limb.gauges.iter().map(|gauge| gauge.strain(displacement));
    strains.map(|strain| 1e6 * scale * strain).collect()
}
