//! What the gauges read when the limb is pressed near one of them, by its model.

use std::path::Path;

use anyhow::Result;
use hapdef::Limb;
use hapdef::scene::read_scene;
use hapdef::touch::response_map;
use hapdef_inverse::ResponseMap;
use hapdef_live::Bundle;
use nalgebra::Point3;

use super::super::files::is_bundle;

/// How far from a gauge a press near it may be, m.
const NEAR_M: f64 = 0.010;
/// A swap is reported where what is left of the readings without it is so much more than with it.
const CLEARLY: f64 = 2.0;

/// What a newton near each gauge does to all of them.
pub(super) struct Expected {
    /// Readings `[n_gauges]` for each point near each gauge.
    near: Vec<Vec<Vec<f64>>>,
}

impl Expected {
    /// That of a scene, whose limb is solved, or of a bundle.
    pub(super) fn read(path: &Path) -> Result<Self> {
        if is_bundle(path)? {
            let bundle = Bundle::read(path)?;
            let places = bundle.info.gauges.iter().map(|g| g.position_m.into());
            return Ok(Self::of(bundle.map(), &places.collect::<Vec<_>>()));
        }
        let scene = read_scene(path)?;
        let limb = Limb::load(&scene, path.parent().unwrap_or(Path::new(".")))?;
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        let map = response_map(&limb, scene.contact.tip_radius_m, threads)?;
        let places: Vec<_> = limb.sites.iter().map(|site| site.position).collect();
        Ok(Self::of(&map, &places))
    }

    fn of(map: &ResponseMap, gauges: &[Point3<f64>]) -> Self {
        let skin = map.skin();
        let points: Vec<_> = skin.node_points().into_iter().flatten().collect();
        let near = |gauge: &Point3<f64>| {
            let gaps = points.iter().map(|p| (skin.position(p) - gauge).norm());
            let gaps: Vec<f64> = gaps.collect();
            let nearest = gaps.iter().copied().fold(f64::INFINITY, f64::min);
            let reach_m = NEAR_M.max(nearest);
            let chosen = points.iter().zip(&gaps).filter(|(_, gap)| **gap <= reach_m);
            chosen.map(|(point, _)| map.normal(point)).collect()
        };
        Self { near: gauges.iter().map(near).collect() }
    }

    /// The gauge whose channel reads what `gauge` should, pressed near it: itself, unless `readings`
    /// `[n_gauges]` are clearly better explained with the two swapped.
    pub(super) fn answering(&self, gauge: usize, readings: &[f64]) -> usize {
        let left_by = |other: usize| {
            let mut swapped = readings.to_vec();
            swapped.swap(gauge, other);
            let near = self.near[gauge].iter();
            near.map(|unit| left(unit, &swapped)).fold(1.0, f64::min)
        };
        let own = left_by(gauge);
        let others = (0..readings.len()).map(|other| (other, left_by(other)));
        let best = others.min_by(|a, b| a.1.total_cmp(&b.1));
        best.filter(|(_, least)| own > CLEARLY * least).map_or(gauge, |(other, _)| other)
    }
}

/// The part of the readings that no force with this response explains.
fn left(unit: &[f64], readings: &[f64]) -> f64 {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    let cosine = dot(unit, readings) / (dot(unit, unit) * dot(readings, readings)).sqrt();
    (1.0 - cosine.max(0.0).powi(2)).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use hapdef::{Profile, Progress, Run, live_limb};
    use hapdef_rig::live::LiveLimb;

    use super::*;

    /// The bundled limb as it is drawn, and as it is.
    fn limbs() -> (Expected, Arc<LiveLimb>, Vec<Point3<f64>>) {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let path = root.join("fixtures/shin/placed.json");
        let out = root.join("target/hapdef");
        let run = Run::new(&path, Profile::full(), &out, 2, Progress::silent()).unwrap();
        let limb = Limb::load(&run.scene, &run.scene_dir).unwrap();
        let places = limb.sites.iter().map(|site| site.position).collect();
        let real = Arc::new(live_limb(&run, &limb).unwrap());
        (Expected::read(&path).unwrap(), real, places)
    }

    /// Presses near every gauge, a little beside it: none answers for another; and with any two wires
    /// swapped, no others do, and these do, but for two presses of 90 that move both gauges alike.
    #[test]
    fn any_two_swapped_wires_are_found_on_a_limb_that_is_not_quite_its_model() {
        let (expected, real, places) = limbs();
        let n = places.len();
        let readings: Vec<Vec<f64>> = places
            .iter()
            .map(|place| {
                let (point, _) = real.nearest(&(place + nalgebra::Vector3::y() * 3e-3)).unwrap();
                let mut readings = vec![0.0; n];
                real.add_strain_ue(&point, &(real.inward(&point) * 15.0), &mut readings);
                readings
            })
            .collect();
        let found = |swapped: Option<(usize, usize)>| -> Vec<usize> {
            let answers = (0..n).map(|gauge| {
                let mut readings = readings[gauge].clone();
                if let Some((a, b)) = swapped {
                    readings.swap(a, b);
                }
                expected.answering(gauge, &readings)
            });
            answers.collect()
        };
        let right: Vec<usize> = (0..n).collect();
        assert_eq!(found(None), right);
        let mut n_told = 0;
        for a in 0..n {
            for b in a + 1..n {
                let answers = found(Some((a, b)));
                let [of_a, of_b] = [answers[a] == b, answers[b] == a];
                assert!(of_a || of_b, "{a} and {b}: {answers:?}");
                n_told += usize::from(of_a) + usize::from(of_b);
                let others = right.iter().filter(|i| ![a, b].contains(i));
                assert!(others.into_iter().all(|&i| answers[i] == i), "{a} and {b}: {answers:?}");
            }
        }
        assert_eq!(n_told, n * (n - 1) - 2);
    }
}
