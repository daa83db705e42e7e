//! The limb of `fixtures/shin`: its numbers, its quality, and that the files are what the
//! generator makes.

use std::path::Path;

use hapdef_mesh::{
    DeckMaterial, GltfParams, MeshError, QualityReport, Shin, ShinHole, ShinOutline, ShinParams,
    TET10_FACES, Tet10Mesh, clear_nodes, farthest_nodes, gauge_patch, read_deck, read_gltf,
    refine_unfolded, shin, tet10, wall,
};
use nalgebra::Point3;

fn limb() -> Shin {
    shin(&ShinParams::default()).unwrap()
}

fn fixture(name: &str) -> std::path::PathBuf {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/shin")).join(name)
}

#[test]
fn the_limb_has_the_paper_s_size() {
    let limb = limb();
    let mesh = &limb.deck.mesh;
    assert_eq!((mesh.nodes().len(), mesh.elements().len()), (20_865, 10_266));
    assert_eq!((limb.skin.nodes.len(), limb.skin.faces.len()), (3_217, 1_490));
    assert_eq!(limb.deck.node_sets["SKIN"], limb.skin.nodes);
    assert_eq!(limb.deck.node_sets["MOUNT"], limb.deck.fixed_nodes);
    assert_eq!(limb.deck.fixed_nodes.len(), 252);
    for node in &limb.deck.fixed_nodes {
        assert_eq!(mesh.position(*node).y, 0.040);
    }
    let extent = |axis: usize| {
        let range = mesh.nodes().iter().map(|p| p[axis]);
        (range.clone().fold(f64::INFINITY, f64::min), range.fold(f64::NEG_INFINITY, f64::max))
    };
    assert_eq!(extent(1), (0.040, 0.162));
    for axis in [0, 2] {
        let across_m = extent(axis).1 - extent(axis).0;
        assert!((0.069..0.073).contains(&across_m), "{across_m}");
    }
    let mass_kg = volume_m3(mesh) * limb.deck.material.unwrap().density_kg_m3.unwrap();
    assert!((mass_kg - 0.035210).abs() < 1e-6, "{mass_kg}");
}

fn volume_m3(mesh: &Tet10Mesh) -> f64 {
    let volumes = (0..mesh.elements().len()).map(|e| tet10::volume(&mesh.element_positions(e)));
    volumes.sum()
}

/// The rig's mesh: mass, skin and holes of the same limb, but less than a quarter of its nodes, most of
/// them where ribs and rings cross.
#[test]
fn meshed_anew_it_is_the_same_limb() {
    let (limb, anew) = (limb(), shin(&ShinParams::meshed_anew()).unwrap());
    let [one, other] = [&limb, &anew].map(|limb| &limb.deck.mesh);
    let ratio = volume_m3(other) / volume_m3(one);
    println!("{} elements, volume {ratio} of the other's", other.elements().len());
    assert!((ratio - 1.0).abs() < 2e-3, "{ratio}");
    let ratio = anew.skin.area_m2(other) / limb.skin.area_m2(one);
    assert!((ratio - 1.0).abs() < 5e-3, "{ratio}");
    outside_is_one_perforated_piece(&anew, 20);
    let scaled = (0..other.elements().len()).map(|e| scaled_jacobian(other, e));
    assert!(scaled.fold(f64::INFINITY, f64::min) > 0.15);
    assert_eq!(refine_unfolded(other).unwrap().n_straightened, 0);
    let places = |mesh: &Tet10Mesh| -> std::collections::BTreeSet<[u64; 3]> {
        let bits = |x: &Point3<f64>| [x.x, x.y, x.z].map(f64::to_bits);
        mesh.nodes().iter().map(bits).collect()
    };
    let common = places(one).intersection(&places(other)).count();
    assert!(common * 4 < one.nodes().len(), "{common} nodes in common");
    assert_eq!(read_deck(&fixture("shin_rig.inp.gz")).unwrap(), anew.deck);
}

#[test]
fn the_outside_is_one_perforated_piece() {
    outside_is_one_perforated_piece(&limb(), 0);
}

fn outside_is_one_perforated_piece(limb: &Shin, most_slivers: usize) {
    let report = QualityReport::of(&limb.skin.surface(&limb.deck.mesh).unwrap());
    assert_eq!(
        (report.n_bodies, report.n_non_manifold_edges, report.n_misoriented_edges),
        (1, 0, 0)
    );
    assert_eq!(report.n_degenerate_triangles, 0);
    let slivers = report.n_sliver_triangles;
    assert!(slivers <= most_slivers, "{slivers}");
    // a sphere without 19 holes and two ends
    let euler = report.n_vertices as i64 - n_edges(limb) + report.n_triangles as i64;
    assert_eq!(euler, 2 - 21);
}

fn n_edges(limb: &Shin) -> i64 {
    let surface = limb.skin.surface(&limb.deck.mesh).unwrap();
    let mut edges: Vec<_> = surface
        .triangles()
        .iter()
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect();
    edges.sort_unstable();
    edges.dedup();
    edges.len() as i64
}

#[test]
fn elements_are_usable_also_when_refined() {
    let limb = limb();
    let mesh = &limb.deck.mesh;
    let scaled = (0..mesh.elements().len()).map(|e| scaled_jacobian(mesh, e));
    let smallest = scaled.fold(f64::INFINITY, f64::min);
    assert!(smallest > 0.24, "smallest det J over that of the straight element: {smallest}");
    let mut dihedral: Vec<f64> =
        (0..mesh.elements().len()).map(|e| smallest_dihedral_deg(mesh, e)).collect();
    dihedral.sort_by(f64::total_cmp);
    println!("dihedral angle: smallest {}°, median {}°", dihedral[0], dihedral[dihedral.len() / 2]);
    assert!(dihedral[0] > 5.0 && dihedral[dihedral.len() / 2] > 13.0);

    let fine = mesh.refine();
    for element in 0..fine.elements().len() {
        let jacobian = tet10::min_gauss_jacobian(&fine.element_positions(element));
        assert!(jacobian > 0.0, "refined element {element}: {jacobian:e}");
    }
    Tet10Mesh::new(fine.nodes().to_vec(), fine.elements().to_vec()).unwrap();
}

fn scaled_jacobian(mesh: &Tet10Mesh, element: usize) -> f64 {
    let p = mesh.element_positions(element);
    tet10::min_gauss_jacobian(&p) / (p[1] - p[0]).cross(&(p[2] - p[0])).dot(&(p[3] - p[0]))
}

fn smallest_dihedral_deg(mesh: &Tet10Mesh, element: usize) -> f64 {
    let p = mesh.element_positions(element);
    let normals = TET10_FACES
        .map(|f| (p[f[1]] - p[f[0]]).cross(&(p[f[2]] - p[f[0]])).try_normalize(0.0).unwrap());
    let pairs = (0..4).flat_map(|a| (0..a).map(move |b| (a, b)));
    pairs.map(|(a, b)| 180.0 - normals[a].angle(&normals[b]).to_degrees()).fold(180.0, f64::min)
}

#[test]
fn the_wall_is_one_millimetre_and_takes_ten_gauges() {
    let limb = limb();
    let mesh = &limb.deck.mesh;
    let inside = wall(mesh, &mesh.boundary(), &limb.skin, 1.5e-3).unwrap();
    let quartiles = [0.25, 0.5, 0.75].map(|q| 1e3 * inside.thickness_quantile_m(q).unwrap());
    println!("thickness quartiles {quartiles:?} mm, {} inner faces", inside.inner_faces.len());
    assert!((quartiles[1] - 1.03).abs() < 0.01 && quartiles[2] > 2.0, "{quartiles:?}");

    let clear = clear_nodes(mesh, &inside.inner_faces, 5e-3);
    let chosen = farthest_nodes(mesh, &clear, 10);
    assert_eq!(chosen.len(), 10);
    for (i, node) in chosen.iter().enumerate() {
        let centre = mesh.position(*node);
        let patch = gauge_patch(mesh, &inside.inner_faces, &centre, 24, 1e-4).unwrap();
        let on_whole_boundary =
            gauge_patch(mesh, &mesh.boundary().faces, &centre, 24, 1e-4).unwrap();
        assert_eq!(patch.nodes, on_whole_boundary.nodes);
        let inward = -Point3::new(centre.x, 0.0, centre.z).coords;
        assert!(patch.normal.dot(&inward) > 0.0);
        for other in &chosen[..i] {
            assert!((mesh.position(*other) - centre).norm() > 0.025);
        }
    }
}

#[test]
fn the_fixture_is_what_the_generator_makes() {
    let limb = limb();
    assert_eq!(read_deck(&fixture("shin.inp.gz")).unwrap(), limb.deck);
    let glb = read_gltf(&fixture("shin_skin.glb"), &GltfParams::default()).unwrap();
    let surface = limb.skin.surface(&limb.deck.mesh).unwrap();
    assert_eq!(glb.mesh.triangles(), surface.triangles());
    for (stored, made) in glb.mesh.vertices().iter().zip(surface.vertices()) {
        // 32-bit floats hold 0.16 m to 8 nm
        assert!((stored - made).amax() < 8e-9, "{stored} {made}");
    }
}

#[test]
fn measures_that_make_no_limb_are_refused() {
    let default = ShinParams::default();
    let hole = ShinHole { sector: 7, band: 0, centre: (0.5, 0.5), half_axes: (0.2, 0.2) };
    let bad = [
        ShinParams { wall_m: 0.0, ..default.clone() },
        ShinParams { rib_width_m: f64::NAN, ..default.clone() },
        ShinParams { rib_depth_m: 0.02, ..default.clone() },
        ShinParams { n_sectors: 2, ..default.clone() },
        ShinParams { n_rib_layers: 0, ..default.clone() },
        ShinParams { unevenness: 0.9, ..default.clone() },
        ShinParams { rib_width_m: 0.03, ..default.clone() },
        ShinParams { holes: vec![hole], ..default.clone() },
        ShinParams {
            outline: ShinOutline { end_radius_m: f64::NAN, ..ShinOutline::default() },
            ..default
        },
    ];
    for params in bad {
        let found = shin(&params);
        assert!(matches!(found, Err(MeshError::ShinParams { .. })), "{params:?}");
    }
}

#[test]
fn measures_can_be_changed() {
    let material = DeckMaterial { youngs_modulus_pa: 3e9, ..ShinParams::default().material };
    let params = ShinParams {
        n_sectors: 5,
        n_bands: 2,
        panel_cells: (6, 8),
        wall_m: 2e-3,
        n_rib_layers: 1,
        material,
        holes: vec![ShinHole { sector: 4, band: 1, centre: (0.5, 0.5), half_axes: (0.25, 0.25) }],
        ..ShinParams::default()
    };
    let limb = shin(&params).unwrap();
    assert_eq!(limb.deck.material, Some(material));
    let mesh = &limb.deck.mesh;
    let inside = wall(mesh, &mesh.boundary(), &limb.skin, 2.5e-3).unwrap();
    let median_m = inside.thickness_quantile_m(0.5).unwrap();
    assert!((median_m - 2e-3).abs() < 1e-4, "{median_m}");
}
