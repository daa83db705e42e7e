//! A scene's bundle: what a robot needs to find its contacts.

use std::collections::BTreeMap;
use std::sync::Arc;

use hapdef_inverse::{OtherLoads, ResponseMap};
use hapdef_live::estimator::{EstimatorKind, SuperpositionSettings};
use hapdef_live::{Bundle, BundleGauge, BundleInfo, BundleMode};
use nalgebra::Vector3;

use super::chosen::calibrated_loads;
use super::learned_loads::given_loads;
use super::{
    Calibration, ChainStages, UncertainParams, UncertainResponse, chain_stages, estimator_settings,
    response_with_loads,
};
use crate::error::HapdefError;
use crate::limb::Limb;
use crate::run::Run;
use crate::stages::trained_chain;

/// What a bundle has beside the map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BundleRequest {
    /// What may change the response: each gauge moved and turned, and that many stiffness modes of
    /// the limb. For a calibration on the robot.
    pub n_stiffness: Option<usize>,
    /// The paper's chain with its trained nets, even where the scene chooses another estimator.
    pub has_nets: bool,
}

/// Makes the bundle of a scene, whose file's text is `scene_json`: from its calibration where it
/// names one, else by one adjoint solve for each gauge. A scene that chooses the paper's chain has its
/// trained nets in it; they are trained where they are not.
///
/// # Errors
/// What the first step that fails returns.
pub fn make_bundle(
    run: &Run,
    limb: &Limb,
    scene_json: String,
    request: &BundleRequest,
) -> Result<Bundle, HapdefError> {
    let source = Source::of(run, limb)?;
    let outward: Vec<Vector3<f64>> = limb.directions.iter().map(|d| -d).collect();
    let info = info(run, limb, source.settings);
    let mut bundle = Bundle::new(info, Arc::new(source.map), Some(&outward))?;
    bundle.scene_json = scene_json;
    bundle.site_error = source.site_error;
    bundle.loads = source.loads;
    bundle.given = given_loads(run)?;
    bundle.calibration_json = source.calibration_json;
    if let Some(n_stiffness) = request.n_stiffness {
        bundle.modes = modes(run, limb, n_stiffness)?;
    }
    if request.has_nets || bundle.info.estimator == EstimatorKind::Hapdefx {
        bundle.nets = nets(run, limb)?;
    }
    Ok(bundle)
}

/// The map with its error and where both come from.
struct Source {
    map: ResponseMap,
    loads: OtherLoads,
    settings: SuperpositionSettings,
    site_error: Vec<f64>,
    calibration_json: Option<String>,
}

impl Source {
    fn of(run: &Run, limb: &Limb) -> Result<Self, HapdefError> {
        let spec = run.scene.estimator.superposition();
        let settings = estimator_settings(&run.scene, &spec);
        let Some(path) = &spec.calibration else {
            run.say("solving the gauges' response");
            let (map, loads) = response_with_loads(run, limb)?;
            return Ok(Self {
                map,
                loads,
                settings,
                site_error: Vec::new(),
                calibration_json: None,
            });
        };
        let calibration = Calibration::read(&run.scene_dir.join(path), limb)?;
        let (map, site_error) = calibration.as_now(limb)?;
        Ok(Self {
            map,
            loads: calibrated_loads(run, limb)?,
            settings: SuperpositionSettings {
                map_error: 0.0,
                n_sites: calibration.n_sites,
                place_factor: calibration.place_factor,
                ..settings
            },
            calibration_json: Some(summary(&calibration)),
            site_error,
        })
    }
}

fn info(run: &Run, limb: &Limb, settings: SuperpositionSettings) -> BundleInfo {
    let gauge = |entry: &crate::scene::GaugeEntry| BundleGauge {
        name: entry.name.clone(),
        position_m: entry.position_m,
        axis: entry.axis,
        scale: 1.0,
    };
    BundleInfo {
        scene: run.scene.name.clone(),
        made_by: env!("CARGO_PKG_VERSION").to_owned(),
        deck_hash: Some(limb.deck_hash.clone()),
        gauges: run.scene.gauges.sites.iter().map(gauge).collect(),
        mount_m: Some(limb.mount_m().into()),
        estimator: run.scene.estimator.kind(),
        settings,
    }
}

/// The calibration that a scene names, for the recordings made with it: what it rests on, as JSON.
///
/// # Errors
/// [`HapdefError::Calibration`] when it can't be used.
pub fn calibration_in_use(run: &Run, limb: &Limb) -> Result<Option<String>, HapdefError> {
    let path = run.scene.estimator.superposition().calibration;
    path.map(|path| Ok(summary(&Calibration::read(&run.scene_dir.join(path), limb)?))).transpose()
}

/// What a calibration rests on, without its arrays.
fn summary(calibration: &Calibration) -> String {
    let mut rests_on = serde_json::json!({
        "scene": calibration.scene,
        "presses_hash": calibration.presses_hash,
        "n_presses": calibration.n_presses,
        "n_used": calibration.n_used,
        "relative_error": calibration.relative_error,
        "relative_error_before": calibration.relative_error_before,
        "noise_ue": calibration.noise_ue,
    });
    if let Some(since) = &calibration.since {
        rests_on["since"] = serde_json::json!(since);
    }
    rests_on.to_string()
}

fn modes(run: &Run, limb: &Limb, n_stiffness: usize) -> Result<Vec<BundleMode>, HapdefError> {
    // Only the modes are used, which are solved for on the limb's own mesh.
    let params = UncertainParams { refinements: 0, ..UncertainParams::of_scene(run, n_stiffness) };
    let (response, _) = UncertainResponse::kept(run, limb, &limb.sites, &limb.gauges, &params)?;
    let mode = |mode: hapdef_inverse::ModeMap<'_>| BundleMode {
        map: mode.map.clone(),
        scope: mode.scope,
        prior_sd: mode.prior_sd,
    };
    Ok(response.modes().into_iter().map(mode).collect())
}

/// The paper's chain, its nets from the cache or trained.
fn nets(run: &Run, limb: &Limb) -> Result<BTreeMap<String, Vec<u8>>, HapdefError> {
    let ChainStages { data, nets, .. } = chain_stages(run, limb)?;
    Ok(trained_chain(run, limb, &data, &nets)?.to_files()?)
}
