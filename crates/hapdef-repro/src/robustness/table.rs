//! The tables in docs/, and the refusals that errors are.

use hapdef_bench::robustness::{Column, Refusal, Table};

use crate::error::ReproError;

/// The rows of a table.
pub type Trials<W> = hapdef_bench::robustness::Trials<W, ReproError>;

const GENERAL: Table = Table {
    folder: "",
    title: "",
    note: "Measured: the metric that must not exceed the limit.",
    layer: "",
    columns: &[
        Column::METHOD,
        Column::EXTREME,
        Column::MUST_HOLD,
        Column::LIMIT,
        Column::MEASURED,
        Column::SAID,
        Column::VERDICT,
    ],
    least: (1e-9, "< 1e-9"),
    rounded_refusals: &["Diverged", "NotFinite", "NothingLearned", "Overflow"],
    word: without_folder,
};

/// docs/stability-nets.md.
pub const NETS_TABLE: Table = Table {
    folder: "stability-nets",
    title: "Robustness of training, baselines and inference",
    layer: "training, inference",
    ..GENERAL
};

/// docs/stability-inverse.md.
pub const INVERSE_TABLE: Table = Table {
    folder: "stability-inverse",
    title: "Robustness of contacts by superposition",
    layer: "superposition, calibration",
    ..GENERAL
};

/// docs/stability-parts.md.
pub const PARTS_TABLE: Table = Table {
    folder: "stability-parts",
    title: "Robustness of meshes, datasets, compliance, k-Max, decoder, clock and recordings",
    ..GENERAL
};

/// A refusal is named by its cause.
impl From<ReproError> for Refusal {
    fn from(error: ReproError) -> Self {
        let text = error.to_string();
        match &error {
            ReproError::Argument(cause) => Self::new(cause, text),
            ReproError::Nets(cause) => Self::new(cause, text),
            ReproError::Data(cause) => Self::new(cause, text),
            ReproError::Limb(cause) => Self::new(&**cause, text),
            ReproError::Inverse(cause) => Self::new(cause, text),
            ReproError::Mesh(hapdef_mesh::MeshError::Solid(cause)) => Self::new(cause, text),
            ReproError::KMax(cause) => Self::new(cause, text),
            ReproError::Daq(cause) => Self::new(cause, text),
            other => Self::new(other, text),
        }
    }
}

/// A path without the folder that a row made for itself; other words as they are.
fn without_folder(word: &str) -> String {
    match word.strip_prefix('/') {
        Some(path) => path.rsplit('/').next().unwrap_or(word).to_owned(),
        None => word.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refusal_is_named_by_its_cause() {
        assert_eq!(Refusal::from(ReproError::Stopped).kind, "Stopped");
        let cause = hapdef_report::check_len("x", 1, 2).unwrap_err();
        assert_eq!(Refusal::from(ReproError::from(cause)).kind, "Shape");
    }

    #[test]
    fn words_have_no_folders() {
        let words = ["in", "/tmp/x1/set.safetensors:", "1/2"].map(without_folder);
        assert_eq!(words, ["in", "set.safetensors:", "1/2"]);
    }
}
