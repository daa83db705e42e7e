//! The scene's virtual rig: the perturbed limb as a device that speaks HDP1, solved once and kept.

use std::path::Path;
use std::sync::Arc;

use hapdef_data::{DatasetReader, DatasetWriter, TensorSpec};
use hapdef_rig::live::{
    BridgeParams, CreepTerm, HandsParams, LiveElectronics, LiveElectronicsParams, LiveLimb,
    LiveSurface, LoadSensorParams, MovingLoads, Play, PressScript, RandomScriptParams, RigDevice,
    RigDeviceParams, RigFault,
};
use nalgebra::Vector3;
use rayon::prelude::*;
use serde_json::json;

use crate::cache::Stage;
use crate::error::HapdefError;
use crate::limb::Limb;
use crate::run::Run;
use crate::scene::{LiveSpec, LoadSensorsSpec, LoadsSpec, Scene};
use crate::stages::{keys, real_limb, rig_key};

const FILE: &str = "columns.safetensors";
const TENSOR: &str = "columns";
const LOADS_FILE: &str = "loads.safetensors";
const LOADS: &str = "loads";
const VERSION: u32 = 1;

/// The limb stands still for so long, s: it is tared then.
const LOADS_BEGIN_S: f64 = 4.0;

/// Least force of a random press, N.
const LEAST_N: f64 = 2.0;

/// What a virtual rig is to do.
#[derive(Clone, Debug, PartialEq)]
pub struct VirtualRigParams {
    /// What presses; nothing but what is pressed by hand if `None`.
    pub script: Option<PressScript>,
    /// Frames per second.
    pub rate_hz: f64,
    /// What goes wrong; what concerns wire and plug is for whoever runs the device.
    pub faults: Vec<RigFault>,
}

impl Default for VirtualRigParams {
    /// Untouched, 1 kHz, faultless.
    fn default() -> Self {
        Self { script: None, rate_hz: 1000.0, faults: Vec::new() }
    }
}

/// The perturbed limb's answer to forces anywhere on the skin: one solve for each gauge, kept in the
/// run's cache.
///
/// # Errors
/// [`HapdefError::Rig`] when the perturbed limb can't be meshed or solved.
pub fn live_limb(run: &Run, limb: &Limb) -> Result<LiveLimb, HapdefError> {
    let limb_key = keys::limb(&run.scene, &limb.deck_hash);
    let mut inputs = json!({ "version": VERSION, "limb": limb_key, "rig": rig_key(run)? });
    let loads = run.scene.loads.clone().unwrap_or_default().loads();
    if let Some(spec) = &run.scene.loads {
        inputs["loads"] = json!(LoadsSpec { learned: None, ..spec.clone() });
    }
    let stage = run.cache.stage("rig-live", &inputs, |dir| {
        run.check_stop("the virtual rig")?;
        run.say("solving the simulated real limb on its own, perturbed mesh");
        let real = real_limb(run, limb, &limb.sites)?;
        let points = limb.surface_points();
        let rows = points.par_iter().map(|point| real.columns_ue_per_n(point));
        let rows: Vec<Vec<Vector3<f64>>> = rows.collect::<Result<_, _>>()?;
        let numbers: Vec<f32> =
            rows.iter().flatten().flat_map(|column| column.iter().map(|v| *v as f32)).collect();
        let spec = TensorSpec::f32(TENSOR, limb.gauges.len() * 3, "µε/N");
        let mut writer = DatasetWriter::create(&dir.join(FILE), points.len(), &[spec])?;
        writer.append(TENSOR, &numbers)?;
        writer.finish()?;
        if !loads.is_empty() {
            let responses = real.load_responses_ue();
            let numbers: Vec<f32> = responses.iter().map(|v| *v as f32).collect();
            let spec = TensorSpec::f32(LOADS, limb.gauges.len(), "µε");
            let mut writer = DatasetWriter::create(&dir.join(LOADS_FILE), loads.len(), &[spec])?;
            writer.append(LOADS, &numbers)?;
            writer.finish()?;
        }
        Ok(json!({ "simulated": true, "n_fe_nodes": real.info().n_fe_nodes }))
    })?;
    let live = read(&stage, limb)?;
    if loads.is_empty() {
        return Ok(live);
    }
    let mut numbers = vec![0.0_f32; loads.len() * limb.gauges.len()];
    let mut reader = DatasetReader::open(&stage.dir.join(LOADS_FILE))?;
    reader.read_rows(LOADS, 0..loads.len(), &mut numbers)?;
    let responses_ue = numbers.into_iter().map(f64::from).collect();
    let seed = run.scene.rig.electronics.seed;
    Ok(live.with_loads(MovingLoads::new(loads, responses_ue, LOADS_BEGIN_S, seed)))
}

/// A script drawn for the scene: its forces, spacing and number of contacts.
#[must_use]
pub fn random_presses(scene: &Scene, limb: &LiveLimb, seed: u64) -> PressScript {
    let contact = &scene.contact;
    let [low, high] = contact.force_range_n;
    let range = (low.max(LEAST_N.min(high)), high);
    let params = RandomScriptParams::new(contact.max_contacts, contact.min_spacing_m, range, seed);
    hapdef_rig::live::random_script(limb, &params)
}

/// Who presses the virtual rig by hand or by itself: as many contacts, as far apart and as hard as the scene says.
#[must_use]
pub fn virtual_hands(scene: &Scene, seed: u64) -> HandsParams {
    let contact = &scene.contact;
    HandsParams {
        max_contacts: contact.max_contacts,
        spacing_m: contact.min_spacing_m,
        largest_n: contact.force_range_n[1],
        seed,
    }
}

/// The device: the scene's electronics behind `limb`.
///
/// # Errors
/// [`HapdefError::Rig`] for a script off the limb, or values out of range.
pub fn virtual_device(
    scene: &Scene,
    limb: Arc<LiveLimb>,
    params: &VirtualRigParams,
) -> Result<RigDevice, HapdefError> {
    let (electronics, device) = virtual_chain(scene, params);
    let largest = limb.largest_ue(scene.contact.force_range_n[1]);
    let electronics = LiveElectronics::new(electronics, params.rate_hz, &largest)?;
    let script = params.script.as_ref();
    let play = script.map(|script| Play::new(script, &limb)).transpose()?;
    Ok(RigDevice::new(limb, play, electronics, device)?)
}

/// The scene's measuring chain, and the device around it.
#[must_use]
pub fn virtual_chain(
    scene: &Scene,
    params: &VirtualRigParams,
) -> (LiveElectronicsParams, RigDeviceParams) {
    let live = scene.rig.live.clone().unwrap_or_default();
    let mut electronics = electronics_params(scene, &live);
    let mut drift_ppm = live.drift_ppm;
    for fault in &params.faults {
        fault.apply(&mut electronics);
        if let RigFault::Drift { ppm } = fault {
            drift_ppm = *ppm;
        }
    }
    let names = scene.gauges.sites.iter().map(|site| site.name.clone());
    let sensors = |spec: LoadSensorsSpec| load_sensor_params(&spec, scene.rig.electronics.seed);
    let device = RigDeviceParams {
        rate_hz: params.rate_hz,
        drift_ppm,
        names: names.collect(),
        has_temperature: live.temperature_channel,
        load_sensors: live.load_sensors.map(sensors),
        ..RigDeviceParams::default()
    };
    (electronics, device)
}

fn load_sensor_params(spec: &LoadSensorsSpec, seed: u64) -> LoadSensorParams {
    LoadSensorParams {
        gain_error: spec.gain_error,
        acceleration_noise_m_s2: spec.acceleration_noise_m_s2,
        rate_noise_rad_s: spec.rate_noise_rad_s,
        force_noise_n: spec.force_noise_n,
        moment_noise_nm: spec.moment_noise_nm,
        seed,
    }
}

fn electronics_params(scene: &Scene, live: &LiveSpec) -> LiveElectronicsParams {
    LiveElectronicsParams {
        bridge: live.bridge.map(|bridge| BridgeParams {
            gauge_factor: bridge.gauge_factor,
            excitation_v: bridge.excitation_v,
            gain: bridge.gain,
            range_v: bridge.range_v,
        }),
        offset_ue: live.offset_ue,
        walk_ue_per_sqrt_s: live.walk_ue_per_sqrt_s,
        flicker_ue: live.flicker_ue,
        temperature_ue_per_k: live.temperature_ue_per_k,
        temperature_c: live.temperature_c.iter().map(|[s, c]| (*s, *c)).collect(),
        creep: live
            .creep
            .iter()
            .map(|term| CreepTerm { share: term.share, time_s: term.time_s })
            .collect(),
        ..LiveElectronicsParams::new(scene.rig.electronics.params())
    }
}

fn read(stage: &Stage, limb: &Limb) -> Result<LiveLimb, HapdefError> {
    let n_gauges = limb.gauges.len();
    let n_nodes = limb.n_surface_nodes();
    let path: &Path = &stage.dir.join(FILE);
    let mut numbers = vec![0.0_f32; n_nodes * n_gauges * 3];
    DatasetReader::open(path)?.read_rows(TENSOR, 0..n_nodes, &mut numbers)?;
    let place = |node| limb.skin.nodes.partition_point(|other| *other < node) as u32;
    let surface = LiveSurface {
        nodes: limb.surface_points(),
        faces: limb.skin.faces.iter().map(|f| f.nodes.map(place)).collect(),
        inward: limb.directions.clone(),
    };
    let columns = numbers.chunks_exact(3);
    let columns = columns.map(|v| Vector3::new(v[0], v[1], v[2]).cast::<f64>());
    Ok(LiveLimb::new(surface, n_gauges, columns.collect())?)
}
