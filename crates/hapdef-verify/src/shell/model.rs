//! A shell on a mapped grid as data, and the one runner of such models.

use std::rc::Rc;

use hapdef_sim::ShellKind;
use nalgebra::Vector3;

use super::benchmark::Solve;
use super::grid::{Grid, Mesh};
use super::problem::{Problem, Solution};
use crate::{Measured, VerifyError};

/// Mesh, supports, load and probe.
#[derive(Clone, Copy)]
pub(super) struct Model {
    pub(super) grid: fn(Mesh) -> Grid,
    pub(super) thickness: f64,
    /// Young's modulus and Poisson's ratio.
    pub(super) material: [f64; 2],
    pub(super) supports: fn(&Grid, &mut Problem),
    pub(super) load: Load,
    pub(super) probe: Probe,
}

/// What acts on a model.
#[derive(Clone, Copy)]
pub(super) enum Load {
    /// A total force (below 3) or moment along a degree of freedom over the side `u = 1`.
    End(usize, f64),
    /// A force per area.
    Area([f64; 3]),
    /// A pressure against the triangles' normals.
    Pressure(f64),
    /// Anything else.
    Other(fn(&Grid, &mut Problem)),
}

/// What is read from a solution.
#[derive(Clone, Copy)]
pub(super) enum Probe {
    /// The mean displacement along an axis of the corners of the side `u = 1`.
    EndCorners(usize),
    /// The displacement along an axis of the middle of that side.
    EndMiddle(usize),
    /// Anything else.
    Value(fn(&Grid, &Solution) -> Result<f64, VerifyError>),
}

/// The side `u = 0` clamped.
pub(super) fn clamped_start(grid: &Grid, problem: &mut Problem) {
    problem.clamp(&grid.side_u(false));
}

impl Model {
    /// For a benchmark.
    pub(super) fn solve(self) -> Solve {
        Rc::new(move |kind, mesh| self.measure(kind, mesh))
    }

    /// The value on a mesh.
    pub(super) fn measure(&self, kind: ShellKind, mesh: Mesh) -> Result<Measured, VerifyError> {
        let grid = (self.grid)(mesh);
        let [e, nu] = self.material;
        let mut problem = Problem::new(&grid, self.thickness, e, nu)?;
        (self.supports)(&grid, &mut problem);
        match self.load {
            Load::End(dof, total) => problem.line_load(&grid.side_u(true), dof, total),
            Load::Area(force) => problem.area_force(Vector3::from(force)),
            Load::Pressure(pressure) => problem.pressure(pressure),
            Load::Other(load) => load(&grid, &mut problem),
        }
        let solution = problem.solve(kind)?;
        let end = grid.side_u(true);
        let value = match self.probe {
            Probe::EndCorners(axis) => {
                0.5 * (solution.u(end[0], axis) + solution.u(end[grid.nv], axis))
            }
            Probe::EndMiddle(axis) => solution.u(end[grid.nv / 2], axis),
            Probe::Value(value) => value(&grid, &solution)?,
        };
        Ok(solution.measured(value, grid.cells(), 1.0 / mesh.n as f64))
    }
}
