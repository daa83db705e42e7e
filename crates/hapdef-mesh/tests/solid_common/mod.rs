//! Solid meshes for tests.
#![allow(dead_code, reason = "each test file uses a part")]
#![allow(clippy::unwrap_used, reason = "test support")]

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use hapdef_mesh::{FeNodeId, TET10_EDGES, Tet10Mesh};
use nalgebra::{Matrix3, Point3};

/// `n` cells a side in the unit cube, six tetrahedra each, every node moved by `map`.
pub fn mapped_box(n: [usize; 3], map: impl Fn([f64; 3]) -> Point3<f64>) -> Tet10Mesh {
    grid(n, false, map)
}

/// A tube about the y axis: `n` cells around, along and through the wall.
pub fn tube(n: [usize; 3], radii_m: [f64; 2], height_m: f64) -> Tet10Mesh {
    grid(n, true, |[around, along, depth]| {
        let radius_m = radii_m[1] + (radii_m[0] - radii_m[1]) * depth;
        let (sin, cos) = (TAU * around).sin_cos();
        Point3::new(radius_m * cos, height_m * along, radius_m * sin)
    })
}

/// Kuhn's six tetrahedra per cell on doubled grid coordinates, so that mid-side nodes have whole
/// coordinates too.
fn grid(n: [usize; 3], closed: bool, map: impl Fn([f64; 3]) -> Point3<f64>) -> Tet10Mesh {
    let mut tets = Vec::new();
    for i in 0..n[0] {
        for j in 0..n[1] {
            for k in 0..n[2] {
                for order in [
                    [0, 1, 2],
                    [0, 2, 1],
                    [1, 0, 2],
                    [1, 2, 0],
                    [2, 0, 1],
                    [2, 1, 0],
                ] {
                    let mut corner = [2 * i, 2 * j, 2 * k];
                    let mut tet = vec![corner];
                    for axis in order {
                        corner[axis] += 2;
                        tet.push(corner);
                    }
                    tets.push([tet[0], tet[1], tet[2], tet[3]]);
                }
            }
        }
    }
    let place = |c: [usize; 3]| map([0, 1, 2].map(|a| c[a] as f64 / (2 * n[a]) as f64));
    let key = |c: [usize; 3]| {
        if closed {
            [c[0] % (2 * n[0]), c[1], c[2]]
        } else {
            c
        }
    };
    let mut ids: BTreeMap<[usize; 3], usize> = BTreeMap::new();
    let mut nodes = Vec::new();
    let mut elements = Vec::new();
    for mut tet in tets {
        let [a, b, c, d] = tet.map(place);
        if Matrix3::from_columns(&[b - a, c - a, d - a]).determinant() < 0.0 {
            tet.swap(1, 2);
        }
        let ten: [[usize; 3]; 10] = std::array::from_fn(|i| match i {
            0..4 => tet[i],
            _ => {
                let [a, b] = TET10_EDGES[i - 4].map(|l| tet[l]);
                std::array::from_fn(|x| (a[x] + b[x]) / 2)
            }
        });
        elements.push(ten.map(|c| {
            FeNodeId::from_index(*ids.entry(key(c)).or_insert_with(|| {
                nodes.push(place(c));
                nodes.len() - 1
            }))
        }));
    }
    Tet10Mesh::new(nodes, elements).unwrap()
}
