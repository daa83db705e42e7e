//! The solid partner of a shell: the same skin and wall as ten-node tetrahedra.

use hapdef_mesh::{
    ExtrudeParams, Extrusion, FaceCurve, FeNodeId, SkinRegion, TET10_EDGES, Tri6Face, extrude,
};
use hapdef_sim::{GaugeParams, GaugeSite, GaugeStrain, ShellGaugeStrain};

use super::ShellLimb;
use super::compare::{ShellComparison, Solid};
use super::sites::on_wall;
use crate::error::HapdefError;

/// Thicker than this part of the edge length, a wall gets two layers of wedges.
const THIN: f64 = 0.5;

impl ShellLimb {
    /// Presses the shell and the solid extruded from the same skin, with flat faces as the shell's,
    /// held and read at the same places.
    ///
    /// # Errors
    /// [`HapdefError::Mesh`] where the wall folds; [`HapdefError::NothingToPress`];
    /// [`HapdefError::Sim`].
    pub fn against_extruded(&self) -> Result<ShellComparison, HapdefError> {
        let thickest_m = self.mesh.thickness_m().iter().copied().fold(0.0, f64::max);
        let n_layers = 1 + usize::from(thickest_m > THIN * self.info.wall.target_edge_m);
        let params = ExtrudeParams {
            side: self.side,
            n_layers,
            curve: FaceCurve::Flat,
        };
        let wall = extrude(&self.skin, self.mesh.thickness_m(), &params)?;
        let outer = SkinRegion::new(&wall.mesh, self.level_faces(&wall, 0))?;
        let (gauges, n_gauges_left_out) = self.gauges_on(&wall)?;
        let outside = |v: usize| wall.mesh.position(wall.node(v as u32, 0));
        let nodes = self.mesh.nodes().iter().enumerate();
        self.compare(&Solid {
            name: format!(
                "its extruded solid ({n_layers} layer{})",
                if n_layers == 1 { "" } else { "s" }
            ),
            mesh: &wall.mesh,
            skin: &outer,
            clamped: self.clamped_columns(&wall),
            gauges,
            n_gauges_left_out,
            places: nodes.map(|(v, middle)| [outside(v), *middle]).collect(),
            directions: self.normals.iter().map(|n| -n).collect(),
            picture: self.skin.clone(),
        })
    }

    /// Boundary faces of the wall whose corners are all on one level.
    fn level_faces(&self, wall: &Extrusion, level: usize) -> Vec<Tri6Face> {
        let is_level = |node: &FeNodeId| node.index() % (wall.n_layers + 1) == level;
        let faces = wall.mesh.boundary().faces.into_iter();
        faces
            .filter(|face| face.nodes[..3].iter().all(is_level))
            .collect()
    }

    /// The shell's gauges on the inside of the wall too, and how many don't lie on it.
    fn gauges_on(
        &self,
        wall: &Extrusion,
    ) -> Result<(Vec<(ShellGaugeStrain, GaugeStrain)>, usize), HapdefError> {
        let inside = self.level_faces(wall, wall.n_layers);
        let params = GaugeParams::default();
        let mut pairs = Vec::new();
        for (gauge, site) in self.gauges.iter().zip(&self.sites) {
            let site = GaugeSite {
                axis: gauge.axis(),
                ..*site
            };
            let on_solid = GaugeStrain::with_params(&wall.mesh, &inside, &site, &params);
            pairs.extend(on_wall(on_solid)?.map(|solid| (gauge.clone(), solid)));
        }
        let n_left_out = self.gauges.len() - pairs.len();
        Ok((pairs, n_left_out))
    }

    /// All nodes of the columns under clamped vertices: corners, and middles between them.
    fn clamped_columns(&self, wall: &Extrusion) -> Vec<FeNodeId> {
        let n_levels = wall.n_layers + 1;
        let mut is_clamped = vec![false; wall.mesh.nodes().len()];
        for vertex in &self.clamped {
            let first = vertex.index() * n_levels;
            is_clamped[first..first + n_levels].fill(true);
        }
        for element in wall.mesh.elements() {
            for (edge, [a, b]) in TET10_EDGES.into_iter().enumerate() {
                if is_clamped[element[a].index()] && is_clamped[element[b].index()] {
                    is_clamped[element[4 + edge].index()] = true;
                }
            }
        }
        let nodes = (0..is_clamped.len()).filter(|&i| is_clamped[i]);
        nodes.map(FeNodeId::from_index).collect()
    }
}
