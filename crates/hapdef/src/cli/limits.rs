//! `hapdef limits`: what a scene's gauges can tell about contacts.

use std::path::Path;

use anyhow::Result;
use clap::Args;
use hapdef::touch::{LimitsReport, LimitsRequest, limits, response_map};
use hapdef::{Limb, SceneArgs};
use hapdef_inverse::LimitParams;
use hapdef_mesh::{VertexField, write_glb};
use serde_json::{Value, json};

#[derive(Args)]
#[command(
    after_help = "Example:\n  hapdef limits fixtures/shin/scene.json --noise-ue 5\n\n\
    Bounds are Cramér–Rao's: no unbiased estimator does better. The picture is a .glb with the \
    bound as colour."
)]
pub(crate) struct LimitsArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Standard deviation of a reading's noise, µε.
    #[arg(long, default_value_t = 5.0)]
    noise_ue: f64,
    /// Force of every contact, N.
    #[arg(long, default_value_t = 10.0)]
    force_n: f64,
    /// A bound up to this is usable, mm.
    #[arg(long, default_value_t = 5.0)]
    usable_mm: f64,
    /// Print the figures as JSON.
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: &LimitsArgs) -> Result<()> {
    let run = args.scene.prepare()?;
    let limb = Limb::load(&run.scene, &run.scene_dir)?;
    let contact = &run.scene.contact;
    let map = response_map(&limb, contact.tip_radius_m, run.threads)?;
    let request = LimitsRequest {
        noise_ue: args.noise_ue,
        n_sites: 800,
        n_partners: 24,
        carried: LimitParams {
            force_n: args.force_n,
            min_gap_m: contact.min_spacing_m,
            usable_sd_m: args.usable_mm * 1e-3,
            seed: run.scene.seed,
            ..LimitParams::default()
        },
    };
    let report = limits(map, &request)?;
    let picture = args.scene.out.join(&run.scene.name).join("limits.glb");
    draw(&picture, &limb, &report, request.carried.usable_sd_m)?;
    if args.json {
        println!("{}", as_json(&limb, &request, &report));
    } else {
        print(&request, &report, &picture);
    }
    Ok(())
}

/// The single bound as colour, from 0 to what is usable.
fn draw(path: &Path, limb: &Limb, report: &LimitsReport, usable_m: f64) -> Result<()> {
    let values: Vec<f64> = report.single_m.iter().map(|b| b.min(usable_m)).collect();
    let surface = limb.skin.surface(&limb.mesh)?;
    let field = VertexField {
        name: "position_bound_m",
        values: &values,
        range: Some((0.0, usable_m)),
    };
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder)?;
    }
    Ok(write_glb(path, &surface, Some(&field))?)
}

fn print(request: &LimitsRequest, report: &LimitsReport, picture: &Path) {
    let mm = |metres: f64| format!("{:8.2}", metres * 1e3);
    println!(
        "bounds at {} µε of noise, contacts of {} N\n\n{:16} median mm  95 % mm",
        request.noise_ue, request.carried.force_n, ""
    );
    let quantiles = |of: &dyn Fn(f64) -> f64| format!("{}   {}", mm(of(0.5)), mm(of(0.95)));
    println!(
        "{:16}{}",
        "one contact",
        quantiles(&|q| report.single_quantile_m(q))
    );
    println!(
        "{:16}{}",
        "one of two",
        quantiles(&|q| report.pair_quantile_m(q))
    );
    println!("\ncontacts  median mm  95 % mm  singular  carried");
    for row in &report.carried {
        println!(
            "{:8} {}  {}  {:6.1} %  {}",
            row.n_contacts,
            mm(row.median_sd_m),
            mm(row.p95_sd_m),
            row.singular_share * 100.0,
            if row.is_carried { "yes" } else { "no" }
        );
    }
    println!(
        "\n{} of {} surface nodes are blind spots (bound beyond {} mm)\npicture: {}",
        report.blind_nodes.len(),
        report.single_m.len(),
        request.carried.usable_sd_m * 1e3,
        picture.display()
    );
}

fn as_json(limb: &Limb, request: &LimitsRequest, report: &LimitsReport) -> Value {
    let carried = report.carried.iter().map(|row| {
        json!({
            "n_contacts": row.n_contacts,
            "median_m": finite(row.median_sd_m),
            "p95_m": finite(row.p95_sd_m),
            "singular_share": row.singular_share,
            "is_carried": row.is_carried,
        })
    });
    let nodes = limb.surface_points().into_iter().zip(&report.single_m);
    let blind = report.blind_nodes.iter().copied();
    json!({
        "noise_ue": request.noise_ue,
        "force_n": request.carried.force_n,
        "usable_m": request.carried.usable_sd_m,
        "single_median_m": finite(report.single_quantile_m(0.5)),
        "single_p95_m": finite(report.single_quantile_m(0.95)),
        "pair_median_m": finite(report.pair_quantile_m(0.5)),
        "pair_p95_m": finite(report.pair_quantile_m(0.95)),
        "carried": carried.collect::<Vec<_>>(),
        "blind_nodes": blind.collect::<Vec<_>>(),
        "single": nodes
            .map(|(x, bound)| json!({"position_m": [x.x, x.y, x.z], "bound_m": finite(*bound)}))
            .collect::<Vec<_>>(),
    })
}

/// JSON has no infinity: a bound that doesn't exist is null.
fn finite(value: f64) -> Option<f64> {
    Some(value).filter(|v| v.is_finite())
}
