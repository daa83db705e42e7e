//! A solid that is held and touched, and the same on a finer mesh.

use crate::error::MeshError;
use crate::ids::FeNodeId;
use crate::skin::regions::SkinRegion;
use crate::solid::{Tet10Mesh, refine_unfolded};

/// A solid with what is done to it.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldSolid {
    /// The mesh.
    pub mesh: Tet10Mesh,
    /// Nodes that are held.
    pub clamped: Vec<FeNodeId>,
    /// Nodes that move as one rigid body.
    pub flange: Vec<FeNodeId>,
    /// Where it may be touched.
    pub skin: SkinRegion,
    /// Elements that were straightened over all refinements: [`refine_unfolded`].
    pub n_straightened: usize,
}

impl HeldSolid {
    /// Every element cut into eight, the drawing unchanged; old nodes keep their number.
    ///
    /// # Errors
    /// As [`refine_unfolded`].
    pub fn refined(&self) -> Result<Self, MeshError> {
        let refined = refine_unfolded(&self.mesh)?;
        Ok(Self {
            clamped: refined.node_set(&self.clamped),
            flange: refined.node_set(&self.flange),
            skin: SkinRegion::new(&refined.mesh, refined.faces(&self.skin.faces))?,
            n_straightened: self.n_straightened + refined.n_straightened,
            mesh: refined.mesh,
        })
    }
}
