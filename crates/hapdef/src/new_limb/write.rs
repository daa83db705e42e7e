//! The folder of a new limb: skin, wall and scene, its gauges placed.

use std::path::{Path, PathBuf};

use hapdef_mesh::{DeckParams, deck_includes};
use serde_json::{Value, json};

use super::given::GivenShape;
use super::skin::{SKIN, Skin, SkinParams};
use super::text::{scene_text, write_text};
use super::{NewLimb, gauges};
use crate::error::HapdefError;
use crate::limb::Limb;
use crate::profile::Profile;
use crate::progress::Progress;
use crate::run::Run;
use crate::scene::{MaterialSpec, Scene, WallSolver};
use crate::touch::gauge_entries;
use crate::touch::to_micrometres;

const SCENE: &str = "scene.json";

/// What was written.
#[derive(Clone, Debug)]
pub struct NewLimbFiles {
    /// The scene.
    pub scene: PathBuf,
    /// What was made, a sentence each.
    pub said: Vec<String>,
}

impl NewLimb {
    /// Makes the skin and its wall, places the gauges, and writes all into a new `folder`.
    ///
    /// # Errors
    /// [`HapdefError::NewLimb`] for a folder that is there already, unless it is one of a limb and
    /// `replaces`; [`HapdefError::Mesh`] for a surface
    /// that takes no wall; what [`Limb::load`] and [`crate::touch::LayoutCandidates`] refuse.
    pub fn write(
        &self,
        folder: &Path,
        replaces: bool,
        threads: usize,
        progress: Progress,
    ) -> Result<NewLimbFiles, HapdefError> {
        let is_limb = folder.join(SCENE).is_file();
        if folder.exists() && !(replaces && is_limb) {
            let what = "it is there already: name another one by --out, or make a limb's folder anew by \
                        --replace";
            return Err(HapdefError::NewLimb { path: folder.into(), what: what.into() });
        }
        let mut part = folder.as_os_str().to_owned();
        part.push(".part");
        let part = PathBuf::from(part);
        std::fs::create_dir_all(&part).map_err(HapdefError::file(&part))?;
        let made = self.fill(&part, threads, progress);
        let moved = made.and_then(|said| {
            if is_limb {
                std::fs::remove_dir_all(folder).map_err(HapdefError::file(folder))?;
            }
            std::fs::rename(&part, folder).map_err(HapdefError::file(folder))?;
            Ok(NewLimbFiles { scene: folder.join(SCENE), said })
        });
        if moved.is_err() {
            // what is left of a limb that can't be made is of no use
            let _ = std::fs::remove_dir_all(&part);
        }
        moved
    }

    fn fill(
        &self,
        folder: &Path,
        threads: usize,
        progress: Progress,
    ) -> Result<Vec<String>, HapdefError> {
        progress.say("making the skin and its wall");
        let (geometry, mut said) = self.geometry(folder, threads)?;
        let (mount, contact) = (self.mount.clone(), self.contact.clone());
        let mut fields = vec![("geometry", geometry), ("mount", mount), ("contact", contact)];
        if self.lacks_material() {
            fields.insert(1, ("material", json!(MaterialSpec::PA2200)));
        }
        let whole = fields.iter().map(|(name, value)| ((*name).to_owned(), value.clone()));
        let mut whole: serde_json::Map<String, Value> = whole.collect();
        whole.insert("gauges".into(), json!({}));
        whole.insert("name".into(), json!("new"));
        let scene: Scene = serde_json::from_value(Value::Object(whole))
            .map_err(|error| HapdefError::file(folder.join(SCENE))(error.into()))?;
        let run = Run::of_scene(scene, folder, Profile::quick(), folder, threads, progress)?;
        let limb = Limb::load(&run.scene, &run.scene_dir)?;
        said.push(format!(
            "{} tetrahedra, {} nodes, {} of them held",
            limb.mesh.elements().len(),
            limb.mesh.nodes().len(),
            limb.clamped.len()
        ));
        said.extend(limb.wall.iter().map(|wall| format!("solved as {wall}")));
        limb.check_held()?;
        let (placed, how) = gauges::placed(&run, &limb, self.params.n_gauges)?;
        said.push(how);
        let sites: Vec<Value> = gauge_entries(&placed).iter().map(|entry| json!(entry)).collect();
        write_text(&folder.join(SCENE), &scene_text(&fields, &sites))?;
        Ok(said)
    }

    /// Writes the files of the shape; the scene's section on it, and what was done.
    fn geometry(&self, folder: &Path, threads: usize) -> Result<(Value, Vec<String>), HapdefError> {
        let axis = json!({
            "point_m": self.axis.point_m.map(to_micrometres),
            "direction": self.axis.direction.map(to_micrometres),
        });
        match &self.given.shape {
            GivenShape::Surface(given) => {
                let params = SkinParams {
                    is_shell: self.params.solver == WallSolver::Shell,
                    ..SkinParams::repaired(self.wall_m, self.params.edge_m, threads)
                };
                let skin = Skin::of(given, &params)?;
                let wall = skin.write(folder)?;
                let mut geometry = json!({"skin": SKIN, "wall_m": wall, "unit": "m", "axis": axis});
                if self.params.solver != WallSolver::Auto {
                    geometry["solver"] = json!(self.params.solver);
                }
                Ok((geometry, skin.said))
            }
            GivenShape::Deck(deck, unit) => {
                let path = &self.given.path;
                let included = deck_includes(path, DeckParams::default().max_bytes)?;
                for file in std::iter::once(path).chain(&included) {
                    let to = folder.join(file.file_name().unwrap_or_default());
                    std::fs::copy(file, &to).map_err(HapdefError::file(to))?;
                }
                let name = path.file_name().unwrap_or_default().to_string_lossy();
                let geometry = json!({"solid_deck": name, "unit": unit.symbol(), "axis": axis});
                Ok((geometry, deck.notes.clone()))
            }
        }
    }

    fn lacks_material(&self) -> bool {
        match &self.given.shape {
            GivenShape::Surface(_) => false,
            GivenShape::Deck(deck, _) => deck.material.is_none_or(|m| m.density_kg_m3.is_none()),
        }
    }
}
