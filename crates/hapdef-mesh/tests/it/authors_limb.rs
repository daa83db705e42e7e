//! The paper authors' own limb (two ANSYS decks), read from the shared inputs; skipped with a
//! reason where they are absent.

use std::path::PathBuf;

use crate::gltf_common::shared;
use hapdef_mesh::{
    FeNodeId, MeshError, OuterSkinParams, RadialRegionParams, SkinRegion, SolidDeck, Tet10Mesh,
    gauge_patch, outer_skin, radial_region, read_deck, tet10, tri6, wall,
};
use nalgebra::{Point3, Vector3};

fn input(name: &str) -> Option<PathBuf> {
    shared(&format!("hapdef-shin/{name}"))
}

fn deck(name: &str) -> Option<SolidDeck> {
    Some(read_deck(&input(name)?).unwrap())
}

fn skin(mesh: &Tet10Mesh) -> SkinRegion {
    let params = RadialRegionParams {
        axis_point: Point3::origin(),
        axis_dir: Vector3::y(),
        min_normal_dot_radial: 0.5,
        min_radius_m: 0.028,
        axial_range_m: (0.0415, f64::INFINITY),
    };
    radial_region(mesh, &mesh.boundary(), &params).unwrap()
}

/// Mass and centre of mass as ANSYS 18.2 printed them for this deck (density 930 kg/m³).
#[test]
fn the_skin_deck_is_read_whole() {
    let Some(deck) = deck("02_skin_ds.dat.gz") else {
        return;
    };
    assert_eq!((deck.mesh.nodes().len(), deck.mesh.elements().len()), (22_284, 10_729));
    assert_eq!(deck.fixed_nodes.len(), 208);
    assert_eq!(deck.node_sets["_FIXEDSU"], deck.fixed_nodes);
    let material = deck.material.unwrap();
    assert_eq!((material.youngs_modulus_pa, material.poissons_ratio), (1.7e9, 0.394));
    assert_eq!(material.density_kg_m3, Some(930.0));
    let loaded = FeNodeId::from_index(deck.node_labels.binary_search(&2984).unwrap());
    assert_eq!(deck.nodal_forces, [(loaded, Vector3::new(10.0, 0.0, -15.0))]);
    assert!(deck.face_tractions.is_empty() && deck.unused_node_labels.is_empty());

    let volume_m3: f64 = (0..deck.mesh.elements().len())
        .map(|e| tet10::volume(&deck.mesh.element_positions(e)))
        .sum();
    assert!((volume_m3 * 930.0 - 0.0261236).abs() < 5e-8);
}

/// 360 N on 46 faces, down the limb's axis.
#[test]
fn the_weight_deck_carries_360_newtons() {
    let Some(deck) = deck("01_weight_ds.dat.gz") else {
        return;
    };
    assert_eq!(deck.face_tractions.len(), 46);
    let mut total = Vector3::zeros();
    for load in &deck.face_tractions {
        assert_eq!(load.traction_pa, Vector3::new(0.0, -185459.906038001, 0.0));
        let nodes = load.nodes.map(|node| deck.mesh.position(node));
        total += load.traction_pa * tri6::area(&nodes);
    }
    assert!((total - Vector3::new(0.0, -360.0, 0.0)).norm() < 1e-4);
    // the faces are the upper end, so the load presses down; the lower end is held
    for load in &deck.face_tractions {
        let nodes = load.nodes.map(|node| deck.mesh.position(node));
        assert!(nodes.iter().all(|p| (p.y - 0.1609).abs() < 1e-9));
        let normal = tri6::area_vector(&nodes, 0.3, 0.3).try_normalize(0.0).unwrap();
        assert!(normal.y > 0.999_999);
    }
    assert!(
        deck.fixed_nodes.iter().all(|node| (deck.mesh.position(*node).y - 0.0385).abs() < 1e-9)
    );
}

/// 3,211 nodes in the paper; 3,190 here with limits that were read off the published geometry.
#[test]
fn the_skin_has_the_paper_s_size() {
    let Some(deck) = deck("02_skin_ds.dat.gz") else {
        return;
    };
    let skin = skin(&deck.mesh);
    assert_eq!((skin.nodes.len(), skin.faces.len()), (3_190, 1_195));
    let area_m2 = skin.area_m2(&deck.mesh);
    assert!((area_m2 - 0.017215).abs() < 1e-6, "{area_m2}");
}

#[test]
fn the_wall_is_about_a_millimetre() {
    let Some(deck) = deck("02_skin_ds.dat.gz") else {
        return;
    };
    let (mesh, boundary) = (&deck.mesh, deck.mesh.boundary());
    let inside = wall(mesh, &boundary, &skin(mesh), 3e-3).unwrap();
    let quartiles = [0.25, 0.5, 0.75].map(|q| 1e3 * inside.thickness_quantile_m(q).unwrap());
    println!("{} inner faces, thickness quartiles {quartiles:?} mm", inside.inner_faces.len());
    for (found, pinned) in quartiles.into_iter().zip([0.818, 0.956, 1.300]) {
        assert!((found - pinned).abs() < 1e-3, "{quartiles:?}");
    }
    let outer = outer_skin(mesh, &boundary, &OuterSkinParams::default()).unwrap();
    assert_eq!((boundary.faces.len(), outer.faces.len()), (7_122, 1_338));
}

/// Ten sites on the inner wall: all on it, patches on the gauge's side only, and none 5 mm off.
#[test]
fn gauge_sites_are_on_the_wall() {
    let Some(deck) = deck("02_skin_ds.dat.gz") else {
        return;
    };
    let Some(path) = input("gauge-sites.json") else {
        return;
    };
    let (mesh, boundary) = (&deck.mesh, deck.mesh.boundary());
    let skin = skin(mesh);
    let inside = wall(mesh, &boundary, &skin, 3e-3).unwrap();
    let sites: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let vectors = |key: &str| -> Vec<Vector3<f64>> {
        let numbers = |v: &serde_json::Value| [0, 1, 2].map(|i| v[i].as_f64().unwrap());
        sites[key].as_array().unwrap().iter().map(|v| numbers(v).into()).collect()
    };
    let (centres_mm, normals) = (vectors("sites_mm"), vectors("normal"));
    assert_eq!(centres_mm.len(), 10);
    let mut n_edge = 0;
    for (centre_mm, normal) in centres_mm.iter().zip(&normals) {
        let centre = Point3::from(centre_mm * 1e-3);
        let patch = gauge_patch(mesh, &boundary.faces, &centre, 24, 2e-4).unwrap();
        assert!(patch.normal.dot(normal) > 0.999, "{} {normal}", patch.normal);
        // where the wall runs out to an edge, a node belongs to both sides
        let is_edge = |node: &&FeNodeId| skin.nodes.binary_search(node).is_ok();
        n_edge += patch.nodes.iter().filter(is_edge).count();
        let on_inner_wall = gauge_patch(mesh, &inside.inner_faces, &centre, 24, 2e-4).unwrap();
        assert_eq!(on_inner_wall, patch);
        // against the inner wall only: 5 mm inwards of one site there is a rib
        match gauge_patch(mesh, &inside.inner_faces, &(centre + normal * 5e-3), 24, 2e-4) {
            Err(MeshError::GaugeOffWall { distance_m, .. }) => {
                assert!((2e-4..=5.2e-3).contains(&distance_m), "{distance_m}");
            }
            other => panic!("{other:?}"),
        }
    }
    assert!(n_edge <= 5, "{n_edge} of 240 patch nodes are on the outside");
    println!("{n_edge} of 240 patch nodes are also on the outside");
}

/// Refinement shows what the Gauss points of these elements don't: some are folded at their
/// corners (Workbench bends slivers onto the CAD surface).
#[test]
fn refinement_keeps_the_authors_volume() {
    let Some(deck) = deck("02_skin_ds.dat.gz") else {
        return;
    };
    let fine = deck.mesh.refine();
    assert_eq!((fine.nodes().len(), fine.elements().len()), (144_694, 85_832));
    let volume_m3 = |mesh: &Tet10Mesh| -> f64 {
        (0..mesh.elements().len()).map(|e| tet10::volume(&mesh.element_positions(e))).sum()
    };
    assert!((volume_m3(&fine) / volume_m3(&deck.mesh) - 1.0).abs() < 1e-12);
    let folded = |mesh: &Tet10Mesh| {
        let usable = |e: &usize| tet10::min_gauss_jacobian(&mesh.element_positions(*e)) > 0.0;
        (0..mesh.elements().len()).filter(|e| !usable(e)).count()
    };
    assert_eq!((folded(&deck.mesh), folded(&fine)), (0, 90));
}
