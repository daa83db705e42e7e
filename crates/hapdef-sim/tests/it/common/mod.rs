//! Box meshes and inputs for the tests.
#![allow(dead_code, reason = "each test uses a part")]

use std::path::PathBuf;

use hapdef_mesh::{FeNodeId, SkinRegion, TET10_EDGES, Tet10Mesh, Tri6Face, kuhn_block};
use hapdef_sim::{ElasticModel, ElasticParams, IsotropicMaterial};
use nalgebra::{Point3, Vector3};
use proptest::prelude::ProptestConfig;

pub const E_PA: f64 = 2.0e9;
pub const NU: f64 = 0.3;

/// A box of `n` cells and size `size_m` from the origin, six tetrahedra a cell, mapped by `map`;
/// mid-side nodes lie on the mapped middle, so curved maps give curved faces.
pub fn mapped_box(
    n: [usize; 3],
    size_m: [f64; 3],
    map: impl Fn(Point3<f64>) -> Point3<f64>,
) -> Tet10Mesh {
    let size = Vector3::from(size_m);
    kuhn_block(n, |p| map(p.coords.component_mul(&size).into())).expect("the box is a valid mesh")
}

pub fn straight_box(n: [usize; 3], size_m: [f64; 3]) -> Tet10Mesh {
    mapped_box(n, size_m, |p| p)
}

/// A box with straight edges whose inner corner nodes are moved, and mid-side nodes with them.
pub fn distorted_box(n: usize) -> Tet10Mesh {
    let straight = straight_box([n; 3], [1.0; 3]);
    let wobble = |p: &Point3<f64>| {
        let inside = p.iter().map(|c| c * (1.0 - c)).product::<f64>() * 64.0;
        let h = 0.15 / n as f64 * inside;
        p + Vector3::new((17.0 * p.y).sin(), (13.0 * p.z + 1.0).sin(), (11.0 * p.x + 2.0).cos()) * h
    };
    let mut nodes: Vec<Point3<f64>> = straight.nodes().to_vec();
    for element in straight.elements() {
        for &corner in &element[..4] {
            nodes[corner.index()] = wobble(&straight.nodes()[corner.index()]);
        }
    }
    for element in straight.elements() {
        for (i, [a, b]) in TET10_EDGES.into_iter().enumerate() {
            let (a, b) = (nodes[element[a].index()], nodes[element[b].index()]);
            nodes[element[4 + i].index()] = nalgebra::center(&a, &b);
        }
    }
    Tet10Mesh::new(nodes, straight.elements().to_vec()).expect("the distortion is mild")
}

pub fn nodes_where(mesh: &Tet10Mesh, take: impl Fn(&Point3<f64>) -> bool) -> Vec<FeNodeId> {
    let nodes = mesh.nodes().iter().enumerate();
    nodes.filter(|(_, p)| take(p)).map(|(i, _)| FeNodeId::from_index(i)).collect()
}

/// The boundary faces all of whose nodes satisfy `take`.
pub fn faces_where(mesh: &Tet10Mesh, take: impl Fn(&Point3<f64>) -> bool) -> Vec<Tri6Face> {
    let on = |face: &Tri6Face| face.nodes.iter().all(|n| take(&mesh.nodes()[n.index()]));
    mesh.boundary().faces.into_iter().filter(on).collect()
}

pub fn skin_where(mesh: &Tet10Mesh, take: impl Fn(&Point3<f64>) -> bool) -> SkinRegion {
    SkinRegion::new(mesh, faces_where(mesh, take)).expect("faces were taken")
}

pub fn material() -> IsotropicMaterial {
    material_of(NU)
}

pub fn material_of(nu: f64) -> IsotropicMaterial {
    IsotropicMaterial::new(E_PA, nu, 1000.0).expect("a valid material")
}

pub fn params(clamped: Vec<FeNodeId>) -> ElasticParams {
    ElasticParams::new(material(), clamped)
}

/// A cantilever box clamped at x = 0.
pub fn cantilever(n: [usize; 3]) -> (Tet10Mesh, ElasticModel) {
    let mesh = straight_box(n, [0.1, 0.02, 0.01]);
    let clamped = nodes_where(&mesh, |p| p.x == 0.0);
    let model = ElasticModel::build(&mesh, &params(clamped)).expect("a clamped cantilever");
    (mesh, model)
}

/// The shared inputs, or nothing (with a printed reason) where they are absent.
pub fn shared(path: &str) -> Option<PathBuf> {
    let default = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared");
    let root = std::env::var("HAPDEF_SHARED").unwrap_or_else(|_| default.to_owned());
    let path = PathBuf::from(root).join("inputs").join(path);
    if path.exists() {
        return Some(path);
    }
    println!("skipped: {} is absent (set HAPDEF_SHARED)", path.display());
    None
}

#[track_caller]
pub fn close(found: f64, expected: f64, relative: f64) {
    assert!(
        (found - expected).abs() <= relative * expected.abs(),
        "found {found:e}, expected {expected:e} to {relative:e} relative, differs by {:e}",
        (found - expected).abs() / expected.abs()
    );
}

/// A property test of `cases` cases that writes no files.
pub fn cases(cases: u32) -> ProptestConfig {
    ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() }
}
