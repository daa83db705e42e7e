//! The estimator that a scene chooses.

use hapdef_inverse::{ContactEstimator, OtherLoads, TrackerParams};
use hapdef_live::estimator::{
    EstimatorKind, PaperChain, SearchPlace, Superposition, TouchEstimator, Tracking,
};

use super::learned_loads::scene_loads;
use super::{Calibration, other_loads, response_with_loads, superposition};
use crate::cache::Stage;
use crate::error::HapdefError;
use crate::limb::Limb;
use crate::run::Run;
use crate::scene::Scene;
use crate::stages::{
    Datasets, NetKind, TrainedNets, compliance, datasets, rig, train_kinds, trained_chain,
};

/// Makes the scene's estimator of each frame on its own, and no more than it needs: by superposition
/// one adjoint solve for each gauge, or none with a calibration; the paper's chain the compliance, the
/// datasets and its three nets, from the cache where they are.
///
/// # Errors
/// What the first step that fails returns.
pub fn touch_estimator(run: &Run, limb: &Limb) -> Result<Box<dyn TouchEstimator>, HapdefError> {
    live_estimator(run, limb, run.scene.estimator.kind(), SearchPlace::Never)
}

/// The estimator `kind`, whatever the scene chooses; superposition has the scene's settings, or the
/// defaults where the scene has none, and full searches of tracking run at `place`.
///
/// # Errors
/// As [`touch_estimator`].
pub fn live_estimator(
    run: &Run,
    limb: &Limb,
    kind: EstimatorKind,
    place: SearchPlace,
) -> Result<Box<dyn TouchEstimator>, HapdefError> {
    Ok(match kind {
        EstimatorKind::Hapdefx => Box::new(paper_chain(run, limb)?),
        EstimatorKind::Superposition => Box::new(Superposition::new(by_superposition(run, limb)?)),
        EstimatorKind::Tracking => {
            let params = tracker_params(&run.scene);
            Box::new(Tracking::new(by_superposition(run, limb)?, params, place)?)
        }
    })
}

/// Parameters of the tracker for a scene: no more contacts than the scene has.
#[must_use]
pub fn tracker_params(scene: &Scene) -> TrackerParams {
    TrackerParams { max_contacts: scene.contact.max_contacts, ..TrackerParams::default() }
}

/// The estimator by superposition on the limb's map, solved or from the scene's calibration, with the scene's
/// settings, or the defaults where the scene chooses another estimator.
///
/// # Errors
/// As [`touch_estimator`].
pub fn by_superposition(run: &Run, limb: &Limb) -> Result<ContactEstimator, HapdefError> {
    let spec = run.scene.estimator.superposition();
    let (estimator, loads) = match &spec.calibration {
        Some(path) => {
            let calibration = Calibration::read(&run.scene_dir.join(path), limb)?;
            let loads = calibrated_loads(run, limb)?;
            (calibration.estimator(&run.scene, &spec, limb)?, loads)
        }
        None => {
            run.say("solving the gauges' response");
            let (map, loads) = response_with_loads(run, limb)?;
            (superposition(&run.scene, &spec, map)?.into_estimator(), loads)
        }
    };
    Ok(if loads.is_empty() { estimator } else { estimator.with_loads(loads)? })
}

/// The loads of a calibrated scene that are no contacts.
pub(super) fn calibrated_loads(run: &Run, limb: &Limb) -> Result<OtherLoads, HapdefError> {
    scene_loads(run, |spec, error| {
        run.say("solving the gauges' response to loads that are no contacts");
        other_loads(limb, &limb.sites, &limb.gauges, spec, error, run.threads)
    })
}

/// The stages behind the paper's chain.
#[derive(Clone, Debug)]
pub struct ChainStages {
    /// The limb's compliance.
    pub compliance: Stage,
    /// The rig's response.
    pub rig: Stage,
    /// The datasets.
    pub data: Datasets,
    /// F_T, F_R on all sets, and F_S.
    pub nets: TrainedNets,
}

/// Runs the stages that the paper's chain needs, and no others.
///
/// # Errors
/// What the first stage that fails returns.
pub fn chain_stages(run: &Run, limb: &Limb) -> Result<ChainStages, HapdefError> {
    let compliance = compliance(run, limb)?;
    let rig = rig(run, limb, &compliance)?;
    let data = datasets(run, limb, &compliance, &rig)?;
    let n_sets = data.simulated.len();
    let kinds = [NetKind::Transfer, NetKind::Reconstruction { n_sets }, NetKind::Sensitivity];
    let nets = train_kinds(run, limb, &compliance, &data, &kinds)?;
    Ok(ChainStages { compliance, rig, data, nets })
}

fn paper_chain(run: &Run, limb: &Limb) -> Result<PaperChain, HapdefError> {
    let ChainStages { data, nets, .. } = chain_stages(run, limb)?;
    let chain = trained_chain(run, limb, &data, &nets)?;
    let contact = &run.scene.contact;
    Ok(PaperChain::new(chain, contact.max_contacts, contact.force_range_n[1]))
}
