//! A wall thin enough to fit.

use super::WrapFault;
use crate::shell::extrude::unfit_triangles;
use crate::{ExtrudeParams, FaceCurve, MeshError, SkinSide, SurfaceMesh};

/// Where the wall folds it becomes this much thinner, until it doesn't.
const THINNER: f64 = 0.7;

/// The wall thickens away from there by at most this much a length.
const SLOPE: f64 = 0.5;

/// The largest share of vertices with a thinner wall.
const MAX_SHARE: f64 = 0.005;

/// Edges sharper than this stay sharp where faces are curved, rad: 40°.
const FEATURE_ANGLE_RAD: f64 = 40.0 * std::f64::consts::PI / 180.0;

/// The wall `wall_m` thick, thinned at the corners of triangles where it would fold or cross, be its faces
/// flat or curved.
pub(super) fn fitting_wall(skin: &SurfaceMesh, wall_m: f64) -> Result<Vec<f64>, MeshError> {
    let curved = FaceCurve::PointNormal { feature_angle_rad: FEATURE_ANGLE_RAD };
    let params = [FaceCurve::Flat, curved].map(|curve| ExtrudeParams {
        side: SkinSide::Outer,
        n_layers: 1,
        curve,
    });
    let n_vertices = skin.vertices().len();
    let max_thinned = (MAX_SHARE * n_vertices as f64) as usize;
    let mut thickness_m = vec![wall_m; n_vertices];
    loop {
        let mut unfit = unfit_triangles(skin, &thickness_m, &params[0])?;
        unfit.extend(unfit_triangles(skin, &thickness_m, &params[1])?);
        let Some(&triangle) = unfit.first() else { return Ok(thickness_m) };
        let mut corners: Vec<u32> = unfit.iter().flat_map(|&t| skin.triangles()[t]).collect();
        corners.sort_unstable();
        corners.dedup();
        corners.iter().for_each(|&v| thickness_m[v as usize] *= THINNER);
        limit_slope(skin, &mut thickness_m);
        let n_thinned = thickness_m.iter().filter(|t| **t < wall_m).count();
        if n_thinned > max_thinned {
            let least_m = thickness_m.iter().copied().fold(wall_m, f64::min);
            let fault =
                WrapFault::Thinned { n_thinned, n_vertices, max_thinned, least_m, triangle };
            return Err(fault.into());
        }
    }
}

/// Thins neighbours until no edge is steeper than [`SLOPE`].
fn limit_slope(skin: &SurfaceMesh, thickness_m: &mut [f64]) {
    let mut is_changed = true;
    while is_changed {
        is_changed = false;
        for corners in skin.triangles() {
            for (a, b) in [(0, 1), (1, 2), (2, 0), (1, 0), (2, 1), (0, 2)] {
                let [a, b] = [corners[a] as usize, corners[b] as usize];
                let rise_m = SLOPE * (skin.vertices()[a] - skin.vertices()[b]).norm();
                if thickness_m[b] > thickness_m[a] + rise_m {
                    thickness_m[b] = thickness_m[a] + rise_m;
                    is_changed = true;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::*;
    use crate::surface::triangles::tests::sphere;

    const WALL_M: f64 = 0.002;
    const RADIUS_M: f64 = 0.02;

    /// A ball with a bump where x is largest; the radius of its tip is the width's square over the height.
    fn with_bump(height_m: f64, width_m: f64) -> SurfaceMesh {
        let ball = sphere(5);
        let raised = ball.vertices().iter().map(|point| {
            let far_m = RADIUS_M * (point - Point3::from([1.0, 0.0, 0.0])).norm();
            point * (RADIUS_M + height_m * (-0.5 * (far_m / width_m).powi(2)).exp())
        });
        SurfaceMesh::new(raised.collect(), ball.triangles().to_vec()).unwrap()
    }

    /// A tip of 0.8 mm radius under a wall of 2 mm.
    #[test]
    fn a_wall_that_would_fold_is_thinned_there_alone() {
        let skin = with_bump(0.005, 0.002);
        let params = ExtrudeParams { side: SkinSide::Outer, n_layers: 1, curve: FaceCurve::Flat };
        let unfit = |wall_m: &[f64]| unfit_triangles(&skin, wall_m, &params).unwrap().len();
        assert!(unfit(&vec![WALL_M; skin.vertices().len()]) > 0);

        let wall_m = fitting_wall(&skin, WALL_M).unwrap();
        assert_eq!(unfit(&wall_m), 0);
        let thinned = skin.vertices().iter().zip(&wall_m).filter(|(_, wall)| **wall < WALL_M);
        let places: Vec<&Point3<f64>> = thinned.map(|(place, _)| place).collect();
        assert!((1..=20).contains(&places.len()), "{places:?}");
        let is_at_tip = |place: &&Point3<f64>| place.y.hypot(place.z) < 0.003 && place.x > 0.0;
        assert!(places.iter().all(is_at_tip), "{places:?}");
    }

    /// A tip of 0.6 mm radius: more than a 200th of the vertices would have to have a thinner wall.
    #[test]
    fn a_wall_that_folds_beyond_that_is_refused_with_numbers() {
        let found = fitting_wall(&with_bump(0.004, 0.0015), WALL_M);
        let Err(MeshError::Wrap(WrapFault::Thinned { n_thinned, max_thinned, .. })) = found else {
            panic!("not refused")
        };
        assert!(n_thinned > max_thinned && max_thinned == 20, "{n_thinned} {max_thinned}");
    }
}
