//! What a scene's runs need, and running them.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use hapdef::scene::Scene;
use hapdef::{Cache, Limb, Profile, Progress, Run};
use pyo3::prelude::*;

use crate::error::{Fault, to_python};
use crate::work::interruptible;

/// A scene, how much to make of it, and where that goes.
#[derive(Clone)]
pub(crate) struct Setup {
    pub scene: Scene,
    pub scene_dir: PathBuf,
    pub profile: Profile,
    pub out: PathBuf,
    pub threads: usize,
    pub is_verbose: bool,
}

impl Setup {
    /// A run over the scene as it is now.
    pub fn run(&self) -> Result<Run, Fault> {
        let mut run = Run {
            scene: self.scene.clone(),
            scene_dir: self.scene_dir.clone(),
            scene_hash: String::new(),
            profile: self.profile.clone(),
            cache: Cache::new(self.out.join("cache")),
            threads: self.threads,
            progress: if self.is_verbose { Progress::lines() } else { Progress::silent() },
            stop: Arc::new(AtomicBool::new(false)),
        };
        run.set_seed(self.scene.seed)?;
        Ok(run)
    }

    /// Does `work` on the limb, without the interpreter's lock, until it is done or Ctrl-C.
    pub fn work<T: Send + 'static>(
        &self,
        py: Python<'_>,
        limb: &Arc<Limb>,
        work: impl FnOnce(&Run, &Limb) -> Result<T, Fault> + Send + 'static,
    ) -> PyResult<T> {
        let run = self.run().map_err(to_python)?;
        let (limb, stop) = (Arc::clone(limb), Arc::clone(&run.stop));
        interruptible(py, self.threads, &stop, move || work(&run, &limb))
    }
}
