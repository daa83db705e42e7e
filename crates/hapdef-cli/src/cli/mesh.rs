//! `hapdef mesh`: a volume mesh of a closed surface, by a gmsh that is installed here.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail, ensure};
use clap::Args;
use hapdef_cli::{print_json, shown};
use hapdef_mesh::{
    GltfParams, LengthUnit, QualityReport, SurfaceMesh, UnitGuess, read_surface, write_stl,
};
use serde_json::json;

use super::unit::Unit;

/// Edges of the tetrahedra where none are stated: so many on the longest side.
const EDGES_PER_LENGTH: f64 = 40.0;

#[derive(Args)]
#[command(after_help = "Example:\n  \
    hapdef mesh forearm.stl --edge 4 -o forearm.msh\n  \
    hapdef new forearm.msh\n\n\
    Calls gmsh (https://gmsh.info), which has to be installed: it fills what the surface encloses with ten-node \
    tetrahedra, in mm. A surface that is a skin only needs none: hapdef new gives it a wall.")]
pub(crate) struct MeshArgs {
    /// The closed surface (.glb, .gltf, .stl, .obj, .dae).
    file: PathBuf,
    /// Unit of its coordinates; the likeliest when not given.
    #[arg(long)]
    unit: Option<Unit>,
    /// Longest edge of a tetrahedron, mm; a 40th of the longest side when not given.
    #[arg(long)]
    edge: Option<f64>,
    /// The volume mesh to write (.msh).
    #[arg(short, long, value_name = "FILE")]
    out: PathBuf,
    /// The program gmsh, where it is not found by its name.
    #[arg(long, default_value = "gmsh")]
    gmsh: PathBuf,
    /// Overwrite the volume mesh.
    #[arg(long)]
    force: bool,
    /// Print what was made as JSON.
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: &MeshArgs) -> Result<()> {
    let out = &args.out;
    ensure!(args.force || !out.exists(), "{}: is there already; say --force", shown(out));
    let (surface, unit) = closed_surface(args)?;
    let folder = Folder::beside(out)?;
    write_stl(&folder.0.join("surface.stl"), &surface)?;
    let edge_mm = args.edge.unwrap_or(1e3 * surface.bounding_box().longest_m() / EDGES_PER_LENGTH);
    ensure!(edge_mm > 0.0, "--edge: expected above 0, found {edge_mm}");
    std::fs::write(folder.0.join("limb.geo"), recipe(edge_mm))?;
    if !args.json {
        println!("{}: read in {unit}, edges up to {edge_mm:.1} mm", shown(&args.file));
    }
    call(&args.gmsh, &folder.0)?;
    std::fs::rename(folder.0.join("limb.msh"), out).with_context(|| shown(out))?;
    if args.json {
        let made = json!({
            "file": args.file, "unit": unit.to_string(), "edge_m": 1e-3 * edge_mm, "out": out,
        });
        return Ok(print_json(&made, false)?);
    }
    println!("written to  {}, in mm\nnext:       hapdef new {}", shown(out), shown(out));
    Ok(())
}

/// The surface in metres, which encloses one body, and the unit it was read in.
fn closed_surface(args: &MeshArgs) -> Result<(SurfaceMesh, LengthUnit)> {
    let given = read_surface(&args.file, &GltfParams::default())?.mesh;
    let guess = UnitGuess::of_length(given.bounding_box().longest_m());
    let unit = args.unit.map(Into::into).or(guess.candidates.first().copied());
    let unit = unit.with_context(|| format!("{}: {guess}: state --unit", shown(&args.file)))?;
    let surface = given.scaled(unit.metres())?;
    let report = QualityReport::of(&surface);
    ensure!(
        report.is_closed(),
        "{}: {} open edges enclose no volume; hapdef new makes a wall of a skin, or closes it",
        shown(&args.file),
        report.n_open_edges
    );
    Ok((surface, unit))
}

/// What gmsh does: the surface as it is, filled; its remeshing of surfaces fails on most limbs.
fn recipe(edge_mm: f64) -> String {
    format!(
        "Merge \"surface.stl\";\n\
         Surface Loop(1) = Surface{{:}};\n\
         Volume(1) = {{1}};\n\
         Physical Volume(\"LIMB\") = {{1}};\n\
         Mesh.MeshSizeMax = {edge_mm};\n\
         Mesh.ElementOrder = 2;\n\
         Mesh.SecondOrderLinear = 1;\n\
         Mesh.MshFileVersion = 4.1;\n"
    )
}

fn call(gmsh: &Path, folder: &Path) -> Result<()> {
    // a path counts from here, not from the folder it works in
    let is_path = gmsh.components().count() > 1;
    let found = is_path.then(|| gmsh.canonicalize().ok()).flatten();
    let mut command = Command::new(found.as_deref().unwrap_or(gmsh));
    command.args(["-3", "limb.geo", "-o", "limb.msh"]).current_dir(folder);
    let output = match command.output() {
        Err(error) if error.kind() == ErrorKind::NotFound => bail!(
            "{}: no such program: install gmsh (https://gmsh.info), or name it by --gmsh; hapdef new \
             makes a limb of a surface without it",
            shown(gmsh)
        ),
        output => output.with_context(|| shown(gmsh))?,
    };
    let text =
        [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
    let errors = text.iter().flat_map(|text| text.lines()).filter(|line| line.starts_with("Error"));
    let errors: Vec<&str> = errors.take(3).collect();
    ensure!(
        output.status.success() && folder.join("limb.msh").exists(),
        "{} did not mesh it: {}; {}. hapdef new makes a limb of the surface without it",
        shown(gmsh),
        if errors.is_empty() { "it wrote nothing".to_owned() } else { errors.join("; ") },
        output.status
    );
    Ok(())
}

/// A folder for the while, beside what is written.
struct Folder(PathBuf);

impl Folder {
    fn beside(out: &Path) -> Result<Self> {
        let name = format!(
            ".{}.gmsh-{}",
            out.file_name().unwrap_or_default().display(),
            std::process::id()
        );
        let folder = out.with_file_name(name);
        std::fs::create_dir_all(&folder).with_context(|| format!("making {}", shown(&folder)))?;
        Ok(Self(folder))
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // what is left is of no use, and no harm
        let _ = std::fs::remove_dir_all(&self.0);
    }
}
