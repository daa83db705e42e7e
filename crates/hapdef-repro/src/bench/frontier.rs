//! `frontier-nets`: error against run time, as a table, plots and JSON.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;
use hapdef_bench::{Column, Metric, Study, against_time, by_cost, or_dash, page_table, table};
use hapdef_cli::{SceneArgs, TrainingArgs};
use hapdef_report::{Figure, Headline, LineChart, Report, SkippedStage, Summary};

use super::measure::{Measured, Point, best_reduced, measure};
use super::variants::Family;
use crate::run::facts;

/// Arguments of `frontier-nets`.
#[derive(Args, Clone, Debug)]
pub(crate) struct FrontierArgs {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    training: TrainingArgs,
    /// Rounds in which every variant is timed.
    #[arg(long, default_value_t = 20)]
    rounds: usize,
    /// Python with onnxruntime, onnx, torch and numpy, for the rows of other programs.
    #[arg(long, env = "HAPDEF_PYTHON", default_value = "python3")]
    python: PathBuf,
}

const STUDY: Study<Vec<Point>> = Study {
    folder: "frontier-nets",
    metrics: &METRICS,
    goals: &[],
    goals_note: "",
    file: Some("frontier.json"),
};

const METRICS: [Metric<Vec<Point>>; 3] = [
    Metric::all("frontier.points", "1", |points| Some(points.len() as f64), "none"),
    REDUCED_P50,
    REDUCED_ERROR,
];

/// The metrics of the best reduced net.
pub(super) const REDUCED: [Metric<Vec<Point>>; 2] = [REDUCED_P50, REDUCED_ERROR];

const REDUCED_P50: Metric<Vec<Point>> = Metric::all(
    "nets.reduced_p50_us",
    "µs",
    |points| Some(best_reduced(points)?.0.times.p50_us),
    "no net found a contact",
);

const REDUCED_ERROR: Metric<Vec<Point>> = Metric::all(
    "nets.reduced_error_ratio",
    "1",
    |points| Some(best_reduced(points)?.1),
    "no net found a contact",
);

/// Measures every variant and writes the report.
pub(crate) fn run(args: &FrontierArgs) -> Result<()> {
    let run = args.training.prepare(&args.scene)?;
    let peers_folder = args.scene.results.join("frontier-nets-peers");
    let Measured { done, points, missing } =
        measure(&run, args.rounds, Some((&args.python, &peers_folder)))?;
    let mut by_time: Vec<&Point> = points.iter().collect();
    by_time.sort_by(|a, b| a.times.p50_us.total_cmp(&b.times.p50_us));
    let text = table(&COLUMNS, by_time);
    let peers = SkippedStage { name: "rows of other programs".into(), reason: missing };
    let mut figures = figures(&points)?;
    let report = Report {
        summary: Some(first(&points, figures.remove(0))),
        tables: vec![page_table("Every method from readings to the map", NOTE, text, &points)?],
        figures,
        stages: facts::stage_times(&done, &[]),
        skipped: if peers.reason.is_empty() { vec![] } else { vec![peers] },
        ..facts::study(&run, "error against run time", run.scene.seed)?
    };
    STUDY.publish(&points, report, &mut facts::log(run.scene.seed), &args.scene.results)?;
    Ok(())
}

/// What a reader sees first: the fastest method, that of the best map, that of the nearest contacts.
fn first(points: &[Point], picture: Figure) -> Summary {
    let least = |of: fn(&Point) -> Option<f64>| {
        let measured = points.iter().filter_map(|p| Some((p, of(p)?)));
        measured.min_by(|a, b| a.1.total_cmp(&b.1))
    };
    let number = |(point, value): (&Point, f64), unit: &str, what: &str| Headline {
        value: format!("{value:.2} {unit}"),
        what: what.to_owned(),
        beside: format!("{}, {:.0} µs", point.name, point.times.p50_us),
    };
    let numbers = [
        least(|p| Some(p.times.p50_us)).map(|best| number(best, "µs", "the fastest")),
        least(|p| p.errors.map_um).map(|best| number(best, "µm", "the best map")),
        least(|p| p.errors.contact_mm).map(|best| number(best, "mm", "the nearest contacts")),
    ];
    let n_front = points.iter().filter(|p| p.on_map_front || p.on_contact_front).count();
    Summary {
        sentence: format!(
            "{n_front} of {} methods from readings to the map are worth choosing: nothing else is both faster and \
             better by the map or by the contacts.",
            points.len()
        ),
        numbers: numbers.into_iter().flatten().collect(),
        picture: Some(picture),
        next: Vec::new(),
    }
}

const NOTE: &str = "Time: F_T and what follows it up to the map, one frame, one core. Map: mean \
    absolute error on simulated test samples of one to four contacts, from exact virtual gauges. \
    Contacts: mean position error on the simulated rig, the mean of single presses and of double \
    presses (the paper's lenient rule with T + 1), through F_T, the method of the row, k-Max and F_S. \
    Front: no other method to the whole map is both faster and better by the map (M), by contacts (C). \
    Training: of the part behind F_T. FNN is F_R trained on I–IV; ranks replace its last layer (or \
    its last two) by two thin ones, from the modes of 500 training samples; parts of the map are \
    the outputs nearest to one node, and their error is over those alone. The direct FNN gives one \
    contact and no map. Other programs have the same F_T and F_R, and a clock of their own, in the \
    same rounds.";

const COLUMNS: [Column<Point>; 11] = [
    Column::new("method", |p| p.name.clone()),
    Column::new("p50, µs", |p| format!("{:.0}", p.times.p50_us)),
    Column::new("p99, µs", |p| format!("{:.0}", p.times.p99_us)),
    Column::new("MB", |p| two_digits(p.bytes.map(|bytes| bytes as f64 * 1e-6))),
    Column::new("map, µm", |p| two_digits(p.errors.map_um)),
    Column::new("contacts, mm", |p| two_digits(p.errors.contact_mm)),
    Column::new("single, mm", |p| two_digits(p.errors.single_mm)),
    Column::new("double, mm", |p| two_digits(p.errors.double_mm)),
    Column::new("found", |p| or_dash(p.errors.found.map(|f| format!("{:.0} %", f * 100.0)))),
    Column::new("training, s", |p| or_dash(p.training_s.map(|s| format!("{s:.1}")))),
    Column::new("front", |p| match (p.on_map_front, p.on_contact_front) {
        (true, true) => "M C".into(),
        (true, false) => "M".into(),
        (false, true) => "C".into(),
        (false, false) => String::new(),
    }),
];

fn two_digits(value: Option<f64>) -> String {
    or_dash(value.map(|v| format!("{v:.2}")))
}

fn figures(points: &[Point]) -> Result<Vec<Figure>> {
    let map = chart(
        points,
        "Map error against run time",
        "mean |error| of the map, µm",
        |p| p.errors.map_um,
        |p| p.on_map_front,
    );
    let contacts = chart(
        points,
        "Contact error against run time",
        "mean position error, mm",
        |p| p.errors.contact_mm,
        |p| p.on_contact_front,
    );
    let figure = |file: &str, what: &str, chart: &LineChart| {
        let caption = format!(
            "{what} against the median time of a frame, logarithmic. Dots of a family are joined \
             from fast to slow; the front is what nothing beats."
        );
        Figure::lines(file, caption, chart)
    };
    Ok(vec![
        figure("frontier_map.svg", "Map error", &map)?,
        figure("frontier_contacts.svg", "Contact error", &contacts)?,
    ])
}

fn chart(
    points: &[Point],
    title: &str,
    y_label: &str,
    error: impl Fn(&Point) -> Option<f64>,
    is_on_front: impl Fn(&Point) -> bool,
) -> LineChart {
    let series = |name: &str, chosen: &dyn Fn(&Point) -> bool| {
        let chosen = points.iter().filter(|p| chosen(p));
        let place = |p: &Point| Some((p.times.p50_us, error(p)?));
        by_cost(name, chosen.filter_map(place))
    };
    let mut all = vec![series("front", &|p| is_on_front(p))];
    let families = Family::ALL.into_iter();
    all.extend(families.map(|family| series(family.name(), &|p: &Point| p.family == family)));
    against_time(title, y_label, all)
}
