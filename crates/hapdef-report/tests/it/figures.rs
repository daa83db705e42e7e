//! The figures as documents: well-formed, labelled, with a mark for each value.

use hapdef_report::{
    BarChart, BarPanel, LineChart, Mark, Scatter, Series, Unrolled, UnrolledArrow, UnrolledMarker,
    bars_svg, lines_svg, scatter_svg, unroll, unrolled_row_svg, unrolled_svg,
};

/// Parses the SVG; returns its texts and how often each element occurs.
#[track_caller]
fn parse(svg: &str) -> (Vec<String>, impl Fn(&str) -> usize + use<>) {
    let document = roxmltree::Document::parse(svg).expect("well-formed XML");
    let names: Vec<String> =
        document.descendants().map(|n| n.tag_name().name().to_owned()).collect();
    let texts = document
        .descendants()
        .filter(|n| n.has_tag_name(("http://www.w3.org/2000/svg", "text")))
        .map(|n| n.text().unwrap_or_default().trim().to_owned())
        .collect();
    assert!(!svg.contains("NaN") && !svg.contains("inf"), "a coordinate is not finite");
    (texts, move |name| names.iter().filter(|n| *n == name).count())
}

#[track_caller]
fn assert_says(texts: &[String], expected: &[&str]) {
    for text in expected {
        assert!(texts.iter().any(|t| t == text), "{text:?} is not among {texts:?}");
    }
}

/// The error bar of the second bar reaches above every bar: the axis has room for it.
#[test]
fn error_bars_widen_the_axis() {
    let chart = |spread: Vec<Vec<Option<f64>>>| {
        let text = bars_svg(&BarChart {
            y_label: "mm".to_owned(),
            x_label: "error".to_owned(),
            log_y: false,
            groups: vec!["position".to_owned(), "force".to_owned()],
            series: vec!["SVR".to_owned()],
            panels: vec![BarPanel {
                title: "single".to_owned(),
                values: vec![vec![Some(1.0), Some(2.0)]],
                paper: vec![],
                spread,
            }],
        });
        parse(&text.unwrap())
    };
    let has_ten = |spread| chart(spread).0.iter().any(|t| t == "10");
    assert!(!has_ten(vec![]));
    assert!(has_ten(vec![vec![Some(0.5), Some(8.0)]]));
}

#[test]
fn lines_break_at_what_cannot_be_drawn() {
    let series = |name: &str, y: &[f64]| Series {
        name: name.to_owned(),
        points: y.iter().enumerate().map(|(i, y)| (i as f64, *y)).collect(),
    };
    let mut chart = LineChart {
        title: "loss & <steps>".to_owned(),
        x_label: "step".to_owned(),
        y_label: "loss".to_owned(),
        log_x: false,
        log_y: true,
        dots: true,
        series: vec![
            series("training", &[1.0, 0.1, 0.0, 0.01, f64::NAN, 1e-3]),
            series("validation", &[2.0, 0.2, 0.1, 0.05, 0.04, 0.03]),
        ],
    };
    let (texts, count) = parse(&lines_svg(&chart).unwrap());
    assert_says(&texts, &["loss & <steps>", "step", "loss", "training", "validation"]);
    assert_eq!(count("circle"), 4 + 6);
    chart.log_y = false;
    let (_, count) = parse(&lines_svg(&chart).unwrap());
    assert_eq!(count("circle"), 5 + 6);
    chart.series[0].name = "a frame while two contacts are followed".to_owned();
    let (texts, _) = parse(&lines_svg(&chart).unwrap());
    assert_says(&texts, &["a frame while two", "contacts are followed"]);
    chart.series = vec![series("nothing", &[f64::NAN])];
    assert!(lines_svg(&chart).is_err());
}

#[test]
fn scatter_thins_evenly() {
    let truth: Vec<f64> = (0..1000).map(f64::from).collect();
    let mut predicted = truth.clone();
    predicted[0] = f64::NAN;
    let mut scatter = Scatter {
        title: "force",
        quantity: "force, N",
        truth: &truth,
        predicted: &predicted,
        max_points: 250,
    };
    let (texts, count) = parse(&scatter_svg(&scatter).unwrap());
    assert_says(&texts, &["force", "true force, N", "predicted force, N"]);
    assert_eq!(count("circle"), 250);
    scatter.max_points = 0;
    assert!(scatter_svg(&scatter).is_err());
}

#[test]
fn unrolled_surface_shows_nodes_contacts_and_errors() {
    let ring: Vec<[f64; 3]> = (0..40)
        .map(|i| {
            let (sin, cos) = (f64::from(i) * 0.157).sin_cos();
            [0.03 * cos, 1e-3 * f64::from(i), 0.03 * sin]
        })
        .collect();
    let points = unroll(&ring, &ring, 1).unwrap();
    let mut values: Vec<f64> = (0..40).map(f64::from).collect();
    values[3] = f64::NAN;
    let figure = Unrolled {
        title: "map",
        value_label: "µm",
        points: &points,
        values: &values,
        range: None,
        markers: &[
            UnrolledMarker { at: points[2], mark: Mark::True },
            UnrolledMarker { at: points[3], mark: Mark::Found },
        ],
        arrows: &[UnrolledArrow { from: points[2], to: points[3], series: 0 }],
        arrow_names: &[],
    };
    let (texts, count) = parse(&unrolled_svg(&figure).unwrap());
    assert_says(&texts, &["map", "angle, degrees", "height, mm", "-180", "90", "µm", "39", "0"]);
    assert_eq!(count("circle"), 40 + 1 + 1, "nodes, arrow head, ring");
    let row = unrolled_row_svg(&[figure.clone(), figure.clone()]).unwrap();
    assert_eq!(parse(&row).1("circle"), 2 * 42, "both surfaces are there");
    let named = Unrolled { value_label: "", arrow_names: &["SVR", "FNN"], ..figure.clone() };
    let (texts, _) = parse(&unrolled_svg(&named).unwrap());
    assert_says(&texts, &["SVR", "FNN"]);
    assert!(!texts.iter().any(|t| t == "39"), "no colour bar");
    let lost = Unrolled {
        markers: &[UnrolledMarker { at: [f64::NAN, 0.0], mark: Mark::True }],
        ..figure.clone()
    };
    assert!(unrolled_svg(&lost).is_err());
    let short = Unrolled { values: &values[1..], ..figure };
    assert!(unrolled_svg(&short).is_err());
}
