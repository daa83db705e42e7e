//! A calibration in use that known touches keep up to date: every touch is recorded, and can be undone.

mod declared;
mod journal;

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

use hapdef_inverse::{Recalibration, ResponseMap, ScanSites};
use hapdef_mesh::{atomic_write, folder_of};

pub use declared::{DeclaredForce, DeclaredTouch, TouchAssumptions};
use journal::Stamp;
pub use journal::{JournalEntry, JournalTouch, JournalUndo};

use super::{Calibration, GainsSince};
use crate::error::HapdefError;
use crate::limb::Limb;
use crate::run::Run;

/// A calibration that takes known touches. What it has is that of the journal's touches, one after the other.
pub struct Recalibrator {
    path: PathBuf,
    calibration: Calibration,
    map: ResponseMap,
    sites: ScanSites,
    site_error: Vec<f64>,
    journal_path: PathBuf,
    journal: String,
    on_disk: OnDisk,
    /// Touches that were taken and not undone.
    kept: Vec<JournalTouch>,
    /// What they have shown; none before the first.
    state: Option<Recalibration>,
}

/// What the files had when they were last read or written here.
#[derive(PartialEq)]
struct OnDisk {
    calibration: Vec<u8>,
    journal: String,
}

impl Recalibrator {
    /// Opens the calibration that a scene names.
    ///
    /// # Errors
    /// [`HapdefError::NoCalibration`]; as [`Recalibrator::open`].
    pub fn of_scene(run: &Run, limb: &Limb) -> Result<Self, HapdefError> {
        let named = run.scene.estimator.superposition().calibration;
        let none = || HapdefError::NoCalibration { scene: run.scene.name.clone() };
        Self::open(&run.scene_dir.join(named.ok_or_else(none)?), limb)
    }

    /// Opens the calibration at `path` and its journal, the file beside it with `.touches.jsonl` after its name.
    ///
    /// # Errors
    /// As [`Calibration::read`]; [`HapdefError::Journal`] for a line that is no entry; [`HapdefError::File`].
    pub fn open(path: &Path, limb: &Limb) -> Result<Self, HapdefError> {
        let journal_path = journal::journal_path(path);
        // Read before what is computed with: what comes between the two is noticed when it is to be written.
        let on_disk = OnDisk::read(path, &journal_path)?;
        let calibration = Calibration::read(path, limb)?;
        let (map, site_error) = calibration.as_pressed(limb)?;
        let sites = ScanSites::farthest(map.skin(), calibration.n_sites)?;
        let journal = on_disk.journal.clone();
        let kept = journal::in_use(&journal_path, &journal, &calibration.presses_hash)?;
        let mut opened = Self {
            path: path.to_owned(),
            calibration,
            map,
            sites,
            site_error,
            journal_path,
            journal,
            on_disk,
            kept: Vec::new(),
            state: None,
        };
        opened.play(kept)?;
        Ok(opened)
    }

    /// Takes a touch, or refuses it: [`JournalTouch::is_accepted`]. `unix_s` is the time now, s since 1970.
    ///
    /// # Errors
    /// [`HapdefError::Inverse`] for a touch that can't be used: off the skin, a force that does not press, readings
    /// of another number of gauges; [`HapdefError::Journal`] for one before the last one's time, or where touches are
    /// missing that the calibration rests on.
    pub fn touch(
        &mut self,
        touch: &DeclaredTouch,
        assumed: &TouchAssumptions,
        unix_s: u64,
    ) -> Result<JournalTouch, HapdefError> {
        self.check_whole()?;
        let taken = self.take(touch, assumed, unix_s)?;
        self.add_line(&JournalEntry::Touch(Box::new(taken.clone())))?;
        if taken.is_accepted {
            self.kept.push(taken.clone());
        }
        Ok(taken)
    }

    /// Goes back to before the last `n_touches` that were taken, or before all; returns how many these were.
    ///
    /// # Errors
    /// [`HapdefError::Journal`] where there are fewer, or where touches are missing that the calibration rests on
    /// and not all are undone.
    pub fn undo(&mut self, n_touches: Option<usize>, unix_s: u64) -> Result<usize, HapdefError> {
        let n_kept = self.kept.len();
        if let Some(n) = n_touches {
            self.check_whole()?;
            if n > n_kept {
                let what = format!("expected {n} touches to undo, found {n_kept}: ask for fewer");
                return Err(self.fault(what));
            }
        }
        let n_touches = n_touches.unwrap_or(n_kept);
        let gains_before = match &self.calibration.since {
            Some(since) if since.n_touches > n_kept => since.gains.clone(),
            _ => self.gains(),
        };
        let mut kept = std::mem::take(&mut self.kept);
        kept.truncate(n_kept - n_touches);
        self.state = None;
        self.play(kept)?;
        let undo = JournalUndo {
            calibration: self.calibration.presses_hash.clone(),
            unix_s,
            n_touches,
            gains_before,
            gains_after: self.gains(),
        };
        self.add_line(&JournalEntry::Undo(undo))?;
        // what the file has is what is known now, touches of a lost journal forgotten
        self.calibration.since = self.since();
        Ok(n_touches)
    }

    /// Writes the journal, then the calibration.
    ///
    /// # Errors
    /// [`HapdefError::Journal`] where another program has changed one of the two since they were opened: neither is
    /// written; [`HapdefError::File`] when one can't be read or written, or their folder can't be locked.
    pub fn write(&mut self) -> Result<(), HapdefError> {
        let _alone = lock_folder(&self.path)?;
        if OnDisk::read(&self.path, &self.journal_path)? != self.on_disk {
            let what = "another program has recorded touches or calibrated anew meanwhile; nothing was written: \
                        give these touches again";
            return Err(self.fault(what.to_owned()));
        }
        let text = self.journal.as_bytes();
        atomic_write(&self.journal_path, |file| file.write_all(text))
            .map_err(HapdefError::file(&self.journal_path))?;
        self.calibration.since = self.since();
        self.calibration.write(&self.path)?;
        self.on_disk = OnDisk::read(&self.path, &self.journal_path)?;
        Ok(())
    }

    /// The calibration with what the touches have shown so far.
    #[must_use]
    pub fn calibration(&self) -> Calibration {
        Calibration { since: self.since(), ..self.calibration.clone() }
    }

    /// How the gains have changed; none before the first touch that is taken.
    #[must_use]
    pub fn since(&self) -> Option<GainsSince> {
        let change = self.state.as_ref()?.change();
        let (gains, covariance) = (change.gains, change.covariance);
        Some(GainsSince { n_touches: self.kept.len(), gains, covariance })
    }

    /// Each gauge's zero and its standard deviation `[n_gauges]`, µε; empty before an untouched frame.
    #[must_use]
    pub fn zeros_ue(&self) -> Vec<(f64, f64)> {
        let is_seen = self.kept.iter().any(|touch| touch.untouched_ue.is_some());
        self.state.as_ref().filter(|_| is_seen).map(Recalibration::zeros).unwrap_or_default()
    }

    /// The file of the calibration.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The file that the touches are recorded in.
    #[must_use]
    pub fn journal_path(&self) -> &Path {
        &self.journal_path
    }

    /// Relative change of each gain since the calibration `[n_gauges]`.
    fn gains(&self) -> Vec<f64> {
        let m = self.calibration.n_gauges;
        self.since().map_or_else(|| vec![0.0; m], |since| since.gains)
    }

    /// Takes touches that were taken before, which come out as they did.
    fn play(&mut self, touches: Vec<JournalTouch>) -> Result<(), HapdefError> {
        for touch in touches {
            self.take(&touch.declared(), &touch.assumed, touch.unix_s)?;
            self.kept.push(touch);
        }
        Ok(())
    }

    fn take(
        &mut self,
        touch: &DeclaredTouch,
        assumed: &TouchAssumptions,
        unix_s: u64,
    ) -> Result<JournalTouch, HapdefError> {
        let hours_since = self.hours_since(touch)?;
        let known = touch.on(self.map.skin(), assumed.off_skin_m, hours_since)?;
        let params = assumed.params(self.calibration.n_gauges);
        let mut state = match &self.state {
            Some(state) => state.clone().with_params(params)?,
            None => Recalibration::new(params)?,
        };
        let info = state.update(&self.map, self.error_near(&touch.position_m), &known)?;
        if info.is_accepted {
            self.state = Some(state);
        }
        let stamp = Stamp { calibration: self.calibration.presses_hash.clone(), unix_s };
        Ok(JournalTouch::new(stamp, touch, known.force_n.into(), *assumed, info))
    }

    /// Time since the last touch, h; 0 where either's is not known.
    fn hours_since(&self, touch: &DeclaredTouch) -> Result<f64, HapdefError> {
        let (Some(before_s), Some(t_s)) = (self.kept.last().and_then(|last| last.t_s), touch.t_s)
        else {
            return Ok(0.0);
        };
        if t_s < before_s {
            let what = format!(
                "the last touch was at {before_s} s, and {} is at {t_s} s: expected touches in the order of time; \
                 sort them, or take one clock for all, such as seconds since 1970",
                touch.from
            );
            return Err(self.fault(what));
        }
        Ok((t_s - before_s) / 3600.0)
    }

    /// Covariance of the map's error at the site nearest to a place, µε²/N² `[n_gauges, n_gauges]`.
    fn error_near(&self, position_m: &[f64; 3]) -> &[f64] {
        let position = nalgebra::Point3::from(*position_m);
        let far = |at: &nalgebra::Point3<f64>| (at - position).norm_squared();
        let sites = self.sites.positions().iter().enumerate();
        let nearest = sites.min_by(|a, b| far(a.1).total_cmp(&far(b.1))).map_or(0, |(i, _)| i);
        let size = self.calibration.n_gauges.pow(2);
        self.site_error.get(nearest * size..(nearest + 1) * size).unwrap_or_default()
    }

    /// Refuses a calibration that rests on more touches than the journal has.
    fn check_whole(&self) -> Result<(), HapdefError> {
        let needed = self.calibration.since.as_ref().map_or(0, |since| since.n_touches);
        let found = self.kept.len();
        if needed <= found {
            return Ok(());
        }
        let what = format!(
            "expected the {needed} touches that {} rests on, found {found}: put the journal back, or go back to the \
             calibration as it was pressed (hapdef recalibrate SCENE --undo)",
            self.path.display()
        );
        Err(self.fault(what))
    }

    fn add_line(&mut self, entry: &JournalEntry) -> Result<(), HapdefError> {
        let line = serde_json::to_string(entry)
            .map_err(|error| HapdefError::file(&self.journal_path)(error.into()))?;
        if !self.journal.is_empty() && !self.journal.ends_with('\n') {
            self.journal.push('\n');
        }
        self.journal.push_str(&line);
        self.journal.push('\n');
        Ok(())
    }

    fn fault(&self, what: String) -> HapdefError {
        HapdefError::Journal { path: self.journal_path.clone(), what }
    }
}

impl OnDisk {
    fn read(calibration: &Path, journal: &Path) -> Result<Self, HapdefError> {
        let bytes = std::fs::read(calibration).map_err(HapdefError::file(calibration))?;
        Ok(Self { calibration: bytes, journal: journal::read_text(journal)? })
    }
}

/// Waits until no other recalibration writes beside `path`; none does while the handle is open.
///
/// The folder is locked as the files in it are replaced, and a lock would go with the replaced file.
fn lock_folder(path: &Path) -> Result<File, HapdefError> {
    let folder = folder_of(path);
    let lock = |folder: File| folder.lock().map(|()| folder);
    File::open(folder).and_then(lock).map_err(HapdefError::file(folder))
}
