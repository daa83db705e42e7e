//! Parameters of the estimator.

use crate::effort::Effort;
use crate::error::{InverseError, check_not_negative, check_positive};
use crate::estimator::wide_params::WideParams;

/// Explanations with a force beyond so many times the strongest that touches are expected to have are not believed: a
/// contact of where the map is uncertain would else explain anything with it.
pub const BELIEVED_OF_RANGE: f64 = 1.5;

/// How hard to search and when to believe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EstimatorParams {
    /// Contacts looked for at most; the live gauges carry one for every three of them.
    pub max_contacts: usize,
    /// The number of contacts where it is known, which then is not estimated.
    pub known_count: Option<usize>,
    /// Below this probability of the readings without any contact, something touches.
    pub touch_p: f64,
    /// An explanation whose residual has at least this probability is good enough: none with more
    /// contacts is looked for, unless there are two already, the map is uncertain, and the gauges could
    /// check one.
    pub accept_p: f64,
    /// The probability that the residual of two contacts and more needs there: a contact that the map's error
    /// may hide leaves a residual that is likely, but less so than without it. The
    /// contacts of the first few starts are exchanged until a residual has it.
    pub settle_p: f64,
    /// Each contact beyond those of an explanation that is good enough has to improve −2 ln evidence by
    /// this.
    pub settle_margin: f64,
    /// A misfit less probable than this, with as many contacts as may be, is reported.
    pub misfit_p: f64,
    /// Single-contact starts that are refined.
    pub n_single_starts: usize,
    /// Starts with two contacts and more that are refined.
    pub n_starts: usize,
    /// Explanations that a further contact is added to, for three contacts and more.
    pub n_bases: usize,
    /// Further contacts tried for each of them.
    pub n_per_base: usize,
    /// Steps of every start before the worse ones are dropped.
    pub n_probe_steps: usize,
    /// Starts that are refined to the end.
    pub n_finalists: usize,
    /// Rounds of new starts around the best explanation's contacts.
    pub n_hops: usize,
    /// Explanations with three contacts and more whose contacts are exchanged two at a time where none is
    /// good enough.
    pub n_exchanged: usize,
    /// Pairs beside each of which pairs are looked for, where four contacts are not found otherwise.
    pub n_pairs_of_pairs: usize,
    /// Steps at most of a refinement.
    pub max_steps: usize,
    /// Longest step of a contact, m.
    pub max_step_m: f64,
    /// A refinement ends when χ² falls by less than this.
    pub chi2_tolerance: f64,
    /// Forces are expected to be of this size, N: the standard deviation of their prior.
    pub force_scale_n: f64,
    /// Explanations with a larger force are not believed, N: where the map is uncertain, a contact of
    /// thousands of newtons on a stiff place explains everything. Where contacts are followed they lose in
    /// evidence beyond it. Infinite for no limit.
    pub max_force_n: f64,
    /// A further contact has to improve −2 ln evidence by this.
    pub count_margin: f64,
    /// Explanations with a contact farther than this from its match are different, m.
    pub distinct_m: f64,
    /// Different explanations within this of the best in −2 ln evidence are reported.
    pub runner_up_delta: f64,
    /// Different explanations within this of the best tie with it.
    pub tie_delta: f64,
    /// One contact wider than the map's tip is looked for where narrow ones leave a doubt; none if absent.
    pub wide: Option<WideParams>,
    /// Contacts are believed if fewer of them with more noise than was assumed are worse by this in
    /// −2 ln evidence; −∞ trusts the noise.
    pub noise_delta: f64,
}

impl Default for EstimatorParams {
    /// [`Effort::Usual`].
    fn default() -> Self {
        Self::of(Effort::Usual)
    }
}

impl EstimatorParams {
    /// The parameters of a search of that effort, on [`Effort::n_sites`] sites: the usual ones but for
    /// what [`EstimatorParams::searched_with`] sets.
    #[must_use]
    pub fn of(effort: Effort) -> Self {
        let usual = Self {
            max_contacts: 4,
            known_count: None,
            // one untouched frame in a thousand is searched in vain, which costs time, not a contact: the
            // evidence decides about that
            touch_p: 1e-3,
            // in one true answer of a hundred more contacts are looked for in vain; a pair that one
            // contact explains to p = 0.015 needs 0.05 to be seen, or `ContactEstimate::if_two`
            accept_p: 0.01,
            // A contact hides in the map's error while the residual of fewer is likely: with `accept_p`
            // here 44 instead of 52 of 60 frames of three contacts have their count right
            // (`a_contact_that_the_maps_error_may_hide_is_looked_for`). Both were chosen on simulated
            // frames of sixteen gauges. 4 is odds of e² against the contact more: without a margin every
            // search beyond a good answer would be another chance for noise.
            settle_p: 0.5,
            settle_margin: 4.0,
            // one frame in a million, 17 minutes at 1,000 a second, is a misfit by noise alone
            misfit_p: 1e-6,
            n_single_starts: 6,
            // 10 starts leave 8.5 % of pairs beyond 10 mm, 30 leave 3.0, 150 leave 1.5 and 600 leave 2.0, on
            // 200 to 1,200 sites (`cargo xtask frontier inverse`, docs/contacts.md): more than 150 only
            // cost time, unless there are three contacts
            n_starts: 150,
            n_bases: 300,
            n_per_base: 3,
            n_probe_steps: 3,
            // go with `n_starts`: a tenth of the starts is refined to the end
            n_finalists: 16,
            // a descent may end at a kink of the map between two faces: one round starts again around it
            n_hops: 1,
            // Of 600 frames of four contacts on sixteen gauges 93.8 % were clean with exchange alone, 95.3 % with 60
            // pairs beside pairs, too, 95.5 % with 100, which take longer: 300 each of the rows of `cargo xtask compare --
            // --diagnose` with the test seeds 611 and 612, taken before the rest of the search was as it is.
            n_exchanged: 4,
            n_pairs_of_pairs: 60,
            max_steps: 40,
            // of the order of the sites' spacing: beyond, other starts search
            max_step_m: 0.01,
            chi2_tolerance: 1e-6,
            force_scale_n: 20.0,
            max_force_n: f64::INFINITY,
            count_margin: 0.0,
            distinct_m: 0.005,
            // odds of 90 to 1, 1.6 to 1 and 20 to 1: −2 ln of them is the difference in cost
            runner_up_delta: 9.0,
            tie_delta: 1.0,
            noise_delta: 6.0,
            wide: None,
        };
        usual.searched_with(effort)
    }

    /// The same with as many starts, bases, finalists, hops and exchanges as `effort` takes: these decide how
    /// long a search of two contacts and more takes, and how often it misses the best explanation.
    #[must_use]
    pub fn searched_with(self, effort: Effort) -> Self {
        let (n_starts, n_finalists, n_hops) = match effort {
            Effort::Fast => (30, 4, 0),
            Effort::Usual => (150, 16, 1),
            Effort::Thorough => (600, 64, 2),
        };
        let (n_exchanged, n_pairs_of_pairs) = match effort {
            Effort::Fast => (1, 0),
            Effort::Usual => (4, 60),
            Effort::Thorough => (16, 300),
        };
        let n_bases = 2 * n_starts;
        Self { n_starts, n_bases, n_finalists, n_hops, n_exchanged, n_pairs_of_pairs, ..self }
    }

    /// The strongest force that touches are expected to have, N.
    #[must_use]
    pub fn range_n(&self) -> f64 {
        self.max_force_n / BELIEVED_OF_RANGE
    }

    pub(crate) fn check(&self) -> Result<(), InverseError> {
        let most = super::MAX_CONTACTS;
        let found = self.known_count.unwrap_or(1).max(self.max_contacts);
        if self.max_contacts == 0 || found > most {
            return Err(InverseError::TooManyContacts { found, most });
        }
        for (what, p) in [
            ("touch_p", self.touch_p),
            ("accept_p", self.accept_p),
            ("settle_p", self.settle_p),
            ("misfit_p", self.misfit_p),
        ] {
            if !(0.0..=1.0).contains(&p) {
                return Err(InverseError::Parameter {
                    what,
                    found: p,
                    expected: "a probability, 0 to 1",
                });
            }
        }
        for (what, n) in [
            ("n_single_starts", self.n_single_starts),
            ("n_starts", self.n_starts),
            ("n_bases", self.n_bases),
            ("n_per_base", self.n_per_base),
            ("n_finalists", self.n_finalists),
        ] {
            check_positive(what, n as f64)?;
        }
        self.wide.as_ref().map_or(Ok(()), WideParams::check)?;
        check_positive("max_step_m", self.max_step_m)?;
        check_positive("force_scale_n", self.force_scale_n)?;
        check_positive("distinct_m", self.distinct_m)?;
        check_not_negative("chi2_tolerance", self.chi2_tolerance)?;
        check_not_negative("runner_up_delta", self.runner_up_delta)?;
        check_not_negative("tie_delta", self.tie_delta)?;
        if self.max_force_n.is_nan() || self.max_force_n <= 0.0 {
            return Err(InverseError::Parameter {
                what: "max_force_n",
                found: self.max_force_n,
                expected: "above 0",
            });
        }
        for (what, found) in
            [("count_margin", self.count_margin), ("settle_margin", self.settle_margin)]
        {
            if !found.is_finite() {
                let expected = "a finite number";
                return Err(InverseError::Parameter { what, found, expected });
            }
        }
        Ok(())
    }
}
