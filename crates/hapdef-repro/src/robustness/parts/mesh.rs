//! A curved block of ten-node tetrahedra, stretched, moved, and broken.

use hapdef_mesh::{FeNodeId, Tet10Mesh, kuhn_block, tet10};
use nalgebra::{Point3, Vector3};

use crate::error::ReproError;
use crate::robustness::table::Trials;

const ROUND_OFF: f64 = 1e-12;

pub(super) fn add(rows: &mut Trials<u64>) {
    for factor in [1e-6_f64, 1e-3, 1e3, 1e6] {
        let holds = ("its volume grows with the cube, relative error", ROUND_OFF);
        rows.accurate(format!("a limb of {factor:e} times its size"), holds, move |_| {
            volume_error(|p| p * factor, factor.powi(3))
        });
    }
    for stretch in [1e2, 1e4, 1e6] {
        let holds = ("its volume grows with the length, relative error", ROUND_OFF);
        rows.accurate(format!("elements {stretch:e} times longer than wide"), holds, move |_| {
            volume_error(|p| Point3::new(p.x * stretch, p.y, p.z), stretch)
        });
    }
    rows.accurate(
        "a limb 1 km from the origin",
        ("its volume stays, relative error", 1e-4),
        |_| volume_error(|p| p + Vector3::repeat(1e3), 1.0),
    );
    rows.accurate("refined twice", ("its volume stays, relative error", ROUND_OFF), |_| {
        let mesh = block(|p| p)?;
        Ok(relative(volume(&mesh.refine().refine()), volume(&mesh)))
    });
    rows.all_refused([
        ("a coordinate is NaN", "NaN", || with_nodes(|nodes| nodes[7].x = f64::NAN)),
        ("a coordinate is infinite", "inf", || with_nodes(|nodes| nodes[7].y = f64::INFINITY)),
        ("turned inside out", "volume", || {
            with_nodes(|nodes| nodes.iter_mut().for_each(|p| p.z = -p.z))
        }),
        ("flat", "volume", || with_nodes(|nodes| nodes.iter_mut().for_each(|p| p.z = 0.0))),
        ("an element names a node that is not there", "node", || {
            let mesh = block(|p| p)?;
            let mut elements = mesh.elements().to_vec();
            elements[2][9] = FeNodeId::from_index(mesh.nodes().len());
            Ok(volume(&Tet10Mesh::new(mesh.nodes().to_vec(), elements)?))
        }),
    ]);
}

fn with_nodes(change: impl Fn(&mut [Point3<f64>])) -> Result<f64, ReproError> {
    let mesh = block(|p| p)?;
    let mut nodes = mesh.nodes().to_vec();
    change(&mut nodes);
    Ok(volume(&Tet10Mesh::new(nodes, mesh.elements().to_vec())?))
}

fn volume_error(map: impl Fn(Point3<f64>) -> Point3<f64>, grows: f64) -> Result<f64, ReproError> {
    let unit = volume(&block(|p| p)?);
    Ok(relative(volume(&block(map)?), grows * unit))
}

fn relative(value: f64, expected: f64) -> f64 {
    (value / expected - 1.0).abs()
}

fn volume(mesh: &Tet10Mesh) -> f64 {
    let n = mesh.elements().len();
    (0..n).map(|e| tet10::volume(&mesh.element_positions(e))).sum()
}

/// A cube of 0.1 m with straight edges, mapped.
fn block(map: impl Fn(Point3<f64>) -> Point3<f64>) -> Result<Tet10Mesh, ReproError> {
    Ok(kuhn_block([1; 3], |p| map(p * 0.1))?)
}
