//! Shell models as a whole: gauges, tips, folds, closed bodies, refusals.

use hapdef_mesh::{FeNodeId, GaugeId, PointIndex};
use hapdef_sim::{
    ElasticModel, GaugeParams, GaugeSite, IsotropicMaterial, NodalLoad, ShellGaugeStrain,
    ShellKind, ShellMesh, ShellParams, SimError,
};
use nalgebra::{Point3, Vector3};

fn material() -> IsotropicMaterial {
    IsotropicMaterial::new(2.0e9, 0.0, 1000.0).expect("valid")
}

fn node(i: usize) -> FeNodeId {
    FeNodeId::from_index(i)
}

/// A strip of length 0.2 and width 0.02 in the x-y plane, `n` cells wide, bent by `map`.
fn strip(n: usize, thickness_m: f64, map: impl Fn(f64, f64) -> Point3<f64>) -> ShellMesh {
    let nu = 10 * n;
    let id = |i: usize, j: usize| node(j * (nu + 1) + i);
    let mut nodes = Vec::new();
    for j in 0..=n {
        for i in 0..=nu {
            nodes.push(map(0.2 * i as f64 / nu as f64, 0.02 * (j as f64 / n as f64 - 0.5)));
        }
    }
    let mut triangles = Vec::new();
    for j in 0..n {
        for i in 0..nu {
            let [a, b, c, d] = [id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    let thickness = vec![thickness_m; nodes.len()];
    ShellMesh::new(nodes, triangles, thickness).expect("a valid strip")
}

fn flat(x: f64, y: f64) -> Point3<f64> {
    Point3::new(x, y, 0.0)
}

fn where_(mesh: &ShellMesh, take: impl Fn(&Point3<f64>) -> bool) -> Vec<FeNodeId> {
    let nodes = mesh.nodes().iter().enumerate();
    nodes.filter(|(_, p)| take(p)).map(|(i, _)| node(i)).collect()
}

fn cantilever(mesh: &ShellMesh, kind: ShellKind) -> ElasticModel {
    let clamped = where_(mesh, |p| p.x < 1e-12);
    let params = ShellParams { kind, ..ShellParams::new(material(), clamped) };
    ElasticModel::build_shell(mesh, &params).expect("held")
}

fn tip_force(mesh: &ShellMesh, force_n: Vector3<f64>) -> NodalLoad {
    let end = where_(mesh, |p| p.x > 0.2 - 1e-9);
    let share = force_n / end.len() as f64;
    NodalLoad { forces_n: end.into_iter().map(|n| (n, share)).collect(), ..NodalLoad::default() }
}

fn site(x: f64) -> GaugeSite {
    GaugeSite {
        position: Point3::new(x, 0.0, 0.0),
        axis: Vector3::x(),
        length_m: 0.008,
        width_m: 0.005,
    }
}

/// ε = z M / (E I) with M = F (L − x), on both faces and at the middle.
#[test]
fn a_gauge_reads_beam_bending_at_its_distance_from_the_mid_surface() {
    let t = 0.002;
    let mesh = strip(6, t, flat);
    for kind in [ShellKind::Thin, ShellKind::Thick] {
        let model = cantilever(&mesh, kind);
        let load = tip_force(&mesh, Vector3::z());
        let (motion, _) = model.solve_motion(&load).expect("solved");
        let per_z = -(0.2 - 0.1) / (2.0e9 * 0.02 * t * t * t / 12.0);
        for z in [0.5 * t, -0.5 * t, 0.2 * t] {
            let params = GaugeParams::default();
            let gauge = ShellGaugeStrain::new(&mesh, kind, &material(), &site(0.1), z, &params)
                .expect("on the wall");
            let (found, expected) = (gauge.strain(&motion), z * per_z);
            assert!(
                (found - expected).abs() < 0.01 * expected.abs(),
                "{kind:?} at z = {z}: {found:e} against {expected:e}"
            );
        }
    }
}

/// The adjoint field times a load is the reading of its solution, also on a curved strip.
#[test]
fn adjoint_readings_are_direct_readings() {
    let mesh = strip(4, 0.001, |x, y| Point3::new(x, y, 0.03 * (10.0 * x).sin() + 2.0 * y * y));
    let model = cantilever(&mesh, ShellKind::default());
    let params = GaugeParams { max_distance_m: 0.1, ..GaugeParams::default() };
    let gauge = |x: f64| {
        ShellGaugeStrain::new(&mesh, ShellKind::default(), &material(), &site(x), 5e-4, &params)
            .expect("on the wall")
    };
    let gauges = [gauge(0.05), gauge(0.12)];
    let (response, info) = model.response(&gauges).expect("solved");
    assert!(info.worst_backward_error < 1e-13, "{info:?}");
    // Both loads press beyond both gauges, so that each gauge carries a moment to compare.
    for (x, direction) in [(0.18_f64, Vector3::z()), (0.15, Vector3::new(0.3, -0.5, 0.8))] {
        let centre = Point3::new(x, 0.004, 0.03 * (10.0 * x).sin());
        let (node, _) = PointIndex::new(mesh.nodes()).nearest(&centre).expect("on the skin");
        let load = NodalLoad::nodal(FeNodeId::from_index(node), direction);
        let (motion, _) = model.solve_motion(&load).expect("solved");
        for (i, gauge) in gauges.iter().enumerate() {
            let direct = gauge.strain(&motion);
            let adjoint = response.reading(GaugeId::from_index(i), &load);
            assert!(
                (direct - adjoint).abs() < 1e-9 * direct.abs(),
                "gauge {i}: {direct:e} direct, {adjoint:e} adjoint"
            );
        }
    }
}

/// A rigid motion strains no gauge.
#[test]
fn rigid_motions_read_nothing() {
    let mesh = strip(4, 0.001, |x, y| Point3::new(x, y, 2.0 * y * y + x * x));
    let params = GaugeParams { max_distance_m: 0.1, ..GaugeParams::default() };
    let gauge =
        ShellGaugeStrain::new(&mesh, ShellKind::Thick, &material(), &site(0.1), 5e-4, &params)
            .expect("on the wall");
    let (shift, turn) = (Vector3::new(1.0, -2.0, 3.0), Vector3::new(0.4, 0.5, -0.6));
    let motion = hapdef_sim::Motion {
        displacement: mesh.nodes().iter().map(|p| shift + turn.cross(&p.coords)).collect(),
        rotation: vec![turn; mesh.nodes().len()],
    };
    let size: f64 = gauge.functional().weights().iter().map(|w| w.per_metre.amax()).sum();
    assert!(gauge.strain(&motion).abs() < 1e-12 * size, "{:e}", gauge.strain(&motion));
}

/// A box girder (closed, with right-angled folds) bends as a beam of its second moment.
#[test]
fn folds_carry_a_box_girder() {
    let (side, length, t, n) = (0.02, 0.4, 0.0005, 4);
    let around = |k: usize| {
        let (face, s) = (k / n, (k % n) as f64 / n as f64 * side);
        let h = 0.5 * side;
        match face {
            0 => [-h + s, -h],
            1 => [h, -h + s],
            2 => [h - s, h],
            _ => [-h, h - s],
        }
    };
    let (nu, nv) = (60, 4 * n);
    let mut nodes = Vec::new();
    for i in 0..=nu {
        for k in 0..nv {
            let [y, z] = around(k);
            nodes.push(Point3::new(length * i as f64 / nu as f64, y, z));
        }
    }
    let id = |i: usize, k: usize| node(i * nv + k % nv);
    let mut triangles = Vec::new();
    for i in 0..nu {
        for k in 0..nv {
            let [a, b, c, d] = [id(i, k), id(i + 1, k), id(i + 1, k + 1), id(i, k + 1)];
            triangles.extend([[a, c, b], [a, d, c]]);
        }
    }
    let thickness = vec![t; nodes.len()];
    let mesh = ShellMesh::new(nodes, triangles, thickness).expect("valid");
    let square = mesh.directors().iter().flatten();
    assert!(square.clone().all(|d| d.iter().any(|c| (c.abs() - 1.0).abs() < 1e-12)));
    let clamped = where_(&mesh, |p| p.x < 1e-12);
    for kind in [ShellKind::Thin, ShellKind::Thick] {
        let params = ShellParams { kind, ..ShellParams::new(material(), clamped.clone()) };
        let model = ElasticModel::build_shell(&mesh, &params).expect("held");
        let webs: Vec<FeNodeId> = where_(&mesh, |p| p.x > length - 1e-9 && p.y.abs() > 0.0099);
        let share = Vector3::z() / webs.len() as f64;
        let load = NodalLoad {
            forces_n: webs.into_iter().map(|n| (n, share)).collect(),
            ..NodalLoad::default()
        };
        let (u, _) = model.solve(&load).expect("solved");
        let second_moment = 2.0 / 3.0 * side.powi(3) * t;
        // Timoshenko's beam: bending, and shear carried by the two webs
        let bending = length.powi(3) / (3.0 * 2.0e9 * second_moment);
        let shear = length * 1.2 / (1.0e9 * 2.0 * side * t);
        let (found, expected) = (load.work_j(&u).expect("fits"), bending + shear);
        assert!(
            (found - expected).abs() < 0.02 * expected,
            "{kind:?}: {found:e} against {expected:e}"
        );
    }
}

#[test]
fn free_and_broken_shells_are_refused() {
    let mesh = strip(1, 0.001, flat);
    let params = ShellParams::new(material(), Vec::new());
    let found = ElasticModel::build_shell(&mesh, &params).expect_err("free");
    assert!(
        matches!(&found, SimError::FreeRigidModes { bodies, .. } if bodies[0].free.len() == 6),
        "{found}"
    );
    let nodes = vec![Point3::origin(); 4];
    let found = ShellMesh::new(nodes.clone(), vec![[node(0), node(1), node(2)]], vec![1.0; 4]);
    assert!(matches!(found, Err(SimError::UnusedNode { node: 3 })), "{found:?}");
    let found =
        ShellMesh::new(nodes[..3].to_vec(), vec![[node(0), node(1), node(2)]], vec![1.0; 3]);
    assert!(matches!(found, Err(SimError::ShellElement { element: 0, .. })), "{found:?}");
    let found = ElasticModel::build_shell(
        &strip(1, -0.001, flat),
        &ShellParams::new(material(), vec![node(0)]),
    );
    assert!(matches!(found, Err(SimError::ShellElement { .. })), "{found:?}");
}

/// One clamped node holds a shell: it holds the rotation too.
#[test]
fn one_clamped_node_holds_a_shell_on_any_number_of_threads() {
    let mesh = strip(2, 0.001, flat);
    let load = tip_force(&mesh, Vector3::new(0.1, 0.2, 0.3));
    let solve = |n_threads| {
        let params = ShellParams { n_threads, ..ShellParams::new(material(), vec![node(0)]) };
        let model = ElasticModel::build_shell(&mesh, &params).expect("held");
        model.solve_motion(&load).expect("solved").0
    };
    assert_eq!(solve(1), solve(2));
}
