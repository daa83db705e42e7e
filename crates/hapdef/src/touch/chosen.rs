//! The estimator that a scene chooses.

use super::{Calibration, PaperChain, Superposition, TouchEstimator, response_map, superposition};
use crate::cache::Stage;
use crate::error::HapdefError;
use crate::limb::Limb;
use crate::run::Run;
use crate::scene::EstimatorSpec;
use crate::stages::{
    Datasets, NetKind, TrainedNets, compliance, datasets, rig, train_kinds, trained_chain,
};

/// Makes the scene's estimator, and no more than it needs: by superposition one adjoint solve for
/// each gauge, or none with a calibration; the paper's chain the compliance, the datasets and its three nets, from the cache where they are.
///
/// # Errors
/// What the first step that fails returns.
pub fn touch_estimator(run: &Run, limb: &Limb) -> Result<Box<dyn TouchEstimator>, HapdefError> {
    match &run.scene.estimator {
        EstimatorSpec::Superposition(spec) => {
            if let Some(path) = &spec.calibration {
                let calibration = Calibration::read(&run.scene_dir.join(path), limb)?;
                let estimator = calibration.estimator(&run.scene, spec, limb)?;
                return Ok(Box::new(Superposition::new(estimator)));
            }
            run.say("solving the gauges' response");
            let map = response_map(limb, run.scene.contact.tip_radius_m, run.threads)?;
            Ok(Box::new(superposition(&run.scene, spec, map)?))
        }
        EstimatorSpec::Hapdefx(_) => Ok(Box::new(paper_chain(run, limb)?)),
    }
}

/// The stages behind the paper's chain.
pub(crate) struct ChainStages {
    pub(crate) compliance: Stage,
    pub(crate) rig: Stage,
    pub(crate) data: Datasets,
    pub(crate) nets: TrainedNets,
}

/// Runs the stages that the paper's chain needs, and no others.
///
/// # Errors
/// What the first stage that fails returns.
pub(crate) fn chain_stages(run: &Run, limb: &Limb) -> Result<ChainStages, HapdefError> {
    let compliance = compliance(run, limb)?;
    let rig = rig(run, limb, &compliance)?;
    let data = datasets(run, limb, &compliance, &rig)?;
    let n_sets = data.simulated.len();
    let kinds = [
        NetKind::Transfer,
        NetKind::Reconstruction { n_sets },
        NetKind::Sensitivity,
    ];
    let nets = train_kinds(run, limb, &compliance, &data, &kinds)?;
    Ok(ChainStages {
        compliance,
        rig,
        data,
        nets,
    })
}

fn paper_chain(run: &Run, limb: &Limb) -> Result<PaperChain, HapdefError> {
    let ChainStages { data, nets, .. } = chain_stages(run, limb)?;
    Ok(PaperChain::new(
        trained_chain(run, limb, &data, &nets)?,
        limb.gauges.len(),
        limb.n_surface_nodes(),
        run.scene.contact.max_contacts,
    ))
}
