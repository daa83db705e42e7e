//! Stage: whether the limb's mesh is fine enough.

use serde_json::json;

use super::keys;
use crate::cache::Stage;
use crate::convergence::{Convergence, ConvergenceParams, convergence};
use crate::error::HapdefError;
use crate::limb::Limb;
use crate::run::Run;

/// Raise when this stage's results change for unchanged inputs.
const VERSION: u32 = 2;

/// Presses the limb on its mesh and on finer ones.
///
/// # Errors
/// As [`convergence`].
pub fn mesh_check(
    run: &Run,
    limb: &Limb,
    params: &ConvergenceParams,
) -> Result<(Stage, Convergence), HapdefError> {
    let inputs = json!({
        "version": VERSION,
        "limb": keys::limb(&run.scene, &limb.deck_hash),
        "params": keys::all_but(params, &["n_threads"]),
    });
    let stage = run.cache.stage("mesh-check", &inputs, |_| {
        run.check_stop("the mesh check")?;
        let tip_radius_m = run.scene.contact.tip_radius_m;
        let params = ConvergenceParams { n_threads: run.threads, ..*params };
        let study = convergence(limb, tip_radius_m, &params, &|text| run.say(text))?;
        serde_json::to_value(study).map_err(|error| stale(&error))
    })?;
    let study = serde_json::from_value(stage.record.info.clone()).map_err(|error| stale(&error))?;
    Ok((stage, study))
}

fn stale(error: &serde_json::Error) -> HapdefError {
    HapdefError::Stale { path: "mesh-check".into(), what: error.to_string() }
}
