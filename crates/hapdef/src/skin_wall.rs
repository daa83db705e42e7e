//! The wall of a skin: what it is solved as, and why.

use hapdef_mesh::{SkinRegion, Tet10Mesh};

use crate::error::HapdefError;
use crate::scene::{Scene, Shape, WallSolver};
use crate::skin_solid::Outside;
use crate::wall_shell::WallShell;

/// The wall of a limb that is a skin.
pub struct SkinWall {
    /// Its outside.
    pub outside: SkinRegion,
    /// Its thickness `[outside.nodes]`, m.
    pub thickness_m: Vec<f64>,
    /// What it is solved as: never [`WallSolver::Auto`].
    pub solver: WallSolver,
    /// Why, with the error expected of each.
    pub why: String,
}

impl SkinWall {
    /// The wall outside of which is `outside`, and the shell where the scene asks for one or, left to
    /// choose, the smaller error is expected of it.
    ///
    /// # Errors
    /// [`HapdefError`].
    pub(crate) fn new(
        scene: &Scene,
        solid: &Tet10Mesh,
        outside: &Outside,
    ) -> Result<(Self, Option<WallShell>), HapdefError> {
        let region = SkinRegion::new(solid, outside.faces.clone())?;
        let thickness_m: Vec<f64> =
            region.nodes.iter().map(|node| outside.thickness_m[node.index()]).collect();
        let solver = match &scene.geometry.shape {
            Shape::Skin(skin) => skin.solver,
            Shape::Deck(_) => WallSolver::Solid,
        };
        let shell = match solver {
            WallSolver::Shell => Some(WallShell::new(solid, &region, &thickness_m)?),
            _ => None,
        };
        Ok((Self { outside: region, thickness_m, solver, why: String::new() }, shell))
    }
}
