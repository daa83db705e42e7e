//! The files that `hapdef shell` writes.

use std::path::Path;

use hapdef_data::{DatasetWriter, TensorSpec};
use hapdef_mesh::{
    GltfParams, LengthUnit, SolidShellParams, SurfaceMesh, VertexField, clean_surface,
    measure_solid, read_surface, write_glb,
};
use serde_json::{Value, json};

use super::{ShellComparison, ShellLimb, ShellLimbParams};
use crate::cache::write_json;
use crate::error::HapdefError;
use crate::new_limb::WallChoice;
use crate::scene::Shape;

impl ShellLimb {
    /// Everything that was found, with the comparisons.
    #[must_use]
    pub fn report(&self, comparisons: &[ShellComparison]) -> Value {
        json!({ "limb": self.info, "comparisons": comparisons })
    }

    /// Writes into `folder`: the scene; `response.json`; `response.glb`, the skin coloured by the strongest
    /// reading; `response.safetensors`, all readings `[n_nodes, n_gauges]`; `thickness.glb` where
    /// the wall was measured; of comparisons a page with its figures, and `shell_vs_solid.glb`, numbered from
    /// the second on, the difference of readings, 0 where nothing was compared.
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
        let skin = self.limb.skin.surface(&self.limb.mesh)?;
        paint("response.glb", &skin, "best_reading_ue_per_n", &self.best_ue_per_n())?;
        if self.params.wall == WallChoice::Measured {
            let thickness_m = self.limb.wall.iter().flat_map(|wall| &wall.thickness_m).copied();
            let thickness_m: Vec<f64> = thickness_m.collect();
            paint("thickness.glb", &skin, "wall_thickness_m", &thickness_m)?;
        }
        for (i, comparison) in comparisons.iter().enumerate() {
            let file = match i {
                0 => "shell_vs_solid.glb".to_owned(),
                _ => format!("shell_vs_solid_{}.glb", i + 1),
            };
            let [.., differences] = &comparison.maps.readings;
            let drawn: Vec<f64> =
                differences.iter().map(|d| if d.is_nan() { 0.0 } else { *d }).collect();
            paint(&file, &comparison.skin, "reading_difference", &drawn)?;
        }
        self.write_scene(folder)?;
        self.write_readings(&folder.join("response.safetensors"))?;
        write_json(&folder.join("response.json"), &self.report(comparisons))?;
        if comparisons.is_empty() {
            return Ok(());
        }
        self.write_page(folder, comparisons)
    }

    /// Writes the limb as a scene with its skin and wall into `folder`: `scene.json`, `skin.glb` and, where
    /// the wall is not everywhere the same, `wall.txt`.
    ///
    /// # Errors
    /// As [`Self::write`].
    pub fn write_scene(&self, folder: &Path) -> Result<(), HapdefError> {
        let mut scene = self.scene.clone();
        if let Shape::Skin(skin) = &mut scene.geometry.shape {
            skin.wall = self.skin.write(folder)?;
        }
        write_json(&folder.join("scene.json"), &scene)
    }

    fn write_readings(&self, path: &Path) -> Result<(), HapdefError> {
        let name = "reading_ue_per_n";
        let spec = TensorSpec::f32(name, self.limb.sites.len(), "ue/N");
        let mut writer = DatasetWriter::create(path, self.limb.n_surface_nodes(), &[spec])?;
        let rounded = self.readings_ue_per_n().into_iter().map(|r| r as f32);
        writer.append(name, &rounded.collect::<Vec<_>>())?;
        writer.finish()?;
        Ok(())
    }
}

/// The picture of a solid that was refused: writes the outer skin of the surface file `from`, coloured by the
/// wall's thickness as far as there is one, to `path`, and says whether there was any.
///
/// # Errors
/// [`HapdefError::Mesh`] and [`HapdefError::File`] when the disk refuses.
pub fn write_measured_wall(
    from: &Path,
    unit: LengthUnit,
    params: &ShellLimbParams,
    path: &Path,
) -> Result<bool, HapdefError> {
    let given = read_surface(from, &GltfParams { unit, ..GltfParams::default() })?.mesh;
    let (cleaned, _) = clean_surface(&given, &params.clean)?;
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
