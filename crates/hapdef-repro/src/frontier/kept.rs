//! Points that were measured, kept for the next run as long as they are comparable with its own.

use std::path::Path;

use anyhow::{Context, Result};
use hapdef::Run;
use hapdef::scene::RigMesh;
use hapdef_report::MetricContext;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};

use super::{ChainFrontierArgs, VERSION};
use crate::run::kept::kept;

/// What a point rests on besides its configuration. A point of any other origin is measured again: its errors may
/// be another program's, its times another machine's.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Origin {
    /// Hash of this program's own file, which changes with its code and that of every crate in it.
    program: String,
    machine: String,
    n_threads: usize,
    scene_hash: String,
    deck_hash: String,
    /// Hash of the rig's own deck, if it has one.
    rig_deck_hash: Option<String>,
    n_frames: usize,
    test_seed: u64,
}

impl Origin {
    /// That of points measured now.
    pub(super) fn here(args: &ChainFrontierArgs, run: &Run, deck_hash: &str) -> Result<Self> {
        let program = std::env::current_exe().context("the program's own path")?;
        let rig_deck_hash = match &run.scene.rig.mesh {
            RigMesh::Refined { .. } => None,
            RigMesh::Deck { solid_deck, .. } => Some(hash_of(&run.scene_dir.join(solid_deck))?),
        };
        Ok(Self {
            program: hash_of(&program)?,
            machine: MetricContext::here(args.test_seed).machine,
            n_threads: run.threads,
            scene_hash: run.scene_hash.clone(),
            deck_hash: deck_hash.to_owned(),
            rig_deck_hash,
            n_frames: args.frames.get(),
            test_seed: args.test_seed,
        })
    }

    /// From the run's cache, or measured and put there; and whether it was there. `what` tells a point
    /// from the others.
    pub(super) fn kept<T: Serialize + DeserializeOwned>(
        &self,
        run: &Run,
        what: &Value,
        measure: impl FnOnce() -> Result<T>,
    ) -> Result<(T, bool)> {
        let (value, stage) = kept(run, "frontier-point", &self.inputs(what), |_| measure())?;
        Ok((value, stage.cached))
    }

    fn inputs(&self, what: &Value) -> Value {
        json!({ "version": VERSION, "origin": self, "what": what })
    }
}

fn hash_of(path: &Path) -> Result<String> {
    let bytes = std::fs::read(path).with_context(|| path.display().to_string())?;
    Ok(blake3::hash(&bytes).to_hex().to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn origin() -> Origin {
        Origin {
            program: "a".into(),
            machine: "two cores".into(),
            n_threads: 2,
            scene_hash: "s".into(),
            deck_hash: "d".into(),
            rig_deck_hash: None,
            n_frames: 200,
            test_seed: 1,
        }
    }

    #[test]
    fn a_point_of_other_code_machine_or_threads_is_measured_again() {
        let changes: [fn(&mut Origin); 7] = [
            |o| o.program = "b".into(),
            |o| o.machine = "four cores".into(),
            |o| o.n_threads = 1,
            |o| o.scene_hash = "t".into(),
            |o| o.rig_deck_hash = Some("r".into()),
            |o| o.n_frames = 20,
            |o| o.test_seed = 2,
        ];
        let what = json!("a configuration");
        let own = origin().inputs(&what);
        assert_eq!(own, origin().inputs(&what));
        assert_ne!(own, origin().inputs(&json!("another configuration")));
        for (i, change) in changes.iter().enumerate() {
            let mut other = origin();
            change(&mut other);
            assert_ne!(own, other.inputs(&what), "change {i}");
        }
    }

    #[test]
    fn the_programs_own_file_has_a_hash() {
        let own = hash_of(&std::env::current_exe().unwrap()).unwrap();
        assert_eq!(own.len(), 64);
        assert!(hash_of(Path::new("not there")).is_err());
    }
}
