//! Strain gauges as linear functionals of the displacement.

use std::collections::BTreeMap;

use hapdef_mesh::{FeNodeId, Tet10Mesh, Tri6Face};
use nalgebra::{Point3, Vector3};

use super::{LinearFunctional, NodeWeight};
use crate::elements::tet10::space_gradients;
use crate::gauges::wall::{Wall, WallPoint};
use crate::loads::nodal::check_node;
use crate::loads::patch::unit;
use crate::{NodalLoad, SimError};

/// Where a strain gauge is glued, and how large its grid is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaugeSite {
    /// The centre of the footprint, m; moved to the nearest point of the wall.
    pub position: Point3<f64>,
    /// The measuring direction, of any length; its part in the wall's tangent plane counts.
    pub axis: Vector3<f64>,
    /// Extent along the axis, m.
    pub length_m: f64,
    /// Extent across the axis, m.
    pub width_m: f64,
}

/// How a gauge's footprint is sampled and what is refused.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaugeParams {
    /// Side of the square that one sample point stands for, m.
    pub sample_m: f64,
    /// The share of sample points that may miss the wall.
    pub max_lost_share: f64,
    /// The distance allowed from the site's position to the wall, m.
    pub max_distance_m: f64,
}

impl Default for GaugeParams {
    /// One sample per square millimetre (8 × 5 on the usual gauge), a tenth lost at most, and 2 mm
    /// to the wall.
    fn default() -> Self {
        Self { sample_m: 1e-3, max_lost_share: 0.1, max_distance_m: 2e-3 }
    }
}

/// The unit of a strain.
pub(crate) const STRAIN: &str = "m/m";

/// A gauge's reading as a linear functional: strain = Σ rowᵢ · uᵢ.
///
/// The reading is the mean over the footprint of aᵀ ε a, with a the axis in the local tangent
/// plane and ε = ½(∇u + ∇uᵀ) at the wall's surface in the element behind it.
#[derive(Clone, Debug, PartialEq)]
pub struct GaugeStrain {
    functional: LinearFunctional,
    normal: Vector3<f64>,
    axis: Vector3<f64>,
    n_samples: usize,
    n_lost: usize,
    distance_m: f64,
}

impl GaugeStrain {
    /// The gauge at `site` on the wall made of `wall_faces` (the whole boundary will do), with
    /// [`GaugeParams::default`].
    ///
    /// # Errors
    /// As [`Self::with_params`].
    pub fn new(
        mesh: &Tet10Mesh,
        wall_faces: &[Tri6Face],
        site: &GaugeSite,
    ) -> Result<Self, SimError> {
        Self::with_params(mesh, wall_faces, site, &GaugeParams::default())
    }

    /// The gauge at `site`.
    ///
    /// The footprint is a rectangle in the tangent plane at the wall point nearest to the site,
    /// projected along the normal there onto the connected wall: holes and rims lose samples, the
    /// other side of a thin wall is never met.
    ///
    /// # Errors
    /// [`SimError::GaugeOffWall`], [`SimError::GaugeOverhang`]; [`SimError::Parameter`] and
    /// [`SimError::Direction`] on unusable sizes or an axis along the normal;
    /// [`SimError::NodeOutOfRange`] and [`SimError::FaceOfOtherElement`] on foreign faces.
    pub fn with_params(
        mesh: &Tet10Mesh,
        wall_faces: &[Tri6Face],
        site: &GaugeSite,
        params: &GaugeParams,
    ) -> Result<Self, SimError> {
        check_site(site, params)?;
        check_faces(mesh, wall_faces)?;
        let reach_m = site.length_m.hypot(site.width_m);
        let (wall, distance_m) = wall_under(mesh, wall_faces, site, params, reach_m)?;
        let [along, across] = axes(site, &wall.normal)?;
        let points = footprint(&wall.origin, &along, &across, site, params.sample_m);
        let n_samples = points.len();
        let hits: Vec<WallPoint> =
            points.iter().filter_map(|point| wall.project(point, reach_m)).collect();
        let n_lost = n_samples - hits.len();
        check_lost(site, n_lost, n_samples, params)?;
        let weight = 1.0 / hits.len() as f64;
        let mut rows = BTreeMap::new();
        for hit in &hits {
            add_sample(mesh, hit, &along, weight, &mut rows)?;
        }
        let weight = |(node, per_metre)| NodeWeight { node, per_metre, per_radian: None };
        let functional = LinearFunctional::new(rows.into_iter().map(weight).collect(), STRAIN);
        Ok(Self { functional, normal: wall.normal, axis: along, n_samples, n_lost, distance_m })
    }

    /// The reading for `displacement` `[n_fe_nodes]`, m: strain, positive in tension.
    ///
    /// # Panics
    /// If `displacement` is shorter than the mesh the gauge was made on.
    #[must_use]
    pub fn strain(&self, displacement: &[Vector3<f64>]) -> f64 {
        self.functional.reading(displacement, &[])
    }

    /// The right-hand side of the gauge's adjoint problem: its solution at a node is the reading per
    /// newton there, in each direction (Betti–Maxwell reciprocity).
    #[must_use]
    pub fn as_load(&self) -> NodalLoad {
        self.functional.as_load()
    }

    /// The gauge as nodes and weights, nodes ascending; strain per metre, 1/m.
    #[must_use]
    pub fn functional(&self) -> &LinearFunctional {
        &self.functional
    }

    /// The wall's outward unit normal at the gauge's centre.
    #[must_use]
    pub fn normal(&self) -> Vector3<f64> {
        self.normal
    }

    /// The measuring direction in the tangent plane at the centre, of unit length.
    #[must_use]
    pub fn axis(&self) -> Vector3<f64> {
        self.axis
    }

    /// Sample points of the footprint.
    #[must_use]
    pub fn n_samples(&self) -> usize {
        self.n_samples
    }

    /// The share of sample points that miss the wall; the reading is the mean over the others.
    #[must_use]
    pub fn lost_share(&self) -> f64 {
        self.n_lost as f64 / self.n_samples as f64
    }

    /// Distance from the site's position to the wall, m.
    #[must_use]
    pub fn distance_to_wall_m(&self) -> f64 {
        self.distance_m
    }
}

impl AsRef<LinearFunctional> for GaugeStrain {
    fn as_ref(&self) -> &LinearFunctional {
        &self.functional
    }
}

pub(crate) fn check_site(site: &GaugeSite, params: &GaugeParams) -> Result<(), SimError> {
    for (what, value) in [
        ("the gauge's length (m)", site.length_m),
        ("the gauge's width (m)", site.width_m),
        ("the gauge's sample side (m)", params.sample_m),
    ] {
        if !(value.is_finite() && value > 0.0) {
            return Err(SimError::Parameter { what, value, expected: "finite and positive" });
        }
    }
    match site.position.iter().find(|c| !c.is_finite()) {
        Some(&value) => Err(SimError::Parameter {
            what: "a coordinate of the gauge (m)",
            value,
            expected: "finite",
        }),
        None => Ok(()),
    }
}

fn check_faces(mesh: &Tet10Mesh, faces: &[Tri6Face]) -> Result<(), SimError> {
    for face in faces {
        for &node in &face.nodes {
            check_node("a wall face", node, mesh.nodes().len())?;
        }
        corners_in_element(mesh, face)?;
    }
    Ok(())
}

fn wall_under(
    mesh: &Tet10Mesh,
    wall_faces: &[Tri6Face],
    site: &GaugeSite,
    params: &GaugeParams,
    reach_m: f64,
) -> Result<(Wall, f64), SimError> {
    let off_wall = |distance_m| SimError::GaugeOffWall {
        centre_m: site.position.coords.into(),
        distance_m,
        max_distance_m: params.max_distance_m,
    };
    let (wall, distance_m) =
        Wall::at(mesh, wall_faces, &site.position, reach_m).ok_or(off_wall(f64::INFINITY))?;
    if distance_m <= params.max_distance_m {
        Ok((wall, distance_m))
    } else {
        Err(off_wall(distance_m))
    }
}

/// Unit vectors along and across the gauge in the tangent plane.
pub(crate) fn axes(site: &GaugeSite, normal: &Vector3<f64>) -> Result<[Vector3<f64>; 2], SimError> {
    let axis = unit("the gauge's axis", &site.axis)?;
    let tangent = axis - normal * axis.dot(normal);
    if tangent.norm() < 0.1 {
        let what = "the gauge's axis, which lies along the wall's normal there,";
        return Err(SimError::Direction { what, value: site.axis.into() });
    }
    let along = tangent / tangent.norm();
    Ok([along, normal.cross(&along)])
}

/// The centres of a grid of cells over the rectangle.
pub(crate) fn footprint(
    origin: &Point3<f64>,
    along: &Vector3<f64>,
    across: &Vector3<f64>,
    site: &GaugeSite,
    sample_m: f64,
) -> Vec<Point3<f64>> {
    let cells = |extent_m: f64| (extent_m / sample_m).round().max(1.0) as usize;
    let (n, m) = (cells(site.length_m), cells(site.width_m));
    let centre = |i: usize, n: usize, extent_m: f64| ((i as f64 + 0.5) / n as f64 - 0.5) * extent_m;
    (0..n * m)
        .map(|i| {
            origin
                + along * centre(i / m, n, site.length_m)
                + across * centre(i % m, m, site.width_m)
        })
        .collect()
}

pub(crate) fn check_lost(
    site: &GaugeSite,
    n_lost: usize,
    n_samples: usize,
    params: &GaugeParams,
) -> Result<(), SimError> {
    let lost_share = n_lost as f64 / n_samples as f64;
    if lost_share <= params.max_lost_share && n_lost < n_samples {
        return Ok(());
    }
    Err(SimError::GaugeOverhang {
        centre_m: site.position.coords.into(),
        n_lost,
        n_samples,
        lost_share,
        max_lost_share: params.max_lost_share,
    })
}

/// Adds weight · aᵀ ε a at one wall point: aᵀ ∇u a = Σ (∇Nᵢ · a)(uᵢ · a).
fn add_sample(
    mesh: &Tet10Mesh,
    hit: &WallPoint,
    axis: &Vector3<f64>,
    weight: f64,
    rows: &mut BTreeMap<FeNodeId, Vector3<f64>>,
) -> Result<(), SimError> {
    let corners = corners_in_element(mesh, &hit.face)?;
    let mut volume = [0.0; 4];
    for (corner, share) in corners.into_iter().zip([1.0 - hit.xi - hit.eta, hit.xi, hit.eta]) {
        volume[corner] = share;
    }
    let parent = [volume[1], volume[2], volume[3]];
    let (_, gradients) = space_gradients(&mesh.element_positions(hit.face.element), parent);
    let a = unit("the gauge's axis", &(axis - hit.normal * axis.dot(&hit.normal)))?;
    for (node, gradient) in mesh.elements()[hit.face.element].iter().zip(gradients) {
        *rows.entry(*node).or_insert_with(Vector3::zeros) += a * (weight * gradient.dot(&a));
    }
    Ok(())
}

/// Which of its element's corners the face's three corners are.
fn corners_in_element(mesh: &Tet10Mesh, face: &Tri6Face) -> Result<[usize; 3], SimError> {
    let foreign = || SimError::FaceOfOtherElement {
        element: face.element,
        corners: [0, 1, 2].map(|i| face.nodes[i].index()),
    };
    let nodes = mesh.elements().get(face.element).ok_or_else(foreign)?;
    let place = |i: usize| nodes[..4].iter().position(|n| *n == face.nodes[i]).ok_or_else(foreign);
    Ok([place(0)?, place(1)?, place(2)?])
}
