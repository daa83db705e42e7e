//! The estimator: what it is made of, and how many contacts it looks for.

use std::sync::Arc;

use crate::chi_square::upper_tail;
use crate::error::InverseError;
use crate::estimator::effective_rank::effective_rank;
use crate::estimator::explanation::Explanation;
use crate::estimator::{EstimatorParams, EstimatorScratch, Model};
use crate::noise::NoiseParams;
use crate::other_loads::OtherLoads;
use crate::response::ResponseMap;
use crate::sites::ScanSites;

/// Finds the contacts behind readings.
#[derive(Clone, Debug)]
pub struct ContactEstimator {
    pub(crate) model: Model,
    pub(crate) noise: NoiseParams,
    pub(crate) params: EstimatorParams,
    /// Directions in which contacts move the readings beyond the noise.
    pub(crate) effective_rank: usize,
    /// One contact on maps of wider tips; none where none are looked for.
    pub(crate) wide: Vec<OfRadius>,
}

/// What looks for one contact of a radius.
#[derive(Clone, Debug)]
pub(crate) struct OfRadius {
    pub(crate) radius_m: f64,
    pub(crate) estimator: ContactEstimator,
}

impl ContactEstimator {
    /// An estimator for the map `map`, scanned at `sites`, all gauges alive.
    ///
    /// # Errors
    /// [`InverseError`] for unusable parameters, a wrong length, fewer than three gauges.
    pub fn new(
        map: Arc<ResponseMap>,
        sites: Arc<ScanSites>,
        noise: NoiseParams,
        params: EstimatorParams,
    ) -> Result<Self, InverseError> {
        params.check()?;
        let live = vec![true; map.n_gauges()];
        let estimator = Self::with_gauges(map, sites, noise, params, &live)?;
        match &params.wide {
            Some(wide) => estimator.widened(wide),
            None => Ok(estimator),
        }
    }

    /// The same estimator with only the gauges of `live` `[n_gauges]`: readings of the others are
    /// not looked at, and every covariance grows accordingly.
    ///
    /// # Errors
    /// [`InverseError::TooFewGauges`] with fewer than three alive; [`InverseError::Length`].
    pub fn masked(&self, live: &[bool]) -> Result<Self, InverseError> {
        self.changed(self.noise.clone(), live, |wide| wide.masked(live))
    }

    /// Standard deviation of each gauge's noise `[n_gauges]`, in the unit of the map, without what its
    /// converter adds.
    #[must_use]
    pub fn gauge_sd(&self) -> &[f64] {
        &self.noise.gauge_sd
    }

    /// The same estimator with other noise `[n_gauges]`.
    ///
    /// # Errors
    /// [`InverseError`] for a wrong length or a value that is not above 0.
    pub fn with_gauge_sd(&self, gauge_sd: &[f64]) -> Result<Self, InverseError> {
        let noise = NoiseParams { gauge_sd: gauge_sd.to_vec(), ..self.noise.clone() };
        self.changed(noise, &self.live(), |wide| wide.with_gauge_sd(gauge_sd))
    }

    /// The same estimator on a limb with such loads that are no contacts.
    ///
    /// # Errors
    /// [`InverseError`] for loads of another number of gauges or values that are not finite.
    pub fn with_loads(&self, loads: OtherLoads) -> Result<Self, InverseError> {
        let noise = NoiseParams { loads: loads.clone(), ..self.noise.clone() };
        self.changed(noise, &self.live(), |wide| wide.with_loads(loads.clone()))
    }

    /// Which gauges count `[n_gauges]`.
    fn live(&self) -> Vec<bool> {
        (0..self.model.map.n_gauges()).map(|gauge| self.model.live.contains(&gauge)).collect()
    }

    /// The loads that are no contacts.
    #[must_use]
    pub fn loads(&self) -> &OtherLoads {
        &self.noise.loads
    }

    /// The same estimator for narrow contacts alone.
    pub(crate) fn without_wide(mut self) -> Self {
        self.params.wide = None;
        self.wide.clear();
        self
    }

    /// The same estimator on another map, wider tips left out.
    pub(crate) fn on_map(&self, map: Arc<ResponseMap>) -> Result<Self, InverseError> {
        let sites = self.model.sites.clone();
        Self::with_gauges(map, sites, self.noise.clone(), self.params, &self.live())
    }

    /// The same estimator with other noise and gauges, on maps of wider tips, too.
    fn changed(
        &self,
        noise: NoiseParams,
        live: &[bool],
        wide: impl Fn(&Self) -> Result<Self, InverseError>,
    ) -> Result<Self, InverseError> {
        let (map, sites) = (self.model.map.clone(), self.model.sites.clone());
        let estimator = Self::with_gauges(map, sites, noise, self.params, live)?;
        let changed = self
            .wide
            .iter()
            .map(|of| Ok(OfRadius { radius_m: of.radius_m, estimator: wide(&of.estimator)? }));
        Ok(Self { wide: changed.collect::<Result<_, InverseError>>()?, ..estimator })
    }

    fn with_gauges(
        map: Arc<ResponseMap>,
        sites: Arc<ScanSites>,
        noise: NoiseParams,
        params: EstimatorParams,
        live: &[bool],
    ) -> Result<Self, InverseError> {
        let mut model = Model::new(map, sites, &noise, live)?;
        model.max_force_n = params.max_force_n;
        let (map, sites) = (&model.map, &model.sites);
        let estimator = Self {
            effective_rank: effective_rank(map, sites, &noise, &model.live, params.force_scale_n),
            model,
            noise,
            params,
            wide: Vec::new(),
        };
        if estimator.most_contacts() > 1 {
            // now, not in the first frame that asks for pairs
            estimator.model.gram();
        }
        Ok(estimator)
    }

    /// How contacts are looked for.
    #[must_use]
    pub fn params(&self) -> &EstimatorParams {
        &self.params
    }

    /// The response map.
    #[must_use]
    pub fn map(&self) -> &ResponseMap {
        &self.model.map
    }

    /// The most contacts that are looked for: a contact takes three unknowns, so the live gauges
    /// carry one for every three of them. Gauges that contacts of the expected force don't move
    /// beyond their noise don't count, nor those that only repeat others; one contact is always
    /// looked for.
    #[must_use]
    pub fn most_contacts(&self) -> usize {
        let wanted = self.params.known_count.unwrap_or(self.params.max_contacts);
        wanted.min((self.effective_rank / 3).max(1))
    }

    /// Buffers for [`ContactEstimator::estimate_into`].
    #[must_use]
    pub fn scratch(&self) -> EstimatorScratch {
        EstimatorScratch::new(&self.model)
    }

    pub(crate) fn p_value(&self, e: &Explanation) -> f64 {
        upper_tail(e.chi2, self.model.m.saturating_sub(3 * e.n))
    }

    /// Whether no force is beyond what is possible.
    pub(crate) fn is_believed(&self, e: &Explanation) -> bool {
        e.forces[..e.n].iter().all(|&a| a <= self.params.max_force_n)
    }
}
