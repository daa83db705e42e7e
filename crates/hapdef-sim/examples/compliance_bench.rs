//! Times the compliance of a limb: `compliance_bench DECK [N_THREADS]`.
//!
//! Patch loads (tip radius 2 mm, inward) at every node of the radial region about the y axis;
//! prints sizes, times, the worst residual and the peak memory.
#![allow(clippy::print_stdout, reason = "a program that prints what it measures")]

use std::error::Error;
use std::path::Path;
use std::time::Instant;

use hapdef_mesh::{RadialRegionParams, SkinRegion, SolidDeck, radial_region, read_deck};
use hapdef_sim::{
    ComplianceParams, ElasticModel, ElasticParams, IsotropicMaterial, NodalLoad, SimError,
};
use nalgebra::{Point3, Vector3};

const TIP_RADIUS_M: f64 = 2e-3;

fn main() -> Result<(), Box<dyn Error>> {
    let mut args = std::env::args().skip(1);
    let path = args.next().ok_or("usage: compliance_bench DECK [N_THREADS]")?;
    let n_threads = args.next().map_or(Ok(1), |n| n.parse())?;
    let deck = read_deck(Path::new(&path))?;
    let model = build(&deck, n_threads)?;
    let skin = skin(&deck)?;
    let started = Instant::now();
    let loads = inward_loads(&deck, &skin)?;
    println!("loads            {} in {:.3} s", loads.len(), started.elapsed().as_secs_f64());
    let params = ComplianceParams::default();
    let (compliance, info) = model.compliance(&loads, &skin.nodes, &params)?;
    println!("compliance       {:.3} s, {n_threads} threads", info.elapsed_s);
    println!("worst residual   {:.3e} relative to the load", info.worst_relative_residual);
    println!("backward error   {:.3e} (load {})", info.worst_backward_error, info.worst_load);
    println!("refinements      {}", info.n_refinements);
    let own = (0..loads.len()).map(|i| compliance.displacement(i, i).norm());
    println!("largest own      {:.4} µm/N", own.fold(0.0, f64::max) * 1e6);
    println!("asymmetry        {:.3e}", asymmetry(&loads, &skin, &compliance));
    println!("peak memory      {}", peak_memory()?);
    Ok(())
}

fn build(deck: &SolidDeck, n_threads: usize) -> Result<ElasticModel, Box<dyn Error>> {
    let stated = deck.material.ok_or("the deck states no material")?;
    let density = stated.density_kg_m3.ok_or("the deck states no density")?;
    let material =
        IsotropicMaterial::new(stated.youngs_modulus_pa, stated.poissons_ratio, density)?;
    let clamped = deck.fixed_nodes.clone();
    let params = ElasticParams { n_threads, ..ElasticParams::new(material, clamped) };
    let model = ElasticModel::build(&deck.mesh, &params)?;
    let info = model.info();
    println!("equations        {}", info.n_equations);
    println!("nnz(K) lower     {}", info.nnz_lower);
    println!("nnz(L)           {} (stored {})", info.nnz_l, info.nnz_l_stored);
    println!(
        "order, assemble, factor: {:.3} s, {:.3} s, {:.3} s",
        info.order_s, info.assemble_s, info.factor_s
    );
    Ok(model)
}

fn skin(deck: &SolidDeck) -> Result<SkinRegion, Box<dyn Error>> {
    let region = RadialRegionParams {
        axis_point: Point3::origin(),
        axis_dir: Vector3::y(),
        min_normal_dot_radial: 0.5,
        min_radius_m: 28e-3,
        axial_range_m: (41.5e-3, f64::INFINITY),
    };
    Ok(radial_region(&deck.mesh, &deck.mesh.boundary(), &region)?)
}

fn inward_loads(deck: &SolidDeck, skin: &SkinRegion) -> Result<Vec<NodalLoad>, SimError> {
    let centres = skin.nodes.iter().map(|&node| deck.mesh.position(node));
    centres
        .zip(&skin.normals)
        .map(|(centre, normal)| NodalLoad::patch(&deck.mesh, skin, &centre, TIP_RADIUS_M, &-normal))
        .collect()
}

/// The largest |fᵢ · u(fⱼ) − fⱼ · u(fᵢ)| over load pairs 97 apart, relative to the largest fᵢ · u(fᵢ).
fn asymmetry(loads: &[NodalLoad], skin: &SkinRegion, compliance: &hapdef_sim::Compliance) -> f64 {
    let work = |i: usize, j: usize| -> f64 {
        let forces = loads[i].forces_n.iter();
        let terms = forces.filter_map(|(node, force)| {
            let wanted = skin.nodes.binary_search(node).ok()?;
            Some(force.dot(&compliance.displacement(j, wanted)))
        });
        terms.sum()
    };
    let pairs = || (97..loads.len()).map(|i| (i, i - 97));
    let largest = (0..loads.len()).map(|i| work(i, i)).fold(0.0, f64::max);
    pairs().map(|(i, j)| (work(i, j) - work(j, i)).abs()).fold(0.0, f64::max) / largest
}

fn peak_memory() -> Result<String, Box<dyn Error>> {
    let status = std::fs::read_to_string("/proc/self/status")?;
    let line = status.lines().find(|line| line.starts_with("VmHWM")).ok_or("no VmHWM")?;
    Ok(line.trim_start_matches("VmHWM:").trim().to_owned())
}
