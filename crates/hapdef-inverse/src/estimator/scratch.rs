//! Buffers of the search, made once.

use crate::estimator::Model;
use crate::estimator::explanation::Explanation;
use crate::estimator::normal_equations::Linear;
use crate::estimator::pairs::{Pair, PairBuffers};
use crate::estimator::scan::{Company, Gain};

/// What [`crate::ContactEstimator::estimate_into`] works in; one for each thread.
#[derive(Clone, Debug)]
pub struct EstimatorScratch {
    pub(crate) linear: Linear,
    /// z / |z|, so that products fit in f32 whatever the force.
    pub(crate) unit_z: Vec<f64>,
    /// u·z / |z| by site.
    pub(crate) c: Vec<f32>,
    pub(crate) gains: Vec<f32>,
    pub(crate) peaks: Vec<Gain>,
    pub(crate) pair_buffers: PairBuffers,
    pub(crate) pairs: Vec<Pair>,
    pub(crate) company: Company,
    pub(crate) base_company: Company,
    pub(crate) atom: Vec<f64>,
    /// A joint covariance.
    pub(crate) joint: Vec<f64>,
    pub(crate) bases: Vec<Explanation>,
    pub(crate) starts: Vec<Explanation>,
    pub(crate) kept: Vec<Explanation>,
    /// Refined explanations of the frame.
    pub(crate) found: Vec<Explanation>,
}

impl EstimatorScratch {
    pub(crate) fn new(model: &Model) -> Self {
        let n_sites = model.n_sites();
        Self {
            linear: Linear::new(model),
            unit_z: vec![0.0; model.width],
            c: vec![0.0; n_sites],
            gains: vec![0.0; n_sites],
            peaks: Vec::with_capacity(64),
            pair_buffers: PairBuffers::new(n_sites),
            pairs: Vec::with_capacity(256),
            company: Company::new(model),
            base_company: Company::new(model),
            atom: vec![0.0; model.width],
            joint: Vec::new(),
            bases: Vec::with_capacity(256),
            starts: Vec::with_capacity(1024),
            kept: Vec::with_capacity(64),
            found: Vec::with_capacity(256),
        }
    }

    /// Whether it was made for a model of this size.
    pub(crate) fn fits(&self, model: &Model) -> bool {
        self.c.len() == model.n_sites()
            && self.linear.z.len() == model.width
            && self.linear.has_gauges(model.m)
    }
}
