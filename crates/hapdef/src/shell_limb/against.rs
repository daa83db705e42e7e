//! A shell against the solid limb of a scene.

use hapdef_mesh::PointIndex;
use nalgebra::Point3;

use super::ShellLimb;
use super::compare::ShellComparison;
use super::press::{Comparison, Solid};
use super::sites::gauge_at;
use crate::error::HapdefError;
use crate::limb::Limb;

impl ShellLimb {
    /// Presses the shell and `solid`, which is named `name`, of the shell's material, at the
    /// solid's surface nodes, and compares displacements and the readings of the solid's gauges.
    /// Each model is held as it says itself; nodes and gauges that don't lie on the shell are
    /// passed over.
    ///
    /// # Errors
    /// [`HapdefError::NothingToPress`] where the two don't lie on one another;
    /// [`HapdefError::Sim`], [`HapdefError::Mesh`].
    pub fn against_solid(&self, name: &str, solid: &Limb) -> Result<ShellComparison, HapdefError> {
        let index = PointIndex::new(self.mesh.nodes());
        let depth_m = |point: &Point3<f64>| {
            let nearest = index.nearest(point);
            0.5 * nearest.map_or(0.0, |(node, _)| self.mesh.thickness_m()[node])
        };
        let (mut on_shell, mut on_solid, mut sites) = (Vec::new(), Vec::new(), Vec::new());
        for (site, gauge) in solid.sites.iter().zip(&solid.gauges) {
            let depth_m = depth_m(&site.position);
            if let Some(same) = gauge_at(&self.mesh, site, depth_m, &self.params)? {
                on_shell.push(same);
                on_solid.push(gauge.clone());
                sites.push(site.position);
            }
        }
        let points = solid.surface_points();
        let places = points.iter().zip(&solid.directions);
        self.compare(&Comparison {
            name: name.to_owned(),
            deck_hash: Some(solid.deck_hash.clone()),
            sites,
            n_gauges_left_out: solid.gauges.len() - on_shell.len(),
            gauges: on_shell,
            solids: vec![Solid {
                mesh: &solid.mesh,
                skin: &solid.skin,
                clamped: solid.clamped.clone(),
                gauges: on_solid,
            }],
            places: places.map(|(p, d)| [*p, p + d * depth_m(p)]).collect(),
            directions: solid.directions.clone(),
            picture: solid.skin.surface(&solid.mesh)?,
        })
    }
}
