//! What a comparison of a shell with a solid model of the same limb says.

use hapdef_mesh::SurfaceMesh;
use serde::{Deserialize, Serialize};

use super::maps::{AboveGood, GaugeDifference, PressDifference, ShellMaps};
use crate::convergence::{Differences, GOOD_DIFFERENCE};

/// What a shell and a solid answer to the same presses.
#[derive(Clone, Debug, Serialize)]
pub struct ShellComparison {
    /// The solid.
    pub solid: String,
    /// Hash of the solid's deck, where it has one.
    pub deck_hash: Option<String>,
    /// The scene that the solid is from, if it is.
    pub scene: Option<SceneSource>,
    /// Nodes of the solid.
    pub n_fe_nodes: usize,
    /// Equations of the solid.
    pub n_equations: usize,
    /// Gauges compared.
    pub n_gauges: usize,
    /// Gauges that the shell can't carry.
    pub n_gauges_left_out: usize,
    /// Places where readings are compared.
    pub n_touches: usize,
    /// The first so many of them where displacements are compared, too.
    pub n_tips: usize,
    /// Places passed over: held, or not wholly on the shell.
    pub n_touches_left_out: usize,
    /// How far the shell is from the solid.
    pub shell: Answered,
    /// How far the solid with edges twice as long is from the solid, where there is one.
    pub coarser_solid: Option<Answered>,
    /// The places.
    pub presses: Vec<PressDifference>,
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
    /// Both models' answers over the skin.
    #[serde(skip)]
    pub maps: ShellMaps,
}

/// A scene compared with.
#[derive(Clone, Debug, Deserialize, PartialEq, Eq, Serialize)]
pub struct SceneSource {
    /// Its file.
    pub file: String,
    /// Hash of its bytes (BLAKE3).
    pub file_hash: String,
}

/// How far a model's answers are from the solid's.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Answered {
    /// Gauge readings at every place.
    pub readings: Differences,
    /// Displacement under the tip along the force at every press.
    pub tip: Differences,
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

impl ShellComparison {
    /// What to take and by which figures.
    #[must_use]
    pub fn advice(&self) -> String {
        let of = |Answered { readings, tip }: &Answered| {
            let percent = [readings.median, tip.median].map(|share| 100.0 * share);
            format!(
                "gauge readings by {:.1} % and displacements by {:.1} %",
                percent[0], percent[1]
            )
        };
        let found = format!(
            "the shell is off in {} (medians of {} places and {} presses; 10 % is allowed)",
            of(&self.shell),
            self.n_touches,
            self.n_tips
        );
        let unsure = ", as far as this solid is fine enough itself";
        match (self.verdict, &self.coarser_solid) {
            (ShellVerdict::ShellIsGood, Some(_)) => format!("good enough: {found}"),
            (ShellVerdict::ShellIsGood, None) => format!("good enough: {found}{unsure}"),
            (ShellVerdict::SolidTooCoarse, Some(coarser)) => format!(
                "no verdict, the solid is too coarse itself: halving its edges changed {} (medians); take \
                 shorter edges (--edge) or halve more often (--halve-solid)",
                of(coarser)
            ),
            (_, Some(_)) => format!("use the solid: {found}"),
            (_, None) => format!("use the solid: {found}{unsure}"),
        }
    }

    /// Rows of the table of differences: what, then median, worst and all in per cent, and the median ratio.
    #[must_use]
    pub fn table(&self) -> Vec<[String; 5]> {
        let coarser = self.coarser_solid.map(|answered| ("solid, edges twice as long", answered));
        let models = [("shell", self.shell)].into_iter().chain(coarser);
        let rows = models.flat_map(|(who, Answered { readings, tip })| {
            [(who, "gauge readings", readings), (who, "displacement", tip)]
        });
        let percent = |share: f64| format!("{:.1}", 100.0 * share);
        rows.map(|(who, what, d)| {
            let [median, worst, overall] = [d.median, d.worst, d.overall].map(percent);
            [format!("{who}: {what}"), median, worst, overall, format!("{:.3}", d.median_ratio)]
        })
        .collect()
    }
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
