//! Times the iterative path: `iterative_bench CASE [N_THREADS] [N_LOADS] [both|auto]`.
//!
//! CASE is `box:NX,NY,NZ` (a clamped box of unit cells, six ten-node tetrahedra each),
//! `jump:NX,NY,NZ` (the same with every twentieth element 10⁶ times stiffer), `shell:NX,NY,NZ` (the
//! same box as a cantilever plate, a tenth as thick in z), or a solid deck. With `both` the direct
//! factor solves the same loads and the solutions are compared; with `auto` the model chooses.
#![allow(clippy::print_stdout, reason = "a program that prints what it measures")]

#[path = "../tests/it/common/mod.rs"]
#[allow(unused_imports, reason = "shared with the tests")]
mod common;

use std::error::Error;
use std::path::Path;
use std::time::Instant;

use common::{nodes_where, straight_box};
use hapdef_mesh::{FeNodeId, Tet10Mesh, read_deck};
use hapdef_sim::{
    ComplianceParams, ElasticModel, ElasticParams, IsotropicMaterial, IterativeParams, NodalLoad,
    SolverChoice,
};
use nalgebra::Vector3;

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let usage = "usage: iterative_bench CASE [N_THREADS] [N_LOADS] [both|auto]";
    let case = args.first().ok_or(usage)?;
    let n_threads = args.get(1).map_or(Ok(1), |n| n.parse())?;
    let n_loads: usize = args.get(2).map_or(Ok(1), |n| n.parse())?;
    let (mesh, mut params) = problem(case)?;
    params.n_threads = n_threads;
    let loads = loads(&mesh, &params.clamped, n_loads);
    let mode = args.get(3).map_or("", String::as_str);
    params.solver = match mode {
        "auto" => SolverChoice::default(),
        _ => SolverChoice::Iterative(IterativeParams::default()),
    };
    let iterative = solve(&mesh, &params, &loads)?;
    if mode == "both" {
        params.solver = SolverChoice::Direct;
        let direct = solve(&mesh, &params, &loads)?;
        let worst = direct.iter().zip(&iterative).map(|(d, i)| miss(d, i));
        println!("worst difference {:.3e}", worst.fold(0.0, f64::max));
    }
    Ok(())
}

fn problem(case: &str) -> Result<(Tet10Mesh, ElasticParams), Box<dyn Error>> {
    let Some((kind, size)) = case.split_once(':') else {
        let deck = read_deck(Path::new(case))?;
        let stated = deck.material.ok_or("the deck states no material")?;
        let density = stated.density_kg_m3.ok_or("the deck states no density")?;
        let material =
            IsotropicMaterial::new(stated.youngs_modulus_pa, stated.poissons_ratio, density)?;
        return Ok((deck.mesh, ElasticParams::new(material, deck.fixed_nodes)));
    };
    let n: Vec<usize> = size.split(',').map(str::parse).collect::<Result<_, _>>()?;
    let n: [usize; 3] = n.try_into().map_err(|_| "three numbers of cells")?;
    let thickness = if kind == "shell" { 0.1 } else { 1.0 };
    let unit = 1e-3;
    let mesh =
        straight_box(n, [n[0] as f64 * unit, n[1] as f64 * unit, n[2] as f64 * unit * thickness]);
    let clamped = nodes_where(&mesh, |p| p.x == 0.0);
    let mut params = ElasticParams::new(common::material(), clamped);
    if kind == "jump" {
        let stiff = |e| if e % 20 == 7 { 1e6 } else { 1.0 };
        params.element_stiffness_scale = Some((0..mesh.elements().len()).map(stiff).collect());
    }
    Ok((mesh, params))
}

/// Unit forces at nodes spread over the mesh.
fn loads(mesh: &Tet10Mesh, clamped: &[FeNodeId], n_loads: usize) -> Vec<NodalLoad> {
    let mut is_clamped = vec![false; mesh.nodes().len()];
    clamped.iter().for_each(|node| is_clamped[node.index()] = true);
    let free: Vec<usize> = (0..mesh.nodes().len()).filter(|&n| !is_clamped[n]).collect();
    (0..n_loads)
        .map(|i| {
            let node = FeNodeId::from_index(free[(i + 1) * (free.len() - 1) / n_loads]);
            NodalLoad::nodal(node, Vector3::new(0.3, -0.5, 1.0))
        })
        .collect()
}

type Field = Vec<Vector3<f64>>;

fn solve(
    mesh: &Tet10Mesh,
    params: &ElasticParams,
    loads: &[NodalLoad],
) -> Result<Vec<Field>, Box<dyn Error>> {
    let started = Instant::now();
    let model = ElasticModel::build(mesh, params)?;
    let build_s = started.elapsed().as_secs_f64();
    let info = model.info();
    println!("solver           {}", model.solver_info());
    println!("equations        {}", info.n_equations);
    println!(
        "build            {build_s:.2} s: order {:.2}, assemble {:.2}, factor or levels {:.2}",
        info.order_s, info.assemble_s, info.factor_s
    );
    let mut fields = Vec::new();
    let all: Vec<FeNodeId> = (0..mesh.nodes().len()).map(FeNodeId::from_index).collect();
    let (compliance, solved) = model.compliance(loads, &all, &ComplianceParams::default())?;
    println!(
        "solve            {:.2} s, {} loads, {} threads",
        solved.elapsed_s,
        loads.len(),
        params.n_threads
    );
    println!("iterations       {} ({} restarts)", solved.n_iterations, solved.n_refinements);
    println!("backward error   {:.3e}", solved.worst_backward_error);
    println!("energy error     {:.3e} (estimate)", solved.worst_energy_error);
    println!("residual         {:.3e}", solved.worst_relative_residual);
    println!("peak memory      {}", peak_memory()?);
    for load in 0..loads.len() {
        fields.push((0..all.len()).map(|n| compliance.displacement(load, n)).collect());
    }
    Ok(fields)
}

/// The largest difference of two fields over the largest displacement.
fn miss(a: &Field, b: &Field) -> f64 {
    let largest = a.iter().map(|u| u.norm()).fold(0.0, f64::max);
    let differences = a.iter().zip(b).map(|(a, b)| (a - b).norm());
    differences.fold(0.0, f64::max) / largest
}

fn peak_memory() -> Result<String, Box<dyn Error>> {
    let status = std::fs::read_to_string("/proc/self/status")?;
    let line = status.lines().find(|line| line.starts_with("VmHWM")).ok_or("no VmHWM")?;
    Ok(line.trim_start_matches("VmHWM:").trim().to_owned())
}
