//! Readings of the simulated hardware: unit responses superposed, then measured.

use hapdef_contact::DrawnContact;
use hapdef_rig::{Electronics, ElectronicsParams};

use crate::error::HapdefError;
use crate::run::Run;

/// The rig's channels: unit responses superposed, then measured.
pub(super) struct RigChannels {
    response_ue_per_n: Vec<f32>,
    n_gauges: usize,
    electronics: Electronics,
}

impl RigChannels {
    /// Sets each channel's full scale by its largest single-press reading.
    pub(super) fn new(
        run: &Run,
        response_ue_per_n: Vec<f32>,
        n_gauges: usize,
        stream: u64,
    ) -> Result<Self, HapdefError> {
        let own = run.scene.rig.electronics.params();
        let params = ElectronicsParams { seed: own.seed.wrapping_add(stream), ..own };
        let strongest = run.scene.contact.force_range_n[1];
        let largest: Vec<f64> = (0..n_gauges)
            .map(|gauge| {
                let column = response_ue_per_n.iter().skip(gauge).step_by(n_gauges);
                strongest * f64::from(column.fold(0.0_f32, |m, v| m.max(v.abs())))
            })
            .collect();
        let electronics = Electronics::new(params, &largest)?;
        Ok(Self { response_ue_per_n, n_gauges, electronics })
    }

    /// Readings of a block of samples `[n, n_gauges]`, µε.
    pub(super) fn readings(&mut self, block: &[Vec<DrawnContact>]) -> Vec<f32> {
        let mut readings = Vec::with_capacity(block.len() * self.n_gauges);
        let mut frame = vec![0.0; self.n_gauges];
        for contacts in block {
            frame.fill(0.0);
            for contact in contacts {
                let row = &self.response_ue_per_n[contact.node * self.n_gauges..];
                for (sum, unit) in frame.iter_mut().zip(row) {
                    *sum += contact.force_n * f64::from(*unit);
                }
            }
            self.electronics.measure(&mut frame);
            readings.extend(frame.iter().map(|v| *v as f32));
        }
        readings
    }

    /// Readings so far that met an end of the converter's range.
    pub(super) fn n_saturated(&self) -> u64 {
        self.electronics.n_saturated()
    }
}
