//! What a comparison of a shell with a solid model of the same limb says.

use std::fmt;

use hapdef_mesh::SurfaceMesh;
use serde::Serialize;

use super::differences::{Differences, GOOD_DIFFERENCE};
use super::maps::{AboveGood, GaugeDifference, ShellMaps, TouchDifference};

/// What a shell and a solid answer to the same presses.
#[derive(Clone, Debug, Serialize)]
pub struct ShellComparison {
    /// The solid.
    pub solid: String,
    /// Hash of the solid's deck, where it has one.
    pub deck_hash: Option<String>,
    /// Nodes of the solid.
    pub n_fe_nodes: usize,
    /// Equations of the solid.
    pub n_equations: usize,
    /// Gauges compared.
    pub n_gauges: usize,
    /// Gauges that not all models can carry.
    pub n_gauges_left_out: usize,
    /// Places where readings are compared.
    pub n_touches: usize,
    /// Places passed over: held, or not wholly on the shell.
    pub n_touches_left_out: usize,
    /// How far the shell is from the solid.
    pub shell: Answered,
    /// How far the solid with edges twice as long is from the solid, where there is one.
    pub coarser_solid: Option<Answered>,
    /// The presses whose displacement is compared.
    pub presses: Vec<PressDifference>,
    /// The places where readings are compared.
    pub touches: Vec<TouchDifference>,
    /// Each gauge over all places.
    pub gauges: Vec<GaugeDifference>,
    /// Shares of the compared surface with larger differences than is good.
    pub above_good: AboveGood,
    /// What follows.
    pub verdict: ShellVerdict,
    /// Seconds.
    pub elapsed_s: f64,
    /// The solid's skin, m.
    #[serde(skip)]
    pub skin: SurfaceMesh,
    /// The readings' difference at the nearest place, `[n_vertices]` of [`Self::skin`].
    #[serde(skip)]
    pub reading_difference: Vec<f64>,
    /// Both models' answers over the skin.
    #[serde(skip)]
    pub maps: ShellMaps,
}

/// How far a model's answers are from the solid's.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Answered {
    /// Gauge readings at every place.
    pub readings: Differences,
    /// Displacement under the tip along the force at every press.
    pub tip: Differences,
}

impl ShellComparison {
    /// What to take instead of the shell and by which figures; nothing where the shell is good or
    /// the solid no judge.
    #[must_use]
    pub fn recommendation(&self) -> Option<String> {
        let Answered { readings, tip } = &self.shell;
        let unsure = match self.coarser_solid {
            Some(_) => "",
            None => ", as far as this solid is fine enough itself",
        };
        (self.verdict == ShellVerdict::UseTheSolid).then(|| {
            format!(
                "use the solid: gauge readings of the shell are off by {:.1} % and its displacements \
                 by {:.1} % (medians of {} places and {} presses; 10 % is allowed){unsure}",
                100.0 * readings.median,
                100.0 * tip.median,
                self.n_touches,
                self.presses.len()
            )
        })
    }
}

/// One press on both models.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PressDifference {
    /// Where on the solid's skin, m.
    pub position_m: [f64; 3],
    /// Displacement under the tip of the shell, µm/N.
    pub shell_tip_um_per_n: f64,
    /// The same of the solid, µm/N.
    pub solid_tip_um_per_n: f64,
    /// The readings' relative difference.
    pub reading_difference: f64,
}

/// What to take.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ShellVerdict {
    /// Both median differences are at most 10 %.
    ShellIsGood,
    /// One is more.
    UseTheSolid,
    /// The solid's own answers change by more than that when its edges are halved.
    SolidTooCoarse,
}

impl ShellVerdict {
    pub(super) fn new(shell: &Answered, coarser_solid: Option<&Answered>) -> Self {
        if coarser_solid.is_some_and(|coarser| !coarser.is_good()) {
            Self::SolidTooCoarse
        } else if shell.is_good() {
            Self::ShellIsGood
        } else {
            Self::UseTheSolid
        }
    }
}

impl Answered {
    fn is_good(&self) -> bool {
        self.readings.median <= GOOD_DIFFERENCE && self.tip.median <= GOOD_DIFFERENCE
    }
}

impl fmt::Display for ShellComparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let percent = |x: f64| 100.0 * x;
        let Answered { readings, tip } = &self.shell;
        write!(
            f,
            "shell against {}: gauge readings within {:.1} % (median; worst of {} places {:.0} %), \
             displacement under the tip within {:.1} % (median; worst of {} presses {:.0} %): ",
            self.solid,
            percent(readings.median),
            self.n_touches,
            percent(readings.worst),
            percent(tip.median),
            self.presses.len(),
            percent(tip.worst),
        )?;
        match (self.verdict, &self.coarser_solid) {
            (ShellVerdict::ShellIsGood, Some(_)) => f.write_str("the shell is good here"),
            (ShellVerdict::ShellIsGood, None) => {
                f.write_str("the shell is good here, as far as this solid is fine enough")
            }
            (ShellVerdict::SolidTooCoarse, Some(coarser)) => write!(
                f,
                "no verdict, the solid is too coarse itself: halving its edges changed readings by \
                 {:.1} % and displacements by {:.1} % (median); take shorter edges (--edge) or \
                 halve more often (--halve-solid)",
                percent(coarser.readings.median),
                percent(coarser.tip.median)
            ),
            (_, Some(_)) => f.write_str("more than 10 %"),
            (_, None) => f.write_str("more than 10 %, as far as this solid is fine enough itself"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answered(readings: f64, tip: f64) -> Answered {
        let differences = |solid: f64| Differences::of(&[vec![1.0 + solid]], &[vec![1.0]]);
        Answered { readings: differences(readings), tip: differences(tip) }
    }

    #[track_caller]
    fn check(shell: (f64, f64), coarser: Option<(f64, f64)>, expected: ShellVerdict) {
        let coarser = coarser.map(|(a, b)| answered(a, b));
        let found = ShellVerdict::new(&answered(shell.0, shell.1), coarser.as_ref());
        assert_eq!(found, expected);
    }

    #[test]
    fn ten_percent_is_the_limit() {
        check((0.09, 0.05), None, ShellVerdict::ShellIsGood);
        check((0.11, 0.05), None, ShellVerdict::UseTheSolid);
        check((0.05, -0.11), None, ShellVerdict::UseTheSolid);
        check((0.05, 0.05), Some((0.02, 0.02)), ShellVerdict::ShellIsGood);
    }

    #[test]
    fn a_coarse_solid_is_no_judge() {
        check((0.05, 0.05), Some((0.02, 0.3)), ShellVerdict::SolidTooCoarse);
    }
}
