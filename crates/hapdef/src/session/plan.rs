//! Where to press: spread over the skin at first, then where the map is least known.

use hapdef_inverse::{Calibrated, CalibrationParams, Press, ResponseMap, ScanSites, SkinPoint};

use super::hold::norm;
use crate::error::HapdefError;
use crate::touch::UncertainResponse;

/// Sites among which the next presses are chosen.
const N_SITES: usize = 240;

/// A press covers the skin around it, m.
const COVERED_M: f64 = 12e-3;

/// Places to press, and the map as far as it is known.
pub(super) struct Plan {
    response: UncertainResponse,
    sites: ScanSites,
    params: CalibrationParams,
    /// The map after the last fit.
    map: ResponseMap,
    /// Places to be asked for, the last one first, and how uncertain the map is there.
    ahead: Vec<(SkinPoint, Option<f64>)>,
    /// Relative error at presses not used, after the last fit.
    pub(super) relative_error: Option<f64>,
}

impl Plan {
    pub(super) fn new(
        response: UncertainResponse,
        n_first: usize,
        params: CalibrationParams,
    ) -> Result<Self, HapdefError> {
        let skin = response.map.skin();
        let first = ScanSites::farthest(skin, n_first)?;
        let mut ahead: Vec<_> = first.points().iter().map(|p| (*p, None)).collect();
        ahead.reverse();
        Ok(Self {
            sites: ScanSites::farthest(skin, N_SITES)?,
            map: response.map.clone(),
            response,
            params,
            ahead,
            relative_error: None,
        })
    }

    pub(super) fn response(&self) -> &UncertainResponse {
        &self.response
    }

    pub(super) fn map(&self) -> &ResponseMap {
        &self.map
    }

    /// The next place; the map is fitted anew when there is none left.
    pub(super) fn next(
        &mut self,
        presses: &[Press],
    ) -> Result<Option<(SkinPoint, Option<f64>)>, HapdefError> {
        if self.ahead.is_empty() {
            self.fit(presses)?;
        }
        Ok(self.ahead.pop())
    }

    /// How far a press is from what the map says, relative to that.
    pub(super) fn residual(&self, press: &Press) -> f64 {
        let expected = self.map.normal(&press.point);
        let readings = press.readings.iter().map(|r| r / press.force_n);
        let off = readings.zip(&expected).map(|(r, e)| r - e);
        norm(off) / norm(expected.iter().copied())
    }

    /// Share of the skin's sites with a press within 12 mm.
    pub(super) fn coverage(&self, presses: &[Press]) -> f64 {
        let skin = self.map.skin();
        let places: Vec<_> = presses.iter().map(|p| skin.position(&p.point)).collect();
        let sites = self.sites.positions();
        let is_covered = |site: &&nalgebra::Point3<f64>| {
            places.iter().any(|x| (*x - **site).norm() <= COVERED_M)
        };
        sites.iter().filter(is_covered).count() as f64 / sites.len() as f64
    }

    fn fit(&mut self, presses: &[Press]) -> Result<(), HapdefError> {
        let modes = self.response.modes();
        let fitted =
            Calibrated::fit(&self.response.map, &self.sites, &modes, presses, &self.params)?;
        self.relative_error = Some(fitted.info.relative_error);
        let next = fitted.info.next.iter().rev();
        self.ahead = next.map(|n| (n.point, Some(n.relative_sd))).collect();
        self.map = fitted.map;
        Ok(())
    }
}
