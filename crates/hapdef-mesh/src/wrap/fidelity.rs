//! How far the skin is from the input, both ways, and where it is not the input.

use rayon::prelude::*;

use super::distance::Distances;
use super::field::Shape;
use super::input::{Input, SAMPLE_SPACING, Sample, samples, total_m2};
use super::params::Sizes;
use super::{WrapFault, WrapParams, WrapPlaces};
use crate::{MeshError, SurfaceMesh};

/// See [`WrapInfo`](super::WrapInfo).
pub(super) struct Fidelity {
    pub share_inside: f64,
    pub share_lost: f64,
    pub share_bridged: f64,
    pub input_to_skin_m: [f64; 2],
    pub skin_to_input_m: f64,
    pub places: WrapPlaces,
}

impl Fidelity {
    pub(super) fn of(
        skin: &SurfaceMesh,
        input: &Input,
        shape: &Shape,
        sizes: &Sizes,
        close_m: f64,
    ) -> Result<Self, MeshError> {
        let to_skin = Distances::to(skin)?;
        // What the flood sees is δ from its edge; what lies behind it is farther.
        let seen_m = 1.02 * close_m + 0.1 * sizes.grid_m;
        let is_seen = |sample: &Sample| shape.edge.at_m(&sample.point) < seen_m;
        let outside: Vec<Sample> = input.samples.par_iter().copied().filter(is_seen).collect();
        let skin_samples = samples(skin, SAMPLE_SPACING * sizes.grid_m);
        let in_to_skin = Measured::of(&outside, &to_skin);
        let skin_to_capped = Measured::of(&skin_samples, &input.to_capped);
        let far_m = sizes.far_m();
        let lost = in_to_skin.farther_than(far_m);
        let bridged = Measured::of(&skin_samples, &input.to_given).farther_than(far_m);
        let (lost_m2, bridged_m2) = (total_m2(lost.iter()), total_m2(bridged.iter()));
        let (all_m2, outside_m2) = (total_m2(input.samples.iter()), total_m2(outside.iter()));
        let points = |samples: Vec<Sample>| samples.into_iter().map(|s| s.point).collect();
        Ok(Self {
            share_inside: 1.0 - outside_m2 / all_m2,
            share_lost: lost_m2 / outside_m2,
            share_bridged: bridged_m2 / total_m2(skin_samples.iter()),
            input_to_skin_m: [0.5, 0.95].map(|q| in_to_skin.quantile_m(q)),
            skin_to_input_m: skin_to_capped.quantile_m(0.95),
            places: WrapPlaces {
                lost: points(lost),
                lost_m2,
                bridged: points(bridged),
                bridged_m2,
            },
        })
    }

    /// Refuses a skin that strays.
    pub(super) fn check(
        &self,
        params: &WrapParams,
        sizes: &Sizes,
        close_m: f64,
    ) -> Result<(), WrapFault> {
        let (allowed_lost, allowed_bridged) = (params.max_lost_share, params.max_bridged_share);
        if self.share_lost <= allowed_lost && self.share_bridged <= allowed_bridged {
            return Ok(());
        }
        Err(WrapFault::NotFaithful {
            share_lost: self.share_lost,
            allowed_lost,
            share_bridged: self.share_bridged,
            allowed_bridged,
            input_to_skin_m: self.input_to_skin_m,
            round_over_m: sizes.round_over_m,
            close_m,
            places: Box::new(self.places.clone()),
        })
    }
}

/// Samples with their distances, the nearest first.
struct Measured(Vec<(f64, Sample)>);

impl Measured {
    fn of(samples: &[Sample], to: &Distances) -> Self {
        let measured = samples.par_iter().map(|sample| (to.at_m(&sample.point), *sample));
        let mut measured: Vec<_> = measured.collect();
        measured.sort_by(|a, b| a.0.total_cmp(&b.0));
        Self(measured)
    }

    fn farther_than(&self, far_m: f64) -> Vec<Sample> {
        let first = self.0.partition_point(|(distance_m, _)| *distance_m <= far_m);
        self.0[first..].iter().map(|(_, sample)| *sample).collect()
    }

    /// The distance that a share `q` of the area does not exceed; 0 where there is none.
    fn quantile_m(&self, q: f64) -> f64 {
        let wanted_m2 = q * total_m2(self.0.iter().map(|(_, sample)| sample));
        let mut sum_m2 = 0.0;
        let reaches = |(_, sample): &&(f64, Sample)| {
            sum_m2 += sample.area_m2;
            sum_m2 >= wanted_m2
        };
        self.0.iter().find(reaches).or(self.0.last()).map_or(0.0, |(distance_m, _)| *distance_m)
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::*;

    #[test]
    fn quantiles_are_weighted_by_area() {
        let sample = |area_m2| Sample { point: Point3::origin(), area_m2 };
        let measured = Measured(vec![(1.0, sample(1.0)), (2.0, sample(8.0)), (5.0, sample(1.0))]);
        assert_eq!([0.05, 0.5, 0.9, 0.95].map(|q| measured.quantile_m(q)), [1.0, 2.0, 2.0, 5.0]);
        assert_eq!(measured.farther_than(2.0).len(), 1);
        assert_eq!(Measured(Vec::new()).quantile_m(0.5), 0.0);
    }
}
