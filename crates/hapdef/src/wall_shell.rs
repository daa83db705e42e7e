//! The wall of a limb as a shell under the solid's outer skin.

use hapdef_mesh::{FeNodeId, PointIndex, ShellSurface, SkinRegion, SkinSide, Tet10Mesh};
use hapdef_sim::{
    GaugeParams, GaugeSite, IsotropicMaterial, ShellGaugeStrain, ShellKind, ShellMesh,
    ShellMeshParams, SimError,
};
use nalgebra::{Point3, Vector3};

use crate::error::HapdefError;

/// The middle of a wall, with a node under every node of the outer skin, those in the middle of its
/// edges included: its edges are half as long as the solid's.
pub struct WallShell {
    pub(crate) mesh: ShellMesh,
    /// The bending theory.
    pub(crate) kind: ShellKind,
    /// The solid's nodes outside, ascending; shell node `i` lies under the `i`-th.
    outside: Vec<FeNodeId>,
    directors: Vec<Vector3<f64>>,
    index: PointIndex,
}

impl WallShell {
    /// The shell behind the outer skin of `solid`, `thickness_m` `[outside.nodes]` thick.
    ///
    /// # Errors
    /// [`HapdefError::Mesh`] for a wall that folds on its middle, [`HapdefError::Sim`].
    pub(crate) fn new(
        solid: &Tet10Mesh,
        outside: &SkinRegion,
        thickness_m: &[f64],
    ) -> Result<Self, HapdefError> {
        let surface = outside.surface(solid)?;
        let shell = ShellSurface::from_skin(&surface, thickness_m, SkinSide::Outer)?;
        let ids = |triangle: &[u32; 3]| triangle.map(|v| FeNodeId::from_index(v as usize));
        let mesh = ShellMesh::with_params(
            shell.nodes().to_vec(),
            shell.triangles().iter().map(ids).collect(),
            thickness_m.to_vec(),
            &ShellMeshParams::default(),
        )?;
        Ok(Self {
            index: PointIndex::new(mesh.nodes()),
            mesh,
            kind: ShellKind::default(),
            outside: outside.nodes.clone(),
            directors: shell.directors().to_vec(),
        })
    }

    /// Triangles.
    #[must_use]
    pub fn n_triangles(&self) -> usize {
        self.mesh.triangles().len()
    }

    /// The shell's node under a node of the solid's outer skin, else the nearest to `place`.
    pub(crate) fn under(&self, node: FeNodeId, place: &Point3<f64>) -> FeNodeId {
        let found = self.outside.binary_search(&node).ok();
        let nearest = || self.index.nearest(place).map_or(0, |(nearest, _)| nearest);
        FeNodeId::from_index(found.unwrap_or_else(nearest))
    }

    /// The shell's nodes under those of `nodes` that are outside, ascending; `nodes` are ascending, too.
    pub(crate) fn under_all(&self, nodes: &[FeNodeId]) -> Vec<FeNodeId> {
        let is_one = |i: &usize| nodes.binary_search(&self.outside[*i]).is_ok();
        (0..self.outside.len()).filter(is_one).map(FeNodeId::from_index).collect()
    }

    /// The gauge at a site on the solid's wall, inside or outside, of which `max_lost_share` may miss
    /// the shell.
    ///
    /// # Errors
    /// As [`ShellGaugeStrain::new`].
    pub(crate) fn gauge(
        &self,
        site: &GaugeSite,
        material: &IsotropicMaterial,
        max_lost_share: f64,
    ) -> Result<ShellGaugeStrain, SimError> {
        let nearest = self.index.nearest(&site.position).map_or(0, |(node, _)| node);
        let off = (site.position - self.mesh.nodes()[nearest]).dot(&self.directors[nearest]);
        let z_m = (0.5 * self.mesh.thickness_m()[nearest]).copysign(off);
        let params = GaugeParams { max_lost_share, ..GaugeParams::default() };
        ShellGaugeStrain::new(&self.mesh, self.kind, material, site, z_m, &params)
    }
}
