//! `hapdef shell`: from a surface to gauge readings.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use clap::builder::RangedU64ValueParser;
use clap::{Args, ValueEnum};
use hapdef::scene::read_scene;
use hapdef::shell_limb::{
    MountChoice, MountEnd, ReportSource, SHELL_REPORT_HTML, SceneSource, ShellComparison,
    ShellLimb, ShellLimbParams, WallChoice, shell_limb, write_measured_wall,
};
use hapdef::{HapdefError, Limb};
use hapdef_cli::{print_json, shown};
use hapdef_mesh::{
    BodyChoice, CleanParams, GltfParams, LengthUnit, SkinSide, SurfaceMesh, UnitGuess, read_surface,
};
use hapdef_sim::{IsotropicMaterial, ShellKind};

use super::shell_table::show;
use super::unit::Unit;

/// Density of PA2200, kg/m³; statics don't depend on it.
const DENSITY_KG_M3: f64 = 930.0;

#[derive(Args)]
#[command(after_help = "Example:\n  \
    hapdef shell fixtures/shin/shin_skin.glb --unit m --wall 1 --solid\n\n\
    Vertices within 1 µm are joined; nothing else is repaired unless asked. Results go to target/hapdef/<file>/.")]
pub(crate) struct ShellArgs {
    /// The surface (.glb, .gltf, .stl, .obj, .dae).
    file: PathBuf,
    /// Unit of its coordinates; without it the command only tells which unit fits.
    #[arg(long)]
    unit: Option<Unit>,
    /// Thickness of the wall, mm, or `measured` for a closed solid with an outer and inner wall.
    #[arg(long, value_parser = wall_choice)]
    wall: WallChoice,
    /// Which side of the wall the surface is.
    #[arg(long, default_value = "outer")]
    side: Side,
    /// Edge length, mm; a fortieth of the longest extent when not given.
    #[arg(long)]
    edge: Option<f64>,
    /// Axis along which the ends lie; the longest when not given.
    #[arg(long)]
    mount_axis: Option<MountAxis>,
    /// The end that is held.
    #[arg(long, default_value = "low")]
    mount_end: End,
    /// How far from that end nodes are held, mm; 5 % of the extent when not given.
    #[arg(long)]
    mount: Option<f64>,
    /// Gauges, spread over the inner side of the wall.
    #[arg(long, default_value_t = 10, value_parser = RangedU64ValueParser::<usize>::new().range(1..))]
    gauges: usize,
    /// Young's modulus, Pa.
    #[arg(long, default_value_t = 1.7e9)]
    youngs_modulus_pa: f64,
    /// Poisson's ratio.
    #[arg(long, default_value_t = 0.394)]
    poissons_ratio: f64,
    /// The bending theory.
    #[arg(long, default_value = "thick")]
    kind: Kind,
    /// Radius of the tip in comparisons with a solid, mm.
    #[arg(long, default_value_t = 2.0)]
    tip: f64,
    /// Join vertices no farther apart than this, µm.
    #[arg(long, default_value_t = 1.0)]
    weld: f64,
    /// Turn triangles over until neighbours agree on the outside.
    #[arg(long)]
    orient: bool,
    /// Drop triangles without area.
    #[arg(long)]
    drop_degenerate: bool,
    /// Drop triangles with the corners of an earlier one.
    #[arg(long)]
    drop_doubled: bool,
    /// Keep only the body with the largest area.
    #[arg(long)]
    largest_body: bool,
    /// Compare with a solid extruded from the same skin and wall.
    #[arg(long)]
    solid: bool,
    /// Halve the edges of that solid this often; from 1 on the change by the last halving is reported.
    /// Once when not given, if that makes no more than 150,000 nodes.
    #[arg(long, value_parser = RangedU64ValueParser::<usize>::new().range(..=3))]
    halve_solid: Option<usize>,
    /// Compare with the solid limb of this scene.
    #[arg(long, value_name = "SCENE")]
    against: Option<PathBuf>,
    /// Threads; results don't depend on it.
    #[arg(long, default_value_t = 2, value_parser = RangedU64ValueParser::<usize>::new().range(1..))]
    threads: usize,
    /// Folder for everything that is written; target/hapdef/<file> when not given.
    #[arg(long)]
    out: Option<PathBuf>,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum Side {
    Outer,
    Middle,
    Inner,
}

#[derive(Clone, Copy, ValueEnum)]
enum MountAxis {
    X,
    Y,
    Z,
}

#[derive(Clone, Copy, ValueEnum)]
enum End {
    Low,
    High,
}

#[derive(Clone, Copy, ValueEnum)]
enum Kind {
    Thin,
    Thick,
}

/// Makes the shell, compares it with the solids asked for, prints and writes everything; where a
/// comparison fails, what there is without it.
pub(crate) fn shell(args: &ShellArgs) -> Result<()> {
    let given = given_surface(args)?;
    let params = args.params()?;
    let out = args.out_folder();
    let limb = match shell_limb(&given, &params) {
        Ok(limb) => limb,
        Err(error) => return refused(error, &given, &params, &out),
    };
    let compared = compare(args, &limb);
    let comparisons = compared.as_deref().unwrap_or_default();
    limb.write(&out, comparisons)?;
    if !comparisons.is_empty() {
        limb.write_report(&out, &source(args)?, comparisons)?;
    }
    if args.json {
        print_json(&limb.report(comparisons), true)?;
    } else {
        println!("{}", shown(&args.file));
        show(&limb, comparisons);
        if !comparisons.is_empty() {
            println!("report            {}", shown(out.join(SHELL_REPORT_HTML)));
        }
        println!("written to        {}", shown(&out));
    }
    compared.map(|_| ())
}

fn source(args: &ShellArgs) -> Result<ReportSource> {
    let scene = args.against.as_deref().map(|path| -> Result<_> {
        Ok(SceneSource { file: shown(path).to_string(), file_hash: hash_of(path)? })
    });
    Ok(ReportSource {
        file: shown(&args.file).to_string(),
        file_hash: hash_of(&args.file)?,
        scene: scene.transpose()?,
    })
}

fn hash_of(path: &Path) -> Result<String> {
    let bytes = std::fs::read(path).with_context(|| format!("reading {}", shown(path)))?;
    Ok(blake3::hash(&bytes).to_hex().to_string())
}

fn given_surface(args: &ShellArgs) -> Result<SurfaceMesh> {
    let read = |unit| {
        let params = GltfParams { unit, ..GltfParams::default() };
        read_surface(&args.file, &params).map(|surface| surface.mesh)
    };
    let unit = match args.unit {
        Some(unit) => unit.into(),
        None => {
            let longest = read(LengthUnit::Metre)?.bounding_box().longest_m();
            let (path, guess) = (args.file.clone(), UnitGuess::of_length(longest));
            return Err(HapdefError::UnitNotStated { path, guess }.into());
        }
    };
    Ok(read(unit)?)
}

/// The picture of a wall that could be measured but is no shell, and the error.
fn refused(
    error: HapdefError,
    given: &SurfaceMesh,
    params: &ShellLimbParams,
    out: &Path,
) -> Result<()> {
    if params.wall == WallChoice::Measured {
        let path = out.join("wall.glb");
        if write_measured_wall(given, params, &path)? {
            println!("the wall as far as it is one, coloured by thickness: {}", shown(&path));
        } else {
            println!("no part of the surface has a wall that could be drawn");
        }
    }
    Err(error.into())
}

fn compare(args: &ShellArgs, limb: &ShellLimb) -> Result<Vec<ShellComparison>> {
    let mut comparisons = Vec::new();
    if args.solid {
        comparisons.push(limb.against_extruded()?);
    }
    if let Some(path) = &args.against {
        let scene = read_scene(path)?;
        let folder = path.parent().unwrap_or(Path::new("."));
        let solid = Limb::load(&scene, folder)?;
        let name = format!("the solid of scene {:?}", scene.name);
        comparisons.push(limb.against_solid(&name, &solid)?);
    }
    Ok(comparisons)
}

impl ShellArgs {
    fn params(&self) -> Result<ShellLimbParams> {
        let (modulus, ratio) = (self.youngs_modulus_pa, self.poissons_ratio);
        let material = IsotropicMaterial::new(modulus, ratio, DENSITY_KG_M3)?;
        let metres = |mm: f64| mm * 1e-3;
        Ok(ShellLimbParams {
            clean: CleanParams {
                weld_tolerance_m: Some(self.weld * 1e-6),
                drop_degenerate: self.drop_degenerate,
                drop_doubled: self.drop_doubled,
                orient: self.orient,
                body: if self.largest_body { BodyChoice::LargestArea } else { BodyChoice::All },
            },
            side: match self.side {
                Side::Outer => SkinSide::Outer,
                Side::Middle => SkinSide::Middle,
                Side::Inner => SkinSide::Inner,
            },
            edge_m: self.edge.map(metres),
            mount: MountChoice {
                axis: self.mount_axis.map(|axis| axis as usize),
                end: match self.mount_end {
                    End::Low => MountEnd::Low,
                    End::High => MountEnd::High,
                },
                length_m: self.mount.map(metres),
            },
            n_gauges: self.gauges,
            kind: match self.kind {
                Kind::Thin => ShellKind::Thin,
                Kind::Thick => ShellKind::Thick,
            },
            tip_radius_m: metres(self.tip),
            n_solid_halvings: self.halve_solid,
            n_threads: self.threads,
            ..ShellLimbParams::new(self.wall, material)
        })
    }

    fn out_folder(&self) -> PathBuf {
        let stem = self.file.file_stem().unwrap_or_default();
        let results = std::env::var_os("HAPDEF_OUT").unwrap_or_else(|| "target/hapdef".into());
        let by_name = || Path::new(&results).join(stem);
        self.out.clone().unwrap_or_else(by_name)
    }
}

fn wall_choice(text: &str) -> Result<WallChoice, String> {
    if text == "measured" {
        return Ok(WallChoice::Measured);
    }
    match text.parse::<f64>() {
        Ok(mm) if mm > 0.0 && mm.is_finite() => Ok(WallChoice::Constant(mm * 1e-3)),
        _ => Err("expected a thickness in mm, above 0, or `measured`".to_owned()),
    }
}
