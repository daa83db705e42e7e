//! `hapdef limits`: what a scene's gauges can tell about contacts.

use std::path::Path;

use anyhow::Result;
use clap::Args;
use hapdef::touch::{LimitsReport, LimitsRequest, limits, response_with_loads};
use hapdef::{Limb, Run, write_json};
use hapdef_cli::{SceneArgs, shown};
use hapdef_inverse::LimitParams;
use hapdef_mesh::{VertexField, write_glb};
use hapdef_report::{Block, LimbMap, LimbView, Page, TextTable, text_table};
use serde_json::{Value, json};

use super::pages;

/// What is not bounded.
const LEFT_OUT: [(&str, &str); 2] = [
    ("tangential forces", "contacts press along the normal"),
    ("most pairs of places", "24 partners are drawn for each of 800 places"),
];

#[derive(Args)]
#[command(after_help = "Example:\n  hapdef limits fixtures/shin/scene.json --noise-ue 5\n\n\
    Bounds are Cramér–Rao's: no unbiased estimator does better. The page limits.html has them on \
    the limb, limits.json the figures, limits.glb the limb with the bound as colour.")]
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
    let (map, loads) = response_with_loads(&run, &limb)?;
    let n_loads = loads.len();
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
    let report = limits(map, loads, &request)?;
    let picture = args.scene.results.join(&run.scene.name).join("limits.glb");
    draw(&picture, &limb, &report, request.carried.usable_sd_m)?;
    let origin = pages::origin(&run, &LEFT_OUT)?;
    let mut figures = as_json(&limb, &request, &report);
    figures["n_loads"] = json!(n_loads);
    figures["single_median_unloaded_m"] = json!(report.unloaded_m.and_then(finite));
    let figures = origin.with(figures);
    write_json(&picture.with_extension("json"), &figures)?;
    let page_file = picture.with_extension("html");
    let mut page = page(&run, &limb, &request, &report)?;
    if let Some(unloaded_m) = report.unloaded_m {
        page.facts.push(pages::fact("loads", beside(n_loads, unloaded_m)));
    }
    page.facts.extend(origin.facts());
    page.write(&page_file)?;
    if args.json {
        println!("{figures}");
    } else {
        if let Some(unloaded_m) = report.unloaded_m {
            println!("{}", beside(n_loads, unloaded_m));
        }
        print(&request, &report, &page_file);
    }
    Ok(())
}

/// What is unknown beside the contacts, and what it costs.
fn beside(n_loads: usize, unloaded_m: f64) -> String {
    format!(
        "beside {n_loads} unknown loads that are no contacts, as the scene's loads say; without them the median of \
         one contact would be {:.2} mm",
        unloaded_m * 1e3
    )
}

/// Bounds in tables and on the limb.
fn page(run: &Run, limb: &Limb, request: &LimitsRequest, report: &LimitsReport) -> Result<Page> {
    let usable_m = request.carried.usable_sd_m;
    let fact = |name: &str, text: String| pages::fact(name, text);
    let most = report.carried.iter().filter(|row| row.is_carried);
    let most = most.map(|row| row.n_contacts).max().unwrap_or_default();
    let n_blind = report.blind_nodes.len();
    Ok(Page {
        title: format!("What the gauges of {} can tell", run.scene.name),
        facts: vec![
            fact("scene", run.scene.name.clone()),
            fact("noise", format!("{} µε", request.noise_ue)),
            fact("contacts", format!("{} N each", request.carried.force_n)),
            fact("usable", format!("a bound up to {} mm", usable_m * 1e3)),
            fact("seed", request.carried.seed.to_string()),
        ],
        blocks: vec![
            Block::Verdict {
                text: format!(
                    "{most} contacts at a time; {n_blind} of {} surface nodes are blind spots",
                    report.single_m.len()
                ),
                warns: most == 0 || n_blind > 0,
            },
            Block::Heading("Bounds of a position".into()),
            Block::Table(bounds_table(report)),
            Block::Note(
                "Cramér–Rao's, one standard deviation: no unbiased estimator does better. Carried: \
                 the median is usable."
                    .into(),
            ),
            Block::Heading("One contact".into()),
            Block::Limb(LimbView::new(
                &limb.skin.surface(&limb.mesh)?,
                vec![LimbMap {
                    title: "bound of the position".into(),
                    unit: "mm".into(),
                    factor: 1e3,
                    values: report.single_m.iter().map(|b| b.min(usable_m)).collect(),
                    range: [0.0, report.single_quantile_m(0.99).min(usable_m)],
                }],
                limb.sites.iter().map(|site| site.position.coords.into()).collect(),
            )),
            Block::Note("Rings: gauges, dashed on the far side.".into()),
        ],
    })
}

fn bounds_table(report: &LimitsReport) -> TextTable {
    let mm = |metres: f64| format!("{:.2}", metres * 1e3);
    let of = |name: &str, quantile: &dyn Fn(f64) -> f64| {
        let [median, p95] = [0.5, 0.95].map(|q| mm(quantile(q)));
        [name.into(), median, p95, "–".into(), "–".into()]
    };
    let single = of("one, all over the skin", &|q| report.single_quantile_m(q));
    let pair = of("one of two", &|q| report.pair_quantile_m(q));
    let carried = report.carried.iter().map(|row| {
        [
            format!("{} drawn at random", row.n_contacts),
            mm(row.median_sd_m),
            mm(row.p95_sd_m),
            format!("{:.1} %", row.singular_share * 100.0),
            if row.is_carried { "yes" } else { "no" }.into(),
        ]
    });
    let header = ["contacts", "median, mm", "95 %, mm", "singular", "carried"];
    text_table(header, [single, pair].into_iter().chain(carried))
}

/// The single bound as colour, from 0 to what is usable.
fn draw(path: &Path, limb: &Limb, report: &LimitsReport, usable_m: f64) -> Result<()> {
    let values: Vec<f64> = report.single_m.iter().map(|b| b.min(usable_m)).collect();
    let surface = limb.skin.surface(&limb.mesh)?;
    let field =
        VertexField { name: "position_bound_m", values: &values, range: Some((0.0, usable_m)) };
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder)?;
    }
    Ok(write_glb(path, &surface, Some(&field))?)
}

fn print(request: &LimitsRequest, report: &LimitsReport, page: &Path) {
    let mm = |metres: f64| format!("{:8.2}", metres * 1e3);
    println!(
        "bounds at {} µε of noise, contacts of {} N\n\n{:16} median mm  95 % mm",
        request.noise_ue, request.carried.force_n, ""
    );
    let quantiles = |of: &dyn Fn(f64) -> f64| format!("{}   {}", mm(of(0.5)), mm(of(0.95)));
    println!("{:16}{}", "one contact", quantiles(&|q| report.single_quantile_m(q)));
    println!("{:16}{}", "one of two", quantiles(&|q| report.pair_quantile_m(q)));
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
        "\n{} of {} surface nodes are blind spots (bound beyond {} mm)\npage: {}",
        report.blind_nodes.len(),
        report.single_m.len(),
        request.carried.usable_sd_m * 1e3,
        shown(page)
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
