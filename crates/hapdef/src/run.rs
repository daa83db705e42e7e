//! One run over a scene: the scene, how much to make, where results go, how to stop.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::cache::Cache;
use crate::error::HapdefError;
use crate::profile::Profile;
use crate::progress::Progress;
use crate::scene::{Scene, read_scene, scene_file};
use crate::solid::geometry_hash;

/// What every stage is given.
#[derive(Clone)]
pub struct Run {
    /// The scene.
    pub scene: Scene,
    /// Folder of the scene file; its paths are relative to it.
    pub scene_dir: PathBuf,
    /// Hash of the scene as it is run, overrides included.
    pub scene_hash: String,
    /// Amounts of data and training.
    pub profile: Profile,
    /// Finished stages.
    pub cache: Cache,
    /// Threads of solves and matrix products. Results don't depend on it.
    pub threads: usize,
    /// Where progress is shown.
    pub progress: Progress,
    /// Set when the person wants to stop.
    pub stop: Arc<AtomicBool>,
}

impl Run {
    /// Reads the scene and prepares a run whose results go under `out`.
    ///
    /// # Errors
    /// [`HapdefError::Scene`] when the scene is refused.
    pub fn new(
        scene_path: &Path,
        profile: Profile,
        out: &Path,
        threads: usize,
        progress: Progress,
    ) -> Result<Self, HapdefError> {
        let scene_path = scene_file(scene_path);
        let scene = read_scene(&scene_path)?;
        let scene_dir = scene_path.parent().unwrap_or(Path::new("."));
        Self::of_scene(scene, scene_dir, profile, out, threads, progress)
    }

    /// Prepares a run of a scene whose paths are relative to `scene_dir`.
    ///
    /// # Errors
    /// [`HapdefError::File`] when the scene can't be written as JSON.
    pub fn of_scene(
        scene: Scene,
        scene_dir: &Path,
        profile: Profile,
        out: &Path,
        threads: usize,
        progress: Progress,
    ) -> Result<Self, HapdefError> {
        Ok(Self {
            scene_hash: hash_of(&scene)?,
            scene,
            scene_dir: scene_dir.to_path_buf(),
            profile,
            cache: Cache::new(out.join("cache")),
            threads,
            progress,
            stop: Arc::new(AtomicBool::new(false)),
        })
    }

    /// Replaces the seed of the training side.
    ///
    /// # Errors
    /// [`HapdefError::File`] when the scene can't be written as JSON.
    pub fn set_seed(&mut self, seed: u64) -> Result<(), HapdefError> {
        self.scene.seed = seed;
        self.scene_hash = hash_of(&self.scene)?;
        Ok(())
    }

    /// Replaces the scene; its folder stays.
    ///
    /// # Errors
    /// [`HapdefError::File`] when the scene can't be written as JSON.
    pub fn set_scene(&mut self, scene: Scene) -> Result<(), HapdefError> {
        self.scene_hash = hash_of(&scene)?;
        self.scene = scene;
        Ok(())
    }

    /// Hashes of what goes in: the scene as it is run, and the bytes of its deck or skin.
    ///
    /// # Errors
    /// [`HapdefError::NoDeck`] when that can't be read.
    pub fn input_hashes(&self) -> Result<[(&'static str, String); 2], HapdefError> {
        let shape = geometry_hash(&self.scene.geometry, &self.scene_dir)?;
        Ok([("scene", self.scene_hash.clone()), ("deck", shape)])
    }

    /// Tells the person what happens now.
    pub fn say(&self, text: &str) {
        self.progress.say(text);
    }

    /// Ends the run before `stage` when the person wants to stop.
    ///
    /// # Errors
    /// [`HapdefError::Stopped`] then.
    pub fn check_stop(&self, stage: &str) -> Result<(), HapdefError> {
        if self.stopping() {
            return Err(HapdefError::Stopped { stage: stage.into() });
        }
        Ok(())
    }

    /// Whether the person wants to stop.
    #[must_use]
    pub fn stopping(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

fn hash_of(scene: &Scene) -> Result<String, HapdefError> {
    let json = serde_json::to_vec(scene).map_err(|e| HapdefError::file("scene")(e.into()))?;
    Ok(blake3::hash(&json).to_hex().to_string())
}
