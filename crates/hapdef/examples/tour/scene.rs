//! The bundled limb with its gauges placed, and the response of its gauges.

use std::path::{Path, PathBuf};

use anyhow::Result;
use hapdef::Limb;
use hapdef::scene::{Scene, read_scene};
use hapdef::touch::{Superposition, response_map, superposition};
use hapdef_inverse::{ResponseMap, SkinPoint};
use nalgebra::Point3;

/// Threads of the solve; results don't depend on it.
const N_THREADS: usize = 2;

/// A scene and what its gauges read for a newton anywhere.
pub struct Placed {
    pub scene: Scene,
    pub map: ResponseMap,
}

impl Placed {
    /// Reads the scene, checks its limb, and solves once for each gauge.
    pub fn load() -> Result<Self> {
        let path = fixture("placed.json");
        let scene = read_scene(&path)?;
        let limb = Limb::load(&scene, path.parent().unwrap_or(Path::new(".")))?;
        let map = response_map(&limb, scene.contact.tip_radius_m, N_THREADS)?;
        Ok(Self { scene, map })
    }

    /// A place on the skin and the readings of a press there, µε.
    pub fn press(&self, face: usize, force_n: f64) -> Result<(Point3<f64>, Vec<f64>)> {
        let skin = self.map.skin();
        let point = SkinPoint::new(skin, face, [0.5, 0.3, 0.2])?;
        let unit = self.map.normal(&point);
        let readings = unit.iter().map(|g| g * force_n).collect();
        Ok((skin.position(&point), readings))
    }

    /// What finds contacts in frames of readings, with the scene's settings.
    pub fn estimator(&self) -> Result<Superposition> {
        let spec = self.scene.estimator.superposition();
        Ok(superposition(&self.scene, &spec, self.map.clone())?)
    }
}

/// A file of the bundled limb.
pub fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/shin").join(name)
}
