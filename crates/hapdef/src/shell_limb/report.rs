//! The report of a shell against solids: one HTML page without anything from outside, and the same
//! figures as JSON.

use std::path::Path;

use hapdef_report::{MetricContext, NamedText, Origin, Page, SkippedStage};
use serde_json::{Map, Value, json};

use super::page::blocks;
use super::{ShellComparison, ShellLimb};
use crate::cache::write_json;
use crate::error::HapdefError;
use crate::new_limb::WallChoice;

/// Name of the page.
pub const SHELL_REPORT_HTML: &str = "shell-report.html";

/// Name of the figures.
pub const SHELL_REPORT_JSON: &str = "shell-report.json";

impl ShellLimb {
    /// Writes [`SHELL_REPORT_HTML`] and [`SHELL_REPORT_JSON`] into `folder`.
    pub(super) fn write_page(
        &self,
        folder: &Path,
        comparisons: &[ShellComparison],
    ) -> Result<(), HapdefError> {
        let facts = self.facts();
        let origin = self.origin(comparisons);
        let parameters: Map<String, Value> =
            facts.iter().map(|fact| (fact.name.clone(), json!(fact.text))).collect();
        let scene = comparisons.iter().find_map(|c| c.scene.as_ref());
        let figures = origin.with(json!({
            "source": { "file": self.file, "file_hash": self.file_hash, "scene": scene },
            "parameters": parameters,
            "comparisons": comparisons,
            "recommendations": comparisons.iter().map(ShellComparison::advice).collect::<Vec<_>>(),
        }));
        let page = Page {
            title: format!("Shell against solid: {}", self.file),
            facts: facts.into_iter().chain(origin.facts()).collect(),
            blocks: comparisons.iter().flat_map(blocks).collect(),
        };
        page.write(&folder.join(SHELL_REPORT_HTML))?;
        write_json(&folder.join(SHELL_REPORT_JSON), &figures)
    }

    fn facts(&self) -> Vec<NamedText> {
        let (params, info) = (&self.params, &self.info);
        let mm = |m: f64| format!("{:.2} mm", m * 1e3);
        let wall = match params.wall {
            WallChoice::Constant(thickness_m) => mm(thickness_m),
            WallChoice::Measured => {
                let [least, _, median, _, most] = info.wall.thickness_quantiles_m.map(mm);
                format!("measured: {least} to {most}, median {median}")
            }
        };
        let (material, gauges) = (&params.material, &self.scene.gauges);
        let (length, width) = (mm(gauges.length_m), mm(gauges.width_m));
        let facts = [
            ("surface", self.file.clone()),
            ("wall", format!("{wall}; the skin is its {:?} side", info.wall.side).to_lowercase()),
            ("edges", mm(info.wall.target_edge_m)),
            ("mount", info.mount.to_string()),
            (
                "material",
                format!("E {:.3e} Pa, ν {}", material.youngs_modulus_pa, material.poissons_ratio),
            ),
            ("shell", format!("{:?}, {} nodes", params.kind, info.model.n_nodes).to_lowercase()),
            ("gauges", format!("{} of {length} × {width}", gauges.sites.len())),
            ("tip", format!("{} radius", mm(params.tip_radius_m))),
            ("expected", info.wall.expected.clone()),
        ];
        facts.map(|(name, text)| NamedText { name: name.into(), text }).into()
    }

    /// Nothing is drawn at random, so there is no seed; hashes are BLAKE3.
    fn origin(&self, comparisons: &[ShellComparison]) -> Origin {
        let scenes = || comparisons.iter().filter_map(|c| c.scene.as_ref());
        let decks = comparisons.iter().filter_map(|c| c.deck_hash.as_ref());
        let hashes = [("surface", &self.file_hash)]
            .into_iter()
            .chain(scenes().map(|scene| ("scene", &scene.file_hash)))
            .chain(decks.map(|hash| ("deck", hash)));
        let named =
            |(name, text): (&str, &String)| NamedText { name: name.into(), text: text.clone() };
        Origin {
            scene: scenes().next().map_or_else(String::new, |scene| scene.file.clone()),
            made: MetricContext::here(0),
            hashes: hashes.map(named).collect(),
            skipped: comparisons.iter().flat_map(left_out).collect(),
        }
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
