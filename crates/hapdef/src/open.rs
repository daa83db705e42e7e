//! A scene that is open: from its file to contacts, one step after another.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use hapdef_inverse::{ContactEstimator, ResponseMap};
use hapdef_live::GivenLoads;
use hapdef_live::estimator::{EstimatorKind, SearchPlace, Superposition, TouchEstimator, Tracking};
use hapdef_rig::live::LiveLimb;

use crate::error::HapdefError;
use crate::limb::Limb;
use crate::profile::Profile;
use crate::progress::Progress;
use crate::run::Run;
use crate::scene::{EstimatorSpec, Scene};
use crate::source::{RigPlay, Source};
use crate::source_args::SourceArg;
use crate::touch::{by_superposition, given_loads, live_estimator, tracker_params};
use crate::virtual_rig::live_limb;

/// A scene, its limb, and where results go.
#[derive(Clone)]
pub struct OpenScene {
    run: Run,
    limb: Arc<Limb>,
}

/// How a scene is opened.
#[derive(Clone, Debug)]
pub struct OpenParams {
    /// Amounts of data and training, where the paper's nets are wanted.
    pub profile: Profile,
    /// Folder of results, the cache in it.
    pub results: PathBuf,
    /// Threads of solves; results don't depend on it.
    pub threads: usize,
    /// Seed of the training side instead of the scene's.
    pub seed: Option<u64>,
    /// Where progress is shown.
    pub progress: Progress,
}

/// A limb whose gauges' response is known: contacts can be found by superposition.
#[derive(Clone)]
pub struct SolvedLimb {
    estimator: ContactEstimator,
    scene: OpenScene,
}

impl Default for OpenParams {
    /// The quick profile, `target/hapdef`, every core, the scene's seed, no progress shown.
    fn default() -> Self {
        Self {
            profile: Profile::quick(),
            results: PathBuf::from("target/hapdef"),
            threads: std::thread::available_parallelism().map_or(1, Into::into),
            seed: None,
            progress: Progress::silent(),
        }
    }
}

impl Scene {
    /// Reads a scene file and the limb that it names, and checks both, with
    /// [`OpenParams::default`].
    ///
    /// # Errors
    /// As [`OpenScene::with_params`].
    pub fn open(path: impl AsRef<Path>) -> Result<OpenScene, HapdefError> {
        OpenScene::with_params(path.as_ref(), OpenParams::default())
    }
}

impl OpenScene {
    /// Reads a scene file and the limb that it names, and checks both.
    ///
    /// # Errors
    /// [`HapdefError::Scene`] when the scene is refused, or what [`Limb::load`] returns.
    pub fn with_params(path: &Path, params: OpenParams) -> Result<Self, HapdefError> {
        let OpenParams { profile, results, threads, seed, progress } = params;
        let mut run = Run::new(path, profile, &results, threads, progress)?;
        if let Some(seed) = seed {
            run.set_seed(seed)?;
        }
        Self::new(run)
    }

    /// The limb of a run's scene.
    ///
    /// # Errors
    /// What [`Limb::load`] returns.
    pub fn new(run: Run) -> Result<Self, HapdefError> {
        let limb = Arc::new(Limb::load(&run.scene, &run.scene_dir)?);
        Ok(Self { run, limb })
    }

    /// The scene with how it is run.
    #[must_use]
    pub fn run(&self) -> &Run {
        &self.run
    }

    /// What the scene file says, with the changes made since.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        &self.run.scene
    }

    /// The limb.
    #[must_use]
    pub fn limb(&self) -> &Limb {
        &self.limb
    }

    /// The same with a flag of its own that stops its work: setting [`Run::stop`] of one leaves
    /// the other alone.
    #[must_use]
    pub fn apart(&self) -> Self {
        let run = Run { stop: Arc::new(AtomicBool::new(false)), ..self.run.clone() };
        Self { run, limb: Arc::clone(&self.limb) }
    }

    /// Another scene in the same folder, its limb read anew.
    ///
    /// # Errors
    /// What [`Limb::load`] returns, and as [`Run::set_scene`].
    pub fn with_scene(&self, scene: Scene) -> Result<Self, HapdefError> {
        let mut run = self.run.clone();
        run.set_scene(scene)?;
        Self::new(run)
    }

    /// The same limb with another section on how contacts are found.
    ///
    /// # Errors
    /// As [`Run::set_scene`].
    pub fn with_estimator(&self, spec: EstimatorSpec) -> Result<Self, HapdefError> {
        let mut run = self.run.clone();
        run.set_scene(Scene { estimator: spec, ..run.scene.clone() })?;
        Ok(Self { run, limb: Arc::clone(&self.limb) })
    }

    /// Solves once for each gauge, or reads the scene's calibration where it names one; with the
    /// default settings of superposition where the scene chooses another estimator.
    ///
    /// # Errors
    /// [`HapdefError::Sim`] when the limb floats or can't be solved, [`HapdefError::Live`] for
    /// settings that can't be used.
    pub fn solve(&self) -> Result<SolvedLimb, HapdefError> {
        let estimator = by_superposition(&self.run, &self.limb)?;
        Ok(SolvedLimb { estimator, scene: self.clone() })
    }

    /// What finds contacts, made with no more than it needs: `kind`, or each frame on its own by
    /// what the scene chooses; full searches of tracking run at `place`.
    ///
    /// # Errors
    /// What the first step that fails returns.
    pub fn estimator(
        &self,
        kind: Option<EstimatorKind>,
        place: SearchPlace,
    ) -> Result<Box<dyn TouchEstimator>, HapdefError> {
        let kind = kind.unwrap_or(self.run.scene.estimator.kind());
        live_estimator(&self.run, &self.limb, kind, place)
    }

    /// The simulated hardware: the perturbed limb, solved once and kept in the cache.
    ///
    /// # Errors
    /// As [`live_limb`].
    pub fn rig(&self) -> Result<LiveLimb, HapdefError> {
        live_limb(&self.run, &self.limb)
    }

    /// What the scene's device measures of loads that are no contacts; none where nothing was learned of it.
    ///
    /// # Errors
    /// [`HapdefError::LearnedLoads`].
    pub fn given_loads(&self) -> Result<GivenLoads, HapdefError> {
        given_loads(&self.run)
    }

    /// A device or a recording, such as `"replay:press.mcap@max".parse()?`.
    ///
    /// # Errors
    /// As [`SourceArg::open`].
    pub fn source(&self, arg: &SourceArg) -> Result<Source, HapdefError> {
        Ok(Source::open(arg, &self.run.scene)?.beside(self.given_loads()?))
    }

    /// The simulated rig, pressed at random, as fast as frames are taken: the same frames every
    /// time.
    ///
    /// # Errors
    /// As [`live_limb`].
    pub fn rig_source(&self, play: &RigPlay) -> Result<Source, HapdefError> {
        Ok(Source::rig(play, &self.run, &self.limb)?.beside(self.given_loads()?))
    }

    /// The same, touched by nothing.
    ///
    /// # Errors
    /// As [`live_limb`].
    pub fn untouched_source(&self, seconds: Option<f64>) -> Result<Source, HapdefError> {
        let source = Source::untouched_rig(seconds, &self.run, &self.limb)?;
        Ok(source.beside(self.given_loads()?))
    }
}

impl SolvedLimb {
    /// What the gauges read for a newton anywhere on the skin, µε/N.
    #[must_use]
    pub fn response(&self) -> &ResponseMap {
        self.estimator.map()
    }

    /// What follows contacts from frame to frame; `place` is where full searches run, see
    /// [`Source::search_place`].
    ///
    /// # Errors
    /// [`HapdefError::Live`] if no thread can be started.
    pub fn tracker(&self, place: SearchPlace) -> Result<Tracking, HapdefError> {
        let params = tracker_params(self.scene.scene());
        Ok(Tracking::new(self.estimator.clone(), params, place)?)
    }

    /// What finds the contacts of each frame on its own.
    #[must_use]
    pub fn estimator(&self) -> Superposition {
        Superposition::new(self.estimator.clone())
    }
}
