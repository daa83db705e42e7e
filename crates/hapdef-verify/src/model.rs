//! A problem as data: mesh, supports, load and probe, and the one runner of such models.

use hapdef_sim::{IsotropicMaterial, NodalLoad};
use nalgebra::{Matrix3, Point3, Vector3};

use crate::meshes::{Blocks, Body, Pattern, Place, grid};
use crate::problem::{Held, Problem, Solution, push, same};
use crate::{Element, Measured, VerifyError};

/// Mesh, material, supports, load and probe.
#[derive(Clone, Copy)]
pub(crate) struct Model {
    pub(crate) mesh: Mesh,
    /// Young's modulus and Poisson's ratio.
    pub(crate) material: [f64; 2],
    pub(crate) supports: &'static [(Held, On)],
    pub(crate) load: Load,
    pub(crate) probe: Probe,
}

/// Where a point of the unit cube or, with z = 0, of the unit square comes to lie.
pub(crate) type Map = fn(Point3<f64>) -> Point3<f64>;

/// Nodes, or faces all of whose nodes are taken, by position.
#[derive(Clone, Copy)]
pub(crate) enum On {
    /// Those at this x.
    X(f64),
    /// Those at this y.
    Y(f64),
    /// Those at this z.
    Z(f64),
    /// Those for which this holds.
    Where(fn(&Point3<f64>) -> bool),
}

/// What is meshed.
#[derive(Clone, Copy)]
pub(crate) enum Mesh {
    /// Cells of the unit cube in ten-node tetrahedra.
    Block(Map),
    /// Cells of the unit square in triangles of this thickness, each of the patterns in its turn.
    Grid(f64, &'static [Pattern], Map),
    /// Anything else, from the numbers of cells.
    Other(fn([usize; 3]) -> Result<Body, VerifyError>),
}

/// What acts on a model.
#[derive(Clone, Copy)]
pub(crate) enum Load {
    /// A total force along axis 0..3, or moment about one as 3..6: uniform over the faces of a solid,
    /// or along a straight line of a shell's nodes.
    Total(On, usize, f64),
    /// A force or moment on a node.
    Node(Place, usize, f64),
    /// A traction on a solid that depends on place and outward unit normal.
    Traction(On, fn(&Point3<f64>, &Vector3<f64>) -> Vector3<f64>),
    /// A unit torque on a solid about an axis along x through this point, by tractions that grow with
    /// the distance.
    Torque(On, [f64; 3]),
    /// Free expansion of a solid per degree, and the rise of temperature.
    Thermal(f64, fn(&Point3<f64>) -> f64),
    /// A force per volume of a solid.
    Volume(fn(&IsotropicMaterial, &Point3<f64>) -> Vector3<f64>),
    /// A force per area of a shell.
    Area([f64; 3]),
    /// A pressure against the normals of a shell's triangles.
    Pressure(f64),
    /// All of these.
    All(&'static [Load]),
}

/// What is read from a solution.
#[derive(Clone, Copy)]
pub(crate) enum Probe {
    /// The work of the load, over this.
    Work(f64),
    /// The displacement of a node along an axis.
    U(Place, usize),
    /// The mean of two nodes' displacements along an axis.
    Mean([Place; 2], usize),
    /// A component of the stress at a node of a solid, in millions.
    Stress([f64; 3], usize, usize),
    /// Anything else.
    Value(fn(&Solution) -> Result<f64, VerifyError>),
}

impl Model {
    /// The patterns of the mesh.
    pub(crate) fn patterns(&self) -> &'static [Pattern] {
        match self.mesh {
            Mesh::Grid(_, patterns, _) => patterns,
            _ => &[Pattern::Up],
        }
    }

    /// The value on a mesh.
    pub(crate) fn measure(
        &self,
        element: Element,
        n: [usize; 3],
        pattern: Pattern,
    ) -> Result<Measured, VerifyError> {
        let body = match self.mesh {
            Mesh::Block(map) => Body::solid(Blocks::default().block(n, map).finish()?, n),
            Mesh::Grid(thickness, _, map) => grid(n, pattern, map).body(thickness)?,
            Mesh::Other(make) => make(n)?,
        };
        let mut problem = Problem::new(element, body, self.material)?;
        for &(held, on) in self.supports {
            problem.hold(held, |p| on.takes(p));
        }
        let load = self.load.on(&problem)?;
        let solution = problem.solve(load)?;
        let value = match self.probe {
            Probe::Work(over) => solution.work() / over,
            Probe::U(place, axis) => solution.u(place, axis)?,
            Probe::Mean([a, b], axis) => 0.5 * (solution.u(a, axis)? + solution.u(b, axis)?),
            Probe::Stress(at, i, j) => {
                solution.stress(at, |p| self.load.free_strain(p))?[(i, j)] / 1e6
            }
            Probe::Value(value) => value(&solution)?,
        };
        Ok(solution.measured(value))
    }
}

impl On {
    fn takes(self, p: &Point3<f64>) -> bool {
        match self {
            Self::X(at) => same(p.x, at),
            Self::Y(at) => same(p.y, at),
            Self::Z(at) => same(p.z, at),
            Self::Where(takes) => takes(p),
        }
    }
}

impl Load {
    /// The forces on the nodes of a problem.
    pub(crate) fn on(&self, problem: &Problem) -> Result<NodalLoad, VerifyError> {
        Ok(match *self {
            Self::Total(on, dof, total) if problem.is_shell() => {
                problem.line_load(&problem.body.nodes_where(|p| on.takes(p)), dof, total)
            }
            Self::Total(on, axis, total) => {
                let direction = Vector3::ith(axis, 1.0);
                let pull = problem.traction(|p| on.takes(p), |_, _| direction)?;
                pull.scaled(total / pull.total_n().dot(&direction))
            }
            Self::Node(place, dof, value) => {
                let mut load = NodalLoad::default();
                push(&mut load, problem.body.node(place)?, dof, value);
                load
            }
            Self::Traction(on, traction) => problem.traction(|p| on.takes(p), traction)?,
            Self::Torque(on, about) => {
                let about = Point3::from(about);
                let turn = |p: &Point3<f64>, _: &_| Vector3::new(0.0, about.z - p.z, p.y - about.y);
                let turn = problem.traction(|p| on.takes(p), turn)?;
                let torque = turn.moment_nm(problem.body.tets()?, &about)?.x;
                turn.scaled(1.0 / torque)
            }
            Self::Thermal(expansion, rise) => {
                NodalLoad::thermal(problem.body.tets()?, &problem.material, expansion, rise)
            }
            Self::Volume(force) => {
                NodalLoad::body_force(problem.body.tets()?, |p| force(&problem.material, p))
            }
            Self::Area(force) => {
                let (shell, all) = problem.body.shell()?;
                shell.traction_load(&all, &Vector3::from(force))?
            }
            Self::Pressure(pressure) => {
                let (shell, all) = problem.body.shell()?;
                shell.pressure_load(&all, pressure)?
            }
            Self::All(loads) => {
                let add = |sum: NodalLoad, load: &Load| Ok(sum.plus(&load.on(problem)?));
                return loads.iter().try_fold(NodalLoad::default(), add);
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
