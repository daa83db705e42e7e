//! `hapdef shell`: from a surface to gauge readings.

use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::builder::RangedU64ValueParser;
use clap::{Args, ValueEnum};
use hapdef::HapdefError;
use hapdef::scene::{MaterialSpec, WallSide};
use hapdef::shell_limb::{
    GaugeInfo, SHELL_REPORT_HTML, ShellComparison, ShellLimb, ShellLimbParams, WallChoice,
    write_measured_wall,
};
use hapdef_cli::{print_json, shown};
use hapdef_mesh::{BodyChoice, CleanParams, GltfParams, LengthUnit, UnitGuess, read_surface};
use hapdef_sim::ShellKind;

use super::new::End;
use super::unit::Unit;

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
    #[arg(short, long, value_name = "FOLDER")]
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
enum Kind {
    Thin,
    Thick,
}

/// Makes the shell, compares it with the solids asked for, prints and writes everything; where a
/// comparison fails, what there is without it.
pub(crate) fn shell(args: &ShellArgs) -> Result<()> {
    let (unit, params, out) = (args.length_unit()?, args.params(), args.out_folder());
    let limb = match ShellLimb::read(&args.file, unit, &params) {
        Err(error) if params.wall == WallChoice::Measured => {
            // the picture of a wall that could be measured but is no shell
            let path = out.join("wall.glb");
            if write_measured_wall(&args.file, unit, &params, &path)? {
                println!("the wall as far as it is one, coloured by thickness: {}", shown(&path));
            } else {
                println!("no part of the surface has a wall that could be drawn");
            }
            return Err(error.into());
        }
        limb => limb?,
    };
    let compared = compare(args, &limb);
    let comparisons = compared.as_deref().unwrap_or_default();
    limb.write(&out, comparisons)?;
    if args.json {
        print_json(&limb.report(comparisons), true)?;
    } else {
        println!("{}", shown(&args.file));
        show(&limb);
        comparisons.iter().for_each(show_comparison);
        if !comparisons.is_empty() {
            println!("report            {}", shown(out.join(SHELL_REPORT_HTML)));
        }
        println!("written to        {}", shown(&out));
    }
    compared.map(drop)
}

fn compare(args: &ShellArgs, limb: &ShellLimb) -> Result<Vec<ShellComparison>> {
    let extruded = args.solid.then(|| limb.against_extruded());
    let scene = args.against.as_deref().map(|path| limb.against_scene(path));
    Ok(extruded.into_iter().chain(scene).collect::<Result<_, _>>()?)
}

impl ShellArgs {
    fn params(&self) -> ShellLimbParams {
        let metres = |mm: f64| mm * 1e-3;
        ShellLimbParams {
            clean: CleanParams {
                weld_tolerance_m: Some(self.weld * 1e-6),
                drop_degenerate: self.drop_degenerate,
                drop_doubled: self.drop_doubled,
                orient: self.orient,
                body: if self.largest_body { BodyChoice::LargestArea } else { BodyChoice::All },
            },
            side: match self.side {
                Side::Outer => WallSide::Outer,
                Side::Middle => WallSide::Middle,
                Side::Inner => WallSide::Inner,
            },
            edge_m: self.edge.map(metres),
            mount_axis: self.mount_axis.map(|axis| axis as usize),
            mount_end: self.mount_end.into(),
            mount_m: self.mount.map(metres),
            n_gauges: self.gauges,
            material: MaterialSpec {
                youngs_modulus_pa: self.youngs_modulus_pa,
                poissons_ratio: self.poissons_ratio,
                ..MaterialSpec::PA2200
            },
            kind: match self.kind {
                Kind::Thin => ShellKind::Thin,
                Kind::Thick => ShellKind::Thick,
            },
            tip_radius_m: metres(self.tip),
            n_solid_halvings: self.halve_solid,
            n_threads: self.threads,
            ..ShellLimbParams::new(self.wall)
        }
    }

    /// The unit stated; where none is, the error says which would fit.
    fn length_unit(&self) -> Result<LengthUnit> {
        if let Some(unit) = self.unit {
            return Ok(unit.into());
        }
        let longest = read_surface(&self.file, &GltfParams::default())?.mesh.bounding_box();
        let (path, guess) = (self.file.clone(), UnitGuess::of_length(longest.longest_m()));
        Err(HapdefError::UnitNotStated { path, guess }.into())
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

/// Prints everything that was found.
fn show(limb: &ShellLimb) {
    let (info, wall, model) = (&limb.info, &limb.info.wall, &limb.info.model);
    wall.made.iter().for_each(|made| println!("made              {made}"));
    let millimetres = wall.thickness_quantiles_m.map(|v| format!("{:.2}", v * 1e3)).join(" ");
    println!("wall              {millimetres} mm (smallest, quartiles, largest)");
    println!("solved as         {}", wall.expected);
    println!("mount             {}", info.mount);
    println!(
        "shell model       {} nodes, {} triangles, {} equations, nnz(L) {}",
        model.n_nodes, model.n_triangles, model.n_equations, model.nnz_l
    );
    println!(
        "solved            relative residual {:.1e}, backward error {:.1e}, {:.2} s",
        model.worst_relative_residual, model.worst_backward_error, info.elapsed_s
    );
    println!(
        "gauges            {} on the inner side; {} sites passed over",
        info.gauges.len(),
        info.n_sites_passed_over
    );
    println!("       at, mm                  axis                strongest at, mm            µε/N");
    for (i, gauge) in info.gauges.iter().enumerate() {
        println!("{}", gauge_line(i, gauge));
    }
    println!("best gauge        {:.1} µε/N (median over free nodes)", info.median_best_ue_per_n);
    wall.too_thick.iter().for_each(|why| println!("use the solid: the wall is {why}"));
}

fn gauge_line(number: usize, gauge: &GaugeInfo) -> String {
    let millimetres = |p: &[f64; 3]| {
        let [x, y, z] = p.map(|c| c * 1e3);
        format!("{x:7.1} {y:7.1} {z:7.1}")
    };
    let [x, y, z] = gauge.axis;
    format!(
        "g{number:<4} {}  {x:6.3} {y:6.3} {z:6.3}  {}  {:10.1}",
        millimetres(&gauge.position_m),
        millimetres(&gauge.strongest_position_m),
        gauge.strongest_ue_per_n
    )
}

fn show_comparison(comparison: &ShellComparison) {
    println!(
        "\nagainst {}: {} FE nodes, {} equations, {:.2} s",
        comparison.solid, comparison.n_fe_nodes, comparison.n_equations, comparison.elapsed_s
    );
    println!(
        "{} gauges ({} left out), {} places ({} passed over: held, or not wholly on the shell)",
        comparison.n_gauges,
        comparison.n_gauges_left_out,
        comparison.n_touches,
        comparison.n_touches_left_out
    );
    println!("{:44}median %    worst %  overall %  ratio (median)", "");
    for [what, median, worst, overall, ratio] in comparison.table() {
        println!("{what:41} {median:>10} {worst:>10} {overall:>10} {ratio:>15}");
    }
    println!(
        "above 10 %          readings on {:.1} % of the compared surface, displacement on {:.1} %",
        100.0 * comparison.above_good.readings_share,
        100.0 * comparison.above_good.tip_share
    );
    println!("{}", comparison.advice());
}
