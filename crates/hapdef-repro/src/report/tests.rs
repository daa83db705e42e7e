//! A small report, read back.

use super::*;
use crate::metrics::MetricContext;
use crate::tables::{Table1, table1_claims};

fn named(name: &str, text: &str) -> NamedText {
    NamedText {
        name: name.to_owned(),
        text: text.to_owned(),
    }
}

fn report() -> Report {
    let table = Table1::paper();
    let figure = |file: &str, content| Figure {
        file: file.to_owned(),
        caption: "a <small> picture".to_owned(),
        content,
    };
    let svg = "<?xml version=\"1.0\"?><svg xmlns=\"http://www.w3.org/2000/svg\"/>";
    let context = MetricContext {
        commit: "c".to_owned(),
        machine: "m".to_owned(),
        seed: 1,
        time: "t".to_owned(),
    };
    let outcome = MetricOutcome::Skipped {
        skipped: "no net".to_owned(),
    };
    Report {
        title: "Shin".to_owned(),
        scene: "shin & co".to_owned(),
        facts: vec![named("seed", "1")],
        profile: "quick".to_owned(),
        seed: 1,
        claims: table1_claims(std::slice::from_ref(&table)),
        tables: vec![ReportTable {
            title: "Table 1".to_owned(),
            note: "µm".to_owned(),
            text: table.to_text(),
            data: serde_json::to_value(&table).unwrap(),
        }],
        figures: vec![
            figure("bars.svg", FigureContent::Svg(svg.to_owned())),
            figure("limb.png", FigureContent::Png(vec![1, 2, 3])),
        ],
        metrics: vec![MetricRecord {
            name: "a.b".to_owned(),
            outcome,
            context,
        }],
        stages: vec![StageTime {
            name: "compliance".to_owned(),
            elapsed_s: 12.34,
            cached: true,
        }],
        skipped: vec![SkippedStage {
            name: "svr".to_owned(),
            reason: "quick".to_owned(),
        }],
        hashes: vec![named("scene", "abc")],
    }
}

#[test]
fn every_part_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let paths = write_report(&folder.path().join("out"), &report()).unwrap();
    let names: Vec<_> = paths
        .iter()
        .map(|p| p.file_name().unwrap().to_str().unwrap())
        .collect();
    assert_eq!(
        names,
        [
            "bars.svg",
            "limb.png",
            "report.json",
            "report.md",
            "report.html"
        ]
    );
    let read = |i: usize| std::fs::read_to_string(&paths[i]).unwrap();
    let json: serde_json::Value = serde_json::from_str(&read(2)).unwrap();
    assert_eq!(json["tables"][0]["data"].as_array().unwrap().len(), 60);
    assert_eq!(json["claims"][0]["verdicts"][0]["fate"], "holds");
    assert_eq!(json["figures"][1]["file"], "limb.png");
    assert_eq!(json["metrics"][0]["skipped"], "no net");
    let markdown = read(3);
    for part in [
        "# Shin",
        "| **holds** | all 3; closest",
        "## Table 1",
        "![](bars.svg)",
        "| svr | quick |",
    ] {
        assert!(markdown.contains(part), "{part} is missing in\n{markdown}");
    }
    assert!(
        markdown.contains("| compliance | 12.3 | cache |"),
        "{markdown}"
    );
}

#[test]
fn the_page_is_well_formed_and_self_contained() {
    let page = html::page(&report());
    for part in [
        "shin &amp; co",
        "a &lt;small&gt; picture",
        "data:image/png;base64,AQID",
        "<svg ",
    ] {
        assert!(page.contains(part), "{part} is missing in\n{page}");
    }
    assert!(
        !page.contains("<?xml") && !page.contains("<script"),
        "{page}"
    );
    for reference in ["src=\"http", "href=", "url("] {
        assert!(!page.contains(reference), "{reference} reaches outside");
    }
    let body = &page[page.find("<body>").unwrap()..page.find("</html>").unwrap()];
    let body = body.replace("base64,AQID\">", "base64,AQID\"/>");
    roxmltree::Document::parse(&body).unwrap();
}

#[test]
fn the_results_page_has_verdicts_tables_and_times() {
    let json = serde_json::to_value(report()).unwrap();
    let page = results_markdown(&json);
    for part in [
        "**A quick run**",
        "- commit: c\n",
        "| mean \\|error\\| | holds | all 3; closest",
        "| LR | I | 2.2 (2.2) |",
        "| compliance | 12.3 |",
    ] {
        assert!(page.contains(part), "{part} is missing in\n{page}");
    }
    assert!(!page.contains("!["), "no pictures");
}

#[test]
fn odd_file_names_are_refused_before_writing() {
    let folder = tempfile::tempdir().unwrap();
    for file in ["../x.svg", "x.png", ".svg", "a/b.svg", "limb.png"] {
        let mut report = report();
        report.figures[0].file = file.to_owned();
        let error = write_report(folder.path(), &report).unwrap_err();
        assert!(matches!(error, ReproError::Name { .. }), "{file}: {error}");
    }
    let mut report = report();
    report.figures[1].file = "limb.png".to_owned();
    report.figures.push(report.figures[1].clone());
    assert!(matches!(
        write_report(folder.path(), &report),
        Err(ReproError::Name { .. })
    ));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}
