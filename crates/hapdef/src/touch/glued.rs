//! How the response changes as gauges are moved and turned on the wall that they are glued to.

use hapdef_sim::{GaugeSite, GaugeStrain, LinearFunctional};
use nalgebra::{Rotation3, Unit, Vector3};

use super::model::{LimbModel, ModelGauge};
use crate::error::HapdefError;

/// Shift and turn that derivatives are taken over.
const SHIFT_M: f64 = 5e-4;
const TURN_RAD: f64 = 0.026;

/// A motion of a gauge on its wall.
#[derive(Clone, Copy)]
enum Motion {
    Along,
    Across,
    Turn,
}

/// Gauges at their sites: on the limb's solid, which tells their directions, and as the model has them.
pub(super) struct Gauges<'a> {
    pub(super) model: &'a LimbModel<'a>,
    pub(super) sites: &'a [GaugeSite],
    pub(super) on_solid: &'a [GaugeStrain],
    pub(super) in_model: &'a [ModelGauge],
}

impl Gauges<'_> {
    /// Every gauge moved along its axis and across it, per metre, and turned, per radian, as maps
    /// that `on_skin` makes of fields.
    pub(super) fn modes<M>(
        &self,
        on_skin: impl Fn(&[Vector3<f64>]) -> Result<M, HapdefError>,
    ) -> Result<[M; 3], HapdefError> {
        Ok([
            on_skin(&self.moved_fields(Motion::Along)?)?,
            on_skin(&self.moved_fields(Motion::Across)?)?,
            on_skin(&self.moved_fields(Motion::Turn)?)?,
        ])
    }

    /// Central differences of the fields with every gauge moved, one-sided where it has no room;
    /// `[n_surface, n_gauges]`, µε/N per m or rad.
    fn moved_fields(&self, motion: Motion) -> Result<Vec<Vector3<f64>>, HapdefError> {
        let step = match motion {
            Motion::Turn => TURN_RAD,
            Motion::Along | Motion::Across => SHIFT_M,
        };
        let (up, steps_up) = self.moved(motion, step);
        let (down, steps_down) = self.moved(motion, -step);
        let ((up, _), (down, _)) = (self.model.fields(&up)?, self.model.fields(&down)?);
        let spans: Vec<f64> = steps_up.iter().zip(&steps_down).map(|(a, b)| a + b).collect();
        let slope = |(i, (up, down)): (usize, (&Vector3<f64>, &Vector3<f64>))| {
            (up - down) / spans[i % spans.len()].max(f64::MIN_POSITIVE)
        };
        Ok(up.iter().zip(&down).enumerate().map(slope).collect())
    }

    /// Every gauge moved by `step`, and how far; where it doesn't fit, as it is.
    fn moved(&self, motion: Motion, step: f64) -> (Vec<ModelGauge>, Vec<f64>) {
        let all = self.sites.iter().zip(self.on_solid).zip(self.in_model);
        let each = all.map(|((site, on_solid), in_model)| {
            let moved = self.glued(&moved_site(site, on_solid, motion, step));
            moved.map_or_else(|| (in_model.clone(), 0.0), |moved| (Some(moved), step.abs()))
        });
        each.unzip()
    }

    /// The gauge at a site; nothing where it doesn't fit.
    fn glued(&self, site: &GaugeSite) -> Option<LinearFunctional> {
        self.model.gauge_at(site).ok().flatten()
    }
}

fn moved_site(site: &GaugeSite, gauge: &GaugeStrain, motion: Motion, step: f64) -> GaugeSite {
    let across = gauge.normal().cross(&gauge.axis());
    match motion {
        Motion::Along => GaugeSite { position: site.position + gauge.axis() * step, ..*site },
        Motion::Across => GaugeSite { position: site.position + across * step, ..*site },
        Motion::Turn => GaugeSite {
            axis: Rotation3::from_axis_angle(&Unit::new_normalize(gauge.normal()), step)
                * site.axis,
            ..*site
        },
    }
}
