//! `hapdef deck`: a deck's own load, solved and compared with another program's result.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use clap::Args;
use hapdef_cli::{print_json, shown};
use hapdef_mesh::{
    PointField, PointValues, SolidDeck, largest_difference, read_deck, read_displacements,
    write_vtu,
};
use hapdef_sim::{ElasticModel, ElasticParams, IsotropicMaterial, MassProperties, NodalLoad};
use nalgebra::Vector3;
use serde::Serialize;

#[derive(Args)]
#[command(after_help = "Example:\n  hapdef deck fixtures/shin/shin.inp.gz")]
pub(crate) struct DeckArgs {
    /// The deck.
    file: PathBuf,
    /// CalculiX displacements (.dat, also .gz) to compare with at every node.
    #[arg(long)]
    reference: Option<PathBuf>,
    /// Writes the displacement over the solid to this file, for ParaView.
    #[arg(long, value_name = "FILE.vtu")]
    vtu: Option<PathBuf>,
    /// Print what was solved as JSON.
    #[arg(long)]
    json: bool,
}

/// Solves the deck's own load and prints what an FE engineer would look at first.
pub(crate) fn run(args: &DeckArgs) -> Result<()> {
    let deck = read_deck(&args.file)?;
    let (solved, displacement) = solve(&deck)?;
    let against = args.reference.as_deref();
    let against = against.map(|file| difference(&deck, &displacement, file)).transpose()?;
    if let Some(path) = &args.vtu {
        let field =
            PointField { name: "displacement_m", values: PointValues::Vectors(&displacement) };
        write_vtu(path, &deck.mesh, &[field])?;
    }
    if args.json {
        return Ok(print_json(&Output { solved, against, vtu: args.vtu.as_deref() }, false)?);
    }
    solved.print();
    if let (Some(against), Some(file)) = (against, &args.reference) {
        println!("against {}: {} nodes", shown(file), against.n_nodes);
        println!("METRIC:deck.u_rel_err:{:.3e}:1", against.relative_difference);
    }
    args.vtu.iter().for_each(|path| println!("displacement in  {}", shown(path)));
    Ok(())
}

#[derive(Serialize)]
struct Output<'a> {
    #[serde(flatten)]
    solved: Solved,
    against: Option<Difference>,
    vtu: Option<&'a Path>,
}

/// A deck's own load, solved.
#[derive(Serialize)]
struct Solved {
    n_equations: usize,
    nnz_l: usize,
    order_s: f64,
    assemble_s: f64,
    factor_s: f64,
    relative_residual: f64,
    mass_kg: f64,
    centre_m: [f64; 3],
    largest_stiffness_n_m: f64,
    largest_stiffness_element: u32,
    smallest_stiffness_n_m: f64,
    smallest_stiffness_element: u32,
    load_n: [f64; 3],
    largest_u_m: f64,
    strain_energy_j: f64,
}

/// How far the displacements are from another program's.
#[derive(Serialize)]
struct Difference {
    n_nodes: usize,
    /// Of the largest displacement.
    relative_difference: f64,
}

fn solve(deck: &SolidDeck) -> Result<(Solved, Vec<Vector3<f64>>)> {
    let material = deck.material.as_ref().context("the deck names no material")?;
    let density = material.density_kg_m3.context("the deck names no density")?;
    let material =
        IsotropicMaterial::new(material.youngs_modulus_pa, material.poissons_ratio, density)?;
    let params = ElasticParams {
        n_threads: std::thread::available_parallelism().map_or(1, usize::from),
        ..ElasticParams::new(material, deck.fixed_nodes.clone())
    };
    let elastic_model = ElasticModel::build(&deck.mesh, &params)?;
    let load = NodalLoad::of_deck(deck)?;
    if load.forces_n.is_empty() {
        bail!("the deck has no load: add a nodal force or a pressure to it");
    }
    let (displacement, solve) = elastic_model.solve(&load)?;
    let info = elastic_model.info();
    let mass = MassProperties::of(&deck.mesh, density);
    let extremes = elastic_model.stiffness_extremes();
    let label = |element: usize| deck.element_labels[element];
    let solved = Solved {
        n_equations: info.n_equations,
        nnz_l: info.nnz_l,
        order_s: info.order_s,
        assemble_s: info.assemble_s,
        factor_s: info.factor_s,
        relative_residual: solve.worst_relative_residual,
        mass_kg: mass.mass_kg,
        centre_m: mass.centre_m.coords.into(),
        largest_stiffness_n_m: extremes.largest_n_m,
        largest_stiffness_element: label(extremes.largest_element),
        smallest_stiffness_n_m: extremes.smallest_n_m,
        smallest_stiffness_element: label(extremes.smallest_element),
        load_n: load.total_n().into(),
        largest_u_m: displacement.iter().map(Vector3::norm).fold(0.0, f64::max),
        strain_energy_j: elastic_model.strain_energy_j(&displacement)?,
    };
    Ok((solved, displacement))
}

impl Solved {
    fn print(&self) {
        println!("equations        {}", self.n_equations);
        println!("nnz(L)           {}", self.nnz_l);
        println!(
            "order, assemble, factor  {:.2} s, {:.2} s, {:.2} s",
            self.order_s, self.assemble_s, self.factor_s
        );
        println!("relative residual {:.1e}", self.relative_residual);
        println!("mass             {:.7} kg, centre {:?} m", self.mass_kg, self.centre_m);
        println!(
            "element stiffness {:.9e} N/m at element {}, {:.3} N/m at element {}",
            self.largest_stiffness_n_m,
            self.largest_stiffness_element,
            self.smallest_stiffness_n_m,
            self.smallest_stiffness_element
        );
        println!("load             {:?} N", self.load_n);
        println!("largest |u|      {:.6} mm", self.largest_u_m * 1e3);
        println!("strain energy    {:.6e} J", self.strain_energy_j);
    }
}

fn difference(
    deck: &SolidDeck,
    displacement: &[Vector3<f64>],
    reference: &Path,
) -> Result<Difference> {
    let found = deck.node_labels.iter().copied().zip(displacement.iter().copied());
    let found = largest_difference(found, &read_displacements(reference)?);
    let Some((n_nodes, relative_difference)) = found else {
        bail!("{}: has no displacement for any node of the deck", shown(reference));
    };
    Ok(Difference { n_nodes, relative_difference })
}
