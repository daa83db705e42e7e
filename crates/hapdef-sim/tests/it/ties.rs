//! Symmetry planes, Winkler foundations, rigid bodies and several materials, against closed forms.

use crate::common;

use common::{
    E_PA, close, faces_where, mapped_box, material_of, nodes_where, params, straight_box,
};
use hapdef_mesh::{FeNodeId, Tet10Mesh};
use hapdef_sim::{
    ElasticModel, ElasticParams, Foundation, FoundationFaces, HeldMotion, Hold, IsotropicMaterial,
    MaterialRegion, NodalLoad, RigidBody, SimError, Supports, SymmetryPlane,
};
use nalgebra::{Point3, Rotation3, Vector3};

const SIZE_M: [f64; 3] = [0.04, 0.02, 0.03];

fn without_poisson() -> IsotropicMaterial {
    material_of(0.0)
}

fn push_top(mesh: &Tet10Mesh, pressure_pa: f64) -> NodalLoad {
    let top = faces_where(mesh, |p| (p.z - SIZE_M[2]).abs() < 1e-9);
    NodalLoad::pressure(mesh, &top, pressure_pa).unwrap()
}

fn foundation_below(mesh: &Tet10Mesh, normal_n_m3: f64, tangential_n_m3: f64) -> Foundation {
    Foundation {
        faces: FoundationFaces::Solid(faces_where(mesh, |p| p.z == 0.0)),
        normal_n_m3,
        tangential_n_m3,
    }
}

#[test]
fn a_block_on_a_foundation_sinks_by_pressure_over_stiffness() {
    let mesh = straight_box([3, 2, 2], SIZE_M);
    let (pressure_pa, foundation_n_m3) = (4.0e4, 2.5e8);
    let params = ElasticParams {
        supports: Supports {
            foundations: vec![foundation_below(&mesh, foundation_n_m3, 1.0e6)],
            ..Supports::default()
        },
        ..ElasticParams::new(without_poisson(), vec![])
    };
    let model = ElasticModel::build(&mesh, &params).unwrap();
    let (u, _) = model.solve(&push_top(&mesh, pressure_pa)).unwrap();
    for (u, x) in u.iter().zip(mesh.nodes()) {
        let exact = -pressure_pa / foundation_n_m3 - pressure_pa * x.z / E_PA;
        close(u.z, exact, 1e-10);
        assert!(u.x.abs() + u.y.abs() < 1e-12 * exact.abs().max(1.0));
    }
}

#[test]
fn a_foundation_without_shear_leaves_the_block_sliding() {
    let mesh = straight_box([2, 1, 1], SIZE_M);
    let params = ElasticParams {
        supports: Supports {
            foundations: vec![foundation_below(&mesh, 1e8, 0.0)],
            ..Supports::default()
        },
        ..params(vec![])
    };
    match ElasticModel::build(&mesh, &params).unwrap_err() {
        SimError::FreeRigidModes { bodies, .. } => assert_eq!(bodies[0].free.len(), 3),
        other => panic!("{other}"),
    }
}

#[test]
fn bars_in_series_add_their_compliances() {
    let mesh = straight_box([4, 2, 2], SIZE_M);
    let stiff = IsotropicMaterial::new(1e3 * E_PA, 0.0, 1000.0).unwrap();
    let middle = |element: usize| {
        let corners = &mesh.elements()[element][..4];
        corners.iter().map(|n| mesh.position(*n).x).sum::<f64>() / 4.0
    };
    let half_m = SIZE_M[0] / 2.0;
    let elements = (0..mesh.elements().len()).filter(|&e| middle(e) > half_m);
    let params = ElasticParams {
        regions: vec![MaterialRegion { elements: elements.collect(), material: stiff }],
        ..ElasticParams::new(without_poisson(), nodes_where(&mesh, |p| p.x == 0.0))
    };
    let model = ElasticModel::build(&mesh, &params).unwrap();
    let end = faces_where(&mesh, |p| (p.x - SIZE_M[0]).abs() < 1e-9);
    let stress_pa = 1e6;
    let pull = NodalLoad::pressure(&mesh, &end, -stress_pa).unwrap();
    let (u, _) = model.solve(&pull).unwrap();
    for (u, x) in u.iter().zip(mesh.nodes()) {
        let exact = stress_pa * (x.x.min(half_m) / E_PA + (x.x - half_m).max(0.0) / (1e3 * E_PA));
        assert!((u.x - exact).abs() < 1e-9 * stress_pa * half_m / E_PA);
    }
}

/// Half of a cantilever, cut along its length by a plane at an angle, against the whole.
#[test]
fn half_a_limb_behind_a_skew_mirror_moves_as_the_whole() {
    let turn = Rotation3::from_axis_angle(&Vector3::x_axis(), 0.6);
    let (length_m, width_m) = (0.05, 0.01);
    let whole = mapped_box([5, 4, 2], [length_m, 2.0 * width_m, 0.008], |p| {
        turn * Point3::new(p.x, p.y - width_m, p.z)
    });
    let half = mapped_box([5, 2, 2], [length_m, width_m, 0.008], |p| turn * p);
    let straight = |p: &Point3<f64>| turn.inverse() * p;
    let clamped = |mesh: &Tet10Mesh| nodes_where(mesh, |p| p.x.abs() < 1e-12);
    let mirror = SymmetryPlane {
        nodes: nodes_where(&half, |p| straight(p).y.abs() < 1e-12),
        normal: turn * Vector3::y() * 3.0,
    };
    let half_model = ElasticModel::build(
        &half,
        &ElasticParams {
            supports: Supports { symmetry: vec![mirror], ..Supports::default() },
            ..params(clamped(&half))
        },
    )
    .unwrap();
    let whole_model = ElasticModel::build(&whole, &params(clamped(&whole))).unwrap();
    let press = |mesh: &Tet10Mesh| {
        let top = faces_where(mesh, |p| (straight(p).z - 0.008).abs() < 1e-9);
        NodalLoad::pressure(mesh, &top, 1e5).unwrap()
    };
    let (u_half, _) = half_model.solve(&press(&half)).unwrap();
    let (u_whole, _) = whole_model.solve(&press(&whole)).unwrap();
    let tip = |mesh: &Tet10Mesh, u: &[Vector3<f64>]| {
        let at = turn * Point3::new(length_m, 0.0, 0.008);
        let node = nodes_where(mesh, |p| (p - at).norm() < 1e-9)[0];
        u[node.index()]
    };
    // the two meshes cut their cells differently, so they agree to discretisation, not rounding
    let (half_tip, whole_tip) = (tip(&half, &u_half), tip(&whole, &u_whole));
    assert!((half_tip - whole_tip).norm() < 5e-3 * whole_tip.norm(), "{half_tip} {whole_tip}");
    let across = turn * Vector3::y();
    assert!(half_tip.dot(&across).abs() < 1e-12 * half_tip.norm());
    assert!(whole_tip.dot(&across).abs() < 1e-2 * whole_tip.norm());
}

#[test]
fn three_mirrors_hold_a_block_and_leave_uniform_strain() {
    let mesh = straight_box([2, 2, 2], SIZE_M);
    let nu = 0.3;
    let plane = |axis: usize| SymmetryPlane {
        nodes: nodes_where(&mesh, |p| p[axis] == 0.0),
        normal: Vector3::ith(axis, 1.0),
    };
    let params = ElasticParams {
        supports: Supports { symmetry: (0..3).map(plane).collect(), ..Supports::default() },
        ..ElasticParams::new(material_of(nu), vec![])
    };
    let model = ElasticModel::build(&mesh, &params).unwrap();
    let pressure_pa = 1e6;
    let (u, _) = model.solve(&push_top(&mesh, pressure_pa)).unwrap();
    let strain = pressure_pa / E_PA;
    for (u, x) in u.iter().zip(mesh.nodes()) {
        let exact = Vector3::new(nu * x.x, nu * x.y, -x.z) * strain;
        assert!((u - exact).norm() < 1e-10 * strain * SIZE_M[0]);
    }
    let energy = model.strain_energy_j(&u).unwrap();
    let exact = 0.5 * pressure_pa * strain * SIZE_M.iter().product::<f64>();
    close(energy, exact, 1e-10);
}

fn rigid_nodes(mesh: &Tet10Mesh) -> Vec<FeNodeId> {
    let inside = |v: f64, size: f64| v > 0.49 * size;
    nodes_where(mesh, |p| inside(p.x, SIZE_M[0]) && inside(p.z, SIZE_M[2]))
}

fn with_rigid_body(mesh: &Tet10Mesh) -> ElasticParams {
    ElasticParams {
        supports: Supports {
            rigid_bodies: vec![RigidBody { nodes: rigid_nodes(mesh) }],
            ..Supports::default()
        },
        ..params(nodes_where(mesh, |p| p.x == 0.0))
    }
}

#[test]
fn an_insert_keeps_its_shape_and_is_the_limit_of_a_stiff_material() {
    let mesh = straight_box([4, 2, 4], SIZE_M);
    let nodes = rigid_nodes(&mesh);
    let model = ElasticModel::build(&mesh, &with_rigid_body(&mesh)).unwrap();
    let corner = nodes_where(&mesh, |p| *p == Point3::from(SIZE_M))[0];
    let load = NodalLoad::nodal(corner, Vector3::new(3.0, -5.0, -20.0));
    let (rigid, info) = model.solve(&load).unwrap();
    assert!(info.worst_backward_error < 1e-13);
    // Lengths between nodes of the body change only to second order in u.
    let (a, size) = (nodes[0].index(), rigid[corner.index()].norm());
    for node in &nodes {
        let arm = mesh.position(*node) - mesh.nodes()[a];
        let stretch = (rigid[node.index()] - rigid[a]).dot(&arm);
        assert!(stretch.abs() < 1e-11 * size * SIZE_M[0], "{stretch:e}");
    }
    let inside = |e: &usize| mesh.elements()[*e].iter().all(|n| nodes.contains(n));
    let difference = |factor: f64| {
        let stiff = ElasticParams {
            regions: vec![MaterialRegion {
                elements: (0..mesh.elements().len()).filter(inside).collect(),
                material: IsotropicMaterial::new(factor * E_PA, 0.3, 1000.0).unwrap(),
            }],
            ..params(nodes_where(&mesh, |p| p.x == 0.0))
        };
        let stiff = ElasticModel::build(&mesh, &stiff).unwrap();
        let (u, _) = stiff.solve(&load).unwrap();
        (u[corner.index()] - rigid[corner.index()]).norm() / size
    };
    let (at_1e3, at_1e5) = (difference(1e3), difference(1e5));
    assert!(at_1e5 < 1e-4, "{at_1e5:e}");
    let ratio = at_1e3 / at_1e5;
    assert!((80.0..120.0).contains(&ratio), "not first order in 1/E: {ratio}");
}

#[test]
fn reciprocity_holds_through_rigid_bodies_mirrors_and_foundations() {
    let mesh = straight_box([4, 2, 4], SIZE_M);
    let mut params = with_rigid_body(&mesh);
    params.clamped.clear();
    params.supports.foundations = vec![foundation_below(&mesh, 1e9, 1e8)];
    params.supports.symmetry = vec![SymmetryPlane {
        nodes: nodes_where(&mesh, |p| p.y == 0.0 && p.x < 0.4 * SIZE_M[0]),
        normal: Vector3::new(0.0, 2.0, 1.0),
    }];
    let one = ElasticModel::build(&mesh, &params).unwrap();
    params.n_threads = 2;
    let two = ElasticModel::build(&mesh, &params).unwrap();
    let corner = nodes_where(&mesh, |p| *p == Point3::from(SIZE_M))[0];
    let low = nodes_where(&mesh, |p| p.x == 0.0 && p.y == 0.0 && p.z > 0.9 * SIZE_M[2])[0];
    let a = NodalLoad::nodal(corner, Vector3::new(1.0, 2.0, -3.0));
    let b = NodalLoad::nodal(low, Vector3::new(-2.0, 1.0, 0.5));
    let (u_a, _) = one.solve(&a).unwrap();
    let (u_b, _) = one.solve(&b).unwrap();
    close(a.work_j(&u_b).unwrap(), b.work_j(&u_a).unwrap(), 1e-10);
    assert_eq!(two.solve(&a).unwrap().0, u_a, "threads change the result");
}

#[test]
fn single_holds_add_up_to_a_statically_determinate_support() {
    let mesh = straight_box([2, 2, 2], SIZE_M);
    let node = |x: f64, y: f64, z: f64| {
        let at = Point3::new(x * SIZE_M[0], y * SIZE_M[1], z * SIZE_M[2]);
        nodes_where(&mesh, |p| (p - at).norm() < 1e-12)
    };
    let hold = |nodes, direction| Hold { nodes, motion: HeldMotion::Translation, direction };
    let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
    let corner = node(0.0, 0.0, 0.0);
    let mut holds = vec![
        hold(corner.clone(), x),
        hold(corner.clone(), y),
        hold(corner, z),
        hold(node(1.0, 0.0, 0.0), y),
        hold(node(1.0, 0.0, 0.0), z),
        hold(node(0.0, 1.0, 0.0), z),
    ];
    let with = |holds: &[Hold]| ElasticParams {
        supports: Supports { holds: holds.to_vec(), ..Supports::default() },
        ..ElasticParams::new(without_poisson(), vec![])
    };
    let model = ElasticModel::build(&mesh, &with(&holds)).unwrap();
    let ends = |at: f64| faces_where(&mesh, |p| (p.x - at * SIZE_M[0]).abs() < 1e-9);
    let pull = |at| NodalLoad::pressure(&mesh, &ends(at), -1e6).unwrap();
    let (u, _) = model.solve(&pull(0.0).plus(&pull(1.0))).unwrap();
    for (u, p) in u.iter().zip(mesh.nodes()) {
        let exact = Vector3::x() * (1e6 / E_PA * p.x);
        assert!((u - exact).norm() < 1e-10 * 1e6 / E_PA * SIZE_M[0]);
    }
    holds.pop();
    match ElasticModel::build(&mesh, &with(&holds)).unwrap_err() {
        SimError::FreeRigidModes { bodies, .. } => assert_eq!(bodies[0].free.len(), 1),
        other => panic!("{other}"),
    }
    holds[0].motion = HeldMotion::Rotation;
    let error = ElasticModel::build(&mesh, &with(&holds)).unwrap_err();
    assert!(matches!(error, SimError::NoRotations { .. }), "{error}");
}

#[test]
fn unusable_ties_are_refused_with_their_numbers() {
    let mesh = straight_box([4, 2, 4], SIZE_M);
    let refused = |change: &dyn Fn(&mut ElasticParams)| {
        let mut params = with_rigid_body(&mesh);
        change(&mut params);
        ElasticModel::build(&mesh, &params).unwrap_err()
    };
    let first = rigid_nodes(&mesh)[0];
    let held = refused(&|p| p.clamped.push(first));
    assert!(
        matches!(held, SimError::RigidBodyHeld { rigid_body: 0, node } if node == first.index()),
        "{held}"
    );
    let shared = refused(&|p| {
        let again = p.supports.rigid_bodies[0].clone();
        p.supports.rigid_bodies.push(again);
    });
    assert!(
        matches!(shared, SimError::RigidBodiesShareNode { rigid_bodies: [0, 1], .. }),
        "{shared}"
    );
    let line = nodes_where(&mesh, |p| p.x == SIZE_M[0] && p.y == 0.0);
    let small = refused(&|p| p.supports.rigid_bodies[0].nodes.clone_from(&line));
    assert!(matches!(small, SimError::RigidBodyTooSmall { n_nodes, .. } if n_nodes == line.len()));
    let region = refused(&|p| {
        p.regions = vec![MaterialRegion { elements: vec![9_999], material: p.material }];
    });
    assert!(matches!(region, SimError::ElementOutOfRange { element: 9_999, .. }), "{region}");
    let foundation =
        refused(&|p| p.supports.foundations = vec![foundation_below(&mesh, -1.0, 0.0)]);
    assert!(matches!(foundation, SimError::Parameter { value: -1.0, .. }), "{foundation}");
    let moment = ElasticModel::build(&mesh, &with_rigid_body(&mesh))
        .unwrap()
        .solve(&NodalLoad::nodal_moment(first, Vector3::x()))
        .unwrap_err();
    assert!(matches!(moment, SimError::NoRotations { .. }), "{moment}");
}
