//! The outer skin of a double-walled solid, the wall behind it, and the wall's thickness.

use std::collections::BTreeMap;

use nalgebra::{Point3, Vector3};

use crate::skin::rays::{FaceRays, cone};
use crate::{BoundarySurface, MeshError, SkinRegion, Tet10Mesh, Tri6Face, face_positions, tri6};

/// When a boundary face counts as seen from outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OuterSkinParams {
    /// Half angle of the cone of rays about a face's normal, rad.
    pub cone_half_angle_rad: f64,
    /// Rays per face.
    pub n_rays: usize,
    /// A face is taken if more than this part of its rays leaves the limb.
    pub min_free_fraction: f64,
}

impl Default for OuterSkinParams {
    /// 60°, 32 rays, three quarters: on a tube's rim one half of the rays gets away.
    fn default() -> Self {
        Self {
            cone_half_angle_rad: std::f64::consts::FRAC_PI_3,
            n_rays: 32,
            min_free_fraction: 0.75,
        }
    }
}

/// The boundary faces that see the outside: most rays from their centre within a cone about their
/// normal meet no other face. End faces belong to it, the inside of a hollow limb and the rims of
/// its holes don't.
///
/// # Errors
/// [`MeshError::RegionParams`] if a parameter is out of its range; [`MeshError::EmptySkin`] if no
/// face qualifies.
pub fn outer_skin(
    mesh: &Tet10Mesh,
    boundary: &BoundarySurface,
    params: &OuterSkinParams,
) -> Result<SkinRegion, MeshError> {
    let angle_ok = params.cone_half_angle_rad > 0.0
        && params.cone_half_angle_rad < std::f64::consts::FRAC_PI_2;
    if !angle_ok || params.n_rays == 0 || !(0.0..1.0).contains(&params.min_free_fraction) {
        let why = "the cone's half angle must lie between 0 and π/2, there must be rays, and the \
                   free fraction must lie in 0..1";
        return Err(MeshError::RegionParams { why });
    }
    let rays = FaceRays::new(mesh, &boundary.faces);
    let sees_outside = |(i, face): &(usize, &Tri6Face)| {
        let Some((centre, normal)) = centre_and_normal(mesh, face) else {
            return false;
        };
        let free = cone(&normal, params.cone_half_angle_rad, params.n_rays)
            .iter()
            .filter(|direction| rays.first_hit(&centre, direction, *i).is_none())
            .count();
        free as f64 > params.min_free_fraction * params.n_rays as f64
    };
    let faces =
        boundary.faces.iter().enumerate().filter(sees_outside).map(|(_, face)| *face).collect();
    SkinRegion::new(mesh, faces)
}

/// The wall between a skin and the inside of the limb.
#[derive(Clone, Debug, PartialEq)]
pub struct Wall {
    /// The faces on the far side of the wall, in boundary order: a ray from such a face into the
    /// material leaves it through the skin.
    pub inner_faces: Vec<Tri6Face>,
    /// The wall's thickness behind each skin face `[n_skin_faces]`, m: from the face's centre
    /// against its normal to where the material ends; ribs count to the wall.
    pub skin_thickness_m: Vec<f64>,
}

/// The wall behind `skin`: inner faces and thickness.
///
/// Inner faces are those where the material is at most `max_thickness_m` thick, which leaves out
/// the tips of ribs that are higher than that.
///
/// # Errors
/// [`MeshError::WallThickness`] if the limit is not a positive number;
/// [`MeshError::OpenWall`] if a skin face is not one of `boundary`, or the material behind it has
/// no end.
pub fn wall(
    mesh: &Tet10Mesh,
    boundary: &BoundarySurface,
    skin: &SkinRegion,
    max_thickness_m: f64,
) -> Result<Wall, MeshError> {
    if max_thickness_m.is_nan() || max_thickness_m <= 0.0 {
        return Err(MeshError::WallThickness { max_thickness_m });
    }
    let rays = FaceRays::new(mesh, &boundary.faces);
    let places: BTreeMap<&Tri6Face, usize> =
        boundary.faces.iter().enumerate().map(|(i, face)| (face, i)).collect();
    let mut is_skin = vec![false; boundary.faces.len()];
    let mut skin_thickness_m = Vec::with_capacity(skin.faces.len());
    for face in &skin.faces {
        let place = *places.get(face).ok_or(MeshError::OpenWall { element: face.element })?;
        is_skin[place] = true;
        let hit = inward_hit(mesh, &rays, face, place);
        let (_, distance_m) = hit.ok_or(MeshError::OpenWall { element: face.element })?;
        skin_thickness_m.push(distance_m);
    }
    let faces_skin = |(i, face): &(usize, &Tri6Face)| {
        let hit = inward_hit(mesh, &rays, face, *i);
        !is_skin[*i] && hit.is_some_and(|(hit, far)| is_skin[hit] && far <= max_thickness_m)
    };
    let inner_faces =
        boundary.faces.iter().enumerate().filter(faces_skin).map(|(_, face)| *face).collect();
    Ok(Wall { inner_faces, skin_thickness_m })
}

impl Wall {
    /// The thickness behind the skin at fraction `q` of all faces, m: 0.5 is the median, 0.25 and
    /// 0.75 the quartiles; faces count alike, whatever their size. `None` if `q` is not in 0..=1.
    #[must_use]
    pub fn thickness_quantile_m(&self, q: f64) -> Option<f64> {
        if !(0.0..=1.0).contains(&q) {
            return None;
        }
        let mut sorted = self.skin_thickness_m.clone();
        sorted.sort_by(f64::total_cmp);
        let last = sorted.len().checked_sub(1)? as f64;
        let (low, high) = ((q * last).floor(), (q * last).ceil());
        let part = q * last - low;
        Some(sorted[low as usize] * (1.0 - part) + sorted[high as usize] * part)
    }
}

/// The face that a ray from the centre of `face` into the material meets, and how far it is.
fn inward_hit(
    mesh: &Tet10Mesh,
    rays: &FaceRays,
    face: &Tri6Face,
    place: usize,
) -> Option<(usize, f64)> {
    let (centre, normal) = centre_and_normal(mesh, face)?;
    let hit = rays.first_hit(&centre, &-normal, place)?;
    Some((hit.face, hit.distance_m))
}

fn centre_and_normal(mesh: &Tet10Mesh, face: &Tri6Face) -> Option<(Point3<f64>, Vector3<f64>)> {
    let nodes = face_positions(mesh, face);
    let third = 1.0 / 3.0;
    let normal = tri6::area_vector(&nodes, third, third).try_normalize(0.0)?;
    Some((tri6::position(&nodes, third, third), normal))
}
