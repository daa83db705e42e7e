//! `frontier-inverse`: effort of the search against error, for one to four contacts, with the
//! Cramér–Rao bound as the floor and the paper's nets as rows.

use std::sync::Arc;

use anyhow::Result;
use hapdef::Limb;
use hapdef_bench::stats::median;
use hapdef_bench::{
    Column, Metric, Named, Study, against_time, by_cost, or_dash, page_table, pareto_front, table,
};
use hapdef_inverse::{EstimatorParams, ScanSites, joint_bounds};
use hapdef_report::{Figure, Headline, Report, Summary};
use serde::Serialize;

use super::cells::{Map, score};
use super::paper::{PaperPipeline, VirtualGauges};
use super::rig::Layout;
use super::score::Row;
use super::setup::{Bench, CompareArgs};
use super::world::Frame;
use crate::run::facts;

/// Most contacts at a time.
const MOST: usize = 4;

/// One configuration on frames of one number of contacts.
#[derive(Clone, Debug, Serialize)]
struct Point {
    n_contacts: usize,
    #[serde(flatten)]
    row: Row,
    on_front: bool,
    /// [`floor_mm`] of the frames.
    #[serde(skip)]
    bound_mm: Option<f64>,
}

impl Named for Point {
    fn name(&self) -> &str {
        &self.row.name
    }
}

/// How hard is searched: the efforts that the estimator names, and others around them.
pub(crate) struct Effort {
    pub(crate) name: &'static str,
    pub(crate) n_sites: usize,
    /// The usual parameters with those that this effort sets.
    pub(crate) params: fn(EstimatorParams) -> EstimatorParams,
}

/// Every effort, the least first.
pub(crate) const EFFORTS: [Effort; 6] = [
    Effort { name: "least", n_sites: 200, params: |usual| searched(usual, 10, 2, 0) },
    Effort {
        name: "small",
        n_sites: hapdef_inverse::Effort::Fast.n_sites(),
        params: |usual| usual.searched_with(hapdef_inverse::Effort::Fast),
    },
    Effort { name: "less", n_sites: 800, params: |usual| searched(usual, 60, 8, 0) },
    Effort {
        name: "usual",
        n_sites: hapdef_inverse::Effort::Usual.n_sites(),
        params: |usual| usual.searched_with(hapdef_inverse::Effort::Usual),
    },
    Effort { name: "more", n_sites: 800, params: |usual| searched(usual, 300, 32, 2) },
    Effort {
        name: "most",
        n_sites: hapdef_inverse::Effort::Thorough.n_sites(),
        params: |usual| usual.searched_with(hapdef_inverse::Effort::Thorough),
    },
];

fn searched(
    usual: EstimatorParams,
    n_starts: usize,
    n_finalists: usize,
    n_hops: usize,
) -> EstimatorParams {
    EstimatorParams { n_starts, n_finalists, n_hops, n_bases: 2 * n_starts, ..usual }
}

const STUDY: Study<Vec<Point>> = Study {
    folder: "frontier-inverse",
    metrics: &[Metric::all("frontier.points", "1", |points| Some(points.len() as f64), "none")],
    goals: &[],
    goals_note: "",
    file: Some("frontier.json"),
};

/// Measures every effort and writes the page.
pub(crate) fn run(args: &CompareArgs) -> Result<()> {
    let run = args.training.prepare(&args.scene)?;
    let limb = Limb::load(&run.scene, &run.scene_dir)?;
    let mut bench = Bench::build(&run, &limb, args)?;
    let mut paper = match args.without_paper {
        true => None,
        false => Some(PaperPipeline::train(&run, &limb)?),
    };
    let mut points = Vec::new();
    for k in 1..=MOST {
        run.say(&format!("frames of {k} contacts"));
        let (params, frames) = (bench.params(), bench.apart(k, 50 + k as u64)?);
        let map = bench.map(Layout::Scene, args.presses)?;
        let of_efforts = EFFORTS.iter().map(|e| by_effort(map, params, e, &frames));
        let mut of_k: Vec<Row> = of_efforts.collect::<Result<_>>()?;
        let floor_mm = floor_mm(map, params, &frames)?;
        if let Some(paper) = &mut paper {
            of_k.extend(bench.paper_rows(paper, &frames, VirtualGauges::Transferred)?);
        }
        points.extend(with_front(k, of_k, floor_mm));
    }
    let text = table(&COLUMNS, &points);
    let note = format!(
        "Simulated: the scene's rig, a map calibrated with {} presses. {NOTE}",
        args.presses
    );
    let mut figures = figures(&points)?;
    let report = Report {
        summary: Some(first(&points, figures.remove(0))),
        tables: vec![page_table(
            "Every configuration from readings to contacts",
            note,
            text,
            &points,
        )?],
        ..facts::study(&run, "search effort against error", args.test_seed)?
    };
    STUDY.publish(
        &points,
        report,
        &mut facts::log_of(&run, args.test_seed),
        &args.scene.results,
    )?;
    Ok(())
}

/// What a reader sees first: the usual effort for each number of contacts.
fn first(points: &[Point], picture: Figure) -> Summary {
    let usual = points.iter().filter(|p| p.row.name == "usual");
    let number = |p: &Point| Headline {
        value: format!("{:.2} mm", p.row.errors.mean_mm),
        what: format!("mean error, {} at once", p.n_contacts),
        beside: format!("in {:.0} µs, the usual effort", p.row.p50_us),
    };
    let n_front = points.iter().filter(|p| p.on_front).count();
    let n = points.len();
    Summary {
        sentence: format!(
            "{n_front} of {n} combinations of search effort and number of contacts are worth choosing: no other \
             is as fast and as near."
        ),
        numbers: usual.map(number).collect(),
        picture: Some(picture),
        next: Vec::new(),
    }
}

fn by_effort(map: &Map, usual: EstimatorParams, effort: &Effort, frames: &[Frame]) -> Result<Row> {
    let sites = ScanSites::farthest(map.calibrated.map.skin(), effort.n_sites)?;
    let estimator = map.estimator_at(&Arc::new(sites), (effort.params)(usual))?;
    let score = score(&estimator, map.channels.clone(), frames, |_, _, _, _| Ok(()))?;
    Ok(score.row(effort.name))
}

/// Marks the rows that no other row beats in time and GOSPA.
fn with_front(n_contacts: usize, rows: Vec<Row>, bound_mm: Option<f64>) -> Vec<Point> {
    let costs: Vec<[f64; 2]> = rows.iter().map(|row| [row.p50_us, row.errors.gospa_mm]).collect();
    let on_front = pareto_front(&costs);
    let point = |(row, on_front)| Point { n_contacts, row, on_front, bound_mm };
    rows.into_iter().zip(on_front).map(point).collect()
}

/// Median Cramér–Rao bound of the position, the map's error included, mm; none if most are singular.
fn floor_mm(map: &Map, params: EstimatorParams, frames: &[Frame]) -> Result<Option<f64>> {
    let estimator = map.estimator(params)?;
    let mut bounds = Vec::new();
    for frame in frames {
        let truth: Vec<_> = frame.contacts.iter().map(|c| (c.point, c.force_n)).collect();
        match joint_bounds(&estimator, &truth)? {
            Some(found) => bounds.extend(found.iter().map(|b| b.position_sd_m * 1e3)),
            None => bounds.extend(truth.iter().map(|_| f64::INFINITY)),
        }
    }
    Ok(Some(median(bounds)).filter(|b| b.is_finite()))
}

const NOTE: &str = "Contacts of 5 N to the strongest, 20 mm apart, matched one to one; by superposition their number is estimated, \
    the paper's pipeline is given it. Efforts differ in scan sites, starts that are refined and \
    rounds of new starts. Bound: the median Cramér–Rao bound with the map's error, which no \
    unbiased estimate beats. GOSPA, over the number of contacts: the error where a missed or spurious \
    contact costs 10 mm. Front: no other row is as fast and as near by GOSPA, and better in one.";

const COLUMNS: [Column<Point>; 12] = [
    Column::new("contacts", |p| p.n_contacts.to_string()),
    Column::new("configuration", |p| p.row.name.clone()),
    Column::new("GOSPA, mm", |p| format!("{:.2}", p.row.errors.gospa_mm)),
    Column::new("mean, mm", |p| format!("{:.2}", p.row.errors.mean_mm)),
    Column::new("median", |p| format!("{:.2}", p.row.errors.median_mm)),
    Column::new("90 %", |p| format!("{:.2}", p.row.errors.p90_mm)),
    Column::new("beyond 10 mm", |p| format!("{:.1} %", 100.0 - p.row.errors.within10_pct)),
    Column::new("count right", |p| format!("{:.1} %", p.row.errors.count_pct)),
    Column::new("p50, µs", |p| format!("{:.0}", p.row.p50_us)),
    Column::new("p99, µs", |p| format!("{:.0}", p.row.p99_us)),
    Column::new("bound, mm", |p| or_dash(p.bound_mm.map(|mm| format!("{mm:.2}")))),
    Column::new("front", |p| if p.on_front { "F".into() } else { String::new() }),
];

fn figures(points: &[Point]) -> Result<Vec<Figure>> {
    let series = |k: usize, is_paper: bool| {
        let of_k = points
            .iter()
            .filter(|p| p.n_contacts == k && p.row.name.starts_with("paper") == is_paper);
        let by = if is_paper { "paper" } else { "superposition" };
        by_cost(format!("{k}, {by}"), of_k.map(|p| (p.row.p50_us, p.row.errors.mean_mm)))
    };
    let all = (1..=MOST).flat_map(|k| [series(k, false), series(k, true)]).collect();
    let chart = against_time("Position error against run time", "mean position error, mm", all);
    Ok(vec![Figure::lines(
        "frontier-inverse.svg",
        "Mean position error against the time of a frame, by number of contacts.",
        &chart,
    )?])
}
