//! Shells whose thickness, size, material or load is extreme: a flat plate, turned in space, in
//! cylindrical bending, which flat triangles meet exactly.

use hapdef_mesh::FeNodeId;
use hapdef_report::robustness::{Expected, Measured};
use hapdef_sim::{ElasticModel, HeldMotion, Hold, NodalLoad, ShellKind, ShellMesh, ShellParams};
use nalgebra::{Point3, Vector3};

use super::field::material;
use super::solid::{relative_error, turn};
use super::solids::result_if;
use super::table::{Trial, measured, trial};
use crate::VerifyError;

/// A square plate.
#[derive(Clone, Copy)]
pub(super) struct Plate {
    kind: ShellKind,
    /// Edge, m.
    size: f64,
    /// Thickness over edge.
    t: f64,
    /// Young's modulus, Pa.
    e: f64,
    nu: f64,
    /// A factor on the load.
    load: f64,
    /// The height of the middle row of cells over that of the others.
    row: f64,
}

const CELLS: usize = 6;

/// Rows of shells.
pub(super) fn trials() -> Vec<Trial> {
    let mut trials = Vec::new();
    let plain =
        Plate { kind: ShellKind::Thick, size: 1.0, t: 1e-2, e: 2e9, nu: 0.3, load: 1.0, row: 1.0 };
    for (case, kind) in [
        ("thin plate in bending, thick shell", ShellKind::Thick),
        ("thin plate in bending, thin shell", ShellKind::Thin),
    ] {
        for t in [1e-2, 1e-3, 1e-4, 1e-5, 1e-6] {
            let plate = Plate { kind, t, ..plain };
            trials.push(shell(case, format!("t/L {t:e}"), result_if(t >= 1e-3), plate));
        }
    }
    for row in [0.1, 0.01, 1e-3, 1e-4] {
        let case = "a row of slivers, shell";
        let plate = Plate { row, ..plain };
        trials.push(shell(case, format!("height × {row:e}"), Expected::Either, plate));
    }
    let usual = |extreme: String, plate| shell("a plate, shell", extreme, Expected::Result, plate);
    for e in [1e3, 1e13] {
        trials.push(usual(format!("E {e:e} Pa"), Plate { e, ..plain }));
    }
    for nu in [0.0, 0.49, 0.4999, 0.4999999] {
        trials.push(usual(format!("ν {nu}"), Plate { nu, ..plain }));
    }
    for (words, size) in [("1 µm wide", 1e-6), ("1 km wide", 1e3)] {
        trials.push(usual(words.to_owned(), Plate { size, ..plain }));
    }
    for load in [1e-12, 1e12] {
        trials.push(usual(format!("load × {load:e}"), Plate { load, ..plain }));
    }
    trials
}

fn shell(case: &'static str, extreme: String, expected: Expected, plate: Plate) -> Trial {
    trial((case, extreme), "shell", expected, move || plate.measure())
}

impl Plate {
    /// The node at grid position (i, j).
    fn id(i: usize, j: usize) -> FeNodeId {
        FeNodeId::from_index(j * (CELLS + 1) + i)
    }

    /// Positions in the plate's own axes.
    fn nodes(&self) -> Vec<Point3<f64>> {
        let heights = (0..CELLS).map(|j| if j == CELLS / 2 { self.row } else { 1.0 });
        let mut y = vec![0.0];
        for height in heights {
            y.push(y[y.len() - 1] + height * self.size / CELLS as f64);
        }
        y.iter()
            .flat_map(|&y| {
                (0..=CELLS).map(move |i| Point3::new(i as f64 * self.size / CELLS as f64, y, 0.0))
            })
            .collect()
    }

    fn triangles() -> Vec<[FeNodeId; 3]> {
        let cells = (0..CELLS * CELLS).map(|c| (c % CELLS, c / CELLS));
        cells
            .flat_map(|(i, j)| {
                let [a, b] = [Self::id(i, j), Self::id(i + 1, j)];
                let [c, d] = [Self::id(i + 1, j + 1), Self::id(i, j + 1)];
                [[a, b, c], [a, c, d]]
            })
            .collect()
    }

    /// Held so that it can't move as a body: the corner at the origin, v and w of the corner along
    /// x, w of the corner along y.
    fn holds() -> Vec<Hold> {
        let held = [
            (Self::id(0, 0), 0),
            (Self::id(0, 0), 1),
            (Self::id(0, 0), 2),
            (Self::id(CELLS, 0), 1),
            (Self::id(CELLS, 0), 2),
            (Self::id(0, CELLS), 2),
        ];
        held.map(|(node, axis)| Hold {
            nodes: vec![node],
            motion: HeldMotion::Translation,
            direction: turn() * Vector3::ith(axis, 1.0),
        })
        .to_vec()
    }

    /// Curvature of the exact field.
    fn curvature(&self) -> f64 {
        1e-3 * self.load / self.size
    }

    /// w = −c/2 (x² − ν y²) less the plane through the three held corners.
    fn exact(&self, p: &Point3<f64>, height: f64) -> Vector3<f64> {
        let (c, nu) = (self.curvature(), self.nu);
        let w = -0.5 * c * (p.x * (p.x - self.size) - nu * p.y * (p.y - height));
        Vector3::new(0.0, 0.0, w)
    }

    /// The moment E t³ c / 12 per length along the edges x = 0 and x = size.
    fn load(&self, nodes: &[Point3<f64>]) -> NodalLoad {
        let thickness = self.t * self.size;
        let per_length = self.e * thickness.powi(3) * self.curvature() / 12.0;
        let mut load = NodalLoad::default();
        for j in 0..CELLS {
            for (i, sign) in [(0, -1.0), (CELLS, 1.0)] {
                let ends = [Self::id(i, j), Self::id(i, j + 1)];
                let length = (nodes[ends[0].index()] - nodes[ends[1].index()]).norm();
                let moment = turn() * Vector3::y() * (0.5 * sign * per_length * length);
                load.moments_nm.extend(ends.map(|node| (node, moment)));
            }
        }
        load
    }

    /// Solves it and compares with the exact field.
    fn measure(&self) -> Result<Measured, VerifyError> {
        let nodes = self.nodes();
        let height = nodes[nodes.len() - 1].y;
        let placed: Vec<_> = nodes.iter().map(|p| turn() * p).collect();
        let thickness = vec![self.t * self.size; nodes.len()];
        let mesh = ShellMesh::new(placed, Self::triangles(), thickness)?;
        let mut params = ShellParams::new(material(self.e, self.nu)?, Vec::new());
        params.kind = self.kind;
        params.supports.holds = Self::holds();
        let model = ElasticModel::build_shell(&mesh, &params)?;
        let (u, info) = model.solve(&self.load(&nodes))?;
        let error = relative_error(&nodes, &u, |p| turn() * self.exact(p, height));
        Ok(measured(&model, &info, error))
    }
}
