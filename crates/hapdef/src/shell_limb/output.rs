//! The files that `hapdef shell` writes.

use std::path::Path;

use hapdef_data::{DatasetWriter, TensorSpec};
use hapdef_mesh::{
    SolidShellParams, SurfaceMesh, VertexField, clean_surface, measure_solid, write_glb,
};
use serde_json::{Value, json};

use super::{ShellComparison, ShellLimb, ShellLimbParams, WallChoice};
use crate::cache::write_json;
use crate::error::HapdefError;

impl ShellLimb {
    /// Everything that was found, with the comparisons.
    #[must_use]
    pub fn report(&self, comparisons: &[ShellComparison]) -> Value {
        json!({ "limb": self.info, "comparisons": comparisons })
    }

    /// Writes into `folder`: `response.json`; `response.glb`, the skin coloured by the strongest
    /// reading; `response.safetensors`, all readings `[n_nodes, n_gauges]`; `thickness.glb` where
    /// the wall was measured; `shell_vs_solid.glb`, numbered from the second on, a comparison's
    /// difference of readings.
    ///
    /// # Errors
    /// [`HapdefError::File`], [`HapdefError::Mesh`] and [`HapdefError::Data`] when the disk refuses.
    pub fn write(&self, folder: &Path, comparisons: &[ShellComparison]) -> Result<(), HapdefError> {
        std::fs::create_dir_all(folder).map_err(HapdefError::file(folder))?;
        let paint = |file: &str, mesh: &SurfaceMesh, name: &str, values: &[f64]| {
            let range = None;
            let field = VertexField { name, values, range };
            write_glb(&folder.join(file), mesh, Some(&field))
        };
        let best = self.best_ue_per_n();
        paint("response.glb", &self.skin, "best_reading_ue_per_n", &best)?;
        if self.params.wall == WallChoice::Measured {
            let thickness_m = self.mesh.thickness_m();
            paint("thickness.glb", &self.skin, "wall_thickness_m", thickness_m)?;
        }
        for (i, comparison) in comparisons.iter().enumerate() {
            let file = match i {
                0 => "shell_vs_solid.glb".to_owned(),
                _ => format!("shell_vs_solid_{}.glb", i + 1),
            };
            let values = &comparison.reading_difference;
            paint(&file, &comparison.skin, "reading_difference", values)?;
        }
        self.write_readings(&folder.join("response.safetensors"))?;
        write_json(&folder.join("response.json"), &self.report(comparisons))
    }

    fn write_readings(&self, path: &Path) -> Result<(), HapdefError> {
        let name = "reading_ue_per_n";
        let spec = TensorSpec::f32(name, self.gauges.len(), "ue/N");
        let mut writer = DatasetWriter::create(path, self.normals.len(), &[spec])?;
        let rounded = self.readings_ue_per_n().into_iter().map(|r| r as f32);
        writer.append(name, &rounded.collect::<Vec<_>>())?;
        writer.finish()?;
        Ok(())
    }
}

/// The picture of a solid that was refused: writes the outer skin, coloured by the wall's thickness
/// as far as there is one, to `path`, and says whether there was any.
///
/// # Errors
/// [`HapdefError::Mesh`] and [`HapdefError::File`] when the disk refuses.
pub fn write_measured_wall(
    given: &SurfaceMesh,
    params: &ShellLimbParams,
    path: &Path,
) -> Result<bool, HapdefError> {
    let (cleaned, _) = clean_surface(given, &params.clean)?;
    let Ok(found) = measure_solid(&cleaned, &SolidShellParams::default()) else {
        return Ok(false);
    };
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(HapdefError::file(folder))?;
    }
    let field = VertexField { name: "wall_thickness_m", values: &found.thickness_m, range: None };
    write_glb(path, &found.skin, Some(&field))?;
    Ok(true)
}
