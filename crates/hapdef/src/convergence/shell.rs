//! The shell of a skin's wall beside the solid's meshes.

use std::time::Instant;

use hapdef_sim::LinearFunctional;
use serde::{Deserialize, Serialize};

use super::answers::Answers;
use super::differences::{Differences, norm, relative};
use super::level::{Levels, MeshLevel};
use crate::error::HapdefError;
use crate::touch::LimbModel;
use crate::wall_shell::WallShell;

/// How a shell's gauge readings agree with those of the finest solid, and so the solids' own.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct ShellAgreement {
    /// FE nodes.
    pub n_fe_nodes: usize,
    /// Equations.
    pub n_equations: usize,
    /// Seconds to factor and to solve for the gauges.
    pub build_s: f64,
    /// ‖shell − finest‖ / ‖finest‖ over the gauges, the median of the presses.
    pub median_difference: f64,
    /// The same at the worst press.
    pub worst_difference: f64,
    /// Those of the solid on the scene's mesh.
    pub solid_median_difference: f64,
    /// The same at the worst press.
    pub solid_worst_difference: f64,
    /// Each gauge over all presses.
    pub gauges: Vec<GaugeAgreement>,
}

/// A gauge of a shell beside the same on solids.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct GaugeAgreement {
    /// Root mean square of what the finest solid reads, µε/N.
    pub finest_ue_per_n: f64,
    /// ‖shell − finest‖ / ‖finest‖ over the presses.
    pub shell_difference: f64,
    /// The same of the solid on the scene's mesh.
    pub solid_difference: f64,
}

impl Levels<'_> {
    /// The shell of the limb's wall under the same presses; nothing of a deck, nor of a wall that has no
    /// shell or carries a gauge that the shell does not.
    ///
    /// # Errors
    /// [`HapdefError::Sim`].
    pub(super) fn shell(
        &self,
        solids: &[MeshLevel],
    ) -> Result<Option<ShellAgreement>, HapdefError> {
        let (limb, started) = (self.limb, Instant::now());
        let Some(wall) = &limb.wall else {
            return Ok(None);
        };
        let Ok(shell) = WallShell::new(&limb.mesh, &wall.outside, &wall.thickness_m) else {
            return Ok(None);
        };
        let model = LimbModel::of_shell(limb, &shell, self.n_threads)?;
        let gauges = model.gauges(&limb.sites, &limb.gauges)?;
        let Some(gauges) = gauges.into_iter().collect::<Option<Vec<LinearFunctional>>>() else {
            return Ok(None);
        };
        let build_s = started.elapsed().as_secs_f64();
        let loads: Vec<_> = self.own_tip_loads()?.iter().map(|load| model.load(load)).collect();
        let answers = Answers::of(&model.model, &gauges, &loads, 0)?;
        let [own, finest] = [0, solids.len() - 1].map(|level| &solids[level].reading_ue_per_n);
        let [of_shell, of_solid] =
            [&answers.reading_ue_per_n, own].map(|coarse| Differences::of(coarse, finest));
        let info = model.model.info();
        Ok(Some(ShellAgreement {
            n_fe_nodes: info.n_fe_nodes,
            n_equations: info.n_equations,
            build_s: build_s + answers.adjoint_s,
            median_difference: of_shell.median,
            worst_difference: of_shell.worst,
            solid_median_difference: of_solid.median,
            solid_worst_difference: of_solid.worst,
            gauges: agreements(&answers.reading_ue_per_n, own, finest),
        }))
    }
}

fn agreements(shell: &[Vec<f64>], solid: &[Vec<f64>], finest: &[Vec<f64>]) -> Vec<GaugeAgreement> {
    let agreement = |gauge: usize| {
        let [shell, solid, finest] = [shell, solid, finest]
            .map(|rows| rows.iter().map(|row| row[gauge]).collect::<Vec<f64>>());
        GaugeAgreement {
            finest_ue_per_n: norm(&finest) / (finest.len() as f64).sqrt(),
            shell_difference: relative(&shell, &finest),
            solid_difference: relative(&solid, &finest),
        }
    };
    (0..finest[0].len()).map(agreement).collect()
}
