//! `hapdef wrap`: one clean skin of a dirty surface.

mod page;

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result};
use clap::Args;
use clap::builder::RangedU64ValueParser;
use hapdef::HapdefError;
use hapdef_cli::{print_json, shown};
use hapdef_mesh::{
    GltfParams, LengthUnit, MeshError, SurfaceMesh, UnitGuess, VertexField, WrapParams, Wrapped,
    read_surface, wrap, write_glb,
};
use serde_json::{Value, json};

use super::unit::Unit;

/// The wall of limbs of 150 mm and more, m; of shorter ones it is a 75th of the length.
const WALL_M: f64 = 0.002;

#[derive(Args)]
#[command(after_help = "Example:\n  \
    hapdef wrap fixtures/shin/shin_skin.glb --wall 1\n\n\
    skin.glb has the skin, coloured by its wall's thickness; wrap.html shows on the limb what was lost and what \
    was bridged, also where the skin is refused.")]
pub(crate) struct WrapArgs {
    /// The surface (.glb, .gltf, .stl, .obj, .dae).
    file: PathBuf,
    /// Unit of its coordinates; the likeliest when not given.
    #[arg(long)]
    unit: Option<Unit>,
    /// Thickness of the wall that is to fit inside, mm; 2, or a 75th of the length if that is less.
    #[arg(long)]
    wall: Option<f64>,
    /// Edge length of the skin, mm.
    #[arg(long)]
    edge: Option<f64>,
    /// Bridge gaps up to twice this wide, mm; 1.5 walls when not given, 5 where that is not faithful.
    #[arg(long)]
    close: Option<f64>,
    /// Threads; results don't depend on it.
    #[arg(long, default_value_t = 2, value_parser = RangedU64ValueParser::<usize>::new().range(1..))]
    threads: usize,
    /// Folder for everything that is written; target/hapdef/<file> when not given.
    #[arg(short, long, value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// Wraps, writes and prints; a skin that is refused, too, has its page.
pub(crate) fn run(args: &WrapArgs) -> Result<()> {
    let (surface, unit, guess) = read(args)?;
    let length_m = surface.bounding_box().longest_m();
    let metres = |mm: f64| mm * 1e-3;
    let wall_m = args.wall.map_or_else(|| WALL_M.min(length_m / 75.0), metres);
    let params = WrapParams {
        edge_m: args.edge.map(metres),
        close_m: args.close.map(metres),
        n_threads: args.threads,
        ..WrapParams::new(wall_m)
    };
    let start = Instant::now();
    let result = wrap(&surface, &params);
    let seconds = start.elapsed().as_secs_f64();
    let out = args.out_folder();
    std::fs::create_dir_all(&out).with_context(|| format!("making {}", shown(&out)))?;
    let given = Given { file: &args.file, surface: &surface, wall_m };
    page::write(&out.join("wrap.html"), &given, &result)?;
    if let Ok(wrapped) = &result {
        let wall = VertexField { name: "wall_m", values: &wrapped.wall_m, range: None };
        write_glb(&out.join("skin.glb"), &wrapped.skin, Some(&wall))?;
    }
    if args.json {
        print_json(&as_json(&given, unit, seconds, &result), false)?;
    } else {
        println!("{}\nunit        {unit} ({guess})", shown(&args.file));
        if let Ok(wrapped) = &result {
            print(wrapped, wall_m, seconds);
        }
        println!("written to  {}", shown(&out));
    }
    result.map(|_| ()).with_context(|| shown(&args.file))
}

/// What was wrapped.
struct Given<'a> {
    file: &'a Path,
    surface: &'a SurfaceMesh,
    wall_m: f64,
}

/// The surface in metres, its unit, and why that.
fn read(args: &WrapArgs) -> Result<(SurfaceMesh, LengthUnit, String)> {
    let given = read_surface(&args.file, &GltfParams::default())?.mesh;
    let guess = UnitGuess::of_length(given.bounding_box().longest_m());
    let (unit, why) = match (args.unit, guess.candidates.first()) {
        (Some(unit), _) => (unit.into(), "as given".to_owned()),
        (None, Some(&likeliest)) => (likeliest, format!("{guess} by --unit")),
        (None, None) => {
            return Err(HapdefError::UnitNotStated { path: args.file.clone(), guess }.into());
        }
    };
    Ok((given.scaled(unit.metres())?, unit, why))
}

impl WrapArgs {
    fn out_folder(&self) -> PathBuf {
        let stem = self.file.file_stem().unwrap_or_default();
        let results = std::env::var_os("HAPDEF_OUT").unwrap_or_else(|| "target/hapdef".into());
        self.out.clone().unwrap_or_else(|| Path::new(&results).join(stem))
    }
}

fn as_json(
    given: &Given<'_>,
    unit: LengthUnit,
    seconds: f64,
    result: &Result<Wrapped, MeshError>,
) -> Value {
    let mut value = json!({
        "file": shown(given.file),
        "unit": unit.symbol(),
        "length_m": given.surface.bounding_box().longest_m(),
        "wall_m": given.wall_m,
        "seconds": seconds,
    });
    match result {
        Err(error) => value["refused"] = json!(error.to_string()),
        Ok(Wrapped { skin, info, .. }) => {
            value["skin"] = json!({
                "n_vertices": skin.vertices().len(),
                "n_triangles": skin.triangles().len(),
                "n_caps": info.n_caps,
                "grid_m": info.grid_m,
                "close_m": info.close_m,
                "edge_m": info.edge_m,
                "share_inside": info.share_inside,
                "share_lost": info.share_lost,
                "lost_m2": info.places.lost_m2,
                "share_bridged": info.share_bridged,
                "bridged_m2": info.places.bridged_m2,
                "input_to_skin_m": info.input_to_skin_m,
                "skin_to_input_m": info.skin_to_input_m,
                "smallest_angle_deg": info.smallest_angle_deg,
                "n_crossings": info.n_crossings,
                "n_thinned": info.n_thinned,
                "seconds": [info.elapsed.grid_s, info.elapsed.skin_s, info.elapsed.check_s],
            });
        }
    }
    value
}

fn print(wrapped: &Wrapped, wall_m: f64, seconds: f64) {
    for (name, text) in lines(wrapped, wall_m) {
        println!("{name:<11} {text}");
    }
    println!("time        {seconds:.1} s");
}

/// The result in words.
fn lines(
    Wrapped { skin, wall_m: walls, info }: &Wrapped,
    wall_m: f64,
) -> Vec<(&'static str, String)> {
    let (mm, percent) = (|m: f64| 1e3 * m, |share: f64| 100.0 * share);
    let [median, most] = info.input_to_skin_m.map(mm);
    let thinned = match info.n_thinned {
        0 => String::new(),
        n => {
            let least = walls.iter().copied().fold(wall_m, f64::min);
            format!(", {n} vertices thinned, to {:.2} mm at least", mm(least))
        }
    };
    vec![
        (
            "skin",
            format!(
                "one closed body, {} triangles on {} vertices, edges of {:.1} mm, smallest angle {:.0}°, {} crossings",
                skin.triangles().len(),
                skin.vertices().len(),
                mm(info.edge_m),
                info.smallest_angle_deg,
                info.n_crossings
            ),
        ),
        ("wall", format!("{:.2} mm inward{thinned}", mm(wall_m))),
        (
            "distances",
            format!(
                "surface to skin {median:.2} mm (median), {most:.2} mm (95 %); skin to surface {:.2} mm (95 %)",
                mm(info.skin_to_input_m)
            ),
        ),
        (
            "lost",
            format!(
                "{:.2} % of the outside, {:.1} cm² thinner than {:.1} mm; {:.1} % of the surface lies inside",
                percent(info.share_lost),
                1e4 * info.places.lost_m2,
                mm(2.0 * info.round_over_m),
                percent(info.share_inside)
            ),
        ),
        (
            "bridged",
            format!(
                "{:.2} % of the skin, {:.1} cm²: {} openings capped, gaps up to {:.1} mm wide closed",
                percent(info.share_bridged),
                1e4 * info.places.bridged_m2,
                info.n_caps,
                mm(2.0 * info.close_m)
            ),
        ),
    ]
}
