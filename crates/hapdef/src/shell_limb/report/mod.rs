//! The report of a shell against solids: one HTML page without anything from outside, and the same
//! figures as JSON.

mod blocks;

use std::path::Path;

use hapdef_report::{MetricContext, NamedText, Origin, Page, SkippedStage};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::{ShellComparison, ShellLimb, WallChoice};
use crate::cache::write_json;
use crate::error::HapdefError;

/// Name of the page.
pub const SHELL_REPORT_HTML: &str = "shell-report.html";

/// Name of the figures.
pub const SHELL_REPORT_JSON: &str = "shell-report.json";

/// Where the limb of a report comes from.
#[derive(Clone, Debug, Deserialize, PartialEq, Eq, Serialize)]
pub struct ReportSource {
    /// The surface file.
    pub file: String,
    /// Hash of its bytes (BLAKE3).
    pub file_hash: String,
    /// The scene compared with, if one is.
    pub scene: Option<SceneSource>,
}

/// A scene compared with.
#[derive(Clone, Debug, Deserialize, PartialEq, Eq, Serialize)]
pub struct SceneSource {
    /// Its file.
    pub file: String,
    /// Hash of its bytes (BLAKE3).
    pub file_hash: String,
}

impl ShellLimb {
    /// Writes [`SHELL_REPORT_HTML`] and [`SHELL_REPORT_JSON`] into `folder`.
    ///
    /// # Errors
    /// [`HapdefError::File`] when the disk refuses.
    pub fn write_report(
        &self,
        folder: &Path,
        source: &ReportSource,
        comparisons: &[ShellComparison],
    ) -> Result<(), HapdefError> {
        std::fs::create_dir_all(folder).map_err(HapdefError::file(folder))?;
        let facts = self.facts(source);
        let origin = origin(source, comparisons);
        let page = Page {
            title: format!("Shell against solid: {}", source.file),
            facts: facts.iter().cloned().chain(origin.facts()).collect(),
            blocks: comparisons.iter().flat_map(blocks::blocks).collect(),
        };
        page.write(&folder.join(SHELL_REPORT_HTML))?;
        let figures = origin.with(figures(source, &facts, comparisons));
        write_json(&folder.join(SHELL_REPORT_JSON), &figures)
    }

    fn facts(&self, source: &ReportSource) -> Vec<NamedText> {
        let (params, info) = (&self.params, &self.info);
        let mm = |m: f64| format!("{:.2} mm", m * 1e3);
        let wall = match params.wall {
            WallChoice::Constant(thickness_m) => mm(thickness_m),
            WallChoice::Measured => {
                let [least, _, median, _, most] = info.wall.thickness_quantiles_m.map(mm);
                format!("measured: {least} to {most}, median {median}")
            }
        };
        let [length, width] = params.gauge_size_m.map(mm);
        let mut facts = vec![
            ("surface", source.file.clone()),
            ("wall", format!("{wall}; the skin is its {} side", info.wall.side)),
            ("edges", mm(info.wall.target_edge_m)),
            (
                "mount",
                format!(
                    "{} end of {}, {}",
                    info.mount.end,
                    info.mount.axis,
                    mm(info.mount.length_m)
                ),
            ),
            (
                "material",
                format!(
                    "E {:.3e} Pa, ν {}",
                    params.material.youngs_modulus_pa(),
                    params.material.poissons_ratio()
                ),
            ),
            ("shell", format!("{:?}, {} nodes", params.kind, info.model.n_nodes).to_lowercase()),
            ("gauges", format!("{} of {length} × {width}", info.gauges.len())),
            ("tip", format!("{} radius", mm(params.tip_radius_m))),
        ];
        if let Some(scene) = &source.scene {
            facts.push(("scene", scene.file.clone()));
        }
        facts.push(("thin wall", self.thin_wall().to_string()));
        let named = |(name, text): (&str, String)| NamedText { name: name.into(), text };
        facts.into_iter().map(named).collect()
    }
}

/// Nothing is drawn at random, so there is no seed; hashes are BLAKE3.
fn origin(source: &ReportSource, comparisons: &[ShellComparison]) -> Origin {
    let scene = source.scene.as_ref();
    let decks = comparisons.iter().filter_map(|c| c.deck_hash.as_ref());
    let hashes = [("surface", &source.file_hash)]
        .into_iter()
        .chain(scene.map(|scene| ("scene", &scene.file_hash)))
        .chain(decks.map(|hash| ("deck", hash)));
    let named = |(name, text): (&str, &String)| NamedText { name: name.into(), text: text.clone() };
    Origin {
        scene: scene.map_or_else(String::new, |scene| scene.file.clone()),
        made: MetricContext::here(0),
        hashes: hashes.map(named).collect(),
        skipped: comparisons.iter().flat_map(left_out).collect(),
    }
}

/// What a comparison passes over.
fn left_out(comparison: &ShellComparison) -> Vec<SkippedStage> {
    let solid = &comparison.solid;
    let skip = |name: String, reason: &str| SkippedStage {
        name: format!("{name}, against {solid}"),
        reason: reason.into(),
    };
    let mut skipped = Vec::new();
    if comparison.n_touches_left_out > 0 {
        let name = format!("{} places", comparison.n_touches_left_out);
        skipped.push(skip(name, "held, or not wholly on the shell"));
    }
    if comparison.n_gauges_left_out > 0 {
        let name = format!("{} gauges", comparison.n_gauges_left_out);
        skipped.push(skip(name, "not all models can carry them"));
    }
    if comparison.coarser_solid.is_none() {
        let reason = "there is no other mesh of that solid to compare it with";
        skipped.push(skip("how far the solid itself is from converged".into(), reason));
    }
    skipped
}

fn figures(source: &ReportSource, facts: &[NamedText], comparisons: &[ShellComparison]) -> Value {
    let parameters: serde_json::Map<String, Value> =
        facts.iter().map(|fact| (fact.name.clone(), json!(fact.text))).collect();
    let recommendations: Vec<_> = comparisons.iter().map(|c| c.recommendation()).collect();
    json!({
        "source": source,
        "parameters": parameters,
        "comparisons": comparisons,
        "recommendations": recommendations,
    })
}
