//! A search for scenes that are silently wrong: geometry, material, gauges, noise and forces at
//! random. Whatever the scene, there is a typed error, an answer that says that it is not sure, or a
//! contact where it was pressed. Scenes that once failed are in `scene_search.proptest-regressions`
//! and are tried first.
#![expect(clippy::unwrap_used, reason = "a test that can't prepare itself fails")]

use std::fs;
use std::path::Path;

use hapdef::touch::{response_map, superposition};
use hapdef::{HapdefError, Limb, Profile, Progress, Run};
use hapdef_inverse::{ContactEstimate, SkinPoint, Verdict};
use hapdef_mesh::{DeckMaterial, ShinParams, shin, write_inp};
use proptest::prelude::*;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use serde_json::{Value, json};

/// Standard deviations that a sure answer may be off, and the least that counts, m.
const MOST_SD: f64 = 6.0;
const LEAST_M: f64 = 2e-4;

/// A scene and a press.
#[derive(Clone, Debug)]
struct Trial {
    wall_m: f64,
    n_sectors: usize,
    n_rib_layers: usize,
    log10_e_pa: f64,
    nu: f64,
    n_gauges: usize,
    first_gauge: usize,
    log10_noise_ue: f64,
    log10_force_n: f64,
    place: f64,
    seed: u64,
}

fn trials() -> impl Strategy<Value = Trial> {
    let limb = (5e-4..1.9e-3_f64, 5..9_usize, 1..4_usize);
    let material = (5.0..12.0_f64, 0.0..0.49_f64);
    let gauges = (1..=10_usize, 0..10_usize, -3.0..3.0_f64);
    let press = (-3.0..4.0_f64, 0.0..1.0_f64, any::<u64>());
    (limb, material, gauges, press).prop_map(
        |(
            (wall_m, n_sectors, n_rib_layers),
            (log10_e_pa, nu),
            (n_gauges, first_gauge, log10_noise_ue),
            (log10_force_n, place, seed),
        )| Trial {
            wall_m,
            n_sectors,
            n_rib_layers,
            log10_e_pa,
            nu,
            n_gauges,
            first_gauge,
            log10_noise_ue,
            log10_force_n,
            place,
            seed,
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 24,
        max_shrink_iters: 40,
        failure_persistence: Some(Box::new(
            proptest::test_runner::FileFailurePersistence::WithSource("proptest-regressions"),
        )),
        ..ProptestConfig::default()
    })]

    #[test]
    fn no_scene_is_silently_wrong(trial in trials()) {
        let folder = tempfile::tempdir().unwrap();
        match answered(folder.path(), &trial) {
            Ok(answer) => prop_assert!(answer.is_honest(), "{:?}", answer),
            Err(error) => prop_assert!(!error.to_string().is_empty()),
        }
    }
}

/// Without extremes there is an answer, and it is sure: the search is not one of refusals alone.
#[test]
fn the_middle_of_the_search_is_answered() {
    let folder = tempfile::tempdir().unwrap();
    let trial = Trial {
        wall_m: 1e-3,
        n_sectors: 7,
        n_rib_layers: 3,
        log10_e_pa: 9.2,
        nu: 0.39,
        n_gauges: 10,
        first_gauge: 0,
        log10_noise_ue: 0.0,
        log10_force_n: 1.3,
        place: 0.37,
        seed: 1,
    };
    let answer = answered(folder.path(), &trial).unwrap();
    assert!(answer.is_sure && answer.n_contacts == 1, "{answer:?}");
    assert!(answer.is_honest(), "{answer:?}");
}

/// What a press gave.
#[derive(Debug)]
struct Answer {
    is_sure: bool,
    is_finite: bool,
    n_contacts: usize,
    /// Distance from the press over what is allowed.
    miss: f64,
}

impl Answer {
    fn is_honest(&self) -> bool {
        let is_right = self.n_contacts == 1 && self.miss <= 1.0;
        self.is_finite && (!self.is_sure || self.n_contacts == 0 || is_right)
    }
}

/// Makes the scene's files, solves it, presses it on its own map with noise as told.
fn answered(folder: &Path, trial: &Trial) -> Result<Answer, HapdefError> {
    let run = prepared(folder, trial)?;
    let limb = Limb::load(&run.scene, &run.scene_dir)?;
    let map = response_map(&limb, run.scene.contact.tip_radius_m, 1)?;
    let spec = run.scene.estimator.superposition();
    let skin = map.skin().clone();
    let face = (trial.place * skin.n_faces() as f64) as usize;
    let point = SkinPoint::new(&skin, face.min(skin.n_faces() - 1), [0.4, 0.3, 0.3])?;
    let mut rng = ChaCha8Rng::seed_from_u64(trial.seed);
    let noise_ue = 10f64.powf(trial.log10_noise_ue);
    let force_n = 10f64.powf(trial.log10_force_n);
    let mut noisy = |g: f64| {
        let draw: f64 = StandardNormal.sample(&mut rng);
        g * force_n + noise_ue * draw
    };
    let readings: Vec<f64> = map.normal(&point).into_iter().map(&mut noisy).collect();
    let estimator = superposition(&run.scene, &spec, map)?.into_estimator();
    let estimate = estimator.estimate(&readings)?;
    let truth = skin.position(&point);
    Ok(judged(&estimate, &truth))
}

fn judged(estimate: &ContactEstimate, truth: &nalgebra::Point3<f64>) -> Answer {
    let contacts = &estimate.contacts;
    let miss = contacts.first().map_or(0.0, |found| {
        let sd_m = found.covariance[(0, 0)]
            .max(found.covariance[(1, 1)])
            .sqrt();
        (found.position_m - truth).norm() / (MOST_SD * sd_m + LEAST_M)
    });
    let is_finite = contacts.iter().all(|c| {
        let numbers = c.position_m.coords.iter().chain(&c.covariance);
        c.force_n.is_finite() && numbers.clone().all(|x| x.is_finite())
    });
    Answer {
        is_sure: !matches!(estimate.verdict, Verdict::NotIdentifiable(_)),
        is_finite,
        n_contacts: contacts.len(),
        miss,
    }
}

/// The bundled scene on a limb of other measures, with some of its gauges.
fn prepared(folder: &Path, trial: &Trial) -> Result<Run, HapdefError> {
    let params = ShinParams {
        wall_m: trial.wall_m,
        n_sectors: trial.n_sectors,
        n_rib_layers: trial.n_rib_layers,
        panel_cells: (3, 3),
        holes: Vec::new(),
        material: DeckMaterial {
            youngs_modulus_pa: 10f64.powf(trial.log10_e_pa),
            poissons_ratio: trial.nu,
            ..ShinParams::default().material
        },
        ..ShinParams::default()
    };
    let deck = shin(&params)?.deck;
    write_inp(&folder.join("limb.inp"), &deck)?;
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/shin/placed.json");
    let mut scene: Value = serde_json::from_slice(&fs::read(source).unwrap()).unwrap();
    scene["geometry"]["solid_deck"] = json!("limb.inp");
    let sites = scene["gauges"]["sites"].as_array().unwrap().clone();
    let some = sites
        .iter()
        .cycle()
        .skip(trial.first_gauge)
        .take(trial.n_gauges);
    scene["gauges"]["sites"] = some.cloned().collect();
    scene["estimator"]["noise_ue"] = json!(10f64.powf(trial.log10_noise_ue));
    scene["contact"]["force_range_n"] =
        json!([0.0, 10f64.powf(trial.log10_force_n.max(0.0) + 0.5)]);
    let path = folder.join("scene.json");
    fs::write(&path, scene.to_string()).unwrap();
    Run::new(
        &path,
        Profile::quick(),
        &folder.join("out"),
        1,
        Progress::silent(),
    )
}
