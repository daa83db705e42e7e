//! Parts of pages that commands write.

use anyhow::Result;
use hapdef::Run;
use hapdef_report::{MetricContext, NamedText, TextCell, TextTable};
use serde_json::{Value, json};

/// A line at the head of a page.
pub(super) fn fact(name: &str, text: String) -> NamedText {
    NamedText {
        name: name.into(),
        text,
    }
}

/// By what and from what a command's results were made.
pub(super) struct Origin {
    scene: String,
    made: MetricContext,
    hashes: [(&'static str, String); 2],
    skipped: Vec<(&'static str, &'static str)>,
}

impl Origin {
    /// Of results over a run's scene; `skipped`: what was left out, and why.
    pub(super) fn of(run: &Run, skipped: &[(&'static str, &'static str)]) -> Result<Self> {
        Ok(Self {
            scene: run.scene.name.clone(),
            made: MetricContext::here(run.scene.seed),
            hashes: run.input_hashes()?,
            skipped: skipped.to_vec(),
        })
    }

    /// Lines at the foot of a page.
    pub(super) fn facts(&self) -> Vec<NamedText> {
        let hashes = self.hashes.iter();
        let hashes = hashes.map(|(name, hash)| fact(&format!("{name} hash"), hash.clone()));
        let skipped = self.skipped.iter();
        let skipped = skipped.map(|(name, why)| fact("left out", format!("{name}: {why}")));
        let made = [
            fact("commit", self.made.commit.clone()),
            fact("machine", self.made.machine.clone()),
            fact("time", self.made.time.clone()),
        ];
        skipped.chain(made).chain(hashes).collect()
    }

    /// The figures of an object, with these before them, under the names of `report.json`.
    pub(super) fn with(&self, figures: Value) -> Value {
        let hashes = self.hashes.iter();
        let skipped = self.skipped.iter();
        let mut all = json!({
            "scene": self.scene,
            "seed": self.made.seed,
            "made": self.made,
            "hashes": hashes.map(|(name, text)| json!({"name": name, "text": text})).collect::<Vec<_>>(),
            "skipped": skipped
                .map(|(name, reason)| json!({"name": name, "reason": reason}))
                .collect::<Vec<_>>(),
        });
        if let (Some(all), Value::Object(figures)) = (all.as_object_mut(), figures) {
            all.extend(figures);
        }
        all
    }
}

/// A table of plain cells.
pub(super) fn table<const N: usize>(
    header: [&str; N],
    rows: impl IntoIterator<Item = [String; N]>,
) -> TextTable {
    let cells = |row: [String; N]| row.map(TextCell::plain).to_vec();
    TextTable {
        header: header.map(str::to_owned).to_vec(),
        rows: rows.into_iter().map(cells).collect(),
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use hapdef::{Profile, Progress};

    use super::*;

    #[test]
    fn results_say_by_what_and_from_what_they_were_made() {
        let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/shin/scene.json");
        let out = tempfile::tempdir().unwrap();
        let progress = Progress::on_stderr();
        let run = Run::new(&scene, Profile::quick(), out.path(), 1, progress).unwrap();
        let origin = Origin::of(&run, &[("pairs", "too few")]).unwrap();
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
