//! The wall of a skin: what it is solved as, and why.

use std::fmt;
use std::path::Path;

use hapdef_bench::stats::median;
use hapdef_mesh::{FeNodeId, SkinRegion, Tet10Mesh};

use crate::error::HapdefError;
use crate::scene::{Scene, SkinShape, WallSolver};
use crate::skin_solid::Outside;
use crate::wall_shell::WallShell;

/// What gauges of a shell are off by on a thin wall, and how that grows with t/2R.
///
/// Medians of 40 presses on open tubes 50 mm across, walls of 0.5 to 8 mm, edges of 5.6 and 11.1 mm, six gauges of
/// 8 × 5 mm, against the same solid refined up to twice: shells 2.0 to 7.9 %, the solids not refined 2.2 to 47 %
/// (docs/shells.md). `tests/it/skin_solver.rs` measures some of them again.
const SHELL_LEAST: f64 = 0.022;
const SHELL_PER_THICKNESS: f64 = 0.3;

/// The same of the solid, one or two tetrahedra thick, and how that grows with h²/Rt: how long an edge is
/// against √(Rt), over which a wall of radius R bends.
const SOLID_LEAST: f64 = 0.01;
const SOLID_PER_EDGE: f64 = 0.053;

/// A shell is chosen where the solid's expected error is so many times its own: what is expected was met
/// within a factor of 1.7, and where neither is clearly better the solid knows the wall's edges and rims.
const CLEARLY: f64 = 1.5;

/// The thickest wall that was measured as a shell, as t/2R: beyond it nothing is known of shells.
const THICKEST: f64 = 0.2;

/// The wall of a limb that is a skin.
pub struct SkinWall {
    /// Its outside.
    pub outside: SkinRegion,
    /// Its thickness `[outside.nodes]`, m.
    pub thickness_m: Vec<f64>,
    /// What it is solved as: never [`WallSolver::Auto`].
    pub solver: WallSolver,
    /// Why.
    pub reason: String,
    /// What the expected errors rest on.
    pub measures: WallMeasures,
}

/// A wall against its curvature, the solid's edges and the gauges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallMeasures {
    /// Median thickness t, m.
    pub thickness_m: f64,
    /// t/2R, R the radius of curvature of the wall's middle, at most half of what the limb is across; the
    /// mean over the skin.
    pub slenderness: f64,
    /// h²/Rt, h the solid's median edge; the mean over the skin.
    pub edges: f64,
    /// Length of a gauge, m.
    pub gauge_m: f64,
}

impl WallMeasures {
    /// Relative error expected of gauge readings on a shell, the median of places.
    #[must_use]
    pub fn shell_error(&self) -> f64 {
        SHELL_LEAST + SHELL_PER_THICKNESS * self.slenderness
    }

    /// The same on the extruded solid.
    #[must_use]
    pub fn solid_error(&self) -> f64 {
        SOLID_LEAST + SOLID_PER_EDGE * self.edges
    }

    /// Whether a clearly smaller error is expected of the shell.
    fn is_shell_better(&self) -> bool {
        CLEARLY * self.shell_error() < self.solid_error()
    }

    /// Why a shell is no choice, whatever is expected of the solid.
    #[must_use]
    pub fn too_thick(&self) -> Option<String> {
        if self.slenderness > THICKEST {
            return Some(format!("thicker than {:.0} % of twice its radius", 100.0 * THICKEST));
        }
        // a strain that a gauge takes the mean of changes through the wall over the wall's thickness
        (self.thickness_m > self.gauge_m).then(|| "thicker than a gauge is long".to_owned())
    }

    fn of(
        solid: &Tet10Mesh,
        outside: &SkinRegion,
        thickness_m: &[f64],
        gauge_m: f64,
    ) -> Result<Self, HapdefError> {
        let place = |node: FeNodeId| outside.nodes.partition_point(|other| *other < node);
        let mut curvature_per_m = vec![0.0_f64; outside.nodes.len()];
        let mut edges_m = Vec::with_capacity(3 * outside.faces.len());
        for face in &outside.faces {
            for [a, b] in [[0, 1], [1, 2], [2, 0]] {
                let [a, b] = [face.nodes[a], face.nodes[b]];
                let edge_m = (solid.position(a) - solid.position(b)).norm();
                let turn = (outside.normals[place(a)] - outside.normals[place(b)]).norm();
                for node in [a, b] {
                    let most = &mut curvature_per_m[place(node)];
                    *most = most.max(turn / edge_m);
                }
                edges_m.push(edge_m);
            }
        }
        let edge_m = median(edges_m);
        let across_m = 0.5 * outside.surface(solid)?.bounding_box().size_m().min();
        let corners = thickness_m.iter().zip(&curvature_per_m).filter(|(_, c)| **c > 0.0);
        let (mut n, mut slenderness, mut edges) = (0.0, 0.0, 0.0);
        for (wall_m, curvature_per_m) in corners {
            let outside_m = across_m.min(1.0 / curvature_per_m);
            // a wall can't be thicker than its outer radius
            let radius_m = (outside_m - 0.5 * wall_m).max(0.5 * wall_m);
            slenderness += 0.5 * wall_m / radius_m;
            edges += edge_m * edge_m / (radius_m * wall_m);
            n += 1.0;
        }
        let thickness_m = median(thickness_m.iter().copied());
        Ok(Self { thickness_m, slenderness: slenderness / n, edges: edges / n, gauge_m })
    }
}

impl SkinWall {
    /// The wall outside of which is `outside`, and the shell where the scene asks for one or, left to
    /// choose, the smaller error is expected of it.
    ///
    /// # Errors
    /// [`HapdefError::SkinSolver`] where a shell is asked for that can't be had.
    pub(crate) fn new(
        scene: &Scene,
        scene_dir: &Path,
        skin: &SkinShape,
        solid: &Tet10Mesh,
        outside: &Outside,
    ) -> Result<(Self, Option<WallShell>), HapdefError> {
        let (region, thickness_m) = outside.region(solid)?;
        let measures = WallMeasures::of(solid, &region, &thickness_m, scene.gauges.length_m)?;
        let shell = || WallShell::new(solid, &region, &thickness_m);
        let refined = (scene.estimator.map_refinements() > 0)
            .then(|| "estimator.map_refinements refines the solid".to_owned());
        let refused = |what: String| {
            let (path, wall_mm) = (scene_dir.join(&skin.file), 1e3 * measures.thickness_m);
            HapdefError::SkinSolver { path, wall_mm, what }
        };
        let (reason, shell) = match skin.solver {
            WallSolver::Solid => ("the scene asks for it".to_owned(), None),
            WallSolver::Shell => match (refined, shell()) {
                (Some(why), _) => return Err(refused(why)),
                (None, Err(error)) => return Err(refused(error.to_string())),
                (None, Ok(shell)) => ("the scene asks for it".to_owned(), Some(shell)),
            },
            WallSolver::Auto => match refined.or_else(|| measures.too_thick()) {
                Some(why) => (why, None),
                None if !measures.is_shell_better() => {
                    ("no clearly smaller error is expected of a shell".to_owned(), None)
                }
                None => match shell() {
                    Ok(shell) => ("a smaller error is expected of it".to_owned(), Some(shell)),
                    Err(error) => (format!("there is no shell: {error}"), None),
                },
            },
        };
        let solver = if shell.is_some() { WallSolver::Shell } else { WallSolver::Solid };
        Ok((Self { outside: region, thickness_m, solver, reason, measures }, shell))
    }
}

impl fmt::Display for SkinWall {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (m, percent) = (&self.measures, |x: f64| 100.0 * x);
        let name = match self.solver {
            WallSolver::Shell => "shell",
            WallSolver::Solid | WallSolver::Auto => "extruded solid",
        };
        write!(
            f,
            "{name}: {}; errors of gauge readings expected by measured tubes, median: shell {:.1} %, \
             extruded solid {:.1} % (wall {:.2} mm: t/2R = {:.1} %, edges of {:.1} √Rt, gauges {:.1} \
             walls long)",
            self.reason,
            percent(m.shell_error()),
            percent(m.solid_error()),
            1e3 * m.thickness_m,
            percent(m.slenderness),
            m.edges.sqrt(),
            m.gauge_m / m.thickness_m,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Walls and edges of measured tubes, mm; the medians measured, of the shell and of the solid that is not
    /// refined, against the finest solid.
    const MEASURED: [([f64; 2], [f64; 2]); 9] = [
        ([0.5, 11.1], [0.033, 0.473]),
        ([0.5, 5.6], [0.023, 0.148]),
        ([1.0, 11.1], [0.028, 0.258]),
        ([1.0, 5.6], [0.020, 0.061]),
        ([2.0, 11.1], [0.034, 0.129]),
        ([2.0, 5.6], [0.024, 0.027]),
        ([4.0, 11.1], [0.045, 0.063]),
        ([4.0, 5.6], [0.044, 0.022]),
        ([8.0, 11.1], [0.079, 0.047]),
    ];

    fn tube([wall_mm, edge_mm]: [f64; 2]) -> WallMeasures {
        let radius_mm = 25.0 - 0.5 * wall_mm;
        WallMeasures {
            thickness_m: 1e-3 * wall_mm,
            slenderness: 0.5 * wall_mm / radius_mm,
            edges: edge_mm * edge_mm / (radius_mm * wall_mm),
            gauge_m: 8e-3,
        }
    }

    #[test]
    fn what_is_expected_is_what_was_measured_within_two_fifths() {
        for (given, [shell, solid]) in MEASURED {
            let of = tube(given);
            for (expected, measured) in [(of.shell_error(), shell), (of.solid_error(), solid)] {
                let off = expected / measured;
                assert!((0.6..1.7).contains(&off), "{given:?}: {expected} {measured}");
            }
        }
    }

    #[test]
    fn a_shell_is_chosen_where_it_was_measured_to_be_better() {
        for (given, [shell, solid]) in MEASURED {
            match tube(given).is_shell_better() {
                true => assert!(shell < solid, "{given:?}"),
                false => assert!(solid < 1.5 * shell, "{given:?}"),
            }
        }
    }

    #[test]
    fn what_was_not_measured_is_no_shell() {
        assert!(tube([8.0, 11.1]).too_thick().is_none());
        assert!(tube([8.5, 11.1]).too_thick().is_some_and(|why| why.contains("thicker than")));
        let long = WallMeasures { gauge_m: 3e-3, ..tube([4.0, 11.1]) };
        assert!(long.too_thick().is_some_and(|why| why.contains("gauge is long")));
    }
}
