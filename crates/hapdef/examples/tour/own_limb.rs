//! A limb of your own: a glTF surface, a shell behind it, gauges on its inner side.

use std::path::Path;
use std::sync::Arc;

use anyhow::{Context, Result};
use hapdef::shell_limb::{ShellLimb, ShellLimbParams, WallChoice, shell_limb};
use hapdef_inverse::{
    ContactEstimator, EstimatorParams, NoiseParams, ResponseMap, ResponseParams, ScanSites, Skin,
    SkinFaces, SkinParams, SkinPoint,
};
use hapdef_mesh::{GaugeId, GltfParams, read_gltf};
use hapdef_sim::IsotropicMaterial;
use nalgebra::Vector3;

use super::scene::fixture;

/// What a limb came to.
pub struct OwnLimb {
    pub n_nodes: usize,
    pub n_gauges: usize,
    /// Half of the nodes have a gauge that reads at least this for a newton, µε.
    pub median_best_ue: f64,
    /// Distance of a contact that was found from where 10 N press, mm.
    pub miss_mm: f64,
}

/// Reads a surface in metres, the bundled one without a file, and gives it a wall of PA2200.
pub fn own_limb(file: Option<&Path>, wall_mm: f64) -> Result<OwnLimb> {
    let bundled = fixture("shin_skin.glb");
    let surface = read_gltf(file.unwrap_or(&bundled), &GltfParams::default())?;
    let material = IsotropicMaterial::new(1.7e9, 0.394, 930.0)?;
    let params = ShellLimbParams::new(WallChoice::Constant(wall_mm * 1e-3), material);
    let limb = shell_limb(&surface.mesh, &params)?;
    let map = Arc::new(response(&limb)?);
    let skin = map.skin();
    let point = SkinPoint::new(skin, skin.n_faces() / 2, [0.5, 0.3, 0.2])?;
    let readings_ue: Vec<f64> = map.normal(&point).iter().map(|g| g * 10.0).collect();
    let sites = Arc::new(ScanSites::farthest(skin, 800)?);
    let noise = NoiseParams::uniform(map.n_gauges(), 1.0);
    let estimator = ContactEstimator::new(map.clone(), sites, noise, EstimatorParams::default())?;
    let estimate = estimator.estimate(&readings_ue)?;
    let found = estimate.contacts.first().context("nothing was found")?;
    Ok(OwnLimb {
        n_nodes: skin.n_nodes(),
        n_gauges: map.n_gauges(),
        median_best_ue: limb.info.median_best_ue_per_n,
        miss_mm: (found.position_m - skin.position(&point)).norm() * 1e3,
    })
}

/// What the gauges read for a newton anywhere on the skin, µε/N.
fn response(limb: &ShellLimb) -> Result<ResponseMap> {
    let n_gauges = limb.gauges.len();
    let field = |gauge| limb.response.field(GaugeId::from_index(gauge));
    let at = |node: usize| (0..n_gauges).map(move |gauge| field(gauge)[node] * 1e6);
    let nodes = limb.skin.vertices();
    let adjoint: Vec<Vector3<f64>> = (0..nodes.len()).flat_map(at).collect();
    let faces = SkinFaces::Linear(limb.skin.triangles());
    let params = SkinParams::default();
    let skin = Skin::new(nodes.to_vec(), faces, Some(&limb.normals), &params)?;
    let params = ResponseParams::default();
    Ok(ResponseMap::from_nodal(skin, n_gauges, &adjoint, &params)?)
}

#[test]
fn the_bundled_skin_comes_to_its_figures() {
    let limb = own_limb(None, 1.0).unwrap();
    assert_eq!(limb.n_gauges, 10);
    // As it was when this was written.
    assert!((limb.median_best_ue / 34.48 - 1.0).abs() < 1e-2, "{}", limb.median_best_ue);
    assert!(limb.miss_mm < 0.05, "{} mm", limb.miss_mm);
}
