//! Rows of a made-up method.

use hapdef_report::MetricContext;

use super::column::Digits;
use super::*;

const TABLE: Table = Table {
    folder: "rows",
    title: "Rows",
    note: "",
    layer: "",
    columns: &[Column::METHOD, Column::MEASURED, Column::SAID, Column::VERDICT],
    least: (1e-9, "little"),
    rounded_refusals: &["Diverged"],
    word: str::to_owned,
};

fn row(outcome: Result<f64, (&'static str, &'static str)>, expected: Expected) -> Row {
    let mut trials = Trials::<(), Refusal>::new(());
    trials.of("LR").add("one", ("", 0.1), expected, move |()| {
        outcome.map_err(|(kind, text)| Refusal { kind: kind.to_owned(), text: text.to_owned() })
    });
    TABLE.rows(trials, |_| {}).remove(0)
}

#[test]
fn beyond_the_limit_is_silently_wrong() {
    for measured in [0.2, f64::INFINITY, f64::NAN] {
        let row = row(Ok(measured), Expected::Either);
        assert_eq!((row.verdict, row.failed), (Verdict::SilentlyWrong, true));
    }
    let good = row(Ok(0.1), Expected::Result);
    assert_eq!((good.verdict, good.failed), (Verdict::Accurate, false));
}

#[test]
fn what_should_be_refused_and_is_not_fails() {
    let expected = Expected::Refusal { kind: "AllClamped", words: "125" };
    let any = Expected::saying("125");
    assert!(row(Ok(0.0), expected).failed);
    assert!(!row(Err(("AllClamped", "all 125 nodes")), expected).failed);
    assert!(row(Err(("AllClamped", "all nodes")), expected).failed);
    assert!(row(Err(("Residual", "125")), expected).failed);
    assert!(!row(Err(("Residual", "125")), any).failed);
    assert!(row(Err(("Residual", "125")), Expected::Result).failed);
    assert!(!row(Err(("Residual", "125")), Expected::Either).failed);
    assert!(row(Err((Refusal::FAULT, "125")), Expected::Either).failed);
}

#[test]
fn numbers_may_differ_and_verdicts_and_words_may_not() {
    let text = |outcome| TABLE.markdown(&[row(outcome, Expected::Either)]);
    let differences = |fresh, committed| TABLE.differences(&text(fresh), &text(committed));
    assert!(differences(Ok(0.09), Ok(1e-3)).is_empty());
    assert!(!differences(Ok(0.2), Ok(1e-3)).is_empty());
    assert_eq!(differences(Err(("Eigen", "row 4")), Err(("Eigen", "row 5"))).len(), 2);
    assert!(text(Err(("Eigen", "row 4"))).contains("- LR, one: row 4"));
    assert!(!text(Err(("Diverged", "at 1.234"))).contains("1.234"));
}

#[test]
fn kinds_are_names_of_variants() {
    let refusal = Refusal::new(&Some(3), "three".to_owned());
    assert_eq!(refusal.kind, "Some");
}

#[test]
fn magnitudes_are_powers_of_ten() {
    let digits = Digits::Magnitude((1e-9, "little"));
    let found = [3e-2, 1e-12, f64::INFINITY, f64::NAN].map(|v| digits.text(v));
    assert_eq!(found, ["1e-2", "little", "∞", "NaN"]);
}

#[test]
fn published_rows_are_joined() {
    let folder = tempfile::tempdir().unwrap();
    let metrics = folder.path().join("metrics.json");
    let rows = [row(Ok(0.05), Expected::Result), row(Ok(f64::INFINITY), Expected::Either)];
    let outputs = Outputs { metrics: &metrics, write: None, check: None };
    let log = (Vec::new(), MetricContext::here(3));
    let published = TABLE.publish(&rows, Inputs::default(), log, outputs).unwrap();
    assert_eq!((published.n_failed, published.page.is_file()), (1, true));
    let mut out = Vec::new();
    let all = publish_all(&["rows", "rows"], "all", &mut out, &metrics).unwrap();
    assert_eq!(all.n_failed, 2);
    let out = String::from_utf8(out).unwrap();
    assert!(out.contains("METRIC:stability.rows:4:1"), "{out}");
    assert!(out.contains("METRIC:stability.silently_wrong:2:1"), "{out}");
    let json = std::fs::read_to_string(folder.path().join("all/report.json")).unwrap();
    assert!(json.contains("5.0e-2 of 1.0e-1"), "{json}");
}
