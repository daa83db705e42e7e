//! The bundled limb as a body to print: written, read back, measured.

use std::path::Path;

use hapdef::scene::{Scene, read_scene};
use hapdef::{Limb, PrintParams, PrintedLimb, print_limb};
use hapdef_mesh::{
    GltfParams, LengthUnit, QualityReport, SurfaceMesh, read_surface, tet10, write_stl,
};
use nalgebra::{Matrix3, Point3, Vector3};

fn limb() -> (Scene, Limb) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/shin");
    let scene = read_scene(&folder.join("placed.json")).unwrap();
    let limb = Limb::load(&scene, &folder).unwrap();
    (scene, limb)
}

fn printed(scene: &Scene, limb: &Limb, params: &PrintParams) -> PrintedLimb {
    print_limb(scene, limb, params).unwrap()
}

fn read_back(body: &SurfaceMesh) -> SurfaceMesh {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("limb.stl");
    write_stl(&path, body).unwrap();
    let params = GltfParams { unit: LengthUnit::Millimetre, ..GltfParams::default() };
    read_surface(&path, &params).unwrap().mesh
}

/// Where a ray first leaves the body, from `start` on, m (Möller and Trumbore, J. Graphics Tools 2(1),
/// 1997).
fn way_through_m(body: &SurfaceMesh, start: &Point3<f64>, ray: &Vector3<f64>) -> f64 {
    let meets = |t: usize| {
        let [a, b, c] = body.corners(t);
        let solved = Matrix3::from_columns(&[-ray, b - a, c - a]).lu().solve(&(start - a))?;
        let [s, u, v]: [f64; 3] = solved.into();
        let leaves = body.area_normal_m2(t).dot(ray) > 0.0;
        (s > 1e-5 && u >= 0.0 && v >= 0.0 && u + v <= 1.0 && leaves).then_some(s)
    };
    (0..body.triangles().len()).filter_map(meets).fold(f64::INFINITY, f64::min)
}

#[test]
fn the_printed_limb_is_one_closed_body_with_the_wall_of_the_limb() {
    let (scene, limb) = limb();
    let params = PrintParams::default();
    let printed = printed(&scene, &limb, &params);
    let body = read_back(&printed.body);
    let report = QualityReport::of(&body);
    assert!(report.is_closed(), "{report}");
    assert_eq!((report.n_bodies, printed.trim_m), (1, 0.0), "{report}");
    let elements = limb.mesh.elements().iter();
    let solid_m3: f64 =
        elements.map(|ids| tet10::volume(&ids.map(|id| limb.mesh.nodes()[id.index()]))).sum();
    let change = report.signed_volume_m3 / (solid_m3 - printed.pockets_m3) - 1.0;
    assert!(change.abs() < 0.02, "{change}");
    // Ten pockets of 8.5 x 5.5 x 0.2 mm, and what rises beside them on a wall that is hollow there.
    let flat_m3 = 10.0 * 0.0085 * 0.0055 * 2e-4;
    assert!(
        (0.8..2.5).contains(&(printed.pockets_m3 / flat_m3)),
        "{}",
        printed.pockets_m3 / flat_m3
    );
    let whole = flat_boundary(&limb);
    for (site, gauge) in limb.sites.iter().zip(&limb.gauges) {
        let bottom = site.position - gauge.normal() * params.pocket_m;
        let left_m = way_through_m(&body, &bottom, &-gauge.normal());
        let wall_m = way_through_m(&whole, &site.position, &-gauge.normal());
        let change = (left_m + params.pocket_m) / wall_m - 1.0;
        assert!(change.abs() < 0.02, "wall {wall_m}, {left_m} below the pocket");
    }
}

/// The limb's boundary with flat faces.
fn flat_boundary(limb: &Limb) -> SurfaceMesh {
    let vertices = limb.mesh.nodes().to_vec();
    let corners = limb.boundary.faces.iter();
    let triangles = corners.map(|face| [0, 1, 2].map(|i| face.nodes[i].index() as u32));
    SurfaceMesh::new(vertices, triangles.collect()).unwrap()
}

#[test]
fn a_trimmed_limb_is_shorter_and_its_rims_are_nearer() {
    let (scene, limb) = limb();
    let whole = printed(&scene, &limb, &PrintParams::default());
    let trimmed =
        printed(&scene, &limb, &PrintParams { trim_m: Some(0.012), ..PrintParams::default() });
    let report = QualityReport::of(&read_back(&trimmed.body));
    assert!(report.is_closed() && report.n_bodies == 1, "{report}");
    assert!(trimmed.body.signed_volume_m3() < whole.body.signed_volume_m3());
    let lengths = [&whole, &trimmed].map(|limb| limb.body.bounding_box().size_m().y);
    assert!((lengths[0] - lengths[1] - 0.012).abs() < 1e-9, "{lengths:?}");
    let mut n_nearer = 0;
    for (before, after) in whole.places.iter().zip(&trimmed.places) {
        assert_eq!(before.rims_m[0], after.rims_m[0]);
        if let [Some(before_m), Some(after_m)] = [before.rims_m[1], after.rims_m[1]] {
            assert!(after_m <= before_m + 1e-6, "{before_m} {after_m}");
            n_nearer += usize::from(after_m < before_m - 1e-3);
        }
    }
    println!("{n_nearer} of {} gauges see the new rim", whole.places.len());
}

#[test]
fn what_can_t_be_printed_is_refused() {
    let (scene, limb) = limb();
    let refused = |params: &PrintParams| print_limb(&scene, &limb, params).unwrap_err().to_string();
    let message = refused(&PrintParams { pocket_m: 0.004, ..PrintParams::default() });
    assert!(message.contains("go through the wall"), "{message}");
    let message = refused(&PrintParams { trim_m: Some(1.0), ..PrintParams::default() });
    assert!(message.contains("a trim of 1 m"), "{message}");
}
