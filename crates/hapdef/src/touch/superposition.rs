//! Contacts by superposition, as the scene asks for it.

use std::sync::Arc;

use hapdef_inverse::{BELIEVED_OF_RANGE, EstimatorParams, ResponseMap, WideParams, tip_ring_m};
pub(super) use hapdef_live::estimator::friction_rms;
use hapdef_live::estimator::{Superposition, SuperpositionSettings};

use crate::error::HapdefError;
use crate::scene::{Scene, SuperpositionSpec};

/// The estimator that the scene's section asks for, on the limb's response `map`.
///
/// # Errors
/// [`HapdefError::Live`] when the map has fewer than three gauges or a value can't be used.
pub fn superposition(
    scene: &Scene,
    spec: &SuperpositionSpec,
    map: ResponseMap,
) -> Result<Superposition, HapdefError> {
    let settings = estimator_settings(scene, spec);
    Ok(Superposition::new(settings.estimator(Arc::new(map), Vec::new())?))
}

/// The scene's section as the runtime has it, for a map that was not calibrated.
#[must_use]
pub fn estimator_settings(scene: &Scene, spec: &SuperpositionSpec) -> SuperpositionSettings {
    let params = estimator_params(scene);
    SuperpositionSettings {
        noise_ue: spec.noise_ue,
        map_error: spec.map_error,
        place_factor: 1.0,
        friction: spec.friction,
        tip_ring_m: tip_ring_m(spec.widest_tip_m, scene.contact.tip_radius_m),
        tip_radius_m: scene.contact.tip_radius_m,
        palm_radius_m: spec.palm_radius_m,
        n_sites: spec.n_sites,
        max_contacts: params.max_contacts,
        max_force_n: params.max_force_n,
    }
}

/// Parameters of the estimator for a scene: no more contacts than the scene has, and no force beyond
/// half more than its strongest, which a contact of where the map is uncertain would else explain
/// anything with.
#[must_use]
pub fn estimator_params(scene: &Scene) -> EstimatorParams {
    EstimatorParams {
        max_contacts: scene.contact.max_contacts,
        max_force_n: BELIEVED_OF_RANGE * scene.contact.force_range_n[1],
        wide: WideParams::up_to(
            scene.estimator.superposition().palm_radius_m,
            scene.contact.tip_radius_m,
        ),
        ..EstimatorParams::default()
    }
}
