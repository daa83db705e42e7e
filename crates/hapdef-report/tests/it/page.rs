//! A page with a limb: well-formed, self-contained, its numbers as they were given.

use hapdef_report::{Block, LimbMap, LimbView, NamedText, Page, TextCell, TextTable};

fn page() -> Page {
    let limb = LimbView {
        points_m: vec![[0.0, 0.0, 0.0], [0.02, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.03]],
        triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]],
        maps: vec![LimbMap {
            title: "bound <1>".to_owned(),
            unit: "mm".to_owned(),
            factor: 1e3,
            values: vec![0.001, 0.0025, f64::NAN, f64::INFINITY],
            range: [0.0, 0.004],
        }],
        marks_m: vec![[0.0, 0.05, 0.0]],
    };
    Page {
        title: "A & B".to_owned(),
        facts: vec![NamedText { name: "seed".to_owned(), text: "1".to_owned() }],
        blocks: vec![
            Block::Verdict { text: "x < y".to_owned(), warns: true },
            Block::Table(TextTable {
                header: vec!["a".to_owned()],
                rows: vec![vec![TextCell::plain("1")]],
            }),
            Block::Limb(limb),
        ],
    }
}

#[test]
fn a_limb_is_drawn_from_four_sides_and_to_be_turned() {
    let html = page().html();
    let text = html.strip_prefix("<!doctype html>\n").expect("a document type");
    let document = roxmltree::Document::parse(text).unwrap();
    let all = |name: &str| {
        let is = |node: &roxmltree::Node<'_, '_>| node.has_tag_name(name);
        document.descendants().filter(is).collect::<Vec<_>>()
    };
    let canvases = all("canvas");
    assert_eq!(canvases.len(), 5);
    for canvas in &canvases {
        assert_eq!(canvas.attribute("role"), Some("img"));
        assert!(canvas.attribute("aria-label").is_some_and(|name| !name.is_empty()));
    }
    assert_eq!(canvases[4].attribute("tabindex"), Some("0"));
    assert!(html.contains("front, from +x"), "y is upright");
    assert!(html.contains("x &lt; y") && html.contains("verdict warns"));
    let data = all("script")[0].text().unwrap();
    let data: serde_json::Value = serde_json::from_str(data).unwrap();
    // A point's coordinates, 5 cm apart, are 5,000 steps: that is what the length bar is drawn by.
    assert_eq!(data["step_mm"].as_f64(), Some(0.01));
    let limb = &data["limbs"][0];
    assert_eq!((&limb["up"], &limb["points"][7]), (&1.into(), &10_000.into()));
    assert_eq!(limb["marks"], serde_json::json!([0, 5000, 0]));
    assert_eq!(limb["maps"][0]["values"], serde_json::json!([0.001, 0.0025, null, null]));
    for outside in ["src=\"http", "href=", "url(", "@import"] {
        assert!(!html.contains(outside), "{outside} reaches outside");
    }
}

#[test]
fn a_page_without_limbs_has_no_script() {
    let mut page = page();
    page.blocks.pop();
    assert!(!page.html().contains("<script"));
}
