//! Rows of a made-up method.

use super::*;

struct Row {
    outcome: Result<f64, StabilityRefusal>,
    wanted: StabilityWanted,
}

impl StabilityCase for Row {
    type Figures = f64;

    fn outcome(&self) -> Result<&f64, &StabilityRefusal> {
        self.outcome.as_ref()
    }

    fn holds(&self, figures: &f64) -> bool {
        *figures <= 0.1
    }

    fn wanted(&self) -> StabilityWanted {
        self.wanted
    }

    fn cells(&self) -> Vec<String> {
        let figure = self.outcome.as_ref().map_or(String::new(), f64::to_string);
        ["LR", &figure, self.said(), self.verdict().word()].map(str::to_owned).to_vec()
    }

    fn words(&self, refusal: &StabilityRefusal) -> String {
        format!("LR: {}", refusal.text)
    }
}

const DOCUMENT: StabilityDocument = StabilityDocument {
    preamble: "# Rows\n\n",
    columns: &["method", "measured", "said", "verdict"],
    rounded_columns: &["measured"],
    rounded_refusals: &["Diverged"],
};

fn row(outcome: Result<f64, (&str, &str)>, wanted: StabilityWanted) -> Row {
    let refusal = |(kind, text): (&str, &str)| StabilityRefusal {
        kind: kind.to_owned(),
        text: text.to_owned(),
    };
    Row { outcome: outcome.map_err(refusal), wanted }
}

#[test]
fn beyond_the_limit_is_silently_wrong() {
    for measured in [0.2, f64::INFINITY, f64::NAN] {
        let row = row(Ok(measured), StabilityWanted::Either);
        assert_eq!(row.verdict(), StabilityVerdict::SilentlyWrong);
        assert!(row.is_failed());
    }
    let good = row(Ok(0.1), StabilityWanted::Result);
    assert_eq!((good.verdict(), good.is_failed()), (StabilityVerdict::Accurate, false));
}

#[test]
fn what_should_be_refused_and_is_not_fails() {
    let wanted = StabilityWanted::Refusal { kind: "AllClamped", words: "125" };
    let any = StabilityWanted::saying("125");
    assert!(row(Ok(0.0), wanted).is_failed());
    assert!(!row(Err(("AllClamped", "all 125 nodes")), wanted).is_failed());
    assert!(row(Err(("AllClamped", "all nodes")), wanted).is_failed());
    assert!(row(Err(("Residual", "125")), wanted).is_failed());
    assert!(!row(Err(("Residual", "125")), any).is_failed());
    assert!(row(Err(("Residual", "125")), StabilityWanted::Result).is_failed());
    assert!(!row(Err(("Residual", "125")), StabilityWanted::Either).is_failed());
}

#[test]
fn figures_may_differ_and_verdicts_and_words_may_not() {
    let text = |outcome| DOCUMENT.markdown(&[row(outcome, StabilityWanted::Either)]);
    let differences = |fresh, committed| DOCUMENT.differences(&text(fresh), &text(committed));
    assert!(differences(Ok(0.09), Ok(1e-3)).is_empty());
    assert!(!differences(Ok(0.2), Ok(1e-3)).is_empty());
    assert_eq!(differences(Err(("Eigen", "row 4")), Err(("Eigen", "row 5"))).len(), 2);
    assert!(text(Err(("Eigen", "row 4"))).contains("- LR: row 4"));
    assert!(!text(Err(("Diverged", "at 1.234"))).contains("1.234"));
}

#[test]
fn kinds_are_names_of_variants() {
    let refusal = StabilityRefusal::new(&Some(3), "three".to_owned());
    assert_eq!(refusal.kind, "Some");
}

#[test]
fn magnitudes_are_powers_of_ten() {
    let found = [3e-2, 1e-12, f64::INFINITY, f64::NAN].map(|v| magnitude_text(v, (1e-9, "little")));
    assert_eq!(found, ["1e-2", "little", "∞", "NaN"]);
}
