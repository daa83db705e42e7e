//! Times adjoint solves on a refined limb: `adjoint_bench DECK [N_THREADS] [N_REFINEMENTS]`.
//!
//! Ten gauges on the boundary; prints sizes, times, the worst residual and the peak memory.
#![allow(
    clippy::print_stdout,
    reason = "a program that prints what it measures"
)]

use std::collections::BTreeSet;
use std::error::Error;
use std::path::Path;
use std::time::Instant;

use hapdef_mesh::{TET10_EDGES, Tet10Mesh, read_deck, tet10};
use hapdef_sim::{
    ElasticModel, ElasticParams, GaugeParams, GaugeSite, GaugeStrain, IsotropicMaterial,
};
use nalgebra::Point3;

fn main() -> Result<(), Box<dyn Error>> {
    let mut args = std::env::args().skip(1);
    let path = args
        .next()
        .ok_or("usage: adjoint_bench DECK [N_THREADS] [N_REFINEMENTS]")?;
    let n_threads = args.next().map_or(Ok(1), |n| n.parse())?;
    let n_refinements: usize = args.next().map_or(Ok(1), |n| n.parse())?;
    let deck = read_deck(Path::new(&path))?;
    let coarse = deck.mesh.boundary();
    let mut mesh = deck.mesh;
    let started = Instant::now();
    for _ in 0..n_refinements {
        let (finer, n_straightened) = refined(&mesh)?;
        println!(
            "straightened     {n_straightened} of {} elements",
            mesh.elements().len()
        );
        mesh = finer;
    }
    println!("refinement       {:.3} s", started.elapsed().as_secs_f64());
    println!(
        "clamped          {} nodes, those of the deck",
        deck.fixed_nodes.len()
    );
    let stated = deck.material.ok_or("the deck states no material")?;
    let density = stated.density_kg_m3.ok_or("the deck states no density")?;
    let material =
        IsotropicMaterial::new(stated.youngs_modulus_pa, stated.poissons_ratio, density)?;
    let clamped = deck.fixed_nodes;
    let params = ElasticParams {
        material,
        element_stiffness_scale: None,
        clamped,
        n_threads,
    };
    let model = ElasticModel::build(&mesh, &params)?;
    println!("{:#?}", model.info());
    let faces = mesh.boundary().faces;
    let lenient = GaugeParams {
        max_lost_share: 0.9,
        ..GaugeParams::default()
    };
    let gauges: Vec<GaugeStrain> = coarse
        .faces
        .iter()
        .filter_map(|face| {
            let (position, tip) = (mesh.position(face.nodes[3]), mesh.position(face.nodes[0]));
            let site = GaugeSite {
                position,
                axis: tip - position,
                length_m: 8e-3,
                width_m: 5e-3,
            };
            GaugeStrain::with_params(&mesh, &faces, &site, &lenient).ok()
        })
        .take(10)
        .collect();
    let (_, info) = model.gauge_response(&gauges)?;
    println!("{info:#?}");
    println!("peak memory      {}", peak_memory()?);
    Ok(())
}

/// `mesh` refined once, and how many of its elements had to be straightened first because their
/// curved map turns a child inside out.
fn refined(mesh: &Tet10Mesh) -> Result<(Tet10Mesh, usize), Box<dyn Error>> {
    let (mut mesh, mut n_straightened) = (mesh.clone(), 0);
    loop {
        let children = mesh.refine();
        let bad: BTreeSet<usize> = (0..children.elements().len())
            .filter(|&child| !is_right_side_out(&children.element_positions(child)))
            .map(|child| child / 8)
            .collect();
        if bad.is_empty() {
            return Ok((children, n_straightened));
        }
        n_straightened += bad.len();
        let mut nodes = mesh.nodes().to_vec();
        for ids in bad.into_iter().map(|parent| mesh.elements()[parent]) {
            for (i, [a, b]) in TET10_EDGES.into_iter().enumerate() {
                nodes[ids[4 + i].index()] =
                    nalgebra::center(&nodes[ids[a].index()], &nodes[ids[b].index()]);
            }
        }
        mesh = Tet10Mesh::new(nodes, mesh.elements().to_vec())?;
    }
}

fn is_right_side_out(nodes: &[Point3<f64>; 10]) -> bool {
    let [a, b, c, d] = [nodes[0], nodes[1], nodes[2], nodes[3]];
    (b - a).cross(&(c - a)).dot(&(d - a)) > 0.0 && tet10::min_gauss_jacobian(nodes) > 0.0
}

fn peak_memory() -> Result<String, Box<dyn Error>> {
    let status = std::fs::read_to_string("/proc/self/status")?;
    let line = status
        .lines()
        .find(|line| line.starts_with("VmHWM"))
        .ok_or("no VmHWM")?;
    Ok(line.trim_start_matches("VmHWM:").trim().to_owned())
}
