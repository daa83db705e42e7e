//! What must hold of an element's stiffness to round-off: six zero-energy modes, and invariance under
//! the order of nodes and under rotation.

use hapdef_sim::{IsotropicMaterial, SimError, shell_stiffness, stiffness};
use nalgebra::{DMatrix, DVector, Matrix3, Point3, Rotation3, Vector3};

use super::prelude::*;
use crate::meshes::straight;

/// Rows of solids.
pub(super) fn solids() -> Vec<Case> {
    ROWS.map(case).into()
}

/// Rows of shells.
pub(super) fn shells() -> Vec<Case> {
    ROWS.into_iter().flat_map(|row| case(row).both()).collect()
}

/// Name, title, quantity, source, and the error.
type Row = (
    &'static str,
    &'static str,
    &'static str,
    &'static str,
    fn(&Sample) -> Result<f64, VerifyError>,
);

const ROWS: [Row; 3] = [
    (
        "modes",
        "Six zero-energy modes of an element",
        "largest |K r| / (|K| |r|)",
        "rigid motions carry no force",
        zero_modes,
    ),
    (
        "order",
        "Invariance under the order of nodes",
        "largest |K′ − P K Pᵀ| / |K|",
        "the stiffness does not depend on how nodes are counted",
        node_order,
    ),
    (
        "rotation",
        "Invariance under rotation",
        "largest |K′ − R K Rᵀ| / |K|",
        "the stiffness turns with the element",
        rotation,
    ),
];

fn case((name, title, quantity, source, error): Row) -> Case {
    Case {
        name,
        title,
        quantity,
        source,
        target: Target::within(1e-10),
        solve: Solve::by(move |element, _| {
            let samples = samples(element);
            let mesh = match element {
                Element::Tet10 | Element::C3d10 => "a straight and a curved element",
                _ => "an element with tilted directors",
            };
            let n_nodes = samples[0].nodes.len();
            Ok(Measured {
                value: worst(&samples, error)?,
                mesh: mesh.to_owned(),
                n_nodes,
                n_equations: samples[0].motions * n_nodes,
                h: 1.0,
            })
        }),
        ..Case::default()
    }
}

/// The largest error, or one that is not a number.
pub(super) fn worst<T>(
    all: impl IntoIterator<Item = T>,
    mut error: impl FnMut(T) -> Result<f64, VerifyError>,
) -> Result<f64, VerifyError> {
    all.into_iter().try_fold(0.0, |worst: f64, one| {
        let error = error(one)?;
        // max would drop what is not a number
        Ok(if error > worst || error.is_nan() { error } else { worst })
    })
}

/// An element whose stiffness is looked at.
struct Sample {
    nodes: Vec<Point3<f64>>,
    /// Degrees of freedom of a node: displacements, and rotations of shells.
    motions: usize,
    /// Other ways to count its nodes.
    orders: &'static [&'static [usize]],
    /// Its stiffness with the nodes in an order, turned.
    stiffness: Stiffness,
}

type Stiffness = Box<dyn Fn(&[usize], &Rotation3<f64>) -> Result<DMatrix<f64>, VerifyError>>;

fn samples(element: Element) -> Vec<Sample> {
    match element {
        Element::Tet10 | Element::C3d10 => tetrahedra().map(solid).into(),
        // thin and thicker than the element's size over five
        _ => [0.02, 0.001].map(|thickness| shell(element, thickness)).into(),
    }
}

/// A straight-sided and a curved one.
fn tetrahedra() -> [[Point3<f64>; 10]; 2] {
    let straight = straight([[0.0; 3], [1.0, 0.1, 0.0], [0.2, 1.3, 0.1], [0.1, 0.2, 0.9]]);
    let bent = straight.map(|p: Point3<f64>| {
        p + Vector3::new(0.1 * p.y * p.y, 0.08 * p.x * p.z, -0.12 * p.x * p.y)
    });
    [straight, bent]
}

fn solid(nodes: [Point3<f64>; 10]) -> Sample {
    Sample {
        nodes: nodes.to_vec(),
        motions: 3,
        // corners 0 1 2 3 become 1 2 0 3, and mid-side nodes go with them
        orders: &[&[1, 2, 0, 3, 5, 6, 4, 8, 9, 7]],
        stiffness: Box::new(move |order, turn| {
            let moved = std::array::from_fn(|i| turn * nodes[order[i]]);
            let k =
                stiffness(&moved, &IsotropicMaterial::new(2e9, 0.3, 1.0)?).map_err(|point| {
                    let found = format!("{} at {:?}", point.det_j_m3, point.parent);
                    VerifyError::setup("the element of an invariance test", "det J > 0", found)
                })?;
            Ok(DMatrix::from_fn(30, 30, |i, j| k[i][j]))
        }),
    }
}

fn shell(element: Element, thickness: f64) -> Sample {
    let corners = [[0.0, 0.0, 0.0], [0.11, 0.01, 0.02], [0.03, 0.09, -0.01]].map(Point3::from);
    let tilts = [[0.1, -0.05, 1.0], [-0.02, 0.08, 1.0], [0.05, 0.12, 1.0]].map(Vector3::from);
    Sample {
        nodes: corners.to_vec(),
        motions: 6,
        orders: &[&[1, 2, 0], &[2, 0, 1]],
        stiffness: Box::new(move |order, turn| {
            let order: [usize; 3] = std::array::from_fn(|i| order[i]);
            let directors = order.map(|i| turn * (tilts[i] / tilts[i].norm()));
            let k = shell_stiffness(
                element.shell_kind(),
                &order.map(|i| turn * corners[i]),
                Some(&directors),
                &order.map(|i| thickness * (1.0 + 0.1 * i as f64)),
                &IsotropicMaterial::new(1e6, 0.25, 1.0)?,
            );
            let k = k.map_err(|problem| SimError::ShellElement { element: 0, problem })?;
            Ok(DMatrix::from_fn(18, 18, |i, j| k[i][j]))
        }),
    }
}

impl Sample {
    /// The stiffness as it is.
    fn own(&self) -> Result<DMatrix<f64>, VerifyError> {
        let order: Vec<usize> = (0..self.nodes.len()).collect();
        (self.stiffness)(&order, &Rotation3::identity())
    }
}

fn zero_modes(sample: &Sample) -> Result<f64, VerifyError> {
    let (k, m) = (sample.own()?, sample.motions);
    worst(0..6, |mode| {
        let axis = Vector3::ith(mode % 3, 1.0);
        let r = DVector::from_fn(k.nrows(), |i, _| match (mode < 3, i % m) {
            (true, c @ 0..3) => axis[c],
            (true, _) => 0.0,
            (false, c @ 0..3) => axis.cross(&sample.nodes[i / m].coords)[c],
            (false, c) => axis[c - 3],
        });
        Ok((&k * &r).amax() / (k.amax() * r.amax()))
    })
}

fn node_order(sample: &Sample) -> Result<f64, VerifyError> {
    let (k, m) = (sample.own()?, sample.motions);
    worst(sample.orders, |order| {
        let other = (sample.stiffness)(order, &Rotation3::identity())?;
        let old = |i: usize| m * order[i / m] + i % m;
        let moved = DMatrix::from_fn(k.nrows(), k.ncols(), |i, j| k[(old(i), old(j))]);
        Ok((other - moved).amax() / k.amax())
    })
}

fn rotation(sample: &Sample) -> Result<f64, VerifyError> {
    let turn = Rotation3::from_euler_angles(0.4, -1.1, 2.3);
    let order: Vec<usize> = (0..sample.nodes.len()).collect();
    let (k, turned) = (sample.own()?, (sample.stiffness)(&order, &turn)?);
    let blocks = Matrix3::from(turn);
    let spin = DMatrix::from_fn(k.nrows(), k.ncols(), |i, j| match i / 3 == j / 3 {
        true => blocks[(i % 3, j % 3)],
        false => 0.0,
    });
    Ok((turned - &spin * &k * spin.transpose()).amax() / k.amax())
}
