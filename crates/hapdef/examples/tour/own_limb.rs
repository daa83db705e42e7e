//! A limb of your own: a glTF surface, a shell behind it, gauges on its inner side.

use std::path::Path;
use std::sync::Arc;

use anyhow::{Context, Result};
use hapdef::shell_limb::{ShellLimb, ShellLimbParams, WallChoice};
use hapdef_inverse::{ContactEstimator, EstimatorParams, NoiseParams, ScanSites, SkinPoint};
use hapdef_mesh::LengthUnit;

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
    let params = ShellLimbParams::new(WallChoice::Constant(wall_mm * 1e-3));
    let limb = ShellLimb::read(file.unwrap_or(&bundled), LengthUnit::Metre, &params)?;
    let map = Arc::new(limb.response()?);
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

#[test]
fn the_bundled_skin_comes_to_its_figures() {
    let limb = own_limb(None, 1.0).unwrap();
    assert_eq!(limb.n_gauges, 10);
    // As it was when this was written.
    assert!((limb.median_best_ue / 29.13 - 1.0).abs() < 1e-2, "{}", limb.median_best_ue);
    assert!(limb.miss_mm < 0.05, "{} mm", limb.miss_mm);
}
