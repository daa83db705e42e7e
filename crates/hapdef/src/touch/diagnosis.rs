//! Why the contacts found in a frame are not those that pressed: by the search, by a tie or by the map.

use hapdef_inverse::{ContactEstimate, ContactEstimator, SkinPoint};
use serde::Serialize;

use crate::error::HapdefError;
use crate::scoring::{ScoredContact, score_one_to_one};
use crate::stats::FAR_M;

/// What an answer that isn't clean comes of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Cause {
    /// The readings prefer the truth, and it was not found.
    Search,
    /// The readings can't decide between both.
    Tie,
    /// The readings prefer what was found, by the map's error or the noise: contacts refined from the true places
    /// are a worse explanation, or end where they were found.
    Map,
}

impl Cause {
    /// The cause where what was found is `behind` the truth in −2 ln evidence; the two tie within `tie_delta`.
    #[must_use]
    pub fn of(behind: f64, tie_delta: f64) -> Self {
        match behind {
            behind if behind > tie_delta => Self::Search,
            behind if behind >= -tie_delta => Self::Tie,
            _ => Self::Map,
        }
    }

    /// One word.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Search => "search",
            Self::Tie => "tie",
            Self::Map => "map",
        }
    }
}

/// A frame with a contact farther than 10 mm from its match, missed or spurious.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct NotClean {
    /// Why.
    pub cause: Cause,
    /// −2 ln evidence of what was found less that of the truth.
    pub behind: f64,
    /// χ² of what was found.
    pub chi2: f64,
    /// χ² of contacts refined from the true places.
    pub chi2_of_truth: f64,
}

/// Frames by what became of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Causes {
    /// All contacts within 10 mm of a true one, none missed, none spurious.
    pub n_clean: usize,
    /// Not clean by [`Cause::Search`].
    pub n_search: usize,
    /// Not clean by [`Cause::Tie`].
    pub n_tie: usize,
    /// Not clean by [`Cause::Map`].
    pub n_map: usize,
}

impl Causes {
    /// Counts a frame, `None` one that is clean.
    pub fn add(&mut self, frame: Option<&NotClean>) {
        *match frame.map(|not_clean| not_clean.cause) {
            None => &mut self.n_clean,
            Some(Cause::Search) => &mut self.n_search,
            Some(Cause::Tie) => &mut self.n_tie,
            Some(Cause::Map) => &mut self.n_map,
        } += 1;
    }

    /// Frames that are not clean.
    #[must_use]
    pub fn n_bad(&self) -> usize {
        self.n_search + self.n_tie + self.n_map
    }

    /// Of the frames that are not clean those by the search, %; 0 where all are clean.
    #[must_use]
    pub fn search_pct(&self) -> f64 {
        100.0 * self.n_search as f64 / self.n_bad().max(1) as f64
    }
}

/// Why `found`, the answer of `estimator` to `readings` `[n_gauges]`, is not clean; `None` if it is. `truth` is where on
/// the skin contacts press, and with what normal force, N; they are refined on the same readings.
///
/// # Errors
/// [`HapdefError::Scoring`] for more contacts than are paired; [`HapdefError::Inverse`] for readings that can't be
/// used, or more true contacts than the gauges carry.
pub fn why_not_clean(
    estimator: &ContactEstimator,
    readings: &[f64],
    truth: &[(SkinPoint, f64)],
    found: &ContactEstimate,
) -> Result<Option<NotClean>, HapdefError> {
    let skin = estimator.map().skin();
    let at = |estimate: &ContactEstimate| -> Vec<ScoredContact> {
        estimate.contacts.iter().map(|c| (c.position_m.coords.into(), c.force_n)).collect()
    };
    let true_at = truth.iter().map(|(p, force_n)| (skin.position(p).coords.into(), *force_n));
    let (found_at, true_at) = (at(found), true_at.collect::<Vec<ScoredContact>>());
    if score_one_to_one(&found_at, &true_at)?.is_within(FAR_M) {
        return Ok(None);
    }
    let places: Vec<SkinPoint> = truth.iter().map(|(point, _)| *point).collect();
    let mut of_truth = ContactEstimate::default();
    estimator.refine_into(readings, &places, &mut estimator.scratch(), &mut of_truth)?;
    let (behind, params) = (found.cost - of_truth.cost, estimator.params());
    let is_same = score_one_to_one(&found_at, &at(&of_truth))?.is_within(params.distinct_m);
    Ok(Some(NotClean {
        cause: if is_same { Cause::Map } else { Cause::of(behind, params.tie_delta) },
        behind,
        chi2: found.chi2,
        chi2_of_truth: of_truth.chi2,
    }))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use hapdef_inverse::{
        EstimatorParams, NoiseParams, ResponseMap, ResponseParams, ScanSites, Skin, SkinFaces,
        SkinParams,
    };
    use nalgebra::{Point3, Vector3};

    use super::*;

    /// Cells of a plate, 10 mm each.
    const N: u32 = 12;

    /// Nine gauges in a plate, each of which sees presses up to about 40 mm away.
    fn estimator() -> ContactEstimator {
        let at = |i: u32, j: u32| Point3::new(f64::from(i), f64::from(j), 0.0) * 0.01;
        let nodes: Vec<_> = (0..=N).flat_map(|j| (0..=N).map(move |i| at(i, j))).collect();
        let cell = |i: u32, j: u32| {
            let [a, b] = [j * (N + 1) + i, (j + 1) * (N + 1) + i];
            [[a, a + 1, b + 1], [a, b + 1, b]]
        };
        let faces: Vec<_> = (0..N).flat_map(|j| (0..N).flat_map(move |i| cell(i, j))).collect();
        let gauges: Vec<_> =
            [2, 6, 10].into_iter().flat_map(|i| [1, 6, 11].map(|j| at(i, j))).collect();
        let seen = |x: &Point3<f64>| {
            let of = |gauge: &Point3<f64>| 100.0 * (-((x - gauge).norm() / 0.04).powi(2)).exp();
            gauges.iter().map(of).map(|ue| -ue * Vector3::z()).collect::<Vec<_>>()
        };
        let nodal: Vec<Vector3<f64>> = nodes.iter().flat_map(seen).collect();
        let params = SkinParams::default();
        let skin = Skin::new(nodes, SkinFaces::Linear(&faces), None, &params).unwrap();
        let params = ResponseParams::default();
        let map = ResponseMap::from_nodal(skin, gauges.len(), &nodal, &params).unwrap();
        let sites = ScanSites::farthest(map.skin(), 150).unwrap();
        let noise = NoiseParams::uniform(gauges.len(), 1.0);
        let params = EstimatorParams { max_contacts: 2, ..EstimatorParams::default() };
        ContactEstimator::new(Arc::new(map), Arc::new(sites), noise, params).unwrap()
    }

    #[test]
    fn a_worse_answer_is_the_searchs_and_a_better_one_the_maps() {
        let estimator = estimator();
        let skin = estimator.map().skin();
        let on = |x: f64, y: f64| skin.nearest(&Point3::new(x, y, 0.0)).unwrap().0;
        let truth = [(on(0.033, 0.028), 20.0), (on(0.091, 0.084), 10.0)];
        let mut readings = vec![0.0; estimator.map().n_gauges()];
        for (point, force_n) in &truth {
            let of_contact = estimator.map().normal(point);
            readings.iter_mut().zip(of_contact).for_each(|(r, g)| *r += force_n * g);
        }
        let found = estimator.estimate(&readings).unwrap();
        let why = |truth: &[_], found: &_| why_not_clean(&estimator, &readings, truth, found);
        assert_eq!(why(&truth, &found).unwrap(), None);

        let mut missed = ContactEstimate::default();
        let scratch = &mut estimator.scratch();
        estimator.refine_into(&readings, &[truth[0].0], scratch, &mut missed).unwrap();
        let searched = why(&truth, &missed).unwrap().unwrap();
        assert_eq!(searched.cause, Cause::Search);
        assert!(searched.behind > 100.0 && searched.chi2 > 100.0, "{searched:?}");
        assert!(searched.chi2_of_truth < 1.0, "{searched:?}");

        // The readings are of two contacts, whatever is said of them.
        let wrong = [(on(0.033, 0.028), 20.0)];
        let mapped = why(&wrong, &found).unwrap().unwrap();
        assert_eq!(mapped.cause, Cause::Map);
        assert!(mapped.behind < -100.0, "{mapped:?}");

        // True places 12 mm off refine to where the contacts were found: the readings are of those.
        let moved = [(on(0.045, 0.028), 20.0), truth[1]];
        let same = why(&moved, &found).unwrap().unwrap();
        assert_eq!(same.cause, Cause::Map);
        assert!(same.behind.abs() < 0.1, "{same:?}");

        let mut causes = Causes::default();
        [None, Some(&searched), Some(&mapped)].into_iter().for_each(|frame| causes.add(frame));
        assert_eq!((causes.n_clean, causes.n_bad(), causes.search_pct()), (1, 2, 50.0));
    }

    #[test]
    fn a_tie_reaches_to_both_sides() {
        let causes = [-1.1, -0.9, 0.9, 1.1].map(|behind| Cause::of(behind, 1.0));
        assert_eq!(causes, [Cause::Map, Cause::Tie, Cause::Tie, Cause::Search]);
    }
}
