//! Errors as plots: figures 4, 5A, 8, 9B and 9C.

use anyhow::Result;
use hapdef::{ContactPair, ForceBin, Hapdefx, by_force, score_lenient, score_one_to_one, scored};
use hapdef_bench::dotted_lines;
use hapdef_bench::stats::mean_and_sd;
use hapdef_report::{BarChart, BarPanel, Figure, Series, Unrolled, UnrolledArrow};

use super::super::frames::Frame;
use super::super::patches::{METHODS, SizePoint};
use super::super::scores::{TOP_WITH_SPREAD, choose};
use super::super::singles::Singles;
use super::surface::Surface;

/// Presses whose errors figure 4B shows.
const N_ARROWS: usize = 24;

/// Errors of SVR, k-NN and FNN on single presses.
pub(super) fn figure_4a(singles: &Singles) -> Result<Figure> {
    let (mut values, mut spread) = (vec![], vec![]);
    for method in &singles.direct {
        let errors: Vec<ContactPair> = singles.errors(method).into_iter().flatten().collect();
        let mm: Vec<f64> = errors.iter().map(|e| e.position_error_m * 1e3).collect();
        let newtons: Vec<f64> = errors.iter().map(|e| e.force_error_n.abs()).collect();
        let cells = [mean_and_sd(&mm), mean_and_sd(&newtons)];
        values.push(cells.map(|c| Some(c.0)).to_vec());
        spread.push(cells.map(|c| Some(c.1)).to_vec());
    }
    let chart = BarChart {
        y_label: "mm, N".into(),
        x_label: "error".into(),
        log_y: false,
        groups: vec!["position, mm".into(), "force, N".into()],
        series: singles.direct.iter().map(|m| m.name.clone()).collect(),
        panels: vec![BarPanel { title: "single contacts".into(), values, paper: vec![], spread }],
    };
    let caption = "Figure 4A: mean errors on single test presses of the rig, straight from \
                   readings; error bars: standard deviation over presses.";
    Ok(Figure::bars("figure4a.svg", caption, &chart)?)
}

/// Error arrows of the same methods on the unrolled surface.
pub(super) fn figure_4b(surface: &Surface, singles: &Singles) -> Result<Figure> {
    let stride = (singles.truth.len() / N_ARROWS).max(1);
    let place = |c: &[f32; 4]| [c[0], c[1], c[2]].map(f64::from);
    let mut arrows = vec![];
    for (series, method) in singles.direct.iter().enumerate() {
        let shown = singles.truth.iter().zip(&method.found).step_by(stride);
        for (truth, found) in shown.filter_map(|(truth, found)| Some((truth, (*found)?))) {
            let [from, to] = [*truth, found].map(|c| surface.unroll(&[place(&c)]));
            let (from, to) = (from?[0], to?[0]);
            arrows.push(UnrolledArrow { from, to, series });
        }
    }
    let points = surface.unroll(&surface.positions)?;
    let names: Vec<&str> = singles.direct.iter().map(|m| m.name.as_str()).collect();
    let arrows = Unrolled {
        title: "",
        value_label: "",
        points: &points,
        values: &vec![f64::NAN; points.len()],
        range: Some([0.0, 1.0]),
        markers: &[],
        arrows: &arrows,
        arrow_names: &names,
    };
    let caption = format!(
        "Figure 4B: from the true to the found position (dot) for every {stride}th single test \
         press."
    );
    Ok(Figure::unrolled("figure4b.svg", caption, &[arrows])?)
}

/// Map error against the number of virtual gauges, on one and on two contacts.
pub(super) fn figure_5a(points: &[SizePoint]) -> Result<Vec<Figure>> {
    let chart = |i: usize, file: &str, name: &str| {
        let series = METHODS.iter().enumerate().map(|(m, method)| Series {
            name: (*method).to_owned(),
            points: points
                .iter()
                .map(|point| (point.size as f64, point.errors[m][i].mean_abs_um))
                .collect(),
        });
        let labels = ["virtual gauges around each gauge", "mean |error| of the map, µm"];
        let title = format!("{name} presses of the rig");
        let chart = dotted_lines(title, labels, [false, false], series);
        let caption = format!(
            "Figure 5A, {name} contacts: F_T by three methods, then F_R. Every net here is trained \
             briefly; the paper's optimum on two contacts is 24."
        );
        anyhow::Ok(Figure::lines(file, caption, &chart)?)
    };
    Ok(vec![chart(0, "figure5a_single.svg", "single")?, chart(1, "figure5a_double.svg", "double")?])
}

/// Errors of the ablations on single presses against the force.
pub(super) fn figure_8(singles: &Singles, strongest_n: f64) -> Result<Vec<Figure>> {
    let methods = || singles.direct.iter().skip(2).chain(&singles.ablations);
    let chart = |y_label: &str, value: fn(&ForceBin) -> f64| {
        let series = methods().map(|method| {
            let bins = singles.by_force(method, strongest_n);
            let points = bins.iter().map(|bin| (bin.force_n, value(bin))).collect();
            Series { name: method.name.clone(), points }
        });
        let labels = ["force, N", y_label];
        dotted_lines("single presses of the rig", labels, [false, false], series)
    };
    Ok(vec![
        Figure::lines(
            "figure8a.svg",
            "Figure 8A: position error with parts of the chain left out. R: readings, S: virtual \
             gauges, D: map; \"net\": position and force straight from the map.",
            &chart("position error, mm", |bin| bin.position_mm),
        )?,
        Figure::lines(
            "figure8b.svg",
            "Figure 8B: force error of the same.",
            &chart("force error, N", |bin| bin.force_error_n),
        )?,
    ])
}

/// Errors on double presses against the varied force, by both rules.
pub(super) fn figure_9(chain: &Hapdefx, frames: &[Frame], strongest_n: f64) -> Result<Vec<Figure>> {
    if frames.is_empty() {
        return Ok(vec![]);
    }
    let names =
        ["lenient, both contacts", "one-to-one, varied contact", "one-to-one, held contact"];
    let mut errors: [Vec<(f64, Option<ContactPair>)>; 3] = Default::default();
    for frame in frames {
        let found = scored(&choose(chain, frame, TOP_WITH_SPREAD)?);
        let varied_n = frame.truth[1].1;
        let lenient = score_lenient(&found, &frame.truth)?;
        errors[0].extend(lenient.into_iter().map(|pair| (varied_n, Some(pair))));
        for pair in score_one_to_one(&found, &frame.truth)?.pairs {
            errors[if pair.truth == 1 { 1 } else { 2 }].push((varied_n, Some(pair)));
        }
    }
    let chart = |y_label: &str, value: fn(&ForceBin) -> f64| {
        let series = names.iter().zip(&errors).map(|(name, errors)| {
            let bins = by_force(errors, strongest_n);
            let points = bins.iter().map(|bin| (bin.force_n, value(bin))).collect();
            Series { name: (*name).to_owned(), points }
        });
        let title = "double presses of the rig, T given, T + 1";
        dotted_lines(title, ["force of the varied contact, N", y_label], [false, false], series)
    };
    let position = chart("position error, mm", |bin| bin.position_mm);
    let force = chart("force error, N", |bin| bin.force_error_n);
    let caption = |letter: &str, what: &str| {
        format!("Figure 9{letter}: {what} error of two contacts, one held at about 30 N.")
    };
    Ok(vec![
        Figure::lines("figure9b.svg", caption("B", "position"), &position)?,
        Figure::lines("figure9c.svg", caption("C", "force"), &force)?,
    ])
}
