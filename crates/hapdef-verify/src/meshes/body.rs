//! A meshed solid or shell.

use hapdef_mesh::{FeNodeId, Tet10Mesh};
use hapdef_sim::ShellMesh;
use nalgebra::Point3;

use crate::VerifyError;

/// A mesh with its size.
#[derive(Clone, Debug)]
pub(crate) struct Body {
    pub(crate) mesh: BodyMesh,
    /// Cells, where it has any.
    pub(crate) n: [usize; 3],
    /// The mesh in a few words.
    pub(crate) words: String,
    /// Element size on any scale.
    pub(crate) h: f64,
}

/// Ten-node tetrahedra, or triangles with a thickness.
#[derive(Clone, Debug)]
pub(crate) enum BodyMesh {
    Solid(Tet10Mesh),
    Shell(ShellMesh),
}

/// A node of a body.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Place {
    /// The one at this position.
    At([f64; 3]),
    /// The one at this share of the cells of a grid in both directions.
    Grid(f64, f64),
}

impl Body {
    /// A solid of `n` cells.
    pub(crate) fn solid(mesh: Tet10Mesh, n: [usize; 3]) -> Self {
        let words = format!("{} × {} × {} cells", n[0], n[1], n[2]);
        Self { mesh: BodyMesh::Solid(mesh), n, words, h: 1.0 / n[0] as f64 }
    }

    /// The same under another name.
    pub(crate) fn named(self, words: String) -> Self {
        Self { words, ..self }
    }

    pub(crate) fn nodes(&self) -> &[Point3<f64>] {
        match &self.mesh {
            BodyMesh::Solid(mesh) => mesh.nodes(),
            BodyMesh::Shell(mesh) => mesh.nodes(),
        }
    }

    /// The nodes at positions for which `is_wanted` holds, ascending.
    pub(crate) fn nodes_where(&self, is_wanted: impl Fn(&Point3<f64>) -> bool) -> Vec<FeNodeId> {
        let wanted = self.nodes().iter().enumerate().filter(|(_, p)| is_wanted(p));
        wanted.map(|(node, _)| FeNodeId::from_index(node)).collect()
    }

    /// The tetrahedra of a solid.
    pub(crate) fn tets(&self) -> Result<&Tet10Mesh, VerifyError> {
        match &self.mesh {
            BodyMesh::Solid(mesh) => Ok(mesh),
            BodyMesh::Shell(_) => Err(VerifyError::setup("the body", "a solid", "a shell")),
        }
    }

    /// A shell, and the numbers of all its triangles.
    pub(crate) fn shell(&self) -> Result<(&ShellMesh, Vec<usize>), VerifyError> {
        match &self.mesh {
            BodyMesh::Shell(mesh) => Ok((mesh, (0..mesh.triangles().len()).collect())),
            BodyMesh::Solid(_) => Err(VerifyError::setup("the body", "a shell", "a solid")),
        }
    }

    /// The node at a place.
    pub(crate) fn node(&self, place: Place) -> Result<FeNodeId, VerifyError> {
        match place {
            Place::At(point) => self.node_near(point, 1e-6),
            Place::Grid(u, v) => {
                let [i, j] = [u * self.n[0] as f64, v * self.n[1] as f64].map(|x| x as usize);
                Ok(FeNodeId::from_index(j * (self.n[0] + 1) + i))
            }
        }
    }

    /// The first node within `reach` of a point.
    pub(crate) fn node_near(&self, point: [f64; 3], reach: f64) -> Result<FeNodeId, VerifyError> {
        let point = Point3::from(point);
        let near = self.nodes_where(|p| (p - point).norm() < reach);
        near.first().copied().ok_or_else(|| {
            let what = "the place where the value is read";
            VerifyError::setup(what, format!("a node at {point}"), format!("none within {reach}"))
        })
    }
}
