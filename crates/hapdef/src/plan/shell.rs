//! Shell or solid: what a skin's wall is solved as, and of a deck, whether a shell of its skin would do, as
//! it was compared, or as its wall looks.

use std::path::Path;

use hapdef_mesh::wall;
use serde::Deserialize;

use super::{Plan, PlanStep};
use crate::convergence::GOOD_DIFFERENCE;
use crate::error::HapdefError;
use crate::limb::Limb;
use crate::shell_limb::SHELL_REPORT_JSON;

/// Name of the step of a deck.
const NAME: &str = "shell model instead";

/// Name of the step of a skin.
const OF_SKIN: &str = "shell or extruded solid";

/// What is read of a report.
#[derive(Deserialize)]
struct Report {
    source: Source,
    parameters: Parameters,
    comparisons: Vec<Compared>,
}

#[derive(Deserialize)]
struct Source {
    file: String,
}

#[derive(Deserialize)]
struct Parameters {
    wall: String,
}

#[derive(Deserialize)]
struct Compared {
    deck_hash: Option<String>,
    shell: Answers,
}

#[derive(Clone, Copy, Deserialize)]
struct Answers {
    readings: Median,
    tip: Median,
}

#[derive(Clone, Copy, Deserialize)]
struct Median {
    median: f64,
}

impl Answers {
    fn worse(&self) -> f64 {
        self.readings.median.max(self.tip.median)
    }
}

impl Plan {
    /// The plan with what a skin's wall is solved as and why, or what speaks for or against a shell of a
    /// deck's skin: the best comparison with this deck that `hapdef shell --against` left in a folder of `results`, or else the wall
    /// behind the skin, up to `max_wall_m`. The scene's solid stays what is used.
    ///
    /// # Errors
    /// [`HapdefError::File`] for a folder or report that can't be read, [`HapdefError::Mesh`] where
    /// the skin has no wall behind it.
    pub fn with_shell_advice(
        mut self,
        limb: &Limb,
        max_wall_m: f64,
        results: &Path,
    ) -> Result<Self, HapdefError> {
        let sizes = [("surface nodes", limb.n_surface_nodes())];
        let step = match (&limb.wall, compared(&limb.deck_hash, results)?) {
            (Some(wall), _) => PlanStep::runs(OF_SKIN, wall.to_string(), &sizes),
            (None, Some(text)) => PlanStep::alternative(NAME, text, &sizes),
            (None, None) => PlanStep::alternative(NAME, by_wall(limb, max_wall_m)?, &sizes),
        };
        let after_design = self.steps.iter().position(|s| s.when == super::When::Frame);
        self.steps.insert(after_design.unwrap_or(self.steps.len()), step);
        Ok(self)
    }
}

/// What the best of the saved comparisons with the deck says, reports in order of their names.
fn compared(deck_hash: &str, results: &Path) -> Result<Option<String>, HapdefError> {
    let Ok(folders) = std::fs::read_dir(results) else {
        return Ok(None);
    };
    let mut paths = Vec::new();
    for folder in folders {
        let folder = folder.map_err(HapdefError::file(results))?.path();
        let path = folder.join(SHELL_REPORT_JSON);
        if path.is_file() {
            paths.push(path);
        }
    }
    paths.sort();
    let mut best: Option<(Answers, String)> = None;
    for path in paths {
        let bytes = std::fs::read(&path).map_err(HapdefError::file(&path))?;
        let report: Report = serde_json::from_slice(&bytes)
            .map_err(|error| HapdefError::file(&path)(error.into()))?;
        let with_deck = |c: &&Compared| c.deck_hash.as_deref() == Some(deck_hash);
        for compared in report.comparisons.iter().filter(with_deck) {
            let better = |(found, _): &(Answers, String)| compared.shell.worse() < found.worse();
            if best.as_ref().is_none_or(better) {
                best = Some((compared.shell, said(&report, &compared.shell, &path)));
            }
        }
    }
    Ok(best.map(|(_, text)| text))
}

fn said(report: &Report, answers: &Answers, path: &Path) -> String {
    let advice = match answers.worse() > GOOD_DIFFERENCE {
        true => "use the solid, as this scene does",
        false => "a shell would do",
    };
    format!(
        "{advice}: compared with this deck, a shell of {} (wall {}) has gauge readings off by {:.1} % \
         and displacements by {:.1} % (medians; 10 % is allowed; from {})",
        report.source.file,
        report.parameters.wall,
        100.0 * answers.readings.median,
        100.0 * answers.tip.median,
        path.display()
    )
}

/// What the wall behind the skin says, which nothing has been compared with: its thickness against
/// the limb's width, and how much of the material is more than a wall of the median thickness.
fn by_wall(limb: &Limb, max_wall_m: f64) -> Result<String, HapdefError> {
    let wall = wall(&limb.mesh, &limb.boundary, &limb.skin, max_wall_m)?;
    let median_m = wall.thickness_quantile_m(0.5).unwrap_or(0.0);
    let n_faces = wall.skin_thickness_m.len() as f64;
    let mean_m = wall.skin_thickness_m.iter().sum::<f64>() / n_faces;
    let beyond = (1.0 - median_m / mean_m).max(0.0);
    let size_m = limb.skin.surface(&limb.mesh)?.bounding_box().size_m();
    let radius_m = 0.5 * size_m.min();
    // a shell of flat facets leaves out that the inner side of a wall is shorter than its middle
    let left_out = 0.5 * median_m / radius_m;
    let advice = match beyond.max(left_out) > GOOD_DIFFERENCE {
        true => "use the solid, as this scene does",
        false => "a shell may do",
    };
    Ok(format!(
        "{advice}: {:.0} % of the material behind the skin is more than its median wall (ribs, rings), \
         t/2R = {:.1} % (wall {:.2} mm, limb {:.1} mm across); by the deck's wall alone, not compared: \
         `hapdef shell SKIN --against SCENE` does",
        100.0 * beyond,
        100.0 * left_out,
        1e3 * median_m,
        2e3 * radius_m
    ))
}
