//! Whether a limb's mesh is fine enough: the same presses on the mesh and on its refinements.
//!
//! Gauge readings are what counts; the displacement under a tip is reported beside them. The
//! displacement under a point force grows without end on a solid and is shown for comparison only.

mod answers;
mod differences;
mod estimate;
mod level;
mod shell;

use serde::{Deserialize, Serialize};

pub(crate) use answers::Answers;
pub use differences::{Differences, GOOD_DIFFERENCE};
pub(crate) use differences::{norm, relative};
pub use estimate::{Quantity, QuantityEstimate};
pub(crate) use level::Levels;
pub use level::MeshLevel;
pub use shell::{GaugeAgreement, ShellAgreement};

use crate::error::HapdefError;
use crate::limb::Limb;
use crate::scene::WallSolver;
use estimate::estimate;

/// How a mesh is judged.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
pub struct ConvergenceParams {
    /// Refinements beside the mesh itself, at least 1; from 2 on the observed order is used in
    /// place of [`Self::assumed_order`].
    pub refinements: usize,
    /// Presses, spread over the skin.
    pub n_presses: usize,
    /// Radius of the tip where the scene presses with a point, m.
    pub tip_radius_m: f64,
    /// Order of convergence taken for granted where it can't be observed; 1 is what re-entrant
    /// edges of ribs and holes leave of a quadratic element's 2.
    pub assumed_order: f64,
    /// Largest median error of a converged mesh's gauge readings.
    pub max_median_error: f64,
    /// Largest error of a converged mesh's gauge readings at any press.
    pub max_worst_error: f64,
    /// Worker threads.
    pub n_threads: usize,
}

impl Default for ConvergenceParams {
    fn default() -> Self {
        Self {
            refinements: 1,
            n_presses: 24,
            tip_radius_m: 2e-3,
            assumed_order: 1.0,
            max_median_error: 0.05,
            max_worst_error: 0.2,
            n_threads: 1,
        }
    }
}

/// A mesh and its refinements side by side.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Convergence {
    /// What was asked.
    pub params: ConvergenceParams,
    /// The mesh of the scene, then finer and finer ones.
    pub levels: Vec<MeshLevel>,
    /// The shell of the same wall, of a limb that is a skin and has a shell.
    pub shell: Option<ShellAgreement>,
    /// Gauge readings under a tip, displacement under a tip, displacement under a point force.
    pub estimates: Vec<QuantityEstimate>,
    /// The judgement.
    pub verdict: Verdict,
}

/// What the study says of the scene's mesh.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Verdict {
    /// The mesh is fine enough.
    Converged,
    /// It is not, but the mesh refined this many times is.
    Refine {
        /// Refinements.
        refinements: usize,
    },
    /// No mesh of the study is.
    NotConverged,
}

/// Presses the limb on its mesh and on finer ones, and judges the mesh by its gauge readings.
///
/// # Errors
/// [`HapdefError::Sim`] and [`HapdefError::Mesh`] where a refined mesh can't be made or solved.
pub fn convergence(
    limb: &Limb,
    tip_radius_m: f64,
    params: &ConvergenceParams,
    say: &dyn Fn(&str),
) -> Result<Convergence, HapdefError> {
    let tip_radius_m = if tip_radius_m > 0.0 { tip_radius_m } else { params.tip_radius_m };
    let params =
        ConvergenceParams { tip_radius_m, refinements: params.refinements.max(1), ..*params };
    let presses = Levels::new(limb, &params);
    let levels = presses.solve(params.refinements, say)?;
    let shell = presses.shell(&levels)?;
    let estimates: Vec<QuantityEstimate> =
        [Quantity::GaugeReading, Quantity::TipDisplacement, Quantity::PointDisplacement]
            .map(|quantity| estimate(quantity, &levels, params.assumed_order))
            .into();
    let verdict = judge(&estimates[0], &params);
    Ok(Convergence { params, levels, shell, estimates, verdict })
}

fn judge(readings: &QuantityEstimate, params: &ConvergenceParams) -> Verdict {
    let fine_enough = |level: &usize| {
        readings.median_error[*level] <= params.max_median_error
            && readings.worst_error[*level] <= params.max_worst_error
    };
    match (0..readings.median_error.len()).find(fine_enough) {
        Some(0) => Verdict::Converged,
        Some(refinements) => Verdict::Refine { refinements },
        None => Verdict::NotConverged,
    }
}

impl Convergence {
    /// The judgement of what `limb` is solved as, its mesh or the shell of its wall, and what to do.
    #[must_use]
    pub fn in_words(&self, limb: &Limb) -> String {
        let is_shell = limb.wall.as_ref().is_some_and(|wall| wall.solver == WallSolver::Shell);
        match &self.shell {
            Some(shell) if is_shell => self.shell_in_words(shell),
            _ => self.mesh_in_words(),
        }
    }

    fn mesh_in_words(&self) -> String {
        let readings = &self.estimates[0];
        let (median, worst) = (readings.median_error[0], readings.worst_error[0]);
        let measured = format!(
            "the mesh's gauge readings are off by an estimated {:.0} % (median) and {:.0} % (worst \
             of {} presses)",
            100.0 * median,
            100.0 * worst,
            self.params.n_presses
        );
        match self.verdict {
            Verdict::Converged => format!("CONVERGED: {measured}"),
            Verdict::Refine { refinements } => format!(
                "NOT CONVERGED: {measured}; set \"refinements\": {refinements} under \"geometry\" \
                 ({} FE nodes, an estimated {:.0} % and {:.0} %)",
                self.levels[refinements].n_fe_nodes,
                100.0 * readings.median_error[refinements],
                100.0 * readings.worst_error[refinements]
            ),
            Verdict::NotConverged => format!(
                "NOT CONVERGED: {measured}, and the finest mesh tried ({} FE nodes) still by {:.0} \
                 % and {:.0} %: use it (\"refinements\": {} under \"geometry\") or a better mesh, \
                 and calibrate",
                self.levels[self.levels.len() - 1].n_fe_nodes,
                100.0 * readings.median_error[self.levels.len() - 1],
                100.0 * readings.worst_error[self.levels.len() - 1],
                self.levels.len() - 1
            ),
        }
    }

    fn shell_in_words(&self, shell: &ShellAgreement) -> String {
        let (readings, params, finest) = (&self.estimates[0], &self.params, self.levels.len() - 1);
        let is_good = shell.median_difference <= params.max_median_error
            && shell.worst_difference <= params.max_worst_error;
        let advice = match is_good {
            true => "",
            false if shell.solid_median_difference < shell.median_difference => {
                ": calibrate, or set \"solver\": \"solid\" under \"geometry\""
            }
            false => ": calibrate",
        };
        format!(
            "{}: the shell's gauge readings differ from the finest solid's by {:.0} % (median) and \
             {:.0} % (worst of {} presses), those of the solid on the scene's mesh by {:.0} % and \
             {:.0} %; the finest solid's own are off by an estimated {:.0} % and {:.0} %{advice}",
            if is_good { "CONVERGED" } else { "NOT CONVERGED" },
            100.0 * shell.median_difference,
            100.0 * shell.worst_difference,
            params.n_presses,
            100.0 * shell.solid_median_difference,
            100.0 * shell.solid_worst_difference,
            100.0 * readings.median_error[finest],
            100.0 * readings.worst_error[finest]
        )
    }
}
