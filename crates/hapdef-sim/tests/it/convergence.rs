//! Manufactured and closed-form solutions, with the observed order.

use crate::common;

use std::collections::BTreeMap;
use std::f64::consts::PI;

use common::{
    E_PA, close, faces_where, mapped_box, material, material_of, nodes_where, params, straight_box,
};
use hapdef_mesh::{FaceTraction, FeNodeId, Tet10Mesh, tet10};
use hapdef_sim::{ElasticModel, ElasticParams, IsotropicMaterial, NodalLoad, strain};
use nalgebra::{Matrix3, Point3, Vector3};

fn stress(material: &IsotropicMaterial, eps: &Matrix3<f64>) -> Matrix3<f64> {
    Matrix3::identity() * (material.lame_lambda_pa() * eps.trace())
        + eps * (2.0 * material.shear_modulus_pa())
}

/// Gauss–Legendre under Duffy's map, exact to degree 5: an error integral needs more than the
/// stiffness rule, at whose points strains superconverge.
fn fine_rule() -> Vec<([f64; 3], f64)> {
    let g = [
        (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
        (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
        (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
        (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
    ];
    let mut rule = Vec::new();
    for (a, wa) in g {
        for (b, wb) in g {
            for (c, wc) in g {
                let (ra, rb) = (1.0 - a, 1.0 - b);
                rule.push(([a, b * ra, c * ra * rb], wa * wb * wc * ra * ra * rb));
            }
        }
    }
    rule
}

/// φ = sin πx sin πy sin πz with gradient and Hessian.
fn bump(p: &Point3<f64>) -> (f64, Vector3<f64>, Matrix3<f64>) {
    let s = p.coords.map(|c| (PI * c).sin());
    let c = p.coords.map(|c| (PI * c).cos() * PI);
    let phi = s.x * s.y * s.z;
    let grad = Vector3::new(c.x * s.y * s.z, s.x * c.y * s.z, s.x * s.y * c.z);
    let hessian =
        Matrix3::from_fn(|i, j| if i == j { -PI * PI * phi } else { c[i] * c[j] * s[3 - i - j] });
    (phi, grad, hessian)
}

/// Errors of the solution of u = φ c in L² and energy on a curved mesh of `n` cells a side.
fn manufactured_errors(n: usize) -> (f64, f64) {
    let c = Vector3::new(1.0, 0.5, -0.7);
    let mesh = mapped_box([n; 3], [1.0; 3], |p| {
        let (phi, _, _) = bump(&p);
        p + Vector3::new(0.06, -0.05, 0.04) * phi
    });
    let (lambda, mu) = (material().lame_lambda_pa(), material().shear_modulus_pa());
    let load = NodalLoad::body_force(&mesh, |p| {
        let (phi, _, hessian) = bump(p);
        c * (3.0 * PI * PI * mu * phi) - hessian * c * (lambda + mu)
    });
    let wall = |p: &Point3<f64>| p.iter().any(|c| c.abs() < 1e-12 || (c - 1.0).abs() < 1e-12);
    let model = ElasticModel::build(&mesh, &params(nodes_where(&mesh, wall))).expect("clamped");
    let (u, _) = model.solve(&load).expect("solved");
    let (mut l2, mut energy) = (0.0, 0.0);
    for (element, ids) in mesh.elements().iter().enumerate() {
        let nodes = mesh.element_positions(element);
        let own: [Vector3<f64>; 10] = std::array::from_fn(|i| u[ids[i].index()]);
        for (r, weight) in fine_rule() {
            let volume = weight * tet10::jacobian(&nodes, r).determinant();
            let (phi, grad, _) = bump(&tet10::position(&nodes, r));
            let found: Vector3<f64> = own.iter().zip(tet10::shape(r)).map(|(u, n)| u * n).sum();
            l2 += (found - c * phi).norm_squared() * volume;
            let grad = c * grad.transpose();
            let eps = strain(&nodes, &own, r) - (grad + grad.transpose()) * 0.5;
            energy += stress(&material(), &eps).component_mul(&eps).sum() * volume;
        }
    }
    (l2.sqrt(), energy.sqrt())
}

#[test]
fn manufactured_solution_converges_with_order_three_and_two() {
    let [coarse, fine] = [4, 8].map(manufactured_errors);
    let (l2, energy) = ((coarse.0 / fine.0).log2(), (coarse.1 / fine.1).log2());
    println!("observed order {l2:.3} in L², {energy:.3} in energy; errors {coarse:?} {fine:?}");
    assert!((2.7..3.4).contains(&l2), "observed order {l2} in L²");
    assert!((1.8..2.3).contains(&energy), "observed order {energy} in energy");
}

/// A hollow sphere, inner radius 1, outer 2, of `n` cells across: concentric cubes blown up.
///
/// Eight mirrored octants of Kuhn cells: no tetrahedron crosses the planes |x| = |y|, where the map
/// has a kink.
fn hollow_sphere(n: usize) -> Tet10Mesh {
    let octant = straight_box([2 * n; 3], [2.0; 3]);
    let grid = |p: Point3<f64>| p.coords.map(|c| (c * (2 * n) as f64).round() as i64);
    let (mut nodes, mut elements, mut ids) = (Vec::new(), Vec::new(), BTreeMap::new());
    for mirror in 0..8 {
        let sign = Vector3::from_fn(|c, _| if mirror >> c & 1 == 1 { -1 } else { 1 });
        for element in octant.elements() {
            let grid = element.map(|node| grid(octant.position(node)));
            if grid.iter().any(|g| g.amax() < 2 * n as i64) {
                continue;
            }
            let mut own = grid.map(|g| {
                let g = g.component_mul(&sign);
                *ids.entry([g.x, g.y, g.z]).or_insert_with(|| {
                    let p = g.map(|c| c as f64 / (2 * n) as f64);
                    nodes.push(Point3::from(p * (p.amax() / p.norm())));
                    FeNodeId::from_index(nodes.len() - 1)
                })
            });
            if sign.product() < 0 {
                for (a, b) in [(1, 2), (4, 6), (8, 9)] {
                    own.swap(a, b);
                }
            }
            elements.push(own);
        }
    }
    Tet10Mesh::new(nodes, elements).expect("a valid sphere")
}

/// Root mean square nodal error relative to the largest displacement of a sphere on a rigid core under
/// outer pressure. Lamé: u = A r + B / r², σ_rr = 3κA − 4μB / r³ (Timoshenko and Goodier, Theory of
/// Elasticity, 3rd ed., article 136), with u(a) = 0 and σ_rr(b) = −p.
fn sphere_error(n: usize, nu: f64) -> f64 {
    let (a, b, p) = (1.0_f64, 2.0_f64, 1e6);
    let mesh = hollow_sphere(n);
    let material = material_of(nu);
    let mu = material.shear_modulus_pa();
    let kappa_3 = E_PA / (1.0 - 2.0 * nu);
    let slope = -p / (kappa_3 + 4.0 * mu * (a / b).powi(3));
    let exact = |r: f64| slope * (r - a.powi(3) / (r * r));
    let outer = faces_where(&mesh, |p| (p.coords.norm() - b).abs() < 1e-9);
    let clamped = nodes_where(&mesh, |p| (p.coords.norm() - a).abs() < 1e-9);
    let params = ElasticParams { material, ..params(clamped) };
    let model = ElasticModel::build(&mesh, &params).expect("clamped inside");
    let load = NodalLoad::pressure(&mesh, &outer, p).expect("valid faces");
    let (u, _) = model.solve(&load).expect("solved");
    let miss = |(p, u): (&Point3<f64>, &Vector3<f64>)| {
        (u - p.coords / p.coords.norm() * exact(p.coords.norm())).norm_squared()
    };
    let squares: f64 = mesh.nodes().iter().zip(&u).map(miss).sum();
    (squares / mesh.nodes().len() as f64).sqrt() / exact(b).abs()
}

#[test]
fn sphere_under_pressure_converges_to_lame() {
    for (nu, within) in [(0.3, 1e-3), (0.4999, 2.5e-2)] {
        let (coarse, fine) = (sphere_error(2, nu), sphere_error(3, nu));
        let order = (coarse / fine).ln() / 1.5_f64.ln();
        println!("Lamé sphere, ν {nu}: {coarse:e}, {fine:e}, observed order {order:.2}");
        assert!(fine < within, "ν {nu}: error {fine:e}");
        assert!(order > 2.5, "ν {nu}: observed order {order}");
    }
}

#[test]
fn bending_matches_a_timoshenko_beam() {
    let tip = |nu: f64, n: usize| {
        let mesh = straight_box([5 * n, n, n], [0.1, 0.01, 0.01]);
        let clamped = nodes_where(&mesh, |p| p.x == 0.0);
        let params = ElasticParams { material: material_of(nu), ..params(clamped) };
        let model = ElasticModel::build(&mesh, &params).expect("clamped");
        let end = faces_where(&mesh, |p| (p.x - 0.1).abs() < 1e-12);
        let pull = |f: &hapdef_mesh::Tri6Face| FaceTraction {
            nodes: f.nodes,
            traction_pa: Vector3::new(0.0, 0.0, 1e4),
        };
        let tractions: Vec<FaceTraction> = end.iter().map(pull).collect();
        let load = NodalLoad::traction(&mesh, &tractions).expect("valid faces");
        close(load.total_n().z, 1.0, 1e-12);
        let (u, _) = model.solve(&load).expect("solved");
        load.work_j(&u).expect("own load")
    };
    // Timoshenko beam: P L³ / 3 E I and, with κ = 5/6, P L / κ G A
    let exact = |nu: f64| {
        let (l, h) = (0.1_f64, 0.01_f64);
        l.powi(3) / (3.0 * E_PA * h.powi(4) / 12.0)
            + l / (5.0 / 6.0 * E_PA / (2.0 + 2.0 * nu) * h * h)
    };
    for (nu, n, within) in [(0.0, 2, 2e-3), (0.3, 4, 1.5e-2)] {
        println!("ν {nu}, {n} cells: {:.4} of the beam's deflection", tip(nu, n) / exact(nu));
        close(tip(nu, n), exact(nu), within);
    }
}
