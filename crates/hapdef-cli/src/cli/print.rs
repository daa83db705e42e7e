//! `hapdef print`: the limb to print, and where its gauges are glued.

mod drawing;

use std::path::Path;

use anyhow::{Context, Result, ensure};
use clap::Args;
use hapdef::{GaugePlace, Limb, PrintParams, PrintedLimb, print_limb};
use hapdef_cli::{SceneArgs, print_json, shown};
use hapdef_mesh::{GltfParams, LengthUnit, QualityReport, atomic_write, read_surface, write_stl};
use serde_json::{Value, json};
use std::io::Write as _;

/// Read back, the volume may differ by this share.
const MAX_VOLUME_CHANGE: f64 = 0.02;

#[derive(Args)]
#[command(after_help = "Example:\n  \
    hapdef print fixtures/shin/placed.json\n\n\
    limb.stl is in millimetres; places-1.svg is drawn 1:1: print it at 100 %.")]
pub(crate) struct PrintArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Depth of the gauges' pockets, mm.
    #[arg(long, default_value_t = 0.2)]
    pocket: f64,
    /// How much is cut off at the mount's end, mm; half the mount when not given, if the limb is closed there.
    #[arg(long)]
    trim: Option<f64>,
    /// Print what was made as JSON.
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: &PrintArgs) -> Result<()> {
    ensure!(args.pocket > 0.0, "--pocket {}: expected more than 0 mm", args.pocket);
    let run = args.scene.prepare()?;
    let limb = Limb::load(&run.scene, &run.scene_dir)?;
    let params = PrintParams {
        pocket_m: args.pocket * 1e-3,
        trim_m: args.trim.map(|mm| mm * 1e-3),
        ..PrintParams::default()
    };
    let printed = print_limb(&run.scene, &limb, &params)?;
    let out = args.scene.results.join(&run.scene.name).join("print");
    std::fs::create_dir_all(&out).with_context(|| format!("making {}", shown(&out)))?;
    let stl = out.join("limb.stl");
    write_stl(&stl, &printed.body)?;
    let read = read_back(&stl, &printed)?;
    for (number, page) in (1..).zip(drawing::pages(&run.scene.name, &printed.places)) {
        let path = out.join(format!("places-{number}.svg"));
        atomic_write(&path, |file| file.write_all(page.as_bytes()))
            .with_context(|| format!("writing {}", shown(&path)))?;
    }
    if args.json {
        return Ok(print_json(&as_json(&stl, &read, &printed), false)?);
    }
    in_words(&stl, &read, &printed);
    Ok(())
}

fn in_words(stl: &Path, read: &QualityReport, printed: &PrintedLimb) {
    let (n, volume_cm3) = (read.n_triangles, 1e6 * read.signed_volume_m3);
    println!(
        "limb        {}, read back: one closed body, {n} triangles, {volume_cm3:.2} cm³",
        shown(stl)
    );
    println!("trimmed     {:.1} mm at the mount", 1e3 * printed.trim_m);
    println!("pockets     {}, {:.3} cm³ in all", printed.places.len(), 1e6 * printed.pockets_m3);
    let folder = stl.parent().unwrap_or(stl);
    println!("places      {}, from each gauge's middle to the rims, mm:", shown(folder));
    for place in &printed.places {
        println!("    {:<8} {}", place.name, drawing::rims(place));
    }
}

fn as_json(stl: &Path, read: &QualityReport, printed: &PrintedLimb) -> Value {
    let place = |place: &GaugePlace| {
        json!({
            "name": place.name,
            "size_m": place.size_m,
            "turn_rad": place.turn_rad,
            "rims_m": place.rims_m,
        })
    };
    json!({
        "stl": stl,
        "n_triangles": read.n_triangles,
        "volume_m3": read.signed_volume_m3,
        "trim_m": printed.trim_m,
        "pockets_m3": printed.pockets_m3,
        "places": printed.places.iter().map(place).collect::<Vec<_>>(),
    })
}

/// What a slicer will find in the file.
fn read_back(stl: &Path, printed: &PrintedLimb) -> Result<QualityReport> {
    let params = GltfParams { unit: LengthUnit::Millimetre, ..GltfParams::default() };
    let report = QualityReport::of(&read_surface(stl, &params)?.mesh);
    ensure!(
        report.is_closed() && report.n_bodies == 1,
        "{}: {} bodies with {} open edges where one closed body is wanted; trim a little more or less",
        shown(stl),
        report.n_bodies,
        report.n_open_edges
    );
    let volume_m3 = printed.body.signed_volume_m3();
    let change = report.signed_volume_m3 / volume_m3 - 1.0;
    ensure!(
        change.abs() <= MAX_VOLUME_CHANGE,
        "{}: the volume differs by {:.1} % from the limb's",
        shown(stl),
        100.0 * change
    );
    Ok(report)
}
