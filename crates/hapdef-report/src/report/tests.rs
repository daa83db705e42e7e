//! A small report, read back.

use super::*;
use crate::TextCell;
use crate::headline::Headline;
use crate::metrics::MetricContext;

fn named(name: &str, text: &str) -> NamedText {
    NamedText { name: name.to_owned(), text: text.to_owned() }
}

fn report() -> Report {
    let table = TextTable {
        header: vec!["method".to_owned(), "I".to_owned()],
        rows: vec![vec![TextCell::plain("LR"), TextCell::plain("2.2 (2.2)")]],
    };
    let figure = |file: &str, content| Figure {
        file: file.to_owned(),
        caption: "a <small> picture".to_owned(),
        content,
        data: serde_json::Value::Null,
    };
    let svg = "<?xml version=\"1.0\"?><svg xmlns=\"http://www.w3.org/2000/svg\"/>";
    let context = MetricContext {
        commit: "c".to_owned(),
        machine: "m".to_owned(),
        seed: 1,
        time: "t".to_owned(),
    };
    let outcome = MetricOutcome::Skipped { skipped: "no net".to_owned() };
    Report {
        title: "Shin".to_owned(),
        scene: "shin & co".to_owned(),
        facts: vec![named("seed", "1")],
        profile: "quick".to_owned(),
        seed: 1,
        tables: vec![ReportTable {
            title: "Table 1".to_owned(),
            note: "µm".to_owned(),
            text: table,
            data: serde_json::json!([1, 2, 3]),
        }],
        figures: vec![
            Figure {
                data: serde_json::json!({ "series": ["LR"] }),
                ..figure("bars.svg", FigureContent::Svg(svg.to_owned()))
            },
            figure("limb.png", FigureContent::Png(vec![1, 2, 3])),
        ],
        limbs: vec![],
        summary: None,
        metrics: vec![MetricRecord { name: "a.b".to_owned(), outcome, context }],
        stages: vec![StageTime { name: "compliance".to_owned(), elapsed_s: 12.34, cached: true }],
        skipped: vec![SkippedStage { name: "svr".to_owned(), reason: "quick".to_owned() }],
        hashes: vec![named("scene", "abc")],
    }
}

#[test]
fn every_part_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let paths = write_report(&folder.path().join("out"), &report()).unwrap();
    let names: Vec<_> = paths.iter().map(|p| p.file_name().unwrap().to_str().unwrap()).collect();
    assert_eq!(
        names,
        ["bars.svg", "bars.json", "limb.png", "report.json", "report.md", "report.html"]
    );
    let read = |i: usize| std::fs::read_to_string(&paths[i]).unwrap();
    assert_eq!(read(1), r#"{"series":["LR"]}"#);
    let json: serde_json::Value = serde_json::from_str(&read(3)).unwrap();
    assert_eq!(json["tables"][0]["data"].as_array().unwrap().len(), 3);
    assert_eq!(json["figures"][1]["file"], "limb.png");
    assert_eq!(json["metrics"][0]["skipped"], "no net");
    assert_eq!(json["made"]["commit"], "c");
    assert_eq!(json["hashes"][0]["text"], "abc");
    assert_eq!(json["skipped"][0]["reason"], "quick");
    let markdown = read(4);
    for part in ["# Shin", "## Table 1", "| LR | 2.2 (2.2) |", "![](bars.svg)", "| svr | quick |"] {
        assert!(markdown.contains(part), "{part} is missing in\n{markdown}");
    }
    assert!(markdown.contains("| compliance | 12.3 | cache |"), "{markdown}");
}

#[test]
fn the_page_is_well_formed_and_self_contained() {
    let page = page(&report()).html();
    for part in ["shin &amp; co", "a &lt;small&gt; picture", "data:image/png;base64,AQID", "<svg "]
    {
        assert!(page.contains(part), "{part} is missing in\n{page}");
    }
    assert!(!page.contains("<?xml") && !page.contains("<script"), "{page}");
    for reference in ["src=\"http", "href=", "url("] {
        assert!(!page.contains(reference), "{reference} reaches outside");
    }
    let body = &page[page.find("<body>").unwrap()..page.find("</html>").unwrap()];
    roxmltree::Document::parse(body).unwrap();
}

#[test]
fn every_report_says_by_what_and_from_what_it_was_made() {
    let folder = tempfile::tempdir().unwrap();
    let mut report = report();
    report.metrics.clear();
    let paths = write_report(folder.path(), &report).unwrap();
    let json: serde_json::Value =
        serde_json::from_slice(&std::fs::read(&paths[3]).unwrap()).unwrap();
    let here = MetricContext::here(report.seed);
    assert_eq!(json["made"]["commit"], here.commit);
    assert_eq!(json["made"]["machine"], here.machine);
    assert_eq!(json["made"]["seed"], 1);
    let page = std::fs::read_to_string(&paths[5]).unwrap();
    for part in [here.commit, here.machine] {
        assert!(page.contains(&format!("<dd>{}</dd>", crate::escape_html(&part))), "{page}");
    }
    report.hashes.clear();
    let empty = tempfile::tempdir().unwrap();
    let refused = write_report(empty.path(), &report);
    assert!(matches!(refused, Err(ReportError::NoHashes { .. })));
    assert_eq!(std::fs::read_dir(empty.path()).unwrap().count(), 0);
}

#[test]
fn odd_file_names_are_refused_before_writing() {
    let folder = tempfile::tempdir().unwrap();
    for file in ["../x.svg", "x.png", ".svg", "a/b.svg", "limb.png", "limb.svg", "report.svg"] {
        let mut report = report();
        report.figures[0].file = file.to_owned();
        let error = write_report(folder.path(), &report).unwrap_err();
        assert!(
            matches!(error, ReportError::Argument(ArgumentError::Name { .. })),
            "{file}: {error}"
        );
    }
    let mut report = report();
    report.figures[1].file = "limb.png".to_owned();
    report.figures.push(report.figures[1].clone());
    assert!(matches!(
        write_report(folder.path(), &report),
        Err(ReportError::Argument(ArgumentError::Name { .. }))
    ));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn a_chart_brings_its_numbers_along() {
    let chart = crate::LineChart {
        title: "growth".to_owned(),
        x_label: "nodes".to_owned(),
        y_label: "s".to_owned(),
        log_x: false,
        log_y: false,
        dots: true,
        series: vec![crate::Series {
            name: "factor".to_owned(),
            points: vec![(1.0, 2.0), (3.0, f64::NAN)],
        }],
    };
    let figure = Figure::lines("growth.svg", "how it grows", &chart).unwrap();
    assert_eq!(figure.data["x_label"], "nodes");
    assert_eq!(figure.data["series"][0]["points"], serde_json::json!([[1.0, 2.0], [3.0, null]]));
}

#[test]
fn the_summary_comes_first_and_what_it_rests_on_last() {
    let folder = tempfile::tempdir().unwrap();
    let picture = Figure { file: "top.png".to_owned(), ..report().figures[1].clone() };
    let number = Headline {
        value: "0.2 mm".to_owned(),
        what: "one contact".to_owned(),
        beside: "6 mm <before>".to_owned(),
    };
    let summary = Summary {
        sentence: "Found & scored.".to_owned(),
        numbers: vec![number],
        picture: Some(picture),
        next: vec!["hapdef live".to_owned()],
    };
    let with_summary = Report { summary: Some(summary.clone()), ..report() };
    let paths = write_report(folder.path(), &with_summary).unwrap();
    assert!(paths[0].ends_with("top.png"), "{paths:?}");
    for (ending, parts) in [
        (
            "html",
            [
                "Found &amp; scored.",
                "<b>0.2 mm</b>",
                "6 mm &lt;before&gt;",
                "<img ",
                "hapdef live",
                "Table 1",
                "What this rests on",
            ],
        ),
        (
            "md",
            [
                "Found & scored.",
                "**0.2 mm**",
                "6 mm <before>",
                "top.png",
                "hapdef live",
                "Table 1",
                "What this rests on",
            ],
        ),
    ] {
        let text =
            std::fs::read_to_string(folder.path().join("report").with_extension(ending)).unwrap();
        let mut rest = text.as_str();
        for part in parts {
            let at = rest.find(part);
            rest = &rest[at.unwrap_or_else(|| panic!("{part} doesn't come next in {rest}"))..];
        }
    }
    let twice = Report { figures: summary.picture.clone().into_iter().collect(), ..with_summary };
    assert!(write_report(folder.path(), &twice).is_err(), "a picture and a figure share a file");
}
