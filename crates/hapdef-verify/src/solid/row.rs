//! A case of the ten-node tetrahedron as data, and the one runner of such cases.

use hapdef_mesh::Tet10Mesh;
use hapdef_sim::NodalLoad;
use nalgebra::{Matrix3, Point3, Vector3};

use super::problem::{Problem, Solution, cells};
use crate::meshes::faces_where;
use crate::{Case, Measured, Reference, Target, VerifyError};

/// Mesh, supports, load, probe and reference of a case; within one percent on the last of three
/// meshes where nothing else is stated.
#[derive(Clone, Copy)]
pub(super) struct Row {
    pub(super) id: &'static str,
    pub(super) title: &'static str,
    pub(super) quantity: &'static str,
    pub(super) unit: &'static str,
    pub(super) reference: Reference,
    pub(super) source: &'static str,
    /// Cells of the meshes.
    pub(super) cells: [[usize; 3]; 3],
    pub(super) mesh: fn([usize; 3]) -> Result<Tet10Mesh, VerifyError>,
    /// The mesh in words.
    pub(super) words: fn([usize; 3]) -> String,
    /// Young's modulus and Poisson's ratio.
    pub(super) material: [f64; 2],
    pub(super) supports: fn(Problem) -> Problem,
    pub(super) load: Load,
    pub(super) probe: Probe,
}

/// What acts on a model.
#[derive(Clone, Copy)]
pub(super) enum Load {
    /// A uniform traction on the faces where the first holds, scaled to this total along this
    /// direction.
    Force(On, [f64; 3], f64),
    /// A traction that depends on place and outward unit normal.
    Traction(On, fn(&Point3<f64>, &Vector3<f64>) -> Vector3<f64>),
    /// A unit torque about an axis along x through this point, by tractions that grow with the
    /// distance.
    Torque(On, [f64; 3]),
    /// Free expansion per degree, and the rise of temperature.
    Thermal(f64, fn(&Point3<f64>) -> f64),
}

/// What is read from a solution.
#[derive(Clone, Copy)]
pub(super) enum Probe {
    /// The work of the load, over this.
    Work(f64),
    /// The displacement at a node along an axis.
    Displacement([f64; 3], usize),
    /// A component of the stress at a node, in millions.
    Stress([f64; 3], usize, usize),
    /// Anything else.
    Value(fn(&Solution<'_>) -> Result<f64, VerifyError>),
}

/// Faces by the position of their nodes.
pub(super) type On = fn(&Point3<f64>) -> bool;

impl Row {
    pub(super) const EMPTY: Self = Self {
        id: "",
        title: "",
        quantity: "",
        unit: "",
        reference: Reference::Zero,
        source: "",
        cells: [[1; 3]; 3],
        mesh: |_| Err(VerifyError::not_run("no mesh")),
        words: cells,
        material: [1.0, 0.0],
        supports: |problem| problem,
        load: Load::Thermal(0.0, |_| 0.0),
        probe: Probe::Work(1.0),
    };

    /// The case of the table.
    pub(super) fn case(self) -> Case {
        Case {
            id: self.id,
            title: self.title,
            element: "TET10",
            quantity: self.quantity,
            unit: self.unit,
            reference: self.reference,
            source: self.source,
            target: Target::within(0.01),
            n_levels: self.cells.len(),
            known_miss: None,
            run: Box::new(move |level| self.measure(self.cells[level])),
        }
    }

    fn measure(&self, n: [usize; 3]) -> Result<Measured, VerifyError> {
        let [e, nu] = self.material;
        let problem = (self.supports)(Problem::new((self.mesh)(n)?, e, nu)?);
        let load = self.load.of(&problem)?;
        let solution = problem.solve(&load)?;
        let value = match self.probe {
            Probe::Work(over) => load.work_j(&solution.u)? / over,
            Probe::Displacement(at, axis) => solution.displacement(at)?[axis],
            Probe::Stress(at, i, j) => {
                let free = |p: &Point3<f64>| self.load.free_strain(p);
                solution.stress_beside(at, free)?[(i, j)] / 1e6
            }
            Probe::Value(value) => value(&solution)?,
        };
        Ok(solution.measured(value, (self.words)(n), 1.0 / n[0] as f64))
    }
}

impl Load {
    fn of(&self, problem: &Problem) -> Result<NodalLoad, VerifyError> {
        let faces = |on: On| faces_where(&problem.mesh, on);
        Ok(match *self {
            Self::Force(on, direction, total) => {
                let direction = Vector3::from(direction);
                let pull = problem.traction(&faces(on), |_, _| direction);
                pull.scaled(total / pull.total_n().dot(&direction))
            }
            Self::Traction(on, traction) => problem.traction(&faces(on), traction),
            Self::Torque(on, about) => {
                let about = Point3::from(about);
                let turn = |p: &Point3<f64>, _: &_| Vector3::new(0.0, about.z - p.z, p.y - about.y);
                let turn = problem.traction(&faces(on), turn);
                let torque = turn.moment_nm(&problem.mesh, &about)?.x;
                turn.scaled(1.0 / torque)
            }
            Self::Thermal(expansion, rise) => {
                NodalLoad::thermal(&problem.mesh, &problem.material, expansion, rise)
            }
        })
    }

    /// The strain that temperature alone would give.
    fn free_strain(&self, p: &Point3<f64>) -> Matrix3<f64> {
        match *self {
            Self::Thermal(expansion, rise) => Matrix3::identity() * (expansion * rise(p)),
            _ => Matrix3::zeros(),
        }
    }
}
