//! What the gauges read for loads on the whole limb that are no contacts.

use hapdef_inverse::OtherLoads;
use hapdef_mesh::GaugeId;
use hapdef_sim::{GaugeResponse, GaugeSite, GaugeStrain, LimbLoad};

use super::model::{LimbModel, ModelGauge};
use crate::error::HapdefError;
use crate::limb::Limb;
use crate::scene::LoadsSpec;

/// The loads of `spec` on a limb, µε per unit, for any `gauges` at `sites`, whose responses are off by `relative_error`:
/// one factorisation and one adjoint solve for each gauge.
///
/// # Errors
/// [`HapdefError::Sim`] when the limb can't be solved or its flange takes no wrench;
/// [`HapdefError::ShellTemperature`].
pub fn other_loads(
    limb: &Limb,
    sites: &[GaugeSite],
    gauges: &[GaugeStrain],
    spec: &LoadsSpec,
    relative_error: f64,
    threads: usize,
) -> Result<OtherLoads, HapdefError> {
    let model = LimbModel::build(limb, threads)?;
    let gauges = model.gauges(sites, gauges)?;
    let (response, _) = model.response(&gauges)?;
    of_response(&model, &gauges, &response, spec, relative_error)
}

/// The same by the gauges' adjoint fields, µε per unit; a gauge that is not in the model
/// reads nothing.
///
/// # Errors
/// [`HapdefError::Sim`] for a flange that takes no wrench; [`HapdefError::ShellTemperature`].
pub(super) fn of_response(
    model: &LimbModel<'_>,
    gauges: &[ModelGauge],
    response: &GaugeResponse,
    spec: &LoadsSpec,
    relative_error: f64,
) -> Result<OtherLoads, HapdefError> {
    let limb = model.limb.loaded(spec);
    let mut found = OtherLoads::default();
    for (load, sd) in spec.loads() {
        if load == LimbLoad::Temperature && model.shell.is_some() {
            return Err(HapdefError::ShellTemperature);
        }
        let load = model.load(&limb.unit(load)?);
        let mut solved = (0..response.n_gauges()).map(GaugeId::from_index);
        let row = gauges.iter().map(|gauge| match gauge.as_ref().and_then(|_| solved.next()) {
            Some(gauge) => response.reading(gauge, &load) * 1e6,
            None => 0.0,
        });
        found.response.extend(row);
        found.sd.push(sd);
    }
    Ok(found.with_response_error(relative_error, gauges.len()))
}
