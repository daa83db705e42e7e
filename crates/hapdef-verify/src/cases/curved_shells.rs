//! Roof, cylinder and hemispheres.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{Point3, Vector3};

use super::prelude::*;
use crate::meshes::Triangles;

/// Rows of the table.
pub(super) fn cases() -> Vec<Case> {
    let roof = Case {
        name: "scordelis_lo",
        title: "Scordelis–Lo roof",
        quantity: "deflection at the middle of the free edge, radius 25, length 50, thickness 0.25, 40°, \
            E = 4.32e8, ν = 0, 90 per area; a quarter",
        unit: "ft",
        reference: Reference::Published(0.3024),
        source: "Scordelis and Lo, J. Am. Concr. Inst. 61, 1964, as given by MacNeal and Harder, 1985 \
            (from memory); deep shell theory gives 0.3086",
        meshes: &[[8, 8, 1], [16, 16, 1], [32, 32, 1]],
        solve: Solve::of(ROOF),
        ..Case::default()
    };
    let cylinder = Case {
        name: "pinched_cylinder",
        title: "Pinched cylinder with end diaphragms",
        quantity: "displacement under unit forces, radius 300, length 600, thickness 3, E = 3e6, ν = 0.3; an \
            eighth",
        reference: Reference::Published(1.8248e-5),
        source: "Belytschko, Stolarski, Liu, Carpenter and Ong, Comput. Methods Appl. Mech. Eng. 51, 1985 \
            (from memory): Flügge's series for a thin shell",
        meshes: FINE,
        solve: Solve::of(CYLINDER),
        ..Case::default()
    };
    let hemisphere = Case {
        name: "hemisphere",
        title: "Hemisphere with an 18° hole",
        quantity: "displacement under unit forces on a quarter, radius 10, thickness 0.04, E = 6.825e7, ν = \
            0.3",
        reference: Reference::Published(0.093),
        source: "Simo, Fox and Rifai, Comput. Methods Appl. Mech. Eng. 73, 1989: 0.093 (from memory; others \
            find 0.0924 to 0.0935 on fine meshes). MacNeal and Harder print 0.0940",
        meshes: FINE,
        solve: Solve::of(HEMISPHERE),
        ..Case::default()
    };
    let le3 = Case {
        name: "le3",
        title: "NAFEMS LE3, hemisphere under point loads",
        quantity: "displacement under pairs of 2 kN, radius 10 m, thickness 0.04 m, E = 68.25 GPa, ν = 0.3; a \
            quarter as a triangle of rows from the pole",
        unit: "m",
        reference: Reference::Published(0.185),
        source: "NAFEMS, The Standard NAFEMS Benchmarks, TNSB rev. 3, 1990, LE3",
        meshes: &[[16, 1, 1], [32, 1, 1], [64, 1, 1]],
        solve: Solve::of(LE3),
        ..Case::default()
    };
    let cylinder = cylinder.both_missed(
        [None, Some(0.0127)],
        "with transverse shear the displacement under a point force grows with every refinement, past the \
            thin shell's value",
    );
    [roof.both(), cylinder, hemisphere.both(), le3.both()].concat()
}

const FINE: &[[usize; 3]] = &[[16, 16, 1], [32, 32, 1], [64, 64, 1]];

/// A quarter of the roof.
const ROOF: Model = Model {
    mesh: Mesh::Grid(0.25, Pattern::ALL, |p| {
        let a = p.x * 40.0 / 180.0 * PI;
        Point3::new(25.0 * a.sin(), 25.0 * p.y, 25.0 * a.cos())
    }),
    material: [4.32e8, 0.0],
    supports: &[(Mirror(0), X(0.0)), (Mirror(1), Y(0.0)), (Only(&[0, 2]), Y(25.0))],
    load: Load::Area([0.0, 0.0, -90.0]),
    probe: Probe::Value(|s| Ok(-s.u(Place::Grid(1.0, 0.0), 2)?)),
};

/// An eighth of the cylinder.
const CYLINDER: Model = Model {
    mesh: Mesh::Grid(3.0, Pattern::ALL, |p| {
        let a = p.x * FRAC_PI_2;
        Point3::new(300.0 * a.sin(), 300.0 * p.y, 300.0 * a.cos())
    }),
    material: [3e6, 0.3],
    supports: &[
        (Mirror(0), X(0.0)),
        (Mirror(2), Z(0.0)),
        (Mirror(1), Y(0.0)),
        (Only(&[0, 2]), Y(300.0)),
    ],
    load: Load::Node(Place::Grid(0.0, 0.0), 2, -0.25),
    probe: Probe::Value(|s| Ok(-s.u(Place::Grid(0.0, 0.0), 2)?)),
};

/// A quarter of the hemisphere.
const HEMISPHERE: Model = Model {
    mesh: Mesh::Grid(0.04, Pattern::ALL, |p| {
        let (a, b) = (p.x * FRAC_PI_2, p.y * 72.0 / 180.0 * PI);
        Point3::new(a.cos() * b.cos(), a.sin() * b.cos(), b.sin()) * 10.0
    }),
    material: [6.825e7, 0.3],
    supports: &[(Mirror(1), Y(0.0)), (Mirror(0), X(0.0)), (Only(&[2]), X(10.0))],
    load: Load::All(&[
        Load::Node(Place::Grid(0.0, 0.0), 0, 1.0),
        Load::Node(Place::Grid(1.0, 0.0), 1, -1.0),
    ]),
    probe: Probe::U(Place::Grid(0.0, 0.0), 0),
};

/// A quarter without a hole; row i of n from the pole has i + 1 nodes.
const LE3: Model = Model {
    mesh: Mesh::Other(|[n, ..]| {
        let id = |i: usize, j: usize| i * (i + 1) / 2 + j;
        let mut triangles = Triangles { n: [n, 0, 0], ..Triangles::default() };
        for i in 0..=n {
            for j in 0..=i {
                let polar = i as f64 / n as f64 * FRAC_PI_2;
                let a = if i == 0 { 0.0 } else { j as f64 / i as f64 * FRAC_PI_2 };
                let out = Vector3::new(polar.sin() * a.cos(), polar.sin() * a.sin(), polar.cos());
                triangles.nodes.push(Point3::from(out * 10.0));
                if i < n {
                    triangles.corners.push([id(i, j), id(i + 1, j), id(i + 1, j + 1)]);
                    if j < i {
                        triangles.corners.push([id(i, j), id(i + 1, j + 1), id(i, j + 1)]);
                    }
                }
            }
        }
        Ok(triangles.body(0.04)?.named(format!("{n} rows")))
    }),
    material: [68.25e9, 0.3],
    supports: &[(Mirror(1), Y(0.0)), (Mirror(0), X(0.0)), (Only(&[2]), Z(10.0))],
    load: Load::All(&[
        Load::Node(Place::At([10.0, 0.0, 0.0]), 0, 2000.0),
        Load::Node(Place::At([0.0, 10.0, 0.0]), 1, -2000.0),
    ]),
    probe: Probe::U(Place::At([10.0, 0.0, 0.0]), 0),
};
