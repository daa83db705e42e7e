//! Loads on the surface of a shell mesh.

use std::collections::BTreeMap;

use hapdef_mesh::FeNodeId;
use nalgebra::{Point3, Vector3};

use super::{ShellMesh, shell_pressure_load, shell_traction_load};
use crate::loads::patch::{Tip, check_tip, unit};
use crate::{NodalLoad, SimError};

impl ShellMesh {
    /// The load of a uniform pressure on `triangles` (counted from 0), against their normals.
    ///
    /// # Errors
    /// [`SimError::ElementOutOfRange`], [`SimError::LoadNotFinite`].
    pub fn pressure_load(
        &self,
        triangles: &[usize],
        pressure_pa: f64,
    ) -> Result<NodalLoad, SimError> {
        check_finite(&Vector3::repeat(pressure_pa))?;
        self.area_load(triangles, |p| shell_pressure_load(p, pressure_pa))
    }

    /// The load of a constant force per area of mid-surface on `triangles` (counted from 0), Pa.
    ///
    /// # Errors
    /// [`SimError::ElementOutOfRange`], [`SimError::LoadNotFinite`].
    pub fn traction_load(
        &self,
        triangles: &[usize],
        traction_pa: &Vector3<f64>,
    ) -> Result<NodalLoad, SimError> {
        check_finite(traction_pa)?;
        self.area_load(triangles, |p| shell_traction_load(p, &[*traction_pa; 3]))
    }

    /// The unit force of a tip of radius `tip_radius_m` (r) pressing at `centre` along `direction`,
    /// N, as [`NodalLoad::patch`] on a solid: the pressure at distance d goes with (1 − (d/r)²)², on
    /// the facets of the mid-surface. A radius of zero puts the force on the nearest node, the first
    /// of equals.
    ///
    /// # Errors
    /// [`SimError::Direction`], [`SimError::Parameter`] for an unusable radius or centre,
    /// [`SimError::PatchOffSkin`] if no facet lies inside the radius.
    pub fn patch_load(
        &self,
        centre: &Point3<f64>,
        tip_radius_m: f64,
        direction: &Vector3<f64>,
    ) -> Result<NodalLoad, SimError> {
        let direction = unit("the direction of the patch load", direction)?;
        check_tip(centre, tip_radius_m)?;
        let (nearest, nearest_node_m) = (0..self.nodes().len())
            .map(|node| (node, (self.nodes()[node] - centre).norm()))
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .ok_or(SimError::Length { what: "the shell's node list", expected: 1, found: 0 })?;
        if tip_radius_m == 0.0 {
            return Ok(NodalLoad::nodal(FeNodeId::from_index(nearest), direction));
        }
        let weights = self.tip_weights(centre, tip_radius_m);
        let total: f64 = weights.values().sum();
        if total.is_nan() || total <= 0.0 {
            return Err(SimError::PatchOffSkin {
                centre_m: centre.coords.into(),
                tip_radius_m,
                nearest_node_m,
            });
        }
        let forces = weights.into_iter();
        Ok(NodalLoad::from_map(forces.map(|(n, w)| (n, direction * (w / total))).collect()))
    }

    /// ∫ λᵢ κ dA of each node near the tip.
    fn tip_weights(&self, centre: &Point3<f64>, radius_m: f64) -> BTreeMap<FeNodeId, f64> {
        let mut weights = BTreeMap::new();
        for (triangle, nodes) in self.triangles().iter().enumerate() {
            let [a, b, c] = self.corners(triangle);
            let middle = nalgebra::center;
            let tip = Tip {
                nodes: [a, b, c, middle(&a, &b), middle(&b, &c), middle(&c, &a)],
                centre,
                radius_m,
            };
            let mut shares = [0.0; 6];
            tip.integrate(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], 0, &mut shares);
            if shares.iter().all(|&share| share == 0.0) {
                continue;
            }
            for (i, node) in nodes.iter().enumerate() {
                // λᵢ is 1 at its corner and ½ at the middles of its two sides
                let share = shares[i] + 0.5 * (shares[3 + i] + shares[3 + (i + 2) % 3]);
                *weights.entry(*node).or_insert(0.0) += share;
            }
        }
        weights
    }

    fn area_load(
        &self,
        triangles: &[usize],
        forces_of: impl Fn(&[Point3<f64>; 3]) -> [Vector3<f64>; 3],
    ) -> Result<NodalLoad, SimError> {
        let mut forces = BTreeMap::new();
        let n_elements = self.triangles().len();
        for &triangle in triangles {
            let nodes = self.triangles().get(triangle);
            let nodes = nodes.ok_or(SimError::ElementOutOfRange {
                what: "a load on a shell",
                element: triangle,
                n_elements,
            })?;
            for (node, force) in nodes.iter().zip(forces_of(&self.corners(triangle))) {
                *forces.entry(*node).or_insert_with(Vector3::zeros) += force;
            }
        }
        Ok(NodalLoad::from_map(forces))
    }
}

fn check_finite(value: &Vector3<f64>) -> Result<(), SimError> {
    if value.iter().all(|v| v.is_finite()) {
        return Ok(());
    }
    let value = (*value).into();
    Err(SimError::LoadNotFinite { load: 0, value })
}
