//! Cook's membrane as a slab and as a shell.

use nalgebra::Point3;

use super::prelude::*;

/// The slab of ten-node tetrahedra. Its lower face is its plane of symmetry, so that the model is half
/// as thick as the slab; with a traction-free upper face the mean over the thickness is plane stress up
/// to (t/L)².
pub(super) fn solids() -> Vec<Case> {
    let slab = Model {
        mesh: Mesh::Block(|p| trapezium(p) + Point3::new(0.0, 0.0, 0.5 * p.z).coords),
        material: [1.0, 1.0 / 3.0],
        // z is free at the wall, as in plane stress
        supports: &[(Only(&[0, 1]), X(0.0)), (Mirror(2), Z(0.0))],
        load: Load::Total(X(48.0), 1, 0.5),
        probe: Probe::U(Place::At([48.0, 52.0, 0.0]), 1),
    };
    vec![Case {
        quantity: "v at (48, 52) under unit shear, E = 1, ν = 1/3; a slab of thickness 1 for plane stress",
        meshes: &[[4, 4, 1], [8, 8, 1], [16, 16, 1]],
        solve: Solve::of(slab),
        ..cook()
    }]
}

/// The shells, whose kinds have one membrane.
pub(super) fn shells() -> Vec<Case> {
    let shell = Model {
        mesh: Mesh::Grid(1.0, Pattern::ALL, trapezium),
        material: [1.0, 1.0 / 3.0],
        supports: &[(All, X(0.0))],
        load: Load::Total(X(48.0), 1, 1.0),
        probe: Probe::U(Place::Grid(1.0, 0.5), 1),
    };
    let case = Case {
        quantity: "v at (48, 52) under unit shear, E = 1, ν = 1/3, thickness 1",
        meshes: &[[8, 8, 1], [16, 16, 1], [32, 32, 1]],
        solve: Solve::of(shell),
        ..cook()
    };
    case.both().into()
}

fn cook() -> Case {
    Case {
        name: "cook",
        title: "Cook's membrane",
        reference: Reference::Published(23.96),
        source: "Cook, J. Struct. Div. ASCE 100, 1974; the converged 23.96 at (48, 52) is quoted by many \
            later papers, here from memory",
        ..Case::default()
    }
}

fn trapezium(p: Point3<f64>) -> Point3<f64> {
    Point3::new(48.0 * p.x, 44.0 * p.x + (44.0 - 28.0 * p.x) * p.y, 0.0)
}
