//! The authors' limb against ANSYS's printout and CalculiX's displacements.

use crate::common;

use std::io::Read;
use std::path::Path;

use common::{close, shared};
use hapdef_mesh::{FeNodeId, SolidDeck, read_deck};
use hapdef_sim::{ElasticModel, ElasticParams, IsotropicMaterial, MassProperties, NodalLoad};
use nalgebra::Vector3;

fn deck(name: &str) -> Option<SolidDeck> {
    let path = shared(&format!("hapdef-shin/{name}"))?;
    Some(read_deck(&path).expect("the authors' deck is readable"))
}

fn model(deck: &SolidDeck) -> ElasticModel {
    let stated = deck.material.expect("the deck states a material");
    let density = stated.density_kg_m3.expect("the deck states a density");
    let material = IsotropicMaterial::new(stated.youngs_modulus_pa, stated.poissons_ratio, density)
        .expect("a valid material");
    let clamped = deck.fixed_nodes.clone();
    let params = ElasticParams { n_threads: 2, ..ElasticParams::new(material, clamped) };
    ElasticModel::build(&deck.mesh, &params).expect("the deck is well supported")
}

/// CalculiX's displacements by node label, m.
fn calculix(path: &Path) -> Vec<(u32, Vector3<f64>)> {
    let mut text = String::new();
    let file = std::fs::File::open(path).expect("readable");
    flate2::read::GzDecoder::new(file).read_to_string(&mut text).expect("gzip");
    let row = |line: &str| {
        let words: Vec<&str> = line.split_whitespace().collect();
        let label = words.first()?.parse().ok()?;
        let value = |i: usize| words.get(i)?.parse::<f64>().ok();
        Some((label, Vector3::new(value(1)?, value(2)?, value(3)?)))
    };
    text.lines().filter_map(row).collect()
}

fn largest(displacement: &[Vector3<f64>]) -> f64 {
    displacement.iter().map(|u| u.norm()).fold(0.0, f64::max)
}

#[test]
fn skin_deck_matches_calculix_at_every_node() {
    let (Some(deck), Some(reference)) =
        (deck("02_skin_ds.dat.gz"), shared("hapdef-shin/ccx_shin_node2984.dat.gz"))
    else {
        return;
    };
    let model = model(&deck);
    let load = NodalLoad { forces_n: deck.nodal_forces.clone(), ..NodalLoad::default() };
    let (u, info) = model.solve(&load).expect("solved");
    println!("{:?}\n{info:?}", model.info());

    let reference = calculix(&reference);
    assert_eq!(reference.len(), deck.mesh.nodes().len());
    let at = |label: u32| u[deck.node_labels.binary_search(&label).expect("a node label")];
    let worst = reference.iter().map(|(label, r)| (at(*label) - r).norm()).fold(0.0, f64::max);
    assert!(worst <= 1e-5 * 1.224494e-3, "worst node differs by {worst:e} m");

    let expected = Vector3::new(0.7116812e-3, 0.0704930e-3, -0.9543635e-3);
    assert!((at(2984) - expected).norm() < 1e-6 * 1.2e-3, "node 2984 moves by {}", at(2984));
    close(largest(&u), 1.224494e-3, 1e-6);
    close(model.strain_energy_j(&u).expect("full field"), 1.071613e-2, 1e-6);
    close(0.5 * load.work_j(&u).expect("own load"), 1.071613e-2, 1e-6);
}

#[test]
fn skin_deck_matches_the_ansys_printout() {
    let Some(deck) = deck("02_skin_ds.dat.gz") else {
        return;
    };
    let model = model(&deck);
    let info = model.info();
    assert_eq!(info.n_equations, 66_228);
    assert_eq!(info.nnz_lower, 2_236_206);
    // ANSYS's factor has 10,377,747
    assert!(info.nnz_l < 15_500_000, "nnz(L) = {}", info.nnz_l);
    assert!(info.nnz_l_stored < info.nnz_l * 3 / 2, "{} stored", info.nnz_l_stored);

    let extremes = model.stiffness_extremes();
    println!("{extremes:?}");
    close(extremes.largest_n_m, 3.856521697e9, 1e-9);
    assert_eq!(deck.element_labels[extremes.largest_element], 1737);
    close(extremes.smallest_n_m, 149_749.234, 1e-8);
    assert_eq!(deck.element_labels[extremes.smallest_element], 1241);

    let mass = MassProperties::of(&deck.mesh, 930.0);
    println!("{mass:?}");
    close(mass.mass_kg, 0.0261236, 2e-6);
    let expected = Vector3::new(-6.7992e-4, 0.094823, 5.5935e-5);
    assert!((mass.centre_m.coords - expected).norm() < 6e-7, "centre {}", mass.centre_m);
}

#[test]
fn weight_deck_matches_calculix_and_its_total_force() {
    let Some(deck) = deck("01_weight_ds.dat.gz") else {
        return;
    };
    let load = NodalLoad::traction(&deck.mesh, &deck.face_tractions).expect("valid faces");
    println!("total {}", load.total_n());
    assert!((load.total_n() - Vector3::new(0.0, -360.0, 0.0)).norm() < 1e-3 * 360.0);
    let (u, info) = model(&deck).solve(&load).expect("solved");
    println!("{info:?} {:e} {:e}", largest(&u), 0.5 * load.work_j(&u).expect("own load"));
    close(largest(&u), 6.046101e-3, 1e-5);
    close(0.5 * load.work_j(&u).expect("own load"), 0.2653024, 1e-5);
}

#[test]
fn inclusions_a_million_times_stiffer_still_solve() {
    let Some(deck) = deck("02_skin_ds.dat.gz") else {
        return;
    };
    let plain = model(&deck);
    let n = deck.mesh.elements().len();
    let scale: Vec<f64> = (0..n).map(|e| if e % 20 == 7 { 1e6 } else { 1.0 }).collect();
    let material = IsotropicMaterial::new(1.7e9, 0.394, 930.0).expect("valid");
    let stiff = plain.with_stiffness(&deck.mesh, &material, Some(&scale)).expect("same mesh");
    let load = NodalLoad { forces_n: deck.nodal_forces.clone(), ..NodalLoad::default() };
    let (u, info) = stiff.solve(&load).expect("solved");
    // ‖r‖/‖b‖ grows with ‖K‖‖u‖/‖b‖, the backward error does not.
    assert!(info.worst_backward_error < 1e-14, "{info:?}");
    let (soft, _) = plain.solve(&load).expect("solved");
    assert!(load.work_j(&u).expect("own") < load.work_j(&soft).expect("own"));
    // reciprocity notices an inaccurate solution that its own residual hides
    let other = NodalLoad::nodal(FeNodeId(7), Vector3::new(1.0, 2.0, 3.0));
    let (v, _) = stiff.solve(&other).expect("solved");
    close(other.work_j(&u).expect("own"), load.work_j(&v).expect("own"), 1e-6);
}
