//! Displacements at wanted nodes without the rest of the solution: the same numbers, and an honest
//! account of what was checked.

use crate::common;

use std::path::Path;

use common::{cantilever, cases, mapped_box, nodes_where, params};
use hapdef_mesh::{FeNodeId, Tet10Mesh, read_deck};
use hapdef_sim::{
    Compliance, ComplianceParams, ElasticModel, ElasticParams, IsotropicMaterial, NodalLoad,
    Residuals, SolveInfo, SolveParams,
};
use nalgebra::{Point3, Vector3};
use proptest::prelude::*;

fn limits(residuals: Residuals) -> ComplianceParams {
    ComplianceParams { residuals, ..ComplianceParams::default() }
}

fn solved(
    model: &ElasticModel,
    loads: &[NodalLoad],
    wanted: &[FeNodeId],
    residuals: Residuals,
) -> (Compliance, SolveInfo) {
    let limits = limits(residuals);
    model.compliance(loads, wanted, &limits).expect("solved")
}

fn unit_loads(nodes: &[FeNodeId]) -> Vec<NodalLoad> {
    let force = |i: usize| Vector3::new(1.0, (i as f64).sin(), (2.0 * i as f64).cos());
    let nodes = nodes.iter().enumerate();
    nodes.map(|(i, &node)| NodalLoad::nodal(node, force(i))).collect()
}

/// The whole solution and its wanted rows agree bit for bit, on one and two threads.
#[track_caller]
fn check_same(
    mesh: &Tet10Mesh,
    params: &ElasticParams,
    loads: &[NodalLoad],
    wanted: &[FeNodeId],
) -> SolveInfo {
    let mut infos = Vec::new();
    let mut all = Vec::new();
    for n_threads in [1, 2] {
        let params = ElasticParams { n_threads, ..params.clone() };
        let model = ElasticModel::build(mesh, &params).expect("a model");
        let (every, full) = solved(&model, loads, wanted, Residuals::Every);
        let (part, info) = solved(&model, loads, wanted, Residuals::Sampled { n_loads: 1 });
        assert_eq!(full.n_residuals, loads.len());
        assert_eq!((full.worst_reciprocity_error, full.backward_factor_share), (0.0, 1.0));
        assert!(every == part, "{n_threads} threads: {info:?}");
        all.push(part);
        infos.push(info);
    }
    assert!(all[0] == all[1], "two threads differ from one");
    assert_eq!(infos[0].backward_factor_share, infos[1].backward_factor_share);
    assert_eq!(infos[0].worst_reciprocity_error, infos[1].worst_reciprocity_error);
    infos[0]
}

proptest! {
    #![proptest_config(cases(12))]

    /// Random sizes and distortions make random elimination trees; some elements are cut out.
    #[test]
    fn wanted_rows_are_those_of_the_whole_solution(
        n in [2_usize..9, 1..4, 1..4],
        cut in any::<u64>(),
        picked in prop::collection::vec(0.0_f64..1.0, 1..6),
        n_loads in 9_usize..90,
    ) {
        let whole = mapped_box(n, [0.1, 0.03, 0.02], |p| p + Vector3::z() * (20.0 * p.x * p.x));
        let mesh = with_holes(&whole, cut);
        let clamped = nodes_where(&mesh, |p| p.x < 1e-12);
        let free = nodes_where(&mesh, |p| p.x > 1e-12);
        let at = |share: f64| free[(share * free.len() as f64) as usize];
        let wanted: Vec<FeNodeId> = picked.iter().map(|&share| at(share)).collect();
        let loaded: Vec<FeNodeId> = (0..n_loads).map(|i| free[i * free.len() / n_loads]).collect();
        let info = check_same(&mesh, &params(clamped), &unit_loads(&loaded), &wanted);
        prop_assert!(info.n_residuals < n_loads, "{info:?}");
        prop_assert!(info.worst_reciprocity_error <= info.forward_error_bound());
    }
}

/// The mesh without some of its elements beyond the first layer, as long as what is left is one
/// piece: an element goes only where all its corners keep two others.
fn with_holes(mesh: &Tet10Mesh, seed: u64) -> Tet10Mesh {
    let mut n_at = vec![0; mesh.nodes().len()];
    for element in mesh.elements() {
        element[..4].iter().for_each(|node| n_at[node.index()] += 1);
    }
    let mut bits = seed;
    let mut kept = Vec::new();
    for element in mesh.elements() {
        bits = bits.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        let inner = element[..4].iter().all(|node| n_at[node.index()] > 8);
        if inner && bits >> 62 == 0 {
            element[..4].iter().for_each(|node| n_at[node.index()] -= 1);
        } else {
            kept.push(*element);
        }
    }
    let mut new = vec![None; mesh.nodes().len()];
    let mut nodes: Vec<Point3<f64>> = Vec::new();
    for element in &mut kept {
        for node in element.iter_mut() {
            let old = node.index();
            *node = *new[old].get_or_insert_with(|| {
                nodes.push(mesh.nodes()[old]);
                FeNodeId::from_index(nodes.len() - 1)
            });
        }
    }
    Tet10Mesh::new(nodes, kept).expect("elements of a valid mesh")
}

#[test]
fn the_authors_limb_gives_the_same_from_a_part_of_the_factor() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/shin/shin.inp.gz");
    let deck = read_deck(&path).expect("the fixture's deck");
    let mut free = deck.mesh.boundary().nodes();
    free.retain(|node| !deck.fixed_nodes.contains(node));
    let loaded: Vec<FeNodeId> = free.iter().copied().step_by(free.len() / 200).collect();
    let wanted: Vec<FeNodeId> = loaded.iter().copied().step_by(40).collect();
    let material = IsotropicMaterial::new(2.2e9, 0.38, 1000.0).expect("a material");
    let params = ElasticParams::new(material, deck.fixed_nodes.clone());
    let info = check_same(&deck.mesh, &params, &unit_loads(&loaded), &wanted);
    assert_eq!(info.n_residuals, 64, "one block of {}", loaded.len());
    assert!(info.forward_factor_share < 0.8, "{info:?}");
    assert!(info.backward_factor_share < 0.7, "{info:?}");
    assert!(info.worst_reciprocity_error > 0.0, "{info:?}");
}

#[test]
fn what_asks_for_refinement_is_solved_in_full() {
    let (mesh, model) = cantilever([12, 3, 2]);
    let free = nodes_where(&mesh, |p| p.x > 0.0);
    let (loads, sampled) = (unit_loads(&free), Residuals::Sampled { n_loads: 70 });
    let (_, info) = solved(&model, &loads, &free[..3], sampled);
    assert_eq!(info.n_residuals, 128, "two blocks of {}", loads.len());
    let all = Residuals::Sampled { n_loads: loads.len() };
    let (_, info) = solved(&model, &loads, &free[..3], all);
    assert_eq!(info.n_residuals, loads.len());
    let refining = [
        SolveParams { extend_above_condition: 1.0, ..SolveParams::default() },
        SolveParams { refine_above: 0.0, ..SolveParams::default() },
    ];
    for solve in refining {
        let limits = ComplianceParams { solve, ..limits(sampled) };
        let solved = model.compliance(&loads, &free[..3], &limits);
        let (_, info) = solved.expect("solved");
        assert_eq!(info.n_residuals, loads.len(), "{solve:?}");
        assert!(info.n_refinements > 0);
    }
}
