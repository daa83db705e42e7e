//! Limbs as bodies to print: written, read back, measured.

use std::path::Path;

use hapdef::new_limb::{NewLimb, NewLimbParams};
use hapdef::scene::{Scene, read_scene};
use hapdef::{Limb, PrintParams, PrintedLimb, Progress, print_limb};
use hapdef_mesh::{
    GltfParams, LengthUnit, QualityReport, SurfaceMesh, read_surface, tet10, write_stl,
};
use nalgebra::{Matrix3, Point3, Vector3};

use crate::support::shared;

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

/// Volume of a closed body between two heights along `axis`, m³: areas of its sections, each a sum over the
/// edges in which a plane cuts the triangles, by the midpoint rule.
fn volume_between_m3(body: &SurfaceMesh, axis: &Vector3<f64>, heights_m: [f64; 2]) -> f64 {
    const N_SECTIONS: usize = 500;
    let step_m = (heights_m[1] - heights_m[0]) / N_SECTIONS as f64;
    let section = |i: usize| {
        let height_m = heights_m[0] + (i as f64 + 0.5) * step_m;
        let doubled_m2 = |t: usize| {
            let corners = body.corners(t);
            let over_m = corners.map(|corner| corner.coords.dot(axis) - height_m);
            let mut ends = [None; 2];
            for (i, j) in [(0, 1), (1, 2), (2, 0)] {
                if (over_m[i] > 0.0) != (over_m[j] > 0.0) {
                    let part = over_m[i] / (over_m[i] - over_m[j]);
                    let met = corners[i].coords.lerp(&corners[j].coords, part);
                    ends[usize::from(over_m[i] > 0.0)] = Some(met);
                }
            }
            let [Some(from), Some(to)] = ends else { return 0.0 };
            from.cross(&to).dot(axis)
        };
        0.5 * (0..body.triangles().len()).map(doubled_m2).sum::<f64>().abs()
    };
    (0..N_SECTIONS).map(section).sum::<f64>() * step_m
}

/// The printed limb read back is one closed body; its volume, pockets filled, and its wall at each gauge are the
/// limb's within 2 %.
#[track_caller]
fn check_printed(scene: &Scene, limb: &Limb) -> PrintedLimb {
    let params = PrintParams::default();
    let printed = printed(scene, limb, &params);
    let body = read_back(&printed.body);
    let report = QualityReport::of(&body);
    assert!(report.is_closed() && report.n_bodies == 1, "{report}");
    let axis = Vector3::from(limb.axis.direction).try_normalize(0.0).unwrap();
    let heights = body.vertices().iter().map(|vertex| vertex.coords.dot(&axis));
    let heights_m = heights.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], height| {
        [low.min(height), high.max(height)]
    });
    let whole = flat_boundary(limb);
    let limb_m3 = volume_between_m3(&whole, &axis, heights_m);
    let change = (report.signed_volume_m3 + printed.pockets_m3) / limb_m3 - 1.0;
    assert!(change.abs() < 0.02, "volume: {change}");
    // and what rises beside a pocket on a wall that is hollow there
    let [longer_m, deep_m] = [params.clearance_m, params.pocket_m];
    let flat = limb.sites.iter().map(|site| (site.length_m + longer_m) * (site.width_m + longer_m));
    let pockets = printed.pockets_m3 / (flat.sum::<f64>() * deep_m);
    assert!((0.8..2.5).contains(&pockets), "pockets: {pockets}");
    for (site, gauge) in limb.sites.iter().zip(&limb.gauges) {
        let bottom = site.position - gauge.normal() * deep_m;
        let left_m = way_through_m(&body, &bottom, &-gauge.normal());
        let wall_m = way_through_m(&whole, &site.position, &-gauge.normal());
        let change = (left_m + deep_m) / wall_m - 1.0;
        assert!(change.abs() < 0.02, "wall {wall_m}, {left_m} below the pocket");
    }
    printed
}

#[test]
fn the_printed_limb_is_one_closed_body_with_the_wall_of_the_limb() {
    let (scene, limb) = limb();
    let printed = check_printed(&scene, &limb);
    assert_eq!(printed.trim_m, 0.0);
    let elements = limb.mesh.elements().iter();
    let solid_m3: f64 =
        elements.map(|ids| tet10::volume(&ids.map(|id| limb.mesh.nodes()[id.index()]))).sum();
    let change = (printed.body.signed_volume_m3() + printed.pockets_m3) / solid_m3 - 1.0;
    assert!(change.abs() < 0.02, "{change}");
}

/// A limb made of a surface, with three gauges.
#[track_caller]
fn check_new_limb(surface: &Path, edge_m: Option<f64>) -> PrintedLimb {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path().join("limb");
    let params = NewLimbParams {
        edge_m,
        n_gauges: Some(3),
        takes_likeliest: true,
        ..NewLimbParams::default()
    };
    let new = NewLimb::guess(surface, &params).unwrap();
    let files = new.write(&folder, false, 2, Progress::silent()).unwrap();
    let scene = read_scene(&files.scene).unwrap();
    let limb = Limb::load(&scene, &folder).unwrap();
    check_printed(&scene, &limb)
}

#[test]
fn an_open_skin_with_its_wall_is_printed_as_it_is() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/shin");
    let printed = check_new_limb(&folder.join("shin_skin.glb"), None);
    assert_eq!(printed.trim_m, 0.0);
}

/// It is closed all round, so its mount is cut open.
#[test]
fn another_makers_limb_is_printed_as_it_is() {
    let Some(surface) = shared("inputs/limbs/kinova_forearm.glb") else { return };
    let printed = check_new_limb(&surface, Some(8e-3));
    assert!(printed.trim_m > 0.0);
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
