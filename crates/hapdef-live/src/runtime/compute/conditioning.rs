//! Tare, drift, bad gauges, noise: what is between a reading and the estimator.

use hapdef_contact::{GaugeHealth, TouchPhase};
use hapdef_daq::without_realtime;
use hapdef_inverse::{Conditioned, Conditioner, ConditionerParams, InverseError, OtherLoads};

use super::Compute;
use crate::frame::LiveFrame;
use crate::runtime::device::Device;
use crate::runtime::frozen::Frozen;
use crate::runtime::noise::TareNoise;
use crate::signals::{GivenLoads, LoadSignal};

/// The filter in front of the estimator, with its output.
pub(super) struct Conditioning {
    pub(super) conditioner: Conditioner,
    pub(super) out: Conditioned,
    pub(super) noise: TareNoise,
    pub(super) frozen: Frozen,
    /// Readings for the filter `[n_gauges]`, µε: at the end of their range where the device says so.
    raw_ue: Vec<f64>,
    /// What of them measured loads read `[n_gauges]`, µε.
    given_ue: Vec<f64>,
    /// Highest reading of each gauge `[n_gauges]`, µε.
    ends_ue: Vec<f64>,
}

impl Conditioning {
    /// The most that a gauge's zero makes its readings more uncertain than their noise does, 1 or more.
    pub(super) fn blur(&self) -> f64 {
        let each = self.conditioner.gauge_sd().iter().zip(&self.out.baseline_sd);
        let of_live = each.zip(&self.out.live).filter(|(_, is_live)| **is_live);
        of_live.map(|((noise, zero), _)| (zero / noise).hypot(1.0)).fold(1.0, f64::max)
    }

    fn take_raw(&mut self, frame: &LiveFrame, device: &Device, given: &GivenLoads) {
        self.raw_ue.copy_from_slice(&frame.raw_ue);
        given.read(&frame.signals, &mut self.given_ue);
        if self.given_ue.iter().any(|ue| !ue.is_finite()) {
            // without what loads the limb no gauge tells of contacts
            self.raw_ue.fill(f64::NAN);
            self.given_ue.fill(0.0);
        }
        for gauge in device.saturated() {
            self.raw_ue[gauge] = self.ends_ue[gauge];
        }
    }
}

impl Compute {
    pub(super) fn condition(&mut self) {
        if !self.setup.wants.has_tared() {
            return;
        }
        self.counts.n_conditioned += 1;
        let to = &mut self.frame;
        let Some(conditioning) = &mut self.conditioning else {
            to.phase = TouchPhase::Untouched;
            self.setup.given.read(&to.signals, &mut to.tared_ue);
            let pairs = to.tared_ue.iter_mut().zip(&to.raw_ue);
            pairs.for_each(|(tared, raw)| *tared = raw - *tared);
            for (health, raw) in to.gauges.iter_mut().zip(&to.raw_ue) {
                *health = health_of_number(*raw);
            }
            return;
        };
        let was_taring = conditioning.out.phase == TouchPhase::Taring;
        if was_taring {
            conditioning.noise.take(&to.raw_ue);
        }
        self.step();
        self.judge_zero();
    }

    fn step(&mut self) {
        let to = &mut self.frame;
        let (Some(conditioning), Some(device)) = (&mut self.conditioning, &self.device) else {
            return;
        };
        conditioning.frozen.take(&to.raw_ue);
        conditioning.take_raw(to, device, &self.setup.given);
        let Conditioning { conditioner, out, raw_ue, given_ue, frozen, .. } = conditioning;
        let stepped = conditioner.step_beside(raw_ue, Some(given_ue), to.temperature, out);
        if let Err(error) = stepped {
            // lengths are those of the device; said all the same
            self.counts.device_fault = Some(error.to_string().into());
            return;
        }
        for gauge in frozen.gauges() {
            if std::mem::replace(&mut out.live[gauge], false) {
                (out.health[gauge], out.readings[gauge]) = (GaugeHealth::Dead, 0.0);
            }
        }
        to.phase = out.phase;
        to.tared_ue.copy_from_slice(&out.readings);
        to.gauges.copy_from_slice(&out.health);
        let is_taring = out.phase == TouchPhase::Taring;
        if is_taring {
            for (health, raw) in to.gauges.iter_mut().zip(&to.raw_ue) {
                *health = health_of_number(*raw);
            }
        }
        for gauge in device.saturated() {
            to.gauges[gauge] = GaugeHealth::Saturated;
        }
        if let Some(end) = out.tare_end {
            let sds = conditioning.noise.least_ue(self.setup.noise_ue);
            conditioning.frozen.end_tare(sds.zip(device.steps_ue()));
            self.trust.start_over();
            self.end_tare(end);
        }
    }

    /// Noise of the tare that is surely larger than assumed counts from now on.
    pub(super) fn take_noise(&mut self) {
        let Some(conditioning) = &mut self.conditioning else {
            return;
        };
        let larger_ue = conditioning.noise.larger_ue();
        self.counts.n_noisier = larger_ue.iter().filter(|sd| **sd > 0.0).count();
        self.counts.noise_ue = conditioning.noise.to_use_ue();
        let priority = self.setup.params.computing_priority();
        let noise_ue = &self.counts.noise_ue;
        let accepted = match &mut self.setup.estimator {
            Some(estimator) => without_realtime(priority, || estimator.set_least_noise(noise_ue)),
            None => Ok(()),
        };
        let conditioner = &mut conditioning.conditioner;
        let taken = accepted.and_then(|()| Ok(conditioner.set_gauge_sd(&self.counts.noise_ue)?));
        if let Err(error) = taken {
            self.counts.device_fault = Some(error.to_string().into());
        }
    }

    /// Noise that is assumed before any is measured: what was declared, and step²/12 for the converter's step
    /// `[n_gauges]`, µε.
    pub(super) fn assumed_noise_ue(&self, device: &Device) -> Vec<f64> {
        let sd = |step_ue: f64| self.setup.noise_ue.hypot(step_ue / 12.0_f64.sqrt());
        device.steps_ue().map(sd).collect()
    }

    /// What conditions the frames of `device`; none where they come tared.
    pub(super) fn conditioning(
        &self,
        device: &Device,
    ) -> Result<Option<Conditioning>, InverseError> {
        let params = &self.setup.params;
        if params.tare_s == 0.0 {
            return Ok(None);
        }
        let defaults = || ConditionerParams::new(Vec::new(), device.period_s);
        let given = params.conditioning.clone().unwrap_or_else(defaults);
        let params = ConditionerParams {
            gauge_sd: self.assumed_noise_ue(device),
            period_s: device.period_s,
            tare_frames: (params.tare_s / device.period_s).round().max(1.0) as usize,
            rails: device.rails_ue(),
            coarse: device.steps_ue().map(|step| step > self.setup.noise_ue).collect(),
            loads: self.loads(),
            ..given
        };
        let noise = TareNoise::new(params.gauge_sd.clone(), params.tare_frames);
        // One that sends real numbers has no end: what it sends then is no number that counts.
        let end_ue = |gauge: usize| params.rails.get(gauge).map_or(f64::NAN, |(_, high)| *high);
        let ends_ue: Vec<f64> = (0..device.n_gauges()).map(end_ue).collect();
        let conditioner = Conditioner::new(params)?;
        Ok(Some(Conditioning {
            out: conditioner.output(),
            conditioner,
            noise,
            frozen: Frozen::new(device.n_gauges()),
            raw_ue: ends_ue.clone(),
            given_ue: vec![0.0; device.n_gauges()],
            ends_ue,
        }))
    }

    /// Refuses a device that lacks a signal of a load that is to be taken off, or has others.
    pub(super) fn check_given(&self, device: &Device) -> Result<(), String> {
        let (expected, found) = (&self.setup.given.signals, device.signals());
        if expected.is_empty() || *expected == found {
            return Ok(());
        }
        let words = |signals: &[LoadSignal]| match signals {
            [] => "none".to_owned(),
            signals => signals.iter().map(ToString::to_string).collect::<Vec<_>>().join(", "),
        };
        Err(format!(
            "loads were learned with the signals {}; the device has {}: learn them anew with it (hapdef loads)",
            words(expected),
            words(&found)
        ))
    }

    /// Loads that are no contacts, as the estimator knows them.
    fn loads(&self) -> OtherLoads {
        let sight = self.setup.estimator.as_ref().and_then(|estimator| estimator.sight());
        sight.and_then(|sight| sight.loads).cloned().unwrap_or_default()
    }

    /// Takes a new tare of the next frames.
    pub(in super::super) fn tare(&mut self) {
        if let Some(conditioning) = &mut self.conditioning {
            conditioning.conditioner.tare();
            conditioning.noise.start_over();
            conditioning.frozen.start_over();
            conditioning.out.phase = TouchPhase::Taring;
            self.tare_watch.n_repeats = 0;
            self.start_over();
        }
    }
}

fn health_of_number(value: f64) -> GaugeHealth {
    if value.is_finite() { GaugeHealth::Good } else { GaugeHealth::NotFinite }
}
