//! The simulated rig behind every frame of the comparison: presses anywhere on the skin.

use std::ops::Range;

use anyhow::Result;
use hapdef::stages::real_limb;
use hapdef::{Limb, Run};
use hapdef_inverse::{NoiseParams, ScanSites, Skin, SkinPoint};
use hapdef_rig::{Electronics, ElectronicsParams, RealLimb};
use hapdef_sim::GaugeSite;
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

/// One contact of a frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TrueContact {
    pub(crate) point: SkinPoint,
    /// Normal force, N.
    pub(crate) force_n: f64,
    /// Tangential force over normal force.
    pub(crate) friction: Vector3<f64>,
}

/// Contacts at a time and what every gauge of the rig reads.
#[derive(Clone, Debug)]
pub(crate) struct Frame {
    pub(crate) contacts: Vec<TrueContact>,
    /// `[n_channels]`, µε, as the converter gives them.
    pub(crate) readings_ue: Vec<f64>,
}

/// The rig with all its gauges, the scene's first.
pub(crate) struct World {
    pub(crate) real: RealLimb,
    pub(crate) skin: Skin,
    electronics: ElectronicsParams,
    largest_ue: Vec<f64>,
    tip_radius_m: f64,
}

impl World {
    /// Builds the rig with the scene's gauges and `further` ones behind them.
    pub(crate) fn build(
        run: &Run,
        limb: &Limb,
        skin: &Skin,
        further: &[GaugeSite],
    ) -> Result<Self> {
        let gauges: Vec<GaugeSite> = limb.sites.iter().chain(further).copied().collect();
        let real = real_limb(run, limb, &gauges)?;
        let mut world = Self {
            real,
            skin: skin.clone(),
            electronics: run.scene.rig.electronics.params(),
            largest_ue: vec![0.0; gauges.len()],
            tip_radius_m: run.scene.contact.tip_radius_m,
        };
        let sites = ScanSites::farthest(skin, 800)?;
        let strongest = run.scene.contact.force_range_n[1];
        for point in sites.points() {
            let unit = world.response(point, &Vector3::zeros(), world.tip_radius_m)?;
            for (largest, unit) in world.largest_ue.iter_mut().zip(unit) {
                *largest = largest.max(strongest * unit.abs());
            }
        }
        // loads of two standard deviations, whatever presses
        let spec = run.scene.loads.clone().unwrap_or_default();
        let responses = world.real.load_responses_ue();
        for (row, (_, sd)) in responses.chunks_exact(gauges.len()).zip(spec.loads()) {
            let each = world.largest_ue.iter_mut().zip(row);
            each.for_each(|(largest, unit)| *largest += 2.0 * sd * unit.abs());
        }
        Ok(world)
    }

    /// What is to be known of the noise of these channels: the converters' steps, too.
    pub(crate) fn noise(&self, channels: &Range<usize>) -> Result<NoiseParams> {
        let electronics = Electronics::new(self.electronics, &self.largest_ue)?;
        let steps = channels.clone().map(|channel| electronics.resolution_ue(channel));
        Ok(NoiseParams {
            quantisation_step: steps.collect(),
            ..NoiseParams::uniform(channels.len(), self.electronics.noise_ue)
        })
    }

    /// Readings of sets of contacts under a tip; `stream` seeds the noise.
    pub(crate) fn frames(
        &self,
        drawn: Vec<Vec<TrueContact>>,
        tip_radius_m: f64,
        stream: u64,
    ) -> Result<Vec<Frame>> {
        let strains: Result<Vec<Vec<f64>>> =
            drawn.par_iter().map(|contacts| self.strains(contacts, tip_radius_m)).collect();
        let mut electronics = self.electronics(stream)?;
        let frame = |(contacts, mut readings_ue): (_, Vec<f64>)| {
            electronics.measure(&mut readings_ue);
            Frame { contacts, readings_ue }
        };
        Ok(drawn.into_iter().zip(strains?).map(frame).collect())
    }

    /// The same beside loads that are no contacts, `amounts` `[n_frames][n_loads]` of each.
    pub(crate) fn loaded_frames(
        &self,
        drawn: Vec<Vec<TrueContact>>,
        amounts: &[Vec<f64>],
        stream: u64,
    ) -> Result<Vec<Frame>> {
        let mut electronics = self.electronics(stream)?;
        let n = self.largest_ue.len();
        let loads = self.real.load_responses_ue();
        let frame = |(contacts, amounts): (Vec<TrueContact>, &Vec<f64>)| {
            let mut readings_ue = self.strains(&contacts, self.tip_radius_m)?;
            for (row, amount) in loads.chunks_exact(n).zip(amounts) {
                readings_ue.iter_mut().zip(row).for_each(|(sum, unit)| *sum += amount * unit);
            }
            electronics.measure(&mut readings_ue);
            Ok(Frame { contacts, readings_ue })
        };
        drawn.into_iter().zip(amounts).map(frame).collect()
    }

    /// A measuring chain with noise of its own.
    pub(crate) fn electronics(&self, stream: u64) -> Result<Electronics> {
        let params = ElectronicsParams {
            seed: self.electronics.seed.wrapping_add(stream),
            ..self.electronics
        };
        Ok(Electronics::new(params, &self.largest_ue)?)
    }

    /// Strain of every gauge per newton of a contact, µε/N.
    pub(crate) fn unit_strains(&self, contact: &TrueContact) -> Result<Vec<f64>> {
        self.response(&contact.point, &contact.friction, self.tip_radius_m)
    }

    fn strains(&self, contacts: &[TrueContact], tip_radius_m: f64) -> Result<Vec<f64>> {
        let mut sum = vec![0.0; self.largest_ue.len()];
        for contact in contacts {
            let unit = self.response(&contact.point, &contact.friction, tip_radius_m)?;
            for (sum, unit) in sum.iter_mut().zip(unit) {
                *sum += contact.force_n * unit;
            }
        }
        Ok(sum)
    }

    fn response(&self, point: &SkinPoint, shear: &Vector3<f64>, tip_m: f64) -> Result<Vec<f64>> {
        let force = shear - self.skin.normal(point);
        let size = force.norm();
        let position = self.skin.position(point);
        let along = force / size;
        let unit = self.real.response_under_tip_ue_per_n(&position, &along, tip_m)?;
        Ok(unit.into_iter().map(|strain| strain * size).collect())
    }
}

/// Draws contacts on a skin.
pub(crate) struct Draw<'a> {
    pub(crate) skin: &'a Skin,
    pub(crate) rng: ChaCha8Rng,
    /// Running sums of the faces' areas.
    area_to: Vec<f64>,
}

impl<'a> Draw<'a> {
    pub(crate) fn new(skin: &'a Skin, seed: u64) -> Self {
        let mut sum = 0.0;
        let area_to = (0..skin.n_faces()).map(|face| {
            let corner = |i: usize| skin.nodes()[skin.face_nodes(face)[i] as usize];
            let (a, b) = (corner(1) - corner(0), corner(2) - corner(0));
            sum += 0.5 * a.cross(&b).norm();
            sum
        });
        Self { area_to: area_to.collect(), skin, rng: ChaCha8Rng::seed_from_u64(seed) }
    }

    /// A place, uniform over the area that contacts may be on.
    pub(crate) fn place(&mut self) -> SkinPoint {
        let whole = self.area_to.last().copied().unwrap_or(0.0);
        loop {
            let at = self.rng.random_range(0.0..whole);
            let face = self.area_to.partition_point(|to| *to <= at);
            let at = [self.rng.random(), self.rng.random()];
            if let Ok(point) = SkinPoint::drawn(self.skin, face, at) {
                return point;
            }
        }
    }

    /// `n` places whose distances, each to each, are all within `gap_m`.
    pub(crate) fn places(&mut self, n: usize, gap_m: [f64; 2]) -> Vec<SkinPoint> {
        loop {
            let places: Vec<SkinPoint> = (0..n).map(|_| self.place()).collect();
            let apart = |i: usize, j: usize| {
                let at = |k: usize| self.skin.position(&places[k]);
                let gap = (at(i) - at(j)).norm();
                (gap_m[0]..=gap_m[1]).contains(&gap)
            };
            if (0..n).all(|i| (0..i).all(|j| apart(i, j))) {
                return places;
            }
        }
    }

    /// A contact with friction up to `most_friction` in any direction.
    pub(crate) fn contact(
        &mut self,
        point: SkinPoint,
        force_n: f64,
        most_friction: f64,
    ) -> TrueContact {
        let [a, b] = self.skin.tangents(&point);
        let turn = self.rng.random_range(0.0..std::f64::consts::TAU);
        let size = most_friction * self.rng.random_range(0.0..=1.0);
        TrueContact { point, force_n, friction: (a * turn.cos() + b * turn.sin()) * size }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use hapdef_inverse::{SkinFaces, SkinParams};
    use nalgebra::Point3;

    use super::*;

    /// A triangle of 100 mm, and a contact of 10 N at each of these places on it, m.
    pub(in crate::compare) fn on_a_triangle(places_m: &[[f64; 2]]) -> (Skin, Vec<TrueContact>) {
        let corners = [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0]].map(Point3::from);
        let faces = SkinFaces::Linear(&[[0, 1, 2]]);
        let skin = Skin::new(corners.to_vec(), faces, None, &SkinParams::default()).unwrap();
        let contact = |[x, y]: &[f64; 2]| TrueContact {
            point: SkinPoint::new(&skin, 0, [1.0 - (x + y) / 0.1, x / 0.1, y / 0.1]).unwrap(),
            force_n: 10.0,
            friction: Vector3::zeros(),
        };
        let contacts = places_m.iter().map(contact).collect();
        (skin, contacts)
    }
}
