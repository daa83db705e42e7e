//! Where to put gauges: greedy log-det, an exchange pass, and for comparison PCA-QR, nearest
//! neighbours, entropy, mutual information and chance.

mod cover;
mod exchange;
mod greedy;
mod information;
mod neighbours;
mod pca_qr;
mod process;
mod random;
mod score;

use nalgebra::Point3;

use crate::error::{InverseError, check_finite, check_length, check_not_negative, check_positive};

pub use cover::{CoverParams, cover, smallest_seen_n};
pub use exchange::exchange;
pub use greedy::place_greedy;
pub use neighbours::place_nearest_neighbours;
pub use pca_qr::place_pca_qr;
pub use process::{place_entropy, place_mutual_information};
pub(crate) use random::Draws;
pub use random::place_random;
pub use score::{PlacementScore, placement_score};

/// Places that gauges could have, and what they would read. A place with several axes is several
/// candidates at the same position, of which the spacing lets one be taken.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidates {
    /// Positions `[n_candidates]`, m.
    pub positions_m: Vec<Point3<f64>>,
    /// Positions of the contact sites `[n_sites]`, m.
    pub sites_m: Vec<Point3<f64>>,
    /// `[n_candidates, n_sites]`: reading per newton against the normal, and its slopes along two
    /// tangents of the skin at right angles, per metre.
    pub responses: Vec<[f64; 3]>,
    /// `[n_candidates, n_loads]`: reading for one standard deviation of each load on the whole limb that is no contact,
    /// unknown when contacts are looked for ([`crate::OtherLoads`]); empty where there are none. Greedy log-det, the exchange
    /// pass and scores count with them, the other methods don't.
    pub loads: Vec<f64>,
    /// Whether a gauge may sit there `[n_candidates]`: `false` in keep-out zones.
    pub allowed: Vec<bool>,
}

/// What is asked of a layout.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacementParams {
    /// Gauges in all, the mounted ones among them.
    pub n_gauges: usize,
    /// Candidates that are mounted already, and stay.
    pub mounted: Vec<usize>,
    /// Least distance of two gauges, m.
    pub min_spacing_m: f64,
    /// Standard deviation of a reading.
    pub noise_sd: f64,
    /// Force of the contacts, N.
    pub force_n: f64,
    /// Standard deviations of what is known before: place, m, and force, N. They keep the
    /// information of few gauges from being singular.
    pub prior_sd: (f64, f64),
    /// Pairs of contacts for the tail.
    pub n_pairs: usize,
    /// Least distance of the contacts of a pair, m.
    pub min_gap_m: f64,
    /// Candidates tried for each gauge in the exchange pass, the most promising ones.
    pub n_tried: usize,
    /// Seed of the pairs and of random layouts.
    pub seed: u64,
}

impl PlacementParams {
    /// Ten-millimetre spacing, 10 N contacts.
    #[must_use]
    pub fn new(n_gauges: usize, noise_sd: f64) -> Self {
        Self {
            n_gauges,
            mounted: Vec::new(),
            min_spacing_m: 0.01,
            noise_sd,
            force_n: 10.0,
            prior_sd: (0.05, 20.0),
            n_pairs: 300,
            min_gap_m: 0.012,
            n_tried: 60,
            seed: 1,
        }
    }
}

impl Candidates {
    pub(crate) fn n(&self) -> usize {
        self.positions_m.len()
    }

    pub(crate) fn n_sites(&self) -> usize {
        self.sites_m.len()
    }

    /// How many loads there are beside contacts.
    #[must_use]
    pub fn n_loads(&self) -> usize {
        self.loads.len() / self.n().max(1)
    }

    /// What candidate `c` reads over its noise for one unit of each unknown, in units of the prior, into `row`
    /// `[3 n_contacts + n_loads]`: contacts at `sites`, then the loads.
    pub(crate) fn unknowns(
        &self,
        c: usize,
        sites: &[usize],
        params: &PlacementParams,
        row: &mut [f64],
    ) {
        let (of_contacts, of_loads) = row.split_at_mut(3 * sites.len());
        for (three, &site) in of_contacts.chunks_exact_mut(3).zip(sites) {
            three.copy_from_slice(&self.row(c, site, params));
        }
        let n_loads = self.n_loads();
        let loads = &self.loads[c * n_loads..(c + 1) * n_loads];
        of_loads.iter_mut().zip(loads).for_each(|(own, load)| *own = load / params.noise_sd);
    }

    /// Whitened (A ∂₁g, A ∂₂g, g) of candidate `c` at `site`, in units of the prior.
    fn row(&self, c: usize, site: usize, params: &PlacementParams) -> [f64; 3] {
        let [g, d1, d2] = self.responses[c * self.n_sites() + site];
        let (place, force) = params.prior_sd;
        let slope = params.force_n * place / params.noise_sd;
        [d1 * slope, d2 * slope, g * force / params.noise_sd]
    }

    /// Whether candidate `c` is allowed and far enough from all `chosen`.
    pub(crate) fn fits(&self, c: usize, chosen: &[usize], params: &PlacementParams) -> bool {
        let x = self.positions_m[c];
        let is_free =
            |&o: &usize| o != c && (self.positions_m[o] - x).norm() >= params.min_spacing_m;
        self.allowed[c] && chosen.iter().all(is_free)
    }

    pub(crate) fn check(&self, params: &PlacementParams) -> Result<(), InverseError> {
        let n = self.n();
        check_length("responses", n * self.n_sites(), self.responses.len())?;
        check_length("allowed", n, self.allowed.len())?;
        check_finite("responses", self.responses.as_flattened())?;
        check_length("loads", n * self.n_loads(), self.loads.len())?;
        check_finite("loads", &self.loads)?;
        check_positive("the number of sites", self.n_sites() as f64)?;
        check_positive("noise_sd", params.noise_sd)?;
        check_positive("force_n", params.force_n)?;
        check_positive("prior_sd of the place", params.prior_sd.0)?;
        check_positive("prior_sd of the force", params.prior_sd.1)?;
        check_not_negative("min_spacing_m", params.min_spacing_m)?;
        match params.mounted.iter().find(|&&c| c >= n) {
            Some(&c) => Err(InverseError::Parameter {
                what: "a mounted gauge",
                found: c as f64,
                expected: "the index of a candidate",
            }),
            None => Ok(()),
        }
    }
}

/// No place is left for as many gauges.
pub(crate) fn no_place(expected: usize, found: usize) -> InverseError {
    let what = "gauges that find a place (allow more candidates or a smaller spacing)";
    InverseError::Length { what, expected, found }
}
