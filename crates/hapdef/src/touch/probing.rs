//! Presses of known places and forces on the scene's simulated rig.

use hapdef_contact::DrawnContact;
use hapdef_rig::live::LiveLimb;
use hapdef_rig::{Electronics, ElectronicsParams};
use nalgebra::Point3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::error::{HapdefError, SceneError};
use crate::limb::Limb;
use crate::run::Run;
use crate::scoring::ScoredContact;
use crate::virtual_rig::live_limb;

/// Least force of a press on the simulated rig, N: less says little.
const LEAST_N: f64 = 2.0;

/// Draws after which contacts may be nearer than the scene's spacing: a skin too small for it has none.
const N_DRAWS: usize = 100;

/// How the simulated rig is pressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ProbeParams {
    /// Number of presses.
    pub n_presses: usize,
    /// Places pressed at a time, as far apart as the scene's contacts are.
    pub n_contacts: usize,
    /// Seed of places, forces and noise.
    pub seed: u64,
    /// Frames in which each contact comes, one after another; 0 for a single frame of what presses in the
    /// end.
    pub n_rising: usize,
}

/// What was pressed, and what the gauges read.
#[derive(Clone, Debug, PartialEq)]
pub struct ProbedPress {
    /// The contacts.
    pub contacts: Vec<ScoredContact>,
    /// Tared readings of each frame `[n_frames][n_gauges]`, µε; all contacts press in the last one.
    pub frames_ue: Vec<Vec<f64>>,
}

/// The scene's simulated rig, to be pressed where one wants.
pub struct ProbedRig<'a> {
    run: &'a Run,
    limb: &'a Limb,
    real: LiveLimb,
    points_m: Vec<Point3<f64>>,
    range_n: [f64; 2],
}

impl<'a> ProbedRig<'a> {
    /// Solves the perturbed limb once, or takes it from the run's cache.
    ///
    /// # Errors
    /// [`HapdefError::Scene`] when no contact of the scene is as strong as a press, and as
    /// [`live_limb`].
    pub fn new(run: &'a Run, limb: &'a Limb) -> Result<Self, HapdefError> {
        let [low, high] = run.scene.contact.force_range_n;
        let range_n = [low.max(LEAST_N), high];
        if range_n[0] >= high {
            let (file, path) = (run.scene.name.clone(), "contact.force_range_n".to_owned());
            let (expected, found) = ("a largest force above 2 N", format!("{high} N"));
            return Err(SceneError::Value { file, path, expected, found }.into());
        }
        let real = live_limb(run, limb)?;
        Ok(Self { run, limb, real, points_m: limb.surface_points(), range_n })
    }

    /// Presses drawn at random and what the gauges read, the scene's noise and converters included.
    ///
    /// # Errors
    /// [`HapdefError::Rig`] when a gauge answers to none of the presses.
    pub fn presses(&self, params: &ProbeParams) -> Result<Vec<ProbedPress>, HapdefError> {
        let presses = self.drawn(params);
        let own = self.run.scene.rig.electronics.params();
        let electronics = ElectronicsParams { seed: own.seed.wrapping_add(params.seed), ..own };
        let mut electronics = Electronics::new(electronics, &self.largest_ue(&presses))?;
        let contact = |c: &DrawnContact| (self.points_m[c.node].coords.into(), c.force_n);
        let press = |press: Vec<DrawnContact>| {
            let mut frames_ue = self.frames_ue(&press, params.n_rising);
            frames_ue.iter_mut().for_each(|frame| electronics.measure(frame));
            ProbedPress { contacts: press.iter().map(contact).collect(), frames_ue }
        };
        Ok(presses.into_iter().map(press).collect())
    }

    /// Sets of contacts, those of a set apart where draws find such.
    fn drawn(&self, params: &ProbeParams) -> Vec<Vec<DrawnContact>> {
        let mut rng = ChaCha8Rng::seed_from_u64(params.seed);
        let spacing_m = self.run.scene.contact.min_spacing_m;
        let mut press = |_| {
            let mut contacts: Vec<DrawnContact> = Vec::with_capacity(params.n_contacts);
            while contacts.len() < params.n_contacts {
                let is_far = |node: usize| {
                    let gap_m = |c: &DrawnContact| self.points_m[node] - self.points_m[c.node];
                    contacts.iter().all(|c| gap_m(c).norm() >= spacing_m)
                };
                let mut node = rng.random_range(0..self.points_m.len());
                for _ in 0..N_DRAWS {
                    if is_far(node) {
                        break;
                    }
                    node = rng.random_range(0..self.points_m.len());
                }
                let force_n = rng.random_range(self.range_n[0]..=self.range_n[1]);
                contacts.push(DrawnContact { node, force_n });
            }
            contacts
        };
        (0..params.n_presses).map(&mut press).collect()
    }

    /// Readings per newton against the skin at a node `[n_gauges]`, µε/N.
    fn unit_ue_per_n(&self, node: usize) -> impl Iterator<Item = f64> {
        let n_gauges = self.limb.gauges.len();
        let columns = &self.real.columns_ue_per_n()[node * n_gauges..][..n_gauges];
        columns.iter().map(move |column| column.dot(&self.limb.directions[node]))
    }

    /// Readings without noise of frames in which the contacts come one after another and stay: untouched
    /// for `n_rising` frames, so many for each contact, and as many of all.
    fn frames_ue(&self, press: &[DrawnContact], n_rising: usize) -> Vec<Vec<f64>> {
        let n_frames = n_rising * (press.len() + 2);
        if n_frames == 0 {
            return vec![self.strains_ue(press, |_| 1.0)];
        }
        let share = |frame: usize, contact: usize| {
            let begin = n_rising * (contact + 1);
            (frame.saturating_sub(begin) as f64 / n_rising as f64).min(1.0)
        };
        (0..n_frames).map(|frame| self.strains_ue(press, |i| share(frame, i))).collect()
    }

    /// Readings without noise of a share of each contact's force `[n_gauges]`, µε.
    fn strains_ue(&self, press: &[DrawnContact], share: impl Fn(usize) -> f64) -> Vec<f64> {
        let mut sum = vec![0.0; self.limb.gauges.len()];
        for (i, contact) in press.iter().enumerate() {
            let unit = self.unit_ue_per_n(contact.node);
            let force_n = share(i) * contact.force_n;
            sum.iter_mut().zip(unit).for_each(|(sum, unit)| *sum += force_n * unit);
        }
        sum
    }

    /// The largest reading of each gauge by one of the contacts at the scene's strongest `[n_gauges]`, µε.
    fn largest_ue(&self, presses: &[Vec<DrawnContact>]) -> Vec<f64> {
        let mut largest = vec![0.0_f64; self.limb.gauges.len()];
        for contact in presses.iter().flatten() {
            let unit = self.unit_ue_per_n(contact.node);
            largest.iter_mut().zip(unit).for_each(|(most, unit)| *most = most.max(unit.abs()));
        }
        largest.iter().map(|unit| unit * self.range_n[1]).collect()
    }
}
