//! Loads on the surface of a shell mesh.

use std::collections::BTreeMap;

use nalgebra::{Point3, Vector3};

use super::{ShellMesh, shell_pressure_load, shell_traction_load};
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
