//! The folder of a new limb: skin, wall and scene, its gauges placed.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use hapdef_mesh::{DeckParams, atomic_write, deck_includes, write_glb};
use serde_json::{Value, json};

use super::given::GivenShape;
use super::guess::to_micrometres;
use super::skin::Skin;
use super::text::scene_text;
use super::{NewLimb, gauges};
use crate::error::HapdefError;
use crate::limb::Limb;
use crate::profile::Profile;
use crate::progress::Progress;
use crate::run::Run;
use crate::scene::{MaterialSpec, Scene, WallSolver};
use crate::touch::gauge_entries;

const SCENE: &str = "scene.json";
const SKIN: &str = "skin.glb";
const WALL: &str = "wall.txt";

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
            let what = "it is there already: name another one by --folder, or make a limb's folder anew by \
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
                let skin = Skin::of(given, self.wall_m, self.params.edge_m, threads)?;
                write_glb(&folder.join(SKIN), &skin.surface, None)?;
                let wall = self.wall(&skin, folder)?;
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

    /// The wall as a scene has it: one thickness, or the file with those of all vertices.
    fn wall(&self, skin: &Skin, folder: &Path) -> Result<Value, HapdefError> {
        if skin.wall_m.iter().all(|wall_m| *wall_m == self.wall_m) {
            return Ok(json!(self.wall_m));
        }
        let mut text = String::new();
        for wall_m in &skin.wall_m {
            let _ = writeln!(text, "{wall_m:.7}");
        }
        write_text(&folder.join(WALL), &text)?;
        Ok(json!(WALL))
    }

    fn lacks_material(&self) -> bool {
        match &self.given.shape {
            GivenShape::Surface(_) => false,
            GivenShape::Deck(deck, _) => deck.material.is_none_or(|m| m.density_kg_m3.is_none()),
        }
    }
}

fn write_text(path: &Path, text: &str) -> Result<(), HapdefError> {
    atomic_write(path, |file| std::io::Write::write_all(file, text.as_bytes()))
        .map_err(HapdefError::file(path))
}
