//! What several tests share: a made-up limb, and what the page is told.

#[path = "../../../../hapdef-view/tests/it/support/chrome.rs"]
#[allow(dead_code, reason = "a part of it is used here")]
pub mod chrome;
pub mod files;
pub mod told;
#[path = "../../../../hapdef-inverse/tests/it/world/mod.rs"]
pub mod world;

use hapdef_live::estimator::{EstimatorKind, SuperpositionSettings};
use hapdef_live::{Bundle, BundleGauge, BundleInfo};
use hapdef_rig::ElectronicsParams;
use hapdef_rig::live::{
    HandsParams, LiveElectronicsParams, LiveLimb, LiveSurface, RigDeviceParams,
};
use hapdef_view::{GaugeSite, LimbPicture, PressOffer};
use hapdef_wasm::PageModel;
use nalgebra::Vector3;
use world::World;

pub const N_GAUGES: usize = 10;
/// Largest force of a press, N.
pub const LARGEST_N: f64 = 30.0;

/// A barrel with gauges, whose virtual limb is as its map says.
pub fn model() -> PageModel {
    let world = World::new(N_GAUGES, 400, 7);
    let bundle = bundle(&world);
    let skin = bundle.skin();
    let face = |face| <[u32; 6]>::try_from(skin.face_nodes(face)).unwrap();
    let surface = LiveSurface {
        nodes: skin.nodes().to_vec(),
        faces: (0..skin.n_faces()).map(face).collect(),
        inward: skin.normals().iter().map(|normal| -normal).collect(),
    };
    let limb = LiveLimb::new(surface, N_GAUGES, world.map.nodal()).unwrap();
    let converter = ElectronicsParams { noise_ue: 1.0, adc_bits: 24, headroom: 1.5, seed: 3 };
    let names = bundle.info.gauges.iter().map(|gauge| gauge.name.clone()).collect();
    let device = RigDeviceParams { names, ..RigDeviceParams::default() };
    let hands = HandsParams { max_contacts: 2, spacing_m: 0.02, largest_n: LARGEST_N, seed: 1 };
    let press = PressOffer { default_n: 10.0, max_n: LARGEST_N };
    let picture = picture(&bundle);
    let chain = (&LiveElectronicsParams::new(converter), &device);
    PageModel::new(bundle, &limb, chain, (press, &hands), picture).unwrap()
}

fn bundle(world: &World) -> Bundle {
    let skin = world.map.skin();
    let outward: Vec<Vector3<f64>> =
        skin.nodes().iter().map(|x| Vector3::new(x.x, 0.0, x.z) / world::RADIUS_M).collect();
    let gauge = |i: usize| BundleGauge {
        name: format!("g{i}"),
        position_m: [0.0, 0.01 * i as f64, 0.0],
        axis: [0.0, 1.0, 0.0],
        scale: 1.0,
    };
    let info = BundleInfo {
        scene: "barrel".to_owned(),
        made_by: "0.0.0".to_owned(),
        mount_m: None,
        deck_hash: None,
        gauges: (0..N_GAUGES).map(gauge).collect(),
        estimator: EstimatorKind::Superposition,
        settings: SuperpositionSettings {
            noise_ue: 1.0,
            map_error: 0.0,
            place_factor: 1.0,
            tip_ring_m: 0.0,
            tip_radius_m: 0.0,
            palm_radius_m: 0.0,
            friction: 0.0,
            n_sites: 400,
            max_contacts: 3,
            max_force_n: 60.0,
        },
    };
    Bundle::new(info, world.map.clone(), Some(&outward)).unwrap()
}

fn picture(bundle: &Bundle) -> LimbPicture {
    let skin = bundle.skin();
    let corners = |face| {
        let nodes = skin.face_nodes(face);
        [nodes[0], nodes[1], nodes[2]]
    };
    let site = |gauge: &BundleGauge| GaugeSite {
        name: gauge.name.clone(),
        position_m: gauge.position_m,
        axis: gauge.axis,
    };
    LimbPicture {
        title: "barrel".to_owned(),
        vertices_m: skin.nodes().iter().map(|p| p.coords.cast().into()).collect(),
        normals: skin.normals().iter().map(|n| n.cast().into()).collect(),
        triangles: (0..skin.n_faces()).map(corners).collect(),
        gauges: bundle.info.gauges.iter().map(site).collect(),
        up: Some([0.0, 1.0, 0.0]),
        view_from: None,
    }
}
