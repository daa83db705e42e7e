//! Patch tests and invariances: what must hold to round-off on any mesh.

use hapdef_mesh::{TET10_EDGES, Tet10Mesh};
use hapdef_sim::{IsotropicMaterial, stiffness, stress};
use nalgebra::{Matrix3, Point3, Rotation3, Vector3};

use super::problem::{Problem, same};
use crate::meshes::{Blocks, faces_where};
use crate::{Case, Measured, Reference, Target, VerifyError};

const E: f64 = 2e9;
const NU: f64 = 0.3;
const SOURCE: &str = "Irons and Razzaque, Experience with the patch test, 1972: a complete polynomial \
    of the element's degree is met on any mesh";

/// Rows of the table.
pub(super) fn cases() -> Vec<Case> {
    vec![
        case(
            "solid.patch.linear",
            "Patch test, six constant strains",
            "largest |u − exact| / largest |exact|",
            SOURCE,
            || {
                let worst = (0..6).map(constant_strain);
                worst.reduce(worse).unwrap_or_else(|| Err(VerifyError::not_run("no strain")))
            },
        ),
        case(
            "solid.patch.bending",
            "Patch test, pure bending",
            "largest |u − exact| / largest |exact|",
            SOURCE,
            bending,
        ),
        case(
            "solid.modes",
            "Six zero-energy modes of an element",
            "largest |K r| / (|K| |r|)",
            "rigid motions carry no force",
            zero_modes,
        ),
        case(
            "solid.order",
            "Invariance under the order of nodes",
            "largest |K′ − P K Pᵀ| / |K|",
            "the stiffness does not depend on how nodes are counted",
            node_order,
        ),
        case(
            "solid.rotation",
            "Invariance under rotation",
            "largest |K′ − R K Rᵀ| / |K|",
            "the stiffness turns with the element",
            rotation,
        ),
    ]
}

fn case(
    id: &'static str,
    title: &'static str,
    quantity: &'static str,
    source: &'static str,
    run: impl Fn() -> Result<Measured, VerifyError> + 'static,
) -> Case {
    Case {
        id,
        title,
        element: "TET10",
        quantity,
        unit: "1",
        reference: Reference::Zero,
        source,
        target: Target::within(1e-10),
        n_levels: 1,
        known_miss: None,
        run: Box::new(move |_| run()),
    }
}

fn worse(
    a: Result<Measured, VerifyError>,
    b: Result<Measured, VerifyError>,
) -> Result<Measured, VerifyError> {
    let (a, b) = (a?, b?);
    Ok(if a.value >= b.value { a } else { b })
}

/// A unit cube whose inner corners are moved; edges stay straight.
fn distorted_cube() -> Result<Tet10Mesh, VerifyError> {
    let straight = Blocks::new(1e-9).block([3; 3], |p| p).finish()?;
    let wobble = |p: &Point3<f64>| {
        let inside = p.iter().map(|c| c * (1.0 - c)).product::<f64>() * 64.0;
        let by =
            Vector3::new((17.0 * p.y).sin(), (13.0 * p.z + 1.0).sin(), (11.0 * p.x + 2.0).cos());
        p + by * (0.08 * inside)
    };
    let mut nodes: Vec<_> = straight.nodes().to_vec();
    for element in straight.elements() {
        for &corner in &element[..4] {
            nodes[corner.index()] = wobble(&straight.position(corner));
        }
    }
    for element in straight.elements() {
        for (i, [a, b]) in TET10_EDGES.into_iter().enumerate() {
            let (a, b) = (nodes[element[a].index()], nodes[element[b].index()]);
            nodes[element[4 + i].index()] = nalgebra::center(&a, &b);
        }
    }
    Ok(Tet10Mesh::new(nodes, straight.elements().to_vec())?)
}

/// The distorted cube held so that it can't move as a body: the origin, and beside it v and w at
/// (1, 0, 0), w at (0, 1, 0).
fn held_cube() -> Result<Problem, VerifyError> {
    let at = |x: [f64; 3]| move |p: &Point3<f64>| (p - Point3::from(x)).norm() < 1e-9;
    Ok(Problem::new(distorted_cube()?, E, NU)?
        .clamp(at([0.0; 3]))
        .hold(1, at([1.0, 0.0, 0.0]))
        .hold(2, at([1.0, 0.0, 0.0]))
        .hold(2, at([0.0, 1.0, 0.0])))
}

/// The error of the exact field `u` with the gradient `gradient`, driven by its own tractions.
fn field_error(
    u: impl Fn(&Point3<f64>) -> Vector3<f64>,
    gradient: impl Fn(&Point3<f64>) -> Matrix3<f64>,
) -> Result<Measured, VerifyError> {
    let problem = held_cube()?;
    let skin = faces_where(&problem.mesh, |p| p.iter().any(|&c| same(c, 0.0) || same(c, 1.0)));
    let load = problem.traction(&skin, |p, n| {
        let g = gradient(p);
        stress(&problem.material, &((g + g.transpose()) * 0.5)) * n
    });
    let solution = problem.solve(&load)?;
    let (mut worst, mut largest) = (0.0_f64, 0.0_f64);
    for (p, found) in problem.mesh.nodes().iter().zip(&solution.u) {
        worst = worst.max((found - u(p)).norm());
        largest = largest.max(u(p).norm());
    }
    Ok(solution.measured(worst / largest, "distorted 3 × 3 × 3 cells".to_owned(), 1.0))
}

/// Strain number `which` of εxx, εyy, εzz, γxy, γxz, γyz as an upper triangular gradient, which
/// the holds of [`held_cube`] leave free.
fn constant_strain(which: usize) -> Result<Measured, VerifyError> {
    let [row, column] = [[0, 0], [1, 1], [2, 2], [0, 1], [0, 2], [1, 2]][which];
    let mut gradient = Matrix3::zeros();
    gradient[(row, column)] = 1e-3;
    field_error(|p| gradient * p.coords, |_| gradient)
}

/// σxx = E c y: u = c xy, v = −c/2 (x² + ν(y² − z²)), w = −c ν yz, turned back by what the holds
/// need: v and w vanish at (1, 0, 0) and w at (0, 1, 0) with the rotation c/2 about z taken off
/// (Timoshenko and Goodier, Theory of Elasticity, 3rd ed., article 102).
fn bending() -> Result<Measured, VerifyError> {
    let c = 1e-3;
    let u = move |p: &Point3<f64>| {
        let (x, y, z) = (p.x, p.y, p.z);
        let v = -0.5 * c * (x * x + NU * (y * y - z * z)) + 0.5 * c * x;
        Vector3::new(c * x * y - 0.5 * c * y, v, -c * NU * y * z)
    };
    let gradient = move |p: &Point3<f64>| {
        let (x, y, z) = (p.x, p.y, p.z);
        Matrix3::new(y, x - 0.5, 0.0, 0.5 - x, -NU * y, NU * z, 0.0, -NU * z, -NU * y) * c
    };
    field_error(u, gradient)
}

/// A straight-sided and a curved tetrahedron.
fn elements() -> [[Point3<f64>; 10]; 2] {
    let corners = [[0.0; 3], [1.0, 0.1, 0.0], [0.2, 1.3, 0.1], [0.1, 0.2, 0.9]].map(Point3::from);
    let straight = std::array::from_fn(|i| match i {
        0..4 => corners[i],
        _ => nalgebra::center(&corners[TET10_EDGES[i - 4][0]], &corners[TET10_EDGES[i - 4][1]]),
    });
    let bent = straight.map(|p: Point3<f64>| {
        p + Vector3::new(0.1 * p.y * p.y, 0.08 * p.x * p.z, -0.12 * p.x * p.y)
    });
    [straight, bent]
}

type Flat = Vec<f64>;

/// K of an element, row after row, `[30 × 30]`.
fn flat(nodes: &[Point3<f64>; 10]) -> Result<Flat, VerifyError> {
    let material = IsotropicMaterial::new(E, NU, 1.0)?;
    let k = stiffness(nodes, &material).map_err(|point| VerifyError::Setup {
        what: "the element of an invariance test",
        expected: "det J > 0".to_owned(),
        found: format!("{} at {:?}", point.det_j_m3, point.parent),
    })?;
    Ok(k.iter().flatten().copied().collect())
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |m, v| m.max(v.abs()))
}

/// The worst of `error` over both elements.
fn over_elements(
    error: impl Fn(&[Point3<f64>; 10], &[f64]) -> Result<f64, VerifyError>,
) -> Result<Measured, VerifyError> {
    let mut worst = 0.0_f64;
    for nodes in elements() {
        let k = flat(&nodes)?;
        worst = worst.max(error(&nodes, &k)? / largest(&k));
    }
    Ok(Measured {
        value: worst,
        mesh: "a straight and a curved element".to_owned(),
        n_nodes: 10,
        n_equations: 30,
        h: 1.0,
    })
}

fn zero_modes() -> Result<Measured, VerifyError> {
    over_elements(|nodes, k| {
        let mut worst = 0.0_f64;
        for mode in 0..6 {
            let axis = Vector3::from_fn(|i, _| f64::from(u8::from(i == mode % 3)));
            let motion = |p: &Point3<f64>| {
                if mode < 3 { axis } else { axis.cross(&p.coords) }
            };
            let r: Vec<f64> = nodes.iter().flat_map(|p| <[f64; 3]>::from(motion(p))).collect();
            let product =
                k.chunks_exact(30).map(|row| row.iter().zip(&r).map(|(k, r)| k * r).sum());
            worst = worst.max(largest(&product.collect::<Flat>()) / largest(&r));
        }
        Ok(worst)
    })
}

fn node_order() -> Result<Measured, VerifyError> {
    // corners 0 1 2 3 become 1 2 0 3, and mid-side nodes go with them
    const ORDER: [usize; 10] = [1, 2, 0, 3, 5, 6, 4, 8, 9, 7];
    over_elements(|nodes, k| {
        let turned = flat(&ORDER.map(|i| nodes[i]))?;
        let old = |i: usize| 3 * ORDER[i / 3] + i % 3;
        let differences = (0..900).map(|i| turned[i] - k[30 * old(i / 30) + old(i % 30)]);
        Ok(largest(&differences.collect::<Flat>()))
    })
}

fn rotation() -> Result<Measured, VerifyError> {
    let r = Rotation3::from_euler_angles(0.4, -1.1, 2.3);
    over_elements(|nodes, k| {
        let turned = flat(&nodes.map(|p| r * p))?;
        let block = |k: &[f64], i: usize, j: usize| {
            Matrix3::from_fn(|a, b| k[30 * (3 * i + a) + 3 * j + b])
        };
        let pairs = (0..100).map(|n| (n / 10, n % 10));
        let difference = |(i, j)| (block(&turned, i, j) - r * block(k, i, j) * r.inverse()).amax();
        Ok(pairs.map(difference).fold(0.0, f64::max))
    })
}
