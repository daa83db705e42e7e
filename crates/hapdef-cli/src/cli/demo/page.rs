//! The demo's page: the limb with true and found contacts, the errors, what to do next.

use std::path::PathBuf;

use anyhow::{Context, Result};
use hapdef::touch::TouchScore;
use hapdef::{Limb, Run, ScoredContact};
use hapdef_bench::stats::{quantile, sorted};
use hapdef_bench::{Column, table};
use hapdef_cli::shown;
use hapdef_inverse::ContactEstimator;
use hapdef_report::{
    Figure, Headline, LimbMarker, LimbPicture, Mark, RenderParams, Report, ReportTable, Summary,
    write_report,
};
use nalgebra::{Point3, Vector3};

use super::super::pages;
use super::{DemoArgs, Found, in_words};

/// Median errors of the paper's chain of networks, trained in full, on the bundled limb, mm: one contact
/// and two, as docs/contacts.md has them.
const PAPER_CHAIN_MM: [(usize, f64); 2] = [(1, 4.1), (2, 30.0)];

/// The errors, a row for each number of contacts.
pub(super) const COLUMNS: [Column<TouchScore>; 6] = [
    Column::new("contacts", |s| in_words(s.n_contacts)),
    Column::new("median error", |s| format!("{:.2} mm", s.median_mm)),
    Column::new("mean of found", |s| format!("{:.2} mm", s.errors.mean_mm)),
    Column::new("within 10 mm", |s| format!("{:.0} %", 100.0 * s.share_within_10mm)),
    Column::new("force error", |s| format!("{:.2} N", s.errors.mean_n)),
    Column::new("time", |s| format!("{:.3} ms", s.median_ms)),
];

/// What the demo came to.
pub(super) fn sentence(found: &Found) -> String {
    let scores = &found.scores;
    let of =
        |text: fn(&TouchScore) -> String| scores.iter().map(text).collect::<Vec<_>>().join(", ");
    format!(
        "{} gauges, calibrated by {} simulated presses, find {}: medians. {} of the contacts are found within \
         10 mm.",
        found.n_gauges,
        found.n_presses,
        of(|score| format!("{} {:.2} mm off", in_words(score.n_contacts), score.median_mm)),
        of(|score| format!("{:.0} %", 100.0 * score.share_within_10mm)),
    )
}

/// What shows the limb live.
pub(super) fn live_command(args: &DemoArgs) -> String {
    format!("hapdef live {} --sim --view", shown(&args.scene.scene))
}

/// Writes the report into the scene's folder; the path of its page.
pub(super) fn write(
    args: &DemoArgs,
    run: &Run,
    limb: &Limb,
    estimator: &ContactEstimator,
    found: &Found,
) -> Result<PathBuf> {
    let origin = pages::origin(run, &[])?;
    let report = Report {
        title: format!("A sense of touch for {}", run.scene.name),
        scene: run.scene.name.clone(),
        seed: run.scene.seed,
        facts: vec![
            pages::fact("simulated", "all readings come from the simulated rig; no hardware".into()),
            pages::fact("gauges", found.n_gauges.to_string()),
            pages::fact(
                "calibration",
                format!(
                    "{} presses; the map is {:.1} % off at presses that were not used",
                    found.n_presses,
                    100.0 * found.map_error
                ),
            ),
        ],
        summary: Some(Summary {
            sentence: sentence(found),
            numbers: found.scores.iter().map(headline).collect(),
            picture: Some(picture(limb, estimator, found)?),
            next: vec![
                format!("See it live and press it with the mouse: {}", live_command(args)),
                "Bring your own limb: hapdef new LIMB.stl".into(),
            ],
        }),
        tables: vec![ReportTable {
            title: "How well contacts are found".into(),
            note: "Presses that the calibration has not seen, 2 N to the scene's strongest. One and two \
                contacts in single frames, four followed while they come one after another. Median: over \
                all true contacts, one that is not found is infinitely far."
                .into(),
            text: table(&COLUMNS, &found.scores),
            data: serde_json::to_value(&found.scores)?,
        }],
        hashes: origin.hashes,
        ..Report::default()
    };
    let paths = write_report(&args.scene.results.join(&run.scene.name).join("demo"), &report)?;
    paths.into_iter().next_back().context("the page's path")
}

fn headline(score: &TouchScore) -> Headline {
    let of_chain = PAPER_CHAIN_MM.iter().find(|(n, _)| *n == score.n_contacts);
    let beside = of_chain.map_or_else(
        || "followed while they come one after another".into(),
        |(_, mm)| format!("the paper's chain, last full run: {mm} mm"),
    );
    Headline {
        value: format!("{:.2} mm", score.median_mm),
        what: format!("{}, median", in_words(score.n_contacts)),
        beside,
    }
}

/// The limb from both sides with the contacts of a usual press of the most contacts, the colour what the
/// gauge that feels it best reads.
fn picture(limb: &Limb, estimator: &ContactEstimator, found: &Found) -> Result<Figure> {
    let surface = limb.skin.surface(&limb.mesh)?;
    let positions: Vec<[f64; 3]> = surface.vertices().iter().map(|p| p.coords.into()).collect();
    let score = found.scores.last().context("no contacts were looked for")?;
    let [truth, detected] = &score.typical;
    let mark = |mark| move |contact: &ScoredContact| LimbMarker { position: contact.0, mark };
    let gauges = limb
        .sites
        .iter()
        .map(|site| LimbMarker { position: site.position.coords.into(), mark: Mark::Gauge });
    let contacts = truth.iter().map(mark(Mark::True)).chain(detected.iter().map(mark(Mark::Found)));
    let markers: Vec<LimbMarker> = gauges.chain(contacts).collect();
    let values = strongest_ue_per_n(estimator, surface.vertices())?;
    let most = quantile(&sorted(values.iter().copied()), 0.98);
    let up_axis = Vector3::from(limb.axis.direction).iamax();
    let picture = |title, azimuth_deg: f64| {
        let picture = LimbPicture {
            title,
            value_label: "µε per N",
            positions: &positions,
            triangles: surface.triangles(),
            values: &values,
            markers: &markers,
        };
        let params = RenderParams {
            up_axis,
            azimuth_rad: azimuth_deg.to_radians(),
            width_px: 520,
            height_px: 430,
            range: Some([0.0, most]),
            ..RenderParams::default()
        };
        (picture, params)
    };
    let caption = format!(
        "{}: rings are true contacts, crosses those that were found, squares gauges; faint where the limb \
         hides them. Colour: reading of the gauge that feels a newton there best.",
        in_words(score.n_contacts)
    );
    Ok(Figure::limbs("contacts.svg", caption, &[picture("front", 30.0), picture("back", 210.0)])?)
}

/// For each point the reading of the gauge that feels a newton there best, µε/N.
fn strongest_ue_per_n(estimator: &ContactEstimator, points: &[Point3<f64>]) -> Result<Vec<f64>> {
    let map = estimator.map();
    let strongest = |point: &Point3<f64>| {
        let (at, _) = map.skin().nearest(point)?;
        Ok(map.normal(&at).into_iter().map(f64::abs).fold(0.0, f64::max))
    };
    points.iter().map(strongest).collect()
}

#[cfg(test)]
mod tests {
    use super::PAPER_CHAIN_MM;

    #[test]
    fn the_papers_chain_is_as_far_off_as_the_docs_say() {
        let docs = include_str!("../../../../../docs/contacts.md");
        for ((_, median_mm), row) in PAPER_CHAIN_MM.iter().zip(["one contact", "two"]) {
            let line = format!("| {row}, the paper's chain | ");
            let cells = docs.lines().find_map(|text| text.strip_prefix(&line)).unwrap();
            let errors = cells.split(" mm").next().unwrap();
            assert_eq!(errors.split(", ").nth(1).unwrap().parse::<f64>().unwrap(), *median_mm);
        }
    }
}
