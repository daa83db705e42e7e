//! By what and from what results were made.

use serde_json::{Value, json};

use crate::metrics::MetricContext;
use crate::report::{NamedText, SkippedStage};

/// What a page and a file of metrics say beside the results.
#[derive(Clone, Debug, PartialEq)]
pub struct Origin {
    /// Name of the scene; empty without one.
    pub scene: String,
    /// By what code, on what machine, with which seed and when.
    pub made: MetricContext,
    /// Of what went in.
    pub hashes: Vec<NamedText>,
    /// What was left out, and why.
    pub skipped: Vec<SkippedStage>,
}

impl Origin {
    /// Lines of a page.
    #[must_use]
    pub fn facts(&self) -> Vec<NamedText> {
        let fact =
            |name: &str, text: &str| NamedText { name: name.to_owned(), text: text.to_owned() };
        let skipped = self.skipped.iter();
        let skipped = skipped.map(|s| fact("left out", &format!("{}: {}", s.name, s.reason)));
        let made = [
            fact("commit", &self.made.commit),
            fact("machine", &self.made.machine),
            fact("time", &self.made.time),
        ];
        let hashes = self.hashes.iter();
        let hashes = hashes.map(|hash| fact(&format!("{} hash", hash.name), &hash.text));
        skipped.chain(made).chain(hashes).collect()
    }

    /// The fields of an object, with these before them, under the names of `report.json`.
    #[must_use]
    pub fn with(&self, figures: Value) -> Value {
        let mut all = json!({
            "scene": self.scene,
            "seed": self.made.seed,
            "made": self.made,
            "hashes": self.hashes,
            "skipped": self.skipped,
        });
        if let (Some(all), Value::Object(figures)) = (all.as_object_mut(), figures) {
            all.extend(figures);
        }
        all
    }
}
