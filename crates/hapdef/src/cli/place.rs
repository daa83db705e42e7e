//! `hapdef place`: where to put gauges.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use clap::Args;
use hapdef::scene::{EstimatorSpec, SuperpositionSpec};
use hapdef::touch::{LayoutParams, LayoutStudy, ScoredLayout, study_layouts};
use hapdef::{Limb, Run, SceneArgs, write_json};
use hapdef_inverse::PlacementScore;
use nalgebra::Point3;
use serde_json::{Value, json};

#[derive(Args)]
#[command(after_help = "Example:\n  \
    hapdef place fixtures/shin/scene.json --gauges 10 --keep-out 0,0.06,0,0.02\n\n\
    The layout is written as gauges.sites, ready for the scene file.")]
pub(crate) struct PlaceArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Gauges in all.
    #[arg(long, default_value_t = 10)]
    gauges: usize,
    /// So many of the scene's gauges, the first ones, are mounted already and stay.
    #[arg(long, default_value_t = 0)]
    mounted: usize,
    /// Places on the inner wall that are looked at.
    #[arg(long, default_value_t = 160)]
    positions: usize,
    /// Directions tried at each place.
    #[arg(long, default_value_t = 4)]
    axes: usize,
    /// Least distance of two gauges, mm.
    #[arg(long, default_value_t = 10.0)]
    spacing_mm: f64,
    /// Standard deviation of a reading's noise, µε.
    #[arg(long, default_value_t = 5.0)]
    noise_ue: f64,
    /// Force of the contacts, N.
    #[arg(long, default_value_t = 10.0)]
    force_n: f64,
    /// A ball that no gauge's centre may lie in: x,y,z,radius in m; may be given again.
    #[arg(long, value_parser = ball, allow_hyphen_values = true)]
    keep_out: Vec<(Point3<f64>, f64)>,
    /// Write the scene with this layout, its contacts found by superposition, to a file beside it.
    #[arg(long)]
    write: Option<PathBuf>,
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
    let params = LayoutParams {
        n_gauges: args.gauges,
        n_mounted: args.mounted,
        n_positions: args.positions,
        n_axes: args.axes,
        keep_out: args.keep_out.clone(),
        min_spacing_m: args.spacing_mm * 1e-3,
        noise_ue: args.noise_ue,
        force_n: args.force_n,
        seed: run.scene.seed,
        ..LayoutParams::default()
    };
    let study = study_layouts(&run, &limb, &params)?;
    let best = study.layouts.last().context("no layout was made")?;
    let path = args.scene.out.join(&run.scene.name).join("gauges.json");
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder)?;
    }
    write_json(&path, &sites(best))?;
    let curves = path.with_file_name("placement.csv");
    std::fs::write(&curves, as_csv(&study))
        .with_context(|| format!("writing {}", curves.display()))?;
    if let Some(path) = &args.write {
        write_scene(path, &run, best, args)?;
    }
    if args.json {
        println!("{}", as_json(&study));
    } else {
        print(&study, &params);
        println!("\n{}: {} (gauges.sites)", best.name, path.display());
    }
    Ok(())
}

fn print(study: &LayoutStudy, params: &LayoutParams) {
    println!(
        "{} candidates on the inner wall ({} don't fit), solved in {:.2} s\n\n\
         bounds of {} gauges, mm      one: mean   95 %   two: median   95 %   chosen in s",
        study.n_candidates, study.n_refused, study.solve_s, params.n_gauges
    );
    for layout in &study.layouts {
        println!(
            "{:27} {}   {:11.2}",
            layout.name,
            figures(&layout.score),
            layout.elapsed_s
        );
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
        "--write {}: expected a file beside {}, whose paths are relative to its folder",
        path.display(),
        args.scene.scene.display()
    );
    let mut scene = run.scene.clone();
    scene.name.push_str("-placed");
    scene.gauges.sites = serde_json::from_value(sites(layout))?;
    scene.estimator = EstimatorSpec::Superposition(SuperpositionSpec {
        noise_ue: args.noise_ue,
        ..SuperpositionSpec::default()
    });
    Ok(write_json(path, &scene)?)
}

/// `gauges.sites` of a scene, to the micrometre.
fn sites(layout: &ScoredLayout) -> Value {
    let site = |(i, gauge): (usize, &hapdef::touch::PlacedGauge)| {
        json!({
            "name": format!("g{i}"),
            "position_m": <[f64; 3]>::from(gauge.position_m.coords).map(to_millionths),
            "axis": <[f64; 3]>::from(gauge.axis).map(to_millionths),
        })
    };
    layout.gauges.iter().enumerate().map(site).collect()
}

fn to_millionths(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}

fn as_json(study: &LayoutStudy) -> Value {
    let layouts = study.layouts.iter().map(|layout| {
        json!({
            "name": layout.name,
            "sites": sites(layout),
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
