//! Parts of pages that commands write.

use anyhow::Result;
use hapdef::Run;
use hapdef_report::{MetricContext, NamedText, Origin, SkippedStage};

/// A line at the head of a page.
pub(super) fn fact(name: &str, text: String) -> NamedText {
    NamedText { name: name.into(), text }
}

/// By what and from what results over a run's scene are made; `skipped`: what is left out, and why.
pub(super) fn origin(run: &Run, skipped: &[(&str, &str)]) -> Result<Origin> {
    let named = |(name, text): (&str, String)| fact(name, text);
    let left_out = |(name, reason): &(&str, &str)| SkippedStage {
        name: (*name).to_owned(),
        reason: (*reason).to_owned(),
    };
    Ok(Origin {
        scene: run.scene.name.clone(),
        made: MetricContext::here(run.scene.seed),
        hashes: run.input_hashes()?.map(named).to_vec(),
        skipped: skipped.iter().map(left_out).collect(),
    })
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use hapdef::Profile;
    use serde_json::json;

    use super::*;

    #[test]
    fn results_say_by_what_and_from_what_they_were_made() {
        let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/shin/scene.json");
        let out = tempfile::tempdir().unwrap();
        let progress = hapdef_cli::on_stderr();
        let run = Run::new(&scene, Profile::quick(), out.path(), 1, progress).unwrap();
        let origin = origin(&run, &[("pairs", "too few")]).unwrap();
        let value = origin.with(json!({"noise_ue": 5.0}));
        assert_eq!(value["scene"], run.scene.name);
        assert_eq!(value["seed"], run.scene.seed);
        assert_eq!(value["hashes"][0]["text"], run.scene_hash);
        assert_eq!(value["hashes"][1]["text"].as_str().unwrap().len(), 64);
        assert_eq!(value["skipped"][0]["reason"], "too few");
        assert_eq!(value["made"]["machine"], MetricContext::here(0).machine);
        assert_eq!(value["noise_ue"], 5.0);
        let facts = origin.facts();
        for text in [&origin.made.commit, &run.scene_hash] {
            assert!(facts.iter().any(|fact| fact.text == *text), "{facts:?}");
        }
    }
}
