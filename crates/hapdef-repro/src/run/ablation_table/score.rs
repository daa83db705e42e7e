//! Frames that every row is tested on, and what a row is worth.

use std::time::Instant;

use anyhow::Result;
use hapdef::stages::Datasets;
use hapdef::{
    ContactPair, ContactStats, MapError, MapErrorSum, score_lenient, score_one_to_one, scored,
};
use hapdef_bench::stats::median;
use serde::{Deserialize, Serialize};

use super::super::dataset::Dataset;
use super::super::presses::{Presses, presses};
use super::configurations::Configuration;
use super::target::TrueMaps;

/// Most presses of each kind on the rig, most simulated samples of each set.
const MOST_PRESSES: usize = 400;
const MOST_SIMULATED: usize = 100;

/// Frames that are timed, one by one.
const N_TIMED: usize = 30;

/// What every row is tested on.
pub(super) struct Tests {
    single: Vec<Presses>,
    double: Vec<Presses>,
    simulated: Vec<Presses>,
    timed: Vec<Presses>,
}

/// What a row is worth.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub(super) struct AblationRow {
    pub(super) name: String,
    pub(super) against: String,
    /// Error of its own map on simulated samples, from true virtual gauges.
    pub(super) simulated: Option<MapError>,
    /// The same on the rig's double presses, from readings.
    pub(super) double_map: Option<MapError>,
    /// Single presses of the rig.
    pub(super) single: ContactStats,
    /// Double presses of the rig by the paper's rule.
    pub(super) lenient: Option<ContactStats>,
    /// Each found contact with a true one of its own.
    pub(super) one_to_one: Option<ContactStats>,
    /// Weights of nets and modes.
    pub(super) n_weights: usize,
}

impl Tests {
    /// An even choice of test presses and test samples.
    pub(super) fn read(data: &Datasets) -> Result<Self> {
        let test = |set: &Dataset| Ok(set.split()?.test);
        let single = presses(&data.rig_single, test, MOST_PRESSES, true)?;
        let double = match &data.rig_double {
            Some(stage) => presses(stage, |set| Ok(0..set.n()), MOST_PRESSES, true)?,
            None => vec![],
        };
        let mut simulated = vec![];
        for stage in &data.simulated {
            simulated.extend(presses(stage, test, MOST_SIMULATED, false)?);
        }
        let timed = single.iter().flat_map(Presses::one_by_one);
        Ok(Self { timed: timed.take(N_TIMED).collect(), single, double, simulated })
    }

    /// What a row is worth.
    pub(super) fn row(
        &self,
        configuration: &Configuration<'_>,
        truth: &TrueMaps<'_>,
    ) -> Result<AblationRow> {
        let single = self.contacts(configuration, truth, &self.single)?;
        let double = match self.double.is_empty() {
            true => None,
            false => Some(self.contacts(configuration, truth, &self.double)?),
        };
        let mut simulated = error_sum(configuration, truth);
        let mut has_maps = false;
        for frames in &self.simulated {
            if let Some(maps) = configuration.simulated_maps(frames, truth)? {
                simulated.add(&truth.of(configuration.target(), &frames.drawn), &maps);
                has_maps = true;
            }
        }
        Ok(AblationRow {
            name: configuration.name.clone(),
            against: configuration.against.into(),
            simulated: has_maps.then(|| simulated.finish()),
            double_map: double.as_ref().map(|d| d.map),
            single: single.lenient,
            lenient: double.as_ref().map(|d| d.lenient),
            one_to_one: double.as_ref().map(|d| d.one_to_one),
            n_weights: configuration.n_weights(),
        })
    }

    /// Median time of one frame up to its contacts, s.
    pub(super) fn frame_s(
        &self,
        configuration: &Configuration<'_>,
        truth: &TrueMaps<'_>,
    ) -> Result<f64> {
        let n_surface = truth.directions.len();
        let mut times = vec![];
        for frame in &self.timed {
            let start = Instant::now();
            let field = configuration.target().field(configuration.maps(frame, truth)?);
            configuration.contacts(&field, n_surface, 1)?;
            times.push(start.elapsed().as_secs_f64());
        }
        Ok(median(times))
    }

    fn contacts(
        &self,
        configuration: &Configuration<'_>,
        truth: &TrueMaps<'_>,
        all: &[Presses],
    ) -> Result<Scores> {
        let n_surface = truth.directions.len();
        let (mut lenient, mut strict): (Vec<ContactPair>, Vec<ContactPair>) = (vec![], vec![]);
        let (mut map, mut n_expected) = (error_sum(configuration, truth), 0);
        for frames in all {
            let maps = configuration.maps(frames, truth)?;
            map.add(&truth.of(configuration.target(), &frames.drawn), &maps);
            let n_contacts = frames.truth[0].len();
            let found = configuration.contacts(
                &configuration.target().field(maps),
                n_surface,
                n_contacts,
            )?;
            for (found, truth) in found.iter().zip(&frames.truth) {
                let found = scored(found);
                lenient.extend(score_lenient(&found, truth)?);
                strict.extend(score_one_to_one(&found, truth)?.pairs);
                n_expected += truth.len();
            }
        }
        Ok(Scores {
            lenient: ContactStats::of(&lenient, n_expected),
            one_to_one: ContactStats::of(&strict, n_expected),
            map: map.finish(),
        })
    }
}

struct Scores {
    lenient: ContactStats,
    one_to_one: ContactStats,
    map: MapError,
}

fn error_sum(configuration: &Configuration<'_>, truth: &TrueMaps<'_>) -> MapErrorSum {
    MapErrorSum::new(configuration.target().width(truth.directions.len()))
}
