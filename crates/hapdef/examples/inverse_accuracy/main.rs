//! Contacts by superposition on a scene's limb: errors by number of contacts and time per frame.
//!
//! First the map is exact and readings carry 5 µε of noise; then the readings are those of the
//! simulated, perturbed limb, 1 µε, and the map is not calibrated.
//!
//! `cargo run --release -p hapdef --example inverse_accuracy -- [scene.json] [n_frames] [parts]`
#![allow(clippy::print_stdout, reason = "a table is what it is for")]

mod row;

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use anyhow::{Context, Result};
use hapdef::Limb;
use hapdef::scene::read_scene;
use hapdef_inverse::{
    ContactEstimate, ContactEstimator, EstimatorParams, ModelError, NoiseParams, ResponseMap,
    ResponseParams, ScanSites, Skin, SkinFaces, SkinParams, SkinPoint,
};
use hapdef_mesh::GaugeId;
use hapdef_rig::{
    GainParams, MisplacementParams, NominalLimb, RealLimb, RigParams, VariationParams,
};
use hapdef_sim::{ElasticModel, ElasticParams};
use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use row::{Response, Row};

const N_SITES: usize = 800;

fn main() -> Result<()> {
    let bundled = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../fixtures/shin/scene.json"
    );
    let mut args = std::env::args().skip(1);
    let path = PathBuf::from(args.next().unwrap_or_else(|| bundled.to_owned()));
    let n_frames = args.next().map_or(Ok(300), |n| n.parse())?;
    let parts = args.next().unwrap_or_else(|| "exact,rig".to_owned());
    let scene = read_scene(&path)?;
    let limb = Limb::load(&scene, path.parent().context("a scene lies in a folder")?)?;
    let tip_radius_m = scene.contact.tip_radius_m;
    let start = Instant::now();
    let map = Arc::new(response_map(&limb, tip_radius_m)?);
    let sites = Arc::new(ScanSites::farthest(map.skin(), N_SITES)?);
    println!(
        "map of {} gauges on {} nodes, {} faces, {} sites within {:.1} mm: {:.2} s",
        map.n_gauges(),
        map.skin().n_nodes(),
        map.skin().n_faces(),
        sites.len(),
        sites.spacing_m() * 1e3,
        start.elapsed().as_secs_f64()
    );
    let uniform = |sd| NoiseParams::uniform(map.n_gauges(), sd);
    if parts.contains("exact") {
        let exact = |p: &SkinPoint| Ok(map.normal(p));
        let title = "the map is exact, 5 µε";
        table(title, &map, &sites, &uniform(5.0), n_frames, &exact)?;
    }
    if parts.contains("rig") {
        let real = real_limb(&limb, tip_radius_m)?;
        let perturbed = |p: &SkinPoint| -> Result<Vec<f64>> {
            let skin = map.skin();
            Ok(real.response_ue_per_n(&skin.position(p), &-skin.normal(p))?)
        };
        let relative = relative_error(&map, &sites, &perturbed)?;
        println!("relative error of the map: {:.0} %", relative * 100.0);
        let model_error = ModelError {
            relative,
            ..ModelError::default()
        };
        let noise = NoiseParams {
            model_error,
            ..uniform(1.0)
        };
        let title = "simulated real limb, map not calibrated, 1 µε";
        table(title, &map, &sites, &noise, n_frames, &perturbed)?;
    }
    Ok(())
}

/// Gauge readings per newton on the training mesh, µε/N.
fn response_map(limb: &Limb, tip_radius_m: f64) -> Result<ResponseMap> {
    let params = ElasticParams::new(limb.material, limb.clamped.clone());
    let model = ElasticModel::build(&limb.mesh, &params)?;
    let (response, _) = model.gauge_response(&limb.gauges)?;
    let n_gauges = limb.gauges.len();
    let mut adjoint = Vec::with_capacity(limb.skin.nodes.len() * n_gauges);
    for node in &limb.skin.nodes {
        for gauge in 0..n_gauges {
            adjoint.push(response.field(GaugeId::from_index(gauge))[node.index()] * 1e6);
        }
    }
    let place = |node| limb.skin.nodes.partition_point(|other| *other < node) as u32;
    let faces: Vec<[u32; 6]> = limb.skin.faces.iter().map(|f| f.nodes.map(place)).collect();
    let outward: Vec<Vector3<f64>> = limb.directions.iter().map(|d| -d).collect();
    let skin = Skin::new(
        limb.surface_points(),
        SkinFaces::Quadratic(&faces),
        Some(&outward),
        &SkinParams::default(),
    )?;
    let params = ResponseParams { tip_radius_m };
    Ok(ResponseMap::from_nodal(skin, n_gauges, &adjoint, &params)?)
}

/// Root mean square of the map's error over that of the response, at the scan sites.
fn relative_error(map: &ResponseMap, sites: &ScanSites, truth: Response<'_>) -> Result<f64> {
    let (mut error, mut all) = (0.0, 0.0);
    for point in sites.points() {
        for (t, g) in truth(point)?.iter().zip(map.normal(point)) {
            error += (t - g).powi(2);
            all += t * t;
        }
    }
    Ok(f64::sqrt(error / all))
}

/// A rig perturbed like the bundled scene's, with seeds of its own.
fn real_limb(limb: &Limb, tip_radius_m: f64) -> Result<RealLimb> {
    let nominal = NominalLimb {
        mesh: &limb.mesh,
        clamped: &limb.clamped,
        material: limb.material,
        gauges: &limb.sites,
        gauge_params: limb.gauge_params,
        skin: &limb.skin,
        tip_radius_m,
    };
    let variation = |fraction, seed| VariationParams {
        fraction,
        correlation_length_m: 0.03,
        seed,
    };
    let misplacement = MisplacementParams {
        shift_m: 1e-3,
        turn_rad: 3_f64.to_radians(),
        seed: 113,
    };
    let gain = GainParams {
        fraction: 0.03,
        seed: 114,
    };
    let params = RigParams {
        refinements: 1,
        stiffness: variation(0.1, 111),
        thickness: variation(0.05, 112),
        max_wall_m: 0.003,
        misplacement,
        gain,
    };
    Ok(RealLimb::build(&nominal, &params, 2)?)
}

fn table(
    title: &str,
    map: &Arc<ResponseMap>,
    sites: &Arc<ScanSites>,
    noise: &NoiseParams,
    n_frames: usize,
    response: Response<'_>,
) -> Result<()> {
    println!(
        "\n{title}; forces 5–34 N, contacts at least 12 mm apart, {n_frames} frames a row\n{}",
        Row::HEAD
    );
    for k in 1..=3 {
        for known_count in [Some(k), None] {
            let params = EstimatorParams {
                known_count,
                ..EstimatorParams::default()
            };
            let estimator =
                ContactEstimator::new(map.clone(), sites.clone(), noise.clone(), params)?;
            let mut rng = ChaCha8Rng::seed_from_u64(900 + k as u64);
            let mut row = Row::default();
            let mut scratch = (estimator.scratch(), ContactEstimate::default());
            for _ in 0..n_frames {
                row.frame(&estimator, k, noise, response, &mut rng, &mut scratch)?;
            }
            let count = known_count.map_or("estimated", |_| "given");
            println!("{k:>2} {count:>9} {}", row.text(n_frames));
        }
    }
    Ok(())
}
