//! One row of the table: a method at an extreme, what must hold, and what came of it.

use hapdef_report::{StabilityCase, StabilityRefusal, StabilityWanted, magnitude_text};

use crate::ReproError;

/// Figures below this are shown as little.
const LITTLE: (f64, &str) = (1e-9, "< 1e-9");

/// One method at one extreme.
#[derive(Clone, Debug, PartialEq)]
pub struct StabilityRow {
    /// The method.
    pub method: &'static str,
    /// What is extreme.
    pub extreme: String,
    /// What must hold, in words; `measured ≤ limit` in numbers.
    pub must_hold: &'static str,
    /// What came out.
    pub outcome: Result<StabilityFigure, StabilityRefusal>,
    /// What should have come out.
    pub wanted: StabilityWanted,
}

/// What was measured, and the most it may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StabilityFigure {
    /// The figure.
    pub measured: f64,
    /// Its limit.
    pub limit: f64,
}

impl StabilityCase for StabilityRow {
    type Figures = StabilityFigure;

    fn outcome(&self) -> Result<&StabilityFigure, &StabilityRefusal> {
        self.outcome.as_ref()
    }

    fn holds(&self, figure: &StabilityFigure) -> bool {
        figure.measured <= figure.limit
    }

    fn wanted(&self) -> StabilityWanted {
        self.wanted
    }

    fn cells(&self) -> Vec<String> {
        let [limit, measured] = match &self.outcome {
            Ok(f) => [format!("{:e}", f.limit), magnitude_text(f.measured, LITTLE)],
            Err(_) => Default::default(),
        };
        let [method, must_hold] = [self.method, self.must_hold].map(str::to_owned);
        let [said, verdict] = [self.said(), self.verdict().word()].map(str::to_owned);
        vec![method, self.extreme.clone(), must_hold, limit, measured, said, verdict]
    }

    fn words(&self, refusal: &StabilityRefusal) -> String {
        let words = without_folders(&refusal.text);
        format!("{}, {}: {words}", self.method, self.extreme)
    }
}

/// Paths without the folder that a row made for itself.
fn without_folders(text: &str) -> String {
    let name = |word: &str| match word.starts_with('/') {
        true => word.rsplit('/').next().unwrap_or(word).to_owned(),
        false => word.to_owned(),
    };
    text.split(' ').map(name).collect::<Vec<_>>().join(" ")
}

fn refusal(error: &ReproError) -> StabilityRefusal {
    let text = error.to_string();
    match error {
        ReproError::Argument(cause) => StabilityRefusal::new(cause, text),
        ReproError::Nets(cause) => StabilityRefusal::new(cause, text),
        ReproError::Data(cause) => StabilityRefusal::new(cause, text),
        ReproError::Limb(cause) => StabilityRefusal::new(&**cause, text),
        ReproError::Inverse(cause) => StabilityRefusal::new(cause, text),
        ReproError::Mesh(hapdef_mesh::MeshError::Solid(cause)) => {
            StabilityRefusal::new(cause, text)
        }
        ReproError::KMax(cause) => StabilityRefusal::new(cause, text),
        ReproError::Daq(cause) => StabilityRefusal::new(cause, text),
        other => StabilityRefusal::new(other, text),
    }
}

/// A row to be run.
pub(super) struct Case {
    pub(super) method: &'static str,
    pub(super) extreme: String,
    pub(super) must_hold: &'static str,
    pub(super) limit: f64,
    pub(super) wanted: StabilityWanted,
    pub(super) run: Box<dyn Fn() -> Result<f64, ReproError>>,
}

impl Case {
    pub(super) fn row(&self) -> StabilityRow {
        let figure = |measured| StabilityFigure { measured, limit: self.limit };
        StabilityRow {
            method: self.method,
            extreme: self.extreme.clone(),
            must_hold: self.must_hold,
            outcome: (self.run)().map(figure).map_err(|e| refusal(&e)),
            wanted: self.wanted,
        }
    }
}

/// A case, written in the order of the table's columns.
pub(super) fn case(
    method: &'static str,
    extreme: impl Into<String>,
    (must_hold, limit): (&'static str, f64),
    wanted: StabilityWanted,
    run: impl Fn() -> Result<f64, ReproError> + 'static,
) -> Case {
    Case { method, extreme: extreme.into(), must_hold, limit, wanted, run: Box::new(run) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refusal_is_named_by_its_cause() {
        let stopped = Case {
            method: "LR",
            extreme: "one".to_owned(),
            must_hold: "",
            limit: 1.0,
            wanted: StabilityWanted::saying("stopped"),
            run: Box::new(|| Err(ReproError::Stopped)),
        };
        let row = stopped.row();
        assert_eq!((row.is_failed(), row.said()), (false, "Stopped"));
        let cause = hapdef_report::check_len("x", 1, 2).unwrap_err();
        assert_eq!(refusal(&cause.into()).kind, "Shape");
    }

    #[test]
    fn words_have_no_folders() {
        let text = "a tensor in /tmp/x1/set.safetensors: 1/2 read";
        assert_eq!(without_folders(text), "a tensor in set.safetensors: 1/2 read");
    }
}
