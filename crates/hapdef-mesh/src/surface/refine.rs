//! Uniform refinement of triangle surfaces: each triangle becomes four.

use crate::surface::curve::EdgeMiddles;
use crate::{FaceCurve, MeshError, ShellSurface, SkinSide, SurfaceMesh};

/// A refined surface and where its new vertices come from.
#[derive(Clone, Debug, PartialEq)]
pub struct RefinedSurface {
    /// The old vertices, then one for each edge.
    pub mesh: SurfaceMesh,
    /// The old edge (ends ascending) that each new vertex halves `[n_new_vertices]`, in order.
    pub halved_edges: Vec<[u32; 2]>,
}

impl SurfaceMesh {
    /// Each triangle split into four at the middles of its edges, which lie where `curve` puts
    /// them. Triangle t becomes 4t..4t+4: the three at its corners, then the inner one.
    ///
    /// # Errors
    /// More vertices than 32 bits can name, or a middle that `curve` puts nowhere finite.
    pub fn refined(&self, curve: &FaceCurve<'_>) -> Result<RefinedSurface, MeshError> {
        let middles = EdgeMiddles::of(self, curve);
        let n_old = self.vertices().len();
        let new = |a, b| (n_old + middles.number(a, b)) as u32;
        let children = |&[a, b, c]: &[u32; 3]| {
            let (ab, bc, ca) = (new(a, b), new(b, c), new(c, a));
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        let triangles = self.triangles().iter().flat_map(children).collect();
        let vertices = [self.vertices(), &middles.middles].concat();
        Ok(RefinedSurface {
            mesh: SurfaceMesh::new(vertices, triangles)?,
            halved_edges: middles.edges,
        })
    }
}

impl ShellSurface {
    /// Each triangle split into four, `curve` being the middle surface's; a new node has the mean
    /// thickness of its edge's ends.
    ///
    /// # Errors
    /// Those of [`SurfaceMesh::refined`], and a triangle that `curve` leaves without area or turns
    /// over onto another.
    pub fn refined(&self, curve: &FaceCurve<'_>) -> Result<Self, MeshError> {
        let fine = self.middle().refined(curve)?;
        let old = self.thickness_m();
        let mean = |[a, b]: &[u32; 2]| 0.5 * (old[*a as usize] + old[*b as usize]);
        let new: Vec<f64> = fine.halved_edges.iter().map(mean).collect();
        Self::from_skin(&fine.mesh, &[old, &new].concat(), SkinSide::Middle)
    }
}
