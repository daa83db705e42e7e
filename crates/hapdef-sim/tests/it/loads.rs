//! Totals, moments and shapes of distributed loads.

use crate::common;

use common::{close, faces_where, mapped_box, shared, skin_where, straight_box};
use hapdef_mesh::{FaceTraction, SkinRegion, Tet10Mesh, tri6};
use hapdef_sim::{MassProperties, NodalLoad, SimError};
use nalgebra::{Point3, Vector3};
use proptest::prelude::*;

fn curved_box() -> Tet10Mesh {
    mapped_box([3, 3, 2], [1.0, 1.0, 0.5], |p| {
        Point3::new(
            p.x + 0.1 * p.y * p.z,
            p.y - 0.1 * p.x * p.x,
            p.z + 0.1 * (2.0 * p.x + p.y).sin(),
        )
    })
}

fn top(mesh: &Tet10Mesh) -> SkinRegion {
    skin_where(mesh, |p| (p.z - 1.0).abs() < 1e-12)
}

#[test]
fn pressure_on_a_closed_curved_surface_has_no_resultant() {
    let mesh = curved_box();
    let load = NodalLoad::pressure(&mesh, &mesh.boundary().faces, 1e5).expect("own faces");
    let size: f64 = load.forces_n.iter().map(|(_, f)| f.norm()).sum();
    let moment = load.moment_nm(&mesh, &Point3::new(3.0, 1.0, -2.0)).expect("own nodes");
    assert!(load.total_n().norm() < 1e-13 * size, "total {}", load.total_n());
    assert!(moment.norm() < 1e-12 * size, "moment {moment}");
}

#[test]
fn traction_totals_traction_times_area() {
    let mesh = curved_box();
    let faces = mesh.boundary().faces;
    let traction_pa = Vector3::new(1.0, -2.0, 0.5);
    let tractions: Vec<_> =
        faces.iter().map(|f| FaceTraction { nodes: f.nodes, traction_pa }).collect();
    let area: f64 =
        faces.iter().map(|f| tri6::area(&f.nodes.map(|n| mesh.nodes()[n.index()]))).sum();
    let load = NodalLoad::traction(&mesh, &tractions).expect("own faces");
    assert!((load.total_n() - traction_pa * area).norm() < 1e-12 * area);
}

#[test]
fn uniform_pressure_on_a_flat_face_acts_at_its_centre() {
    let mesh = straight_box([3, 2, 1], [2.0, 1.0, 1.0]);
    let faces = faces_where(&mesh, |p| (p.z - 1.0).abs() < 1e-12);
    let load = NodalLoad::pressure(&mesh, &faces, 7.0).expect("own faces");
    assert!((load.total_n() - Vector3::new(0.0, 0.0, -14.0)).norm() < 1e-12);
    let moment = load.moment_nm(&mesh, &Point3::new(1.0, 0.5, 1.0)).expect("own nodes");
    assert!(moment.norm() < 1e-12, "moment {moment}");
}

#[test]
fn gravity_totals_weight_at_the_centre_of_mass() {
    let mesh = curved_box();
    let mass = MassProperties::of(&mesh, 800.0);
    let g = Vector3::new(0.0, -9.81, 1.0);
    let load = NodalLoad::body_force(&mesh, |_| g * 800.0);
    assert!((load.total_n() - g * mass.mass_kg).norm() < 1e-12 * load.total_n().norm());
    let moment = load.moment_nm(&mesh, &mass.centre_m).expect("own nodes");
    assert!(moment.norm() < 1e-12 * load.total_n().norm(), "moment {moment}");
}

#[test]
fn patch_of_radius_zero_is_the_nearest_node() {
    let mesh = straight_box([4, 4, 1], [1.0; 3]);
    let centre = Point3::new(0.26, 0.49, 1.02);
    let load = NodalLoad::patch(&mesh, &top(&mesh), &centre, 0.0, &Vector3::new(0.0, 0.0, -2.0))
        .expect("a valid tip");
    assert_eq!(load.forces_n.len(), 1);
    let (node, force) = load.forces_n[0];
    assert!((mesh.position(node) - Point3::new(0.25, 0.5, 1.0)).norm() < 1e-12);
    assert_eq!(force, Vector3::new(0.0, 0.0, -1.0));
}

#[test]
fn tips_off_the_skin_and_unusable_tips_are_refused() {
    let mesh = straight_box([2, 2, 1], [1.0; 3]);
    let skin = top(&mesh);
    let patch = |z: f64, radius: f64, direction: Vector3<f64>| {
        NodalLoad::patch(&mesh, &skin, &Point3::new(0.5, 0.5, z), radius, &direction)
            .expect_err("refused")
    };
    let down = -Vector3::z();
    let error = patch(1.2, 0.1, down);
    assert!(
        matches!(error, SimError::PatchOffSkin { nearest_node_m, .. } if (nearest_node_m - 0.2).abs() < 1e-12),
        "{error}"
    );
    assert!(matches!(patch(1.0, -1.0, down), SimError::Parameter { .. }));
    assert!(matches!(patch(f64::NAN, 0.1, down), SimError::Parameter { .. }));
    assert!(matches!(patch(1.0, 0.1, Vector3::zeros()), SimError::Direction { .. }));
}

#[test]
fn patches_on_the_authors_limb_total_one_newton() {
    let Some(path) = shared("hapdef-shin/02_skin_ds.dat.gz") else {
        return;
    };
    let mesh = hapdef_mesh::read_deck(&path).expect("readable").mesh;
    let far = |p: &Point3<f64>| p.x.hypot(p.z) > 28e-3 && p.y > 41.5e-3;
    let skin = skin_where(&mesh, far);
    for i in (0..skin.nodes.len()).step_by(97) {
        let centre = mesh.position(skin.nodes[i]);
        let inward = -skin.normals[i];
        for radius_m in [1e-4, 2e-3, 5e-3] {
            let load = NodalLoad::patch(&mesh, &skin, &centre, radius_m, &inward).expect("on skin");
            assert!((load.total_n() - inward).norm() < 1e-13, "total {}", load.total_n());
        }
    }
}

proptest! {
    #![proptest_config(common::cases(48))]

    /// A tip inside a flat skin acts at its centre, and its mean square radius is r²/4:
    /// ∫ s³(1 − s²)² ds / ∫ s(1 − s²)² ds over (0, 1). Tri6 shape functions carry both exactly, so
    /// only the quadrature of the kernel counts, from tips far smaller than a face to tips over many.
    #[test]
    fn patch_has_the_kernel_s_moments(
        x in 0.36..0.64, y in 0.36..0.64, log_radius in -7.0..-1.1, direction in prop::array::uniform3(-1.0..1.0),
    ) {
        let mesh = straight_box([4, 3, 1], [1.0; 3]);
        let (centre, radius) = (Point3::new(x, y, 1.0), f64::exp(log_radius));
        let direction = Vector3::from(direction);
        prop_assume!(direction.norm() > 0.1);
        let load = NodalLoad::patch(&mesh, &top(&mesh), &centre, radius, &direction).expect("on skin");
        let unit = direction / direction.norm();
        prop_assert!((load.total_n() - unit).norm() < 1e-13);
        let arm = |node: hapdef_mesh::FeNodeId| mesh.position(node) - centre;
        let first: Vector3<f64> = load.forces_n.iter().map(|(n, f)| arm(*n) * f.dot(&unit)).sum();
        let second: f64 = load.forces_n.iter().map(|(n, f)| arm(*n).norm_squared() * f.dot(&unit)).sum();
        prop_assert!(first.norm() < 2e-3 * radius, "acts {} off centre, radius {radius}", first);
        prop_assert!((second / (radius * radius) - 0.25).abs() < 1e-3, "{}", second / (radius * radius));
    }
}

#[test]
fn patch_spreads_evenly_over_directions_on_a_face_it_covers_alone() {
    // one face of a coarse box, a tip far smaller than it, off its middle: the shape functions there
    let mesh = straight_box([1, 1, 1], [1.0; 3]);
    let centre = Point3::new(0.6, 0.3, 1.0);
    let load = NodalLoad::patch(&mesh, &top(&mesh), &centre, 1e-4, &Vector3::z()).expect("on skin");
    assert_eq!(load.forces_n.len(), 6);
    let weights: f64 = load.forces_n.iter().map(|(_, f)| f.z).sum();
    close(weights, 1.0, 1e-14);
    let x: f64 = load.forces_n.iter().map(|(n, f)| mesh.position(*n).x * f.z).sum();
    close(x, 0.6, 1e-6);
}
