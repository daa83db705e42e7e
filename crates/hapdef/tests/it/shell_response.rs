//! What a shell of a limb's skin tells its gauges, against the solid.

use std::f64::consts::TAU;

use hapdef::Limb;
use hapdef::scene::Axis;
use hapdef::touch::{UncertainParams, UncertainResponse};
use hapdef_inverse::ResponseMap;
use hapdef_mesh::{FeNodeId, OuterSkinParams, kuhn_tube, outer_skin};
use hapdef_sim::{GaugeParams, GaugeSite, GaugeStrain, IsotropicMaterial};
use nalgebra::{Point3, Vector3};

const WALL_M: f64 = 1e-3;
const INNER_M: f64 = 0.024;
const LENGTH_M: f64 = 0.12;

/// A gauge on the inner wall, along the tube.
fn site(turn_rad: f64, along_m: f64) -> GaugeSite {
    GaugeSite {
        position: Point3::new(INNER_M * turn_rad.cos(), INNER_M * turn_rad.sin(), along_m),
        axis: Vector3::z(),
        length_m: 8e-3,
        width_m: 5e-3,
    }
}

/// A tube 50 mm across without ribs, held at its lower rim, with three gauges.
fn tube() -> Limb {
    let mesh = kuhn_tube([40, 36, 1], |at| {
        let (sin, cos) = (TAU * at.x).sin_cos();
        let radius_m = INNER_M + WALL_M * at.z;
        Point3::new(radius_m * cos, radius_m * sin, LENGTH_M * at.y)
    })
    .unwrap();
    let boundary = mesh.boundary();
    let skin = outer_skin(&mesh, &boundary, &OuterSkinParams::default()).unwrap();
    let ids = (0..mesh.nodes().len()).map(FeNodeId::from_index);
    let clamped = ids.filter(|id| mesh.position(*id).z < 1e-9).collect();
    let sites = vec![site(0.3, 0.03), site(2.4, 0.06), site(4.4, 0.08)];
    let gauge_params = GaugeParams::default();
    let gauge = |site| GaugeStrain::with_params(&mesh, &boundary.faces, site, &gauge_params);
    Limb {
        gauges: sites.iter().map(|site| gauge(site).unwrap()).collect(),
        directions: skin.normals.iter().map(|normal| -normal).collect(),
        material: IsotropicMaterial::new(1.7e9, 0.394, 1000.0).unwrap(),
        patches: Vec::new(),
        wall: None,
        shell: None,
        deck_hash: String::new(),
        deck_notes: Vec::new(),
        mesh,
        boundary,
        skin,
        clamped,
        flange: Vec::new(),
        axis: Axis { point_m: [0.0; 3], direction: [0.0, 0.0, 1.0] },
        max_wall_m: 0.003,
        sites,
        gauge_params,
    }
}

/// |shell − solid| over |solid| of the readings at each node that is clear of gauges and mount, the
/// median.
fn median_difference(limb: &Limb, shell: &ResponseMap, solid: &ResponseMap) -> f64 {
    let (shell, solid) = (shell.nodal(), solid.nodal());
    let is_clear = |point: &Point3<f64>| {
        let near = |site: &GaugeSite| (site.position - point).norm() < 0.01;
        point.z > 0.02 && !limb.sites.iter().any(near)
    };
    let n = limb.sites.len();
    let norm = |rows: &[Vector3<f64>], node: usize, minus: Option<&[Vector3<f64>]>| -> f64 {
        let each = (n * node..n * (node + 1)).map(|i| {
            let difference = rows[i] - minus.map_or_else(Vector3::zeros, |other| other[i]);
            difference.dot(&limb.directions[node]).powi(2)
        });
        each.sum::<f64>().sqrt()
    };
    let points = limb.surface_points();
    let clear = (0..points.len()).filter(|i| is_clear(&points[*i]));
    let mut off: Vec<f64> =
        clear.map(|i| norm(&shell, i, Some(&solid)) / norm(&solid, i, None)).collect();
    off.sort_by(f64::total_cmp);
    off[off.len() / 2]
}

/// Where a limb is nothing but a thin wall, the shell of its skin reads what the solid reads, and
/// gauges that are turned or moved change it alike: a shift along the gauge compares strains of single
/// elements half a gauge apart, which both meshes tell coarsely.
#[test]
fn a_plain_wall_reads_as_its_solid() {
    let limb = tube();
    let params =
        UncertainParams { tip_radius_m: 2e-3, refinements: 0, n_stiffness: 0, n_threads: 2 };
    let solid = UncertainResponse::solve(&limb, &limb.sites, &limb.gauges, &params).unwrap();
    let shell =
        UncertainResponse::solve_shell(&limb, &limb.sites, &limb.gauges, 3e-3, &params).unwrap();
    let off = median_difference(&limb, &shell.map, &solid.map);
    assert!(off < 0.1, "{off}");
    let modes = shell.gauge_modes.iter().zip(&solid.gauge_modes);
    let off: Vec<f64> =
        modes.map(|(shell, solid)| median_difference(&limb, shell, solid)).collect();
    let [along, across, turn] = [off[0], off[1], off[2]];
    assert!(along < 0.5 && across < 0.2 && turn < 0.1, "{off:?}");
    assert!(shell.stiffness_modes.is_empty());
}

/// A gauge that hangs in the air beside the shell's wall, as one on a rib does, reads nothing; the
/// others read as before.
#[test]
fn a_gauge_off_the_wall_reads_nothing() {
    let mut limb = tube();
    let params =
        UncertainParams { tip_radius_m: 2e-3, refinements: 0, n_stiffness: 0, n_threads: 2 };
    let all = UncertainResponse::solve_shell(&limb, &limb.sites, &limb.gauges, 3e-3, &params);
    let all = all.unwrap().map.nodal();
    limb.sites[1].position.coords *= 0.8;
    limb.sites[1].position.z = 0.06;
    let without = UncertainResponse::solve_shell(&limb, &limb.sites, &limb.gauges, 3e-3, &params);
    let without = without.unwrap().map.nodal();
    for (i, (all, without)) in all.iter().zip(&without).enumerate() {
        match i % 3 {
            1 => assert_eq!(*without, Vector3::zeros()),
            _ => assert!((all - without).norm() <= 1e-9 * (1.0 + all.norm())),
        }
    }
}
