//! `hapdef deck`: a deck's own load, solved and compared with another program's result.

use std::path::Path;

use anyhow::{Context, Result, bail};
use hapdef_cli::shown;
use hapdef_mesh::{
    PointField, PointValues, SolidDeck, largest_difference, read_deck, read_displacements,
    write_vtu,
};
use hapdef_sim::{ElasticModel, ElasticParams, IsotropicMaterial, MassProperties, NodalLoad};
use nalgebra::Vector3;

/// Solves the deck's own load and prints what an FE engineer would look at first.
pub(crate) fn solve(file: &Path, reference: Option<&Path>, vtu: Option<&Path>) -> Result<()> {
    let deck = read_deck(file)?;
    let material = deck.material.as_ref().context("the deck names no material")?;
    let density = material.density_kg_m3.context("the deck names no density")?;
    let material =
        IsotropicMaterial::new(material.youngs_modulus_pa, material.poissons_ratio, density)?;
    let params = ElasticParams {
        n_threads: std::thread::available_parallelism().map_or(1, usize::from),
        ..ElasticParams::new(material, deck.fixed_nodes.clone())
    };
    let elastic_model = ElasticModel::build(&deck.mesh, &params)?;
    let load = NodalLoad::of_deck(&deck)?;
    if load.forces_n.is_empty() {
        bail!("the deck has no load: add a nodal force or a pressure to it");
    }
    let (displacement, solve) = elastic_model.solve(&load)?;
    let info = elastic_model.info();
    let mass = MassProperties::of(&deck.mesh, density);
    let extremes = elastic_model.stiffness_extremes();
    let label = |element: usize| deck.element_labels[element];
    println!("equations        {}", info.n_equations);
    println!("nnz(L)           {}", info.nnz_l);
    println!(
        "order, assemble, factor  {:.2} s, {:.2} s, {:.2} s",
        info.order_s, info.assemble_s, info.factor_s
    );
    println!("relative residual {:.1e}", solve.worst_relative_residual);
    println!(
        "mass             {:.7} kg, centre {:?} m",
        mass.mass_kg,
        mass.centre_m.coords.as_slice()
    );
    println!(
        "element stiffness {:.9e} N/m at element {}, {:.3} N/m at element {}",
        extremes.largest_n_m,
        label(extremes.largest_element),
        extremes.smallest_n_m,
        label(extremes.smallest_element)
    );
    println!("load             {:?} N", load.total_n().as_slice());
    let largest_m = displacement.iter().map(Vector3::norm).fold(0.0, f64::max);
    println!("largest |u|      {:.6} mm", largest_m * 1e3);
    println!("strain energy    {:.6e} J", elastic_model.strain_energy_j(&displacement)?);
    if let Some(reference) = reference {
        compare(&deck, &displacement, reference)?;
    }
    if let Some(path) = vtu {
        let field =
            PointField { name: "displacement_m", values: PointValues::Vectors(&displacement) };
        write_vtu(path, &deck.mesh, &[field])?;
        println!("displacement in  {}", shown(path));
    }
    Ok(())
}

fn compare(deck: &SolidDeck, displacement: &[Vector3<f64>], reference: &Path) -> Result<()> {
    let found = deck.node_labels.iter().copied().zip(displacement.iter().copied());
    let Some((n, share)) = largest_difference(found, &read_displacements(reference)?) else {
        bail!("{}: has no displacement for any node of the deck", shown(reference));
    };
    println!("against {}: {n} nodes", shown(reference));
    println!("METRIC:deck.u_rel_err:{share:.3e}:1");
    Ok(())
}
