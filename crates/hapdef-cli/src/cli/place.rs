//! `hapdef place`: where to put gauges.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use clap::Args;
use clap::builder::RangedU64ValueParser;
use hapdef::scene::{EstimatorSpec, SuperpositionSpec};
use hapdef::touch::{LayoutParams, LayoutStudy, ScoredLayout, gauge_entries, study_layouts};
use hapdef::{Limb, Run, write_json};
use hapdef_cli::{SceneArgs, shown};
use hapdef_inverse::PlacementScore;
use hapdef_report::{
    Block, Figure, LimbMap, LimbView, LineChart, Page, Series, TextTable, text_table,
};
use nalgebra::Point3;
use serde_json::{Value, json};

use super::pages;

/// A bound of a layout, m.
type Bound = fn(&PlacementScore) -> f64;

/// Bounds that the page plots.
const BOUNDS: [(&str, Bound); 4] = [
    ("One contact: mean", |score| score.single_mean_m),
    ("One contact: 95 %", |score| score.single_p95_m),
    ("One of two contacts: median", |score| score.pair_median_m),
    ("One of two contacts: 95 %", |score| score.pair_p95_m),
];

/// What is not tried.
const LEFT_OUT: [(&str, &str); 1] =
    [("places off the inner wall", "gauges are mounted inside the shell")];

#[derive(Args)]
#[command(after_help = "Example:\n  \
    hapdef place fixtures/shin/scene.json --gauges 10 --keep-out 0,0.06,0,0.02\n\n\
    The layout is written as gauges.sites, ready for the scene file; placement.html has it on the \
    limb and the bounds by number of gauges as a plot.")]
pub(crate) struct PlaceArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Gauges in all.
    #[arg(long, default_value_t = 10, value_parser = RangedU64ValueParser::<usize>::new().range(1..))]
    gauges: usize,
    /// So many of the scene's gauges, the first ones, are mounted already and stay.
    #[arg(long, default_value_t = 0)]
    mounted: usize,
    /// Places on the inner wall that are looked at.
    #[arg(long, default_value_t = 160, value_parser = RangedU64ValueParser::<usize>::new().range(1..))]
    positions: usize,
    /// Directions tried at each place.
    #[arg(long, default_value_t = 4, value_parser = RangedU64ValueParser::<usize>::new().range(1..))]
    axes: usize,
    /// Least distance of two gauges, mm.
    #[arg(long, default_value_t = 10.0)]
    spacing_mm: f64,
    /// How far off a gauge may be glued and must still fit on its wall, mm.
    #[arg(long, default_value_t = 1.0)]
    margin_mm: f64,
    /// Standard deviation of a reading's noise, µε.
    #[arg(long, default_value_t = 5.0)]
    noise_ue: f64,
    /// Force of the contacts, N.
    #[arg(long, default_value_t = 10.0)]
    force_n: f64,
    /// Count the scene's loads that are no contacts as unknown, too: gauges tell contacts from them.
    #[arg(long)]
    beside_loads: bool,
    /// A ball that no gauge's centre may lie in: x,y,z,radius in m; may be given again.
    #[arg(long, value_parser = ball, allow_hyphen_values = true)]
    keep_out: Vec<(Point3<f64>, f64)>,
    /// Write the scene with this layout, its contacts found by superposition, to this file beside it.
    #[arg(short, long, alias = "write", value_name = "FILE")]
    out: Option<PathBuf>,
    /// Print the study as JSON.
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: &PlaceArgs) -> Result<()> {
    let run = args.scene.prepare()?;
    let limb = Limb::load(&run.scene, &run.scene_dir)?;
    let n_own = limb.gauges.len();
    ensure!(
        args.mounted <= args.gauges.min(n_own),
        "--mounted {}: expected at most {}, the scene's gauges and --gauges",
        args.mounted,
        args.gauges.min(n_own)
    );
    ensure!(
        !args.beside_loads || run.scene.loads.is_some(),
        "--beside-loads: expected loads in {}, which has none",
        shown(&args.scene.scene)
    );
    let params = LayoutParams {
        n_gauges: args.gauges,
        n_mounted: args.mounted,
        n_positions: args.positions,
        n_axes: args.axes,
        keep_out: args.keep_out.clone(),
        min_spacing_m: args.spacing_mm * 1e-3,
        margin_m: args.margin_mm * 1e-3,
        noise_ue: args.noise_ue,
        force_n: args.force_n,
        beside_loads: args.beside_loads,
        seed: run.scene.seed,
        ..LayoutParams::default()
    };
    let study = study_layouts(&run, &limb, &params)?;
    let best = study.layouts.last().context("no layout was made")?;
    let path = args.scene.results.join(&run.scene.name).join("gauges.json");
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder)?;
    }
    write_json(&path, &json!(gauge_entries(&best.gauges)))?;
    let curves = path.with_file_name("placement.csv");
    std::fs::write(&curves, as_csv(&study))
        .with_context(|| format!("writing {}", shown(&curves)))?;
    let origin = pages::origin(&run, &LEFT_OUT)?;
    let figures = origin.with(as_json(&study));
    write_json(&curves.with_extension("json"), &figures)?;
    let page_file = curves.with_extension("html");
    let mut page = page(&run, &limb, &params, &study)?;
    page.facts.extend(origin.facts());
    page.write(&page_file)?;
    if let Some(path) = &args.out {
        write_scene(path, &run, best, args)?;
    }
    if args.json {
        println!("{figures}");
    } else {
        print(&study, &params);
        println!("\n{}: {} (gauges.sites)", best.name, shown(&path));
        println!("page: {}", shown(&page_file));
    }
    Ok(())
}

/// Layouts in a table, bounds as plots, the recommended one on the limb.
fn page(run: &Run, limb: &Limb, params: &LayoutParams, study: &LayoutStudy) -> Result<Page> {
    let best = study.layouts.last().context("no layout was made")?;
    let n_candidates = study.n_candidates;
    let mut blocks = vec![
        Block::Verdict {
            text: format!("{}: the layout of the table's last row", best.name),
            warns: false,
        },
        Block::Heading(format!("Bounds of {} gauges", params.n_gauges)),
        Block::Table(layouts_table(study)),
        Block::Note("Cramér–Rao bounds of the position, one standard deviation.".into()),
        Block::Heading("By number of gauges".into()),
    ];
    for (title, bound) in BOUNDS {
        blocks.push(Block::Figure(curves(study, title, bound)?));
    }
    blocks.extend([
        Block::Heading(format!("The layout: {}", best.name)),
        Block::Limb(LimbView::new(
            &limb.skin.surface(&limb.mesh)?,
            vec![distances(limb, best)],
            best.gauges.iter().map(|g| g.position_m.coords.into()).collect(),
        )),
        Block::Note("Rings: gauges, on the inner wall, dashed on the far side.".into()),
    ]);
    Ok(Page {
        title: format!("Where to put gauges on {}", run.scene.name),
        facts: vec![
            pages::fact("scene", run.scene.name.clone()),
            pages::fact("gauges", format!("{}, {} mounted", params.n_gauges, params.n_mounted)),
            pages::fact("noise", format!("{} µε", params.noise_ue)),
            pages::fact("contacts", format!("{} N", params.force_n)),
            pages::fact("candidates", format!("{n_candidates}, {} don't fit", study.n_refused)),
            pages::fact("beside", loads_text(study)),
            pages::fact("solved in", format!("{:.2} s", study.solve_s)),
            pages::fact("seed", params.seed.to_string()),
        ],
        blocks,
    })
}

/// The loads beside which contacts are to be found.
fn loads_text(study: &LayoutStudy) -> String {
    match study.n_loads {
        0 => "no loads but contacts".to_owned(),
        n => format!("{n} unknown loads that are no contacts, as the scene's loads say"),
    }
}

fn layouts_table(study: &LayoutStudy) -> TextTable {
    let mm = |metres: f64| format!("{:.2}", metres * 1e3);
    let row = |layout: &ScoredLayout| {
        let score = &layout.score;
        [
            layout.name.clone(),
            mm(score.single_mean_m),
            mm(score.single_p95_m),
            mm(score.pair_median_m),
            mm(score.pair_p95_m),
            format!("{:.2}", layout.elapsed_s),
        ]
    };
    let header = ["layout", "one: mean, mm", "95 %", "two: median, mm", "95 %", "chosen in, s"];
    text_table(header, study.layouts.iter().map(row))
}

/// One bound of every method by number of gauges.
fn curves(study: &LayoutStudy, title: &str, bound: Bound) -> Result<Figure> {
    let mut series: Vec<Series> = Vec::new();
    for counted in &study.by_count {
        let point = (counted.n_gauges as f64, bound(&counted.score) * 1e3);
        match series.iter_mut().find(|s| s.name == counted.name) {
            Some(found) => found.points.push(point),
            None => series.push(Series { name: counted.name.into(), points: vec![point] }),
        }
    }
    let chart = LineChart {
        title: title.into(),
        x_label: "gauges".into(),
        y_label: "bound, mm".into(),
        log_x: false,
        log_y: true,
        dots: true,
        series,
    };
    let caption = format!("{title}, by number of gauges and method");
    Ok(Figure::lines("", caption, &chart)?)
}

/// How far each place of the skin is from the nearest gauge.
fn distances(limb: &Limb, layout: &ScoredLayout) -> LimbMap {
    let nearest = |x: &Point3<f64>| {
        let gaps = layout.gauges.iter().map(|g| (g.position_m - x).norm());
        gaps.fold(f64::INFINITY, f64::min)
    };
    let values: Vec<f64> = limb.surface_points().iter().map(nearest).collect();
    LimbMap {
        title: "distance to the nearest gauge".into(),
        unit: "mm".into(),
        factor: 1e3,
        range: [0.0, values.iter().copied().fold(0.0, f64::max)],
        values,
    }
}

fn print(study: &LayoutStudy, params: &LayoutParams) {
    println!(
        "{} candidates on the inner wall ({} don't fit), solved in {:.2} s; beside {}\n\n\
         bounds of {} gauges, mm      one: mean   95 %   two: median   95 %   chosen in s",
        study.n_candidates,
        study.n_refused,
        study.solve_s,
        loads_text(study),
        params.n_gauges
    );
    for layout in &study.layouts {
        println!("{:27} {}   {:11.2}", layout.name, figures(&layout.score), layout.elapsed_s);
    }
    println!("\nby number of gauges");
    for counted in &study.by_count {
        let name = format!("{}, {}", counted.name, counted.n_gauges);
        println!("{name:27} {}", figures(&counted.score));
    }
}

fn figures(score: &PlacementScore) -> String {
    format!(
        "{:10.2} {:6.2}   {:11.2} {:6.2}",
        score.single_mean_m * 1e3,
        score.single_p95_m * 1e3,
        score.pair_median_m * 1e3,
        score.pair_p95_m * 1e3
    )
}

/// The scene with the layout's gauges, named `…-placed`.
fn write_scene(path: &Path, run: &Run, layout: &ScoredLayout, args: &PlaceArgs) -> Result<()> {
    let folder = |p: &Path| p.parent().unwrap_or(Path::new("")).canonicalize();
    ensure!(
        folder(path)? == folder(&args.scene.scene)?,
        "--out {}: expected a file beside {}, whose paths are relative to its folder",
        shown(path),
        shown(&args.scene.scene)
    );
    let mut scene = run.scene.clone();
    scene.name.push_str("-placed");
    scene.gauges.sites = gauge_entries(&layout.gauges);
    if let Some(loads) = &mut scene.loads {
        // learned by the gauges that there were
        loads.learned = None;
    }
    scene.estimator = EstimatorSpec::Superposition(SuperpositionSpec {
        noise_ue: args.noise_ue,
        ..SuperpositionSpec::default()
    });
    Ok(write_json(path, &scene)?)
}

fn as_json(study: &LayoutStudy) -> Value {
    let layouts = study.layouts.iter().map(|layout| {
        json!({
            "name": layout.name,
            "sites": gauge_entries(&layout.gauges),
            "bounds": bounds(&layout.score),
            "elapsed_s": layout.elapsed_s,
        })
    });
    let by_count = study
        .by_count
        .iter()
        .map(|c| json!({"name": c.name, "n_gauges": c.n_gauges, "bounds": bounds(&c.score)}));
    json!({
        "n_candidates": study.n_candidates,
        "n_refused": study.n_refused,
        "n_loads": study.n_loads,
        "solve_s": study.solve_s,
        "layouts": layouts.collect::<Vec<_>>(),
        "by_count": by_count.collect::<Vec<_>>(),
    })
}

/// Bounds by method and number of gauges, for plots.
fn as_csv(study: &LayoutStudy) -> String {
    let mut text =
        "method,n_gauges,single_mean_m,single_p95_m,pair_median_m,pair_p95_m\n".to_owned();
    for c in &study.by_count {
        let s = &c.score;
        let _ = writeln!(
            text,
            "{},{},{},{},{},{}",
            c.name, c.n_gauges, s.single_mean_m, s.single_p95_m, s.pair_median_m, s.pair_p95_m
        );
    }
    text
}

fn bounds(score: &PlacementScore) -> Value {
    json!({
        "single_mean_m": score.single_mean_m,
        "single_p95_m": score.single_p95_m,
        "pair_median_m": score.pair_median_m,
        "pair_p95_m": score.pair_p95_m,
    })
}

fn ball(text: &str) -> Result<(Point3<f64>, f64), String> {
    let numbers: Vec<f64> = text
        .split(',')
        .map(|part| part.trim().parse::<f64>())
        .collect::<Result<_, _>>()
        .map_err(|e| format!("{e}; expected x,y,z,radius in metres"))?;
    match numbers[..] {
        [x, y, z, radius] if radius > 0.0 => Ok((Point3::new(x, y, z), radius)),
        _ => Err("expected x,y,z,radius in metres, the radius above 0".into()),
    }
}
