//! Strain gauges on a shell as linear functionals of displacement and rotation.

use std::collections::BTreeMap;

use hapdef_mesh::FeNodeId;
use nalgebra::{Point3, Vector3};

use super::patch::{PatchPoint, ShellPatch};
use super::{ShellKind, ShellMesh, ShellStrain};
use crate::gauges::strain_gauge::{STRAIN, axes, check_lost, check_site, footprint};
use crate::gauges::{LinearFunctional, NodeWeight};
use crate::loads::patch::unit;
use crate::{GaugeParams, GaugeSite, IsotropicMaterial, Motion, NodalLoad, SimError};

/// A gauge's reading on a shell as a linear functional: strain = Σ uᵢ · aᵢ + θᵢ · bᵢ.
///
/// The reading is the mean over the footprint of aᵀ ε a at a signed distance from the mid-surface,
/// with a the axis in the facet under each sample point.
#[derive(Clone, Debug, PartialEq)]
pub struct ShellGaugeStrain {
    functional: LinearFunctional,
    normal: Vector3<f64>,
    axis: Vector3<f64>,
    n_samples: usize,
    n_lost: usize,
    distance_m: f64,
}

impl ShellGaugeStrain {
    /// The gauge at `site` on `mesh`, read at the distance `z_m` from the mid-surface (positive on
    /// the side the normals point to; half the wall for a gauge glued outside), for a model of the
    /// same kind and material.
    ///
    /// The footprint is a rectangle in the tangent plane at the nearest point of the mid-surface,
    /// projected along the normal there onto the connected wall, as for solids.
    ///
    /// # Errors
    /// [`SimError::GaugeOffWall`] where the site is further from the mid-surface than
    /// [`GaugeParams::max_distance_m`] beyond |z|, [`SimError::GaugeOverhang`];
    /// [`SimError::Parameter`] and [`SimError::Direction`] on unusable sizes or an axis along the
    /// normal; [`SimError::ShellElement`].
    pub fn new(
        mesh: &ShellMesh,
        kind: ShellKind,
        material: &IsotropicMaterial,
        site: &GaugeSite,
        z_m: f64,
        params: &GaugeParams,
    ) -> Result<Self, SimError> {
        check_site(site, params)?;
        if !z_m.is_finite() {
            return Err(SimError::Parameter {
                what: "the gauge's distance from the mid-surface (m)",
                value: z_m,
                expected: "finite",
            });
        }
        let reach_m = site.length_m.hypot(site.width_m);
        let (patch, distance_m) = patch_under(mesh, &site.position, reach_m, z_m, params)?;
        let [along, across] = axes(site, &patch.normal)?;
        let points = footprint(&patch.origin, &along, &across, site, params.sample_m);
        let n_samples = points.len();
        let hits = points.iter().filter_map(|p| patch.project(p, reach_m));
        let hits: Vec<PatchPoint> = hits.collect();
        let n_lost = n_samples - hits.len();
        check_lost(site, n_lost, n_samples, params)?;
        let mut rows = BTreeMap::new();
        let weight = 1.0 / hits.len() as f64;
        for hit in &hits {
            let element = strain_at(mesh, kind, material, hit)?;
            add_sample(mesh, hit, &element, &along, z_m, weight, &mut rows)?;
        }
        let weight = |(node, (per_metre, per_radian))| NodeWeight {
            node,
            per_metre,
            per_radian: Some(per_radian),
        };
        let functional = LinearFunctional::new(rows.into_iter().map(weight).collect(), STRAIN);
        Ok(Self { functional, normal: patch.normal, axis: along, n_samples, n_lost, distance_m })
    }

    /// The reading for a motion of the mesh: strain, positive in tension.
    ///
    /// # Panics
    /// If `motion` is not of a shell of as many nodes.
    #[must_use]
    pub fn strain(&self, motion: &Motion) -> f64 {
        self.functional.reading(&motion.displacement, &motion.rotation)
    }

    /// The right-hand side of the gauge's adjoint problem: its solution at a node is the reading per
    /// newton there, in each direction (Betti–Maxwell reciprocity).
    #[must_use]
    pub fn as_load(&self) -> NodalLoad {
        self.functional.as_load()
    }

    /// The gauge as nodes and weights, nodes ascending; strain per metre and per radian.
    #[must_use]
    pub fn functional(&self) -> &LinearFunctional {
        &self.functional
    }

    /// The wall's unit normal at the gauge's centre.
    #[must_use]
    pub fn normal(&self) -> Vector3<f64> {
        self.normal
    }

    /// The measuring direction in the tangent plane at the centre, of unit length.
    #[must_use]
    pub fn axis(&self) -> Vector3<f64> {
        self.axis
    }

    /// The share of sample points that miss the wall; the reading is the mean over the others.
    #[must_use]
    pub fn lost_share(&self) -> f64 {
        self.n_lost as f64 / self.n_samples as f64
    }

    /// Distance from the site's position to the mid-surface, m.
    #[must_use]
    pub fn distance_to_mid_surface_m(&self) -> f64 {
        self.distance_m
    }
}

impl AsRef<LinearFunctional> for ShellGaugeStrain {
    fn as_ref(&self) -> &LinearFunctional {
        &self.functional
    }
}

fn patch_under(
    mesh: &ShellMesh,
    centre: &Point3<f64>,
    reach_m: f64,
    z_m: f64,
    params: &GaugeParams,
) -> Result<(ShellPatch, f64), SimError> {
    let max_distance_m = params.max_distance_m + z_m.abs();
    let off_wall = |distance_m| SimError::GaugeOffWall {
        centre_m: centre.coords.into(),
        distance_m,
        max_distance_m,
    };
    let (patch, distance_m) =
        ShellPatch::at(mesh, centre, reach_m).ok_or(off_wall(f64::INFINITY))?;
    if distance_m <= max_distance_m { Ok((patch, distance_m)) } else { Err(off_wall(distance_m)) }
}

fn strain_at(
    mesh: &ShellMesh,
    kind: ShellKind,
    material: &IsotropicMaterial,
    hit: &PatchPoint,
) -> Result<ShellStrain, SimError> {
    let element = hit.triangle;
    ShellStrain::new(
        kind,
        &mesh.corners(element),
        Some(&mesh.directors()[element]),
        &mesh.corner_thickness_m(element),
        material,
        &hit.at,
    )
    .map_err(|problem| SimError::ShellElement { element, problem })
}

/// Adds weight · aᵀ ε a at one sample point, a the axis laid into its facet.
fn add_sample(
    mesh: &ShellMesh,
    hit: &PatchPoint,
    strain: &ShellStrain,
    axis: &Vector3<f64>,
    z_m: f64,
    weight: f64,
    rows: &mut BTreeMap<FeNodeId, (Vector3<f64>, Vector3<f64>)>,
) -> Result<(), SimError> {
    let normal = strain.axes()[2];
    let a = unit("the gauge's axis", &(axis - normal * axis.dot(&normal)))?;
    let row = strain.along(&a, z_m);
    for (node, values) in mesh.triangles()[hit.triangle].iter().zip(row.chunks_exact(6)) {
        let entry = rows.entry(*node).or_default();
        entry.0 += Vector3::from_column_slice(&values[..3]) * weight;
        entry.1 += Vector3::from_column_slice(&values[3..]) * weight;
    }
    Ok(())
}
