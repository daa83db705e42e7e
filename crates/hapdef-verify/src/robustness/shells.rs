//! Shells whose thickness, size, material or load is extreme: a flat plate, turned in space, in
//! cylindrical bending, which flat triangles meet exactly.

use hapdef_bench::robustness::{Expected, Measured};
use hapdef_mesh::FeNodeId;
use hapdef_sim::{ElasticModel, Hold, NodalLoad, ShellKind, ShellParams};
use nalgebra::{Point3, Vector3};

use super::field::material;
use super::solid::{hold, relative_error, turn};
use super::solids::{result_if, wide};
use super::table::{RobustnessTrials, add as add_row, measured};
use crate::VerifyError;
use crate::meshes::{Pattern, Triangles, grid as cells};

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

const PLAIN: Plate =
    Plate { kind: ShellKind::Thick, size: 1.0, t: 1e-2, e: 2e9, nu: 0.3, load: 1.0, row: 1.0 };

/// A case, values of what is extreme, their words, when a result is expected, and the plate.
type Sweep =
    (&'static str, &'static [f64], fn(f64) -> String, fn(f64) -> Expected, fn(f64) -> Plate);

const THICK: &str = "thin plate in bending, thick shell";
const THIN: &str = "thin plate in bending, thin shell";
const ANY: &str = "a plate, shell";
const RATIOS: &[f64] = &[1e-2, 1e-3, 1e-4, 1e-5, 1e-6];

const SWEEPS: [Sweep; 7] = [
    (THICK, RATIOS, |t| format!("t/L {t:e}"), |t| result_if(t >= 1e-3), |t| Plate { t, ..PLAIN }),
    (
        THIN,
        RATIOS,
        |t| format!("t/L {t:e}"),
        |t| result_if(t >= 1e-3),
        |t| Plate { t, kind: ShellKind::Thin, ..PLAIN },
    ),
    (
        "a row of slivers, shell",
        &[0.1, 0.01, 1e-3, 1e-4],
        |row| format!("height × {row:e}"),
        |_| Expected::Either,
        |row| Plate { row, ..PLAIN },
    ),
    (ANY, &[1e3, 1e13], |e| format!("E {e:e} Pa"), |_| Expected::Result, |e| Plate { e, ..PLAIN }),
    (
        ANY,
        &[0.0, 0.49, 0.4999, 0.4999999],
        |nu| format!("ν {nu}"),
        |_| Expected::Result,
        |nu| Plate { nu, ..PLAIN },
    ),
    (ANY, &[1e-6, 1e3], wide, |_| Expected::Result, |size| Plate { size, ..PLAIN }),
    (
        ANY,
        &[1e-12, 1e12],
        |load| format!("load × {load:e}"),
        |_| Expected::Result,
        |load| Plate { load, ..PLAIN },
    ),
];

/// Rows of shells.
pub(super) fn add(rows: &mut RobustnessTrials) {
    for (case, values, words, expected, plate) in SWEEPS {
        for &value in values {
            let plate = plate(value);
            let extreme = (case, words(value));
            add_row(rows, extreme, "shell", expected(value), move || plate.measure());
        }
    }
}

impl Plate {
    /// The node at grid position (i, j).
    fn id(i: usize, j: usize) -> FeNodeId {
        FeNodeId::from_index(j * (CELLS + 1) + i)
    }

    /// Positions in the plate's own axes; the middle row of cells has its own height.
    fn cells(&self) -> Triangles {
        let side = self.size / CELLS as f64;
        let heights = (0..CELLS).map(|j| if j == CELLS / 2 { self.row } else { 1.0 });
        let mut y = vec![0.0];
        for height in heights {
            y.push(y[y.len() - 1] + height * side);
        }
        cells([CELLS, CELLS, 1], Pattern::Up, |p| {
            let [i, j] = [p.x, p.y].map(|c| (c * CELLS as f64).round());
            Point3::new(i * self.size / CELLS as f64, y[j as usize], 0.0)
        })
    }

    /// Held so that it can't move as a body: the corner at the origin, v and w of the corner along
    /// x, w of the corner along y.
    fn holds() -> Vec<Hold> {
        let [origin, x, y] = [(0, 0), (CELLS, 0), (0, CELLS)].map(|(i, j)| Self::id(i, j));
        let held = [(origin, 0), (origin, 1), (origin, 2), (x, 1), (x, 2), (y, 2)];
        held.map(|(node, axis)| hold(vec![node], axis)).to_vec()
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
        let cells = self.cells();
        let nodes = cells.nodes.clone();
        let height = nodes[nodes.len() - 1].y;
        let placed = Triangles { nodes: nodes.iter().map(|p| turn() * p).collect(), ..cells };
        let body = placed.body(self.t * self.size)?;
        let mut params = ShellParams::new(material(self.e, self.nu)?, Vec::new());
        params.kind = self.kind;
        params.supports.holds = Self::holds();
        let model = ElasticModel::build_shell(body.shell()?.0, &params)?;
        let (u, info) = model.solve(&self.load(&nodes))?;
        let error = relative_error(&nodes, &u, |p| turn() * self.exact(p, height));
        Ok(measured(&model, &info, error))
    }
}
