//! The session from frame to frame.

use hapdef_inverse::{
    CalibrationInfo, CalibrationParams, Conditioned, Conditioner, ConditionerParams, Press,
    ResponseMap, SkinPoint, TouchPhase,
};
use nalgebra::Point3;

use super::hold::{Hold, HoldParams, norm};
use super::plan::Plan;
use super::table::PressRow;
use crate::error::HapdefError;
use crate::limb::Limb;
use crate::run::Run;
use crate::touch::{
    CALIBRATION_SITES, Calibration, PressQuality, UncertainParams, UncertainResponse,
};

/// Untouched frames after a press before the next one is asked for, per second.
const REST_S: f64 = 0.2;

/// Time to take one's hands off the limb before the tare, s.
const BEFORE_TARE_S: f64 = 1.0;

/// What a session is to reach.
#[derive(Clone, Debug, PartialEq)]
pub struct SessionParams {
    /// Presses in all.
    pub n_presses: usize,
    /// Presses spread over the skin before the first fit; after it, and again after every
    /// `n_between`, the places are those where the map is least known.
    pub n_first: usize,
    /// See `n_first`.
    pub n_between: usize,
    /// The force asked for, N.
    pub force_n: f64,
    /// Stiffness modes of the fits in between; the calibration in the end has 32.
    pub n_stiffness: usize,
    /// Frames per second.
    pub rate_hz: f64,
    /// Step of each gauge's converter `[n_gauges]`, µε; empty where it is too small to matter.
    pub step_ue: Vec<f64>,
    /// Lowest and highest reading that each gauge's numbers can have `[n_gauges]`, µε; empty for no
    /// limits.
    pub rails_ue: Vec<(f64, f64)>,
    /// What is known of readings and presses; of the noise that of a single frame.
    pub quality: PressQuality,
    /// When a press counts.
    pub hold: HoldParams,
}

/// A press that is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AskedPress {
    /// Its number, from 0.
    pub index: usize,
    /// Where, m.
    pub position_m: Point3<f64>,
    /// Normal force, N.
    pub force_n: f64,
    /// How uncertain the map is there, relative to a typical response; `None` before the first fit.
    pub relative_sd: Option<f64>,
}

/// A press that was held still.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeldPress {
    /// What was asked for.
    pub asked: AskedPress,
    /// How far its readings are from what the map says so far, relative to that.
    pub residual: f64,
    /// How far the session is.
    pub progress: SessionProgress,
}

/// How far a session is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SessionProgress {
    /// Presses kept.
    pub n_presses: usize,
    /// Share of the skin with a press within 12 mm.
    pub coverage: f64,
    /// Relative error of the map at presses not used, after the last fit.
    pub relative_error: Option<f64>,
}

/// What has happened, or is to be done.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SessionEvent {
    /// The tare is taken: press here.
    Press(AskedPress),
    /// It is touched: hold still.
    Touched,
    /// It was let go before it was held still long enough: press there again.
    LetGo,
    /// A gauge is not to be believed while it is pressed; its number.
    GaugeOut(usize),
    /// The press is kept: let go.
    Held(HeldPress),
    /// All presses are kept, and the last one is let go.
    Done,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    Taring,
    Asked,
    Holding,
    LettingGo { n_quiet: usize },
    Done,
}

/// A guided calibration.
pub struct CalibrationSession {
    params: SessionParams,
    plan: Plan,
    conditioner: Conditioner,
    conditioned: Conditioned,
    hold: Hold,
    phase: Phase,
    /// Frames left before the tare begins.
    n_before_tare: usize,
    asked: Option<(AskedPress, SkinPoint)>,
    presses: Vec<Press>,
    has_told_gauge: bool,
}

impl SessionParams {
    /// `n_presses` of `force_n` at `rate_hz`: 12 spread over the skin, then 6 between fits.
    #[must_use]
    pub fn new(n_presses: usize, force_n: f64, rate_hz: f64, quality: PressQuality) -> Self {
        Self {
            n_presses,
            n_first: 12,
            n_between: 6,
            force_n,
            n_stiffness: 32,
            rate_hz,
            step_ue: Vec::new(),
            rails_ue: Vec::new(),
            quality,
            hold: HoldParams::at_rate(rate_hz),
        }
    }

    fn step_ue(&self, gauge: usize) -> f64 {
        self.step_ue.get(gauge).copied().unwrap_or(0.0)
    }

    /// The steps of a converter that are larger than the noise are not averaged out.
    fn is_coarse(&self, gauge: usize) -> bool {
        self.step_ue(gauge) > self.quality.noise_ue
    }

    /// Noise of a press `[n_gauges]`, µε: a frame's, averaged over those that are held and those of the
    /// tare, and the steps of both where they are coarse.
    fn press_noise_ue(&self, n_gauges: usize) -> Vec<f64> {
        let tare_frames = ConditionerParams::new(Vec::new(), 1.0).tare_frames as f64;
        let by_mean = 1.0 / self.hold.hold_frames as f64 + 1.0 / tare_frames;
        let noise = |gauge| {
            let step = if self.is_coarse(gauge) { self.step_ue(gauge) } else { 0.0 };
            (self.quality.noise_ue.powi(2) * by_mean + step * step / 6.0).sqrt()
        };
        (0..n_gauges).map(noise).collect()
    }

    fn before_tare(&self) -> usize {
        (BEFORE_TARE_S * self.rate_hz).round() as usize
    }

    fn conditioning(&self, n_gauges: usize) -> ConditionerParams {
        let sd = |gauge| self.quality.noise_ue.hypot(self.step_ue(gauge) / 12f64.sqrt());
        let sds: Vec<f64> = (0..n_gauges).map(sd).collect();
        ConditionerParams {
            coarse: (0..n_gauges).map(|gauge| self.is_coarse(gauge)).collect(),
            rails: self.rails_ue.clone(),
            ..ConditionerParams::new(sds, 1.0 / self.rate_hz)
        }
    }
}

impl CalibrationSession {
    /// Solves for the limb's response and begins with the tare, a second after the first frame: the limb
    /// must be untouched then.
    ///
    /// # Errors
    /// [`HapdefError::Sim`] when the limb can't be solved; [`HapdefError::Inverse`] for parameters
    /// that can't be used.
    pub fn new(run: &Run, limb: &Limb, params: SessionParams) -> Result<Self, HapdefError> {
        let solve = UncertainParams::of_scene(run, params.n_stiffness);
        let (response, _) = UncertainResponse::kept(run, limb, &limb.sites, &limb.gauges, &solve)?;
        let n_gauges = limb.gauges.len();
        let noise_ue = params.quality.noise_ue;
        let calibration = CalibrationParams {
            position_sd_m: params.quality.position_sd_m,
            force_sd_n: params.quality.force_sd_n,
            n_next: params.n_between,
            // the finger waits; the calibration in the end holds some out
            holds_out: false,
            n_threads: run.threads,
            ..CalibrationParams::new(params.press_noise_ue(n_gauges))
        };
        let conditioner = Conditioner::new(params.conditioning(n_gauges))?;
        Ok(Self {
            plan: Plan::new(response, params.n_first.min(params.n_presses), calibration)?,
            conditioned: conditioner.output(),
            conditioner,
            hold: Hold::new(params.hold, noise_ue, n_gauges),
            phase: Phase::Taring,
            n_before_tare: params.before_tare(),
            asked: None,
            presses: Vec::new(),
            has_told_gauge: false,
            params,
        })
    }

    /// Takes a frame of raw readings `[n_gauges]`, µε, and says what is new.
    ///
    /// # Errors
    /// [`HapdefError::Inverse`] for a frame of another length, or presses that can't be fitted.
    pub fn frame(&mut self, raw_ue: &[f64]) -> Result<Option<SessionEvent>, HapdefError> {
        if self.n_before_tare > 0 {
            self.n_before_tare -= 1;
            return Ok(None);
        }
        self.conditioner.step_into(raw_ue, None, &mut self.conditioned)?;
        let is_touched = self.conditioned.phase == TouchPhase::Touched;
        match self.phase {
            Phase::Done => Ok(None),
            Phase::Taring if self.conditioned.phase == TouchPhase::Taring => Ok(None),
            Phase::Taring => self.ask(),
            Phase::Asked if is_touched => {
                self.hold.begin();
                (self.phase, self.has_told_gauge) = (Phase::Holding, false);
                Ok(Some(SessionEvent::Touched))
            }
            Phase::Asked => Ok(None),
            Phase::Holding if !is_touched => {
                self.phase = Phase::Asked;
                Ok(Some(SessionEvent::LetGo))
            }
            Phase::Holding => Ok(self.held()),
            Phase::LettingGo { n_quiet } => self.let_go(n_quiet, is_touched),
        }
    }

    /// Begins with the tare again, a second from now, as after the device has started anew; the press
    /// that is asked for is asked for again.
    pub fn restart(&mut self) {
        self.n_before_tare = self.params.before_tare();
        self.conditioner.tare();
        if self.phase != Phase::Done {
            self.phase = Phase::Taring;
        }
    }

    /// What is asked for, from [`SessionEvent::Press`] to [`SessionEvent::Held`].
    #[must_use]
    pub fn asked(&self) -> Option<AskedPress> {
        self.asked.map(|(asked, _)| asked)
    }

    /// The presses kept, as rows of a table.
    #[must_use]
    pub fn rows(&self) -> Vec<PressRow> {
        let skin = self.plan.map().skin();
        let row = |press: &Press| PressRow {
            position_m: skin.position(&press.point),
            force_n: press.force_n,
            readings_ue: press.readings.clone(),
        };
        self.presses.iter().map(row).collect()
    }

    /// The map as far as it is known: after the last fit.
    #[must_use]
    pub fn map(&self) -> &ResponseMap {
        self.plan.map()
    }

    /// How far the session is.
    #[must_use]
    pub fn progress(&self) -> SessionProgress {
        SessionProgress {
            n_presses: self.presses.len(),
            coverage: self.plan.coverage(&self.presses),
            relative_error: self.plan.relative_error,
        }
    }

    /// The calibration of all presses kept.
    ///
    /// # Errors
    /// [`HapdefError::Inverse`] for too few presses.
    pub fn finish(
        &self,
        run: &Run,
        limb: &Limb,
    ) -> Result<(Calibration, CalibrationInfo), HapdefError> {
        let noise = self.params.press_noise_ue(limb.gauges.len());
        let quality = PressQuality {
            noise_ue: norm(noise.iter().copied()) / (noise.len() as f64).sqrt(),
            ..self.params.quality
        };
        let response = self.plan.response();
        Calibration::of_response(run, limb, response, &self.presses, &quality, CALIBRATION_SITES)
    }

    /// Asks for the next press, or for the last one again.
    fn ask(&mut self) -> Result<Option<SessionEvent>, HapdefError> {
        self.phase = Phase::Asked;
        if self.asked.is_none() {
            let next = if self.presses.len() < self.params.n_presses {
                self.plan.next(&self.presses)?
            } else {
                None
            };
            let Some((point, relative_sd)) = next else {
                self.phase = Phase::Done;
                return Ok(Some(SessionEvent::Done));
            };
            let asked = AskedPress {
                index: self.presses.len(),
                position_m: self.plan.map().skin().position(&point),
                force_n: self.params.force_n,
                relative_sd,
            };
            self.asked = Some((asked, point));
        }
        Ok(self.asked().map(SessionEvent::Press))
    }

    fn held(&mut self) -> Option<SessionEvent> {
        if let Some(gauge) = self.conditioned.live.iter().position(|live| !live) {
            self.hold.begin();
            let is_new = !std::mem::replace(&mut self.has_told_gauge, true);
            return is_new.then_some(SessionEvent::GaugeOut(gauge));
        }
        let readings = self.hold.take(&self.conditioned.readings)?;
        let (asked, point) = self.asked.take()?;
        let press = Press { point, force_n: asked.force_n, readings };
        let residual = self.plan.residual(&press);
        self.presses.push(press);
        self.phase = Phase::LettingGo { n_quiet: 0 };
        Some(SessionEvent::Held(HeldPress { asked, residual, progress: self.progress() }))
    }

    fn let_go(
        &mut self,
        n_quiet: usize,
        is_touched: bool,
    ) -> Result<Option<SessionEvent>, HapdefError> {
        let n_quiet = if is_touched { 0 } else { n_quiet + 1 };
        self.phase = Phase::LettingGo { n_quiet };
        if (n_quiet as f64) < REST_S * self.params.rate_hz {
            return Ok(None);
        }
        self.ask()
    }
}
