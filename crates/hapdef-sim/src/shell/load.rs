//! Nodal forces of loads on a shell element.

use nalgebra::{Point3, Vector3};

/// The nodal forces, N, of a pressure (Pa) that pushes against the triangle's normal
/// (counter-clockwise corners seen from its tip): a third of the total at each node.
///
/// The discrete Kirchhoff triangle has no deflection inside, so no nodal moments arise (Batoz,
/// Bathe and Ho 1980, section 3.3).
#[must_use]
pub fn shell_pressure_load(nodes: &[Point3<f64>; 3], pressure_pa: f64) -> [Vector3<f64>; 3] {
    let area = (nodes[1] - nodes[0]).cross(&(nodes[2] - nodes[0])) * 0.5;
    [area * (-pressure_pa / 3.0); 3]
}

/// The nodal forces, N, of a traction (Pa, in space) that varies linearly between its values at the
/// corners: Fᵢ = A/12 (tᵢ + Σⱼ tⱼ).
#[must_use]
pub fn shell_traction_load(
    nodes: &[Point3<f64>; 3],
    traction_pa: &[Vector3<f64>; 3],
) -> [Vector3<f64>; 3] {
    let area_m2 = 0.5 * (nodes[1] - nodes[0]).cross(&(nodes[2] - nodes[0])).norm();
    let sum: Vector3<f64> = traction_pa.iter().sum();
    traction_pa.map(|t| (t + sum) * (area_m2 / 12.0))
}
