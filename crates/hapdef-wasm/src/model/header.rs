//! What of a model is no long list of numbers.

use hapdef_rig::ElectronicsParams;
use hapdef_rig::live::{
    BridgeParams, CreepTerm, HandsParams, LiveElectronicsParams, RigDeviceParams,
};
use hapdef_view::{LimbPicture, PressOffer};
use serde::{Deserialize, Serialize};

/// Version of the form that is written and read here.
pub(super) const VERSION: u32 = 1;
/// The metadata entry with the header.
pub(super) const ENTRY: &str = "hapdef_page";
/// The bundle's file: most of it are numbers of eight bytes.
pub(super) const BUNDLE: &str = "bundle";
pub(super) const INWARD: &str = "inward";
pub(super) const COLUMNS: &str = "columns_ue_per_n";
pub(super) const VERTICES: &str = "vertices_m";
pub(super) const NORMALS: &str = "normals";
pub(super) const TRIANGLES: &str = "triangles";

/// Width of the numbers of a part, by which its bytes are split.
pub(super) fn width(part: &str) -> usize {
    match part {
        BUNDLE | INWARD => 8,
        _ => 4,
    }
}

/// The header of the file.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub(super) struct Header {
    pub(super) version: u32,
    pub(super) title: String,
    pub(super) up: Option<[f64; 3]>,
    pub(super) view_from: Option<[f64; 3]>,
    pub(super) rig: RigHeader,
}

/// The virtual rig but its limb, and who presses it.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct RigHeader {
    /// Frames per second.
    pub rate_hz: f64,
    /// How much faster than true the device's clock runs, parts per million.
    pub drift_ppm: f64,
    /// Names of the gauges.
    pub names: Vec<String>,
    /// Whether there is a channel with the temperature.
    pub has_temperature: bool,
    /// The measuring chain.
    pub electronics: ElectronicsHeader,
    /// Force of a press on the page at first, N.
    pub default_n: f64,
    /// Largest force of a press, N.
    pub largest_n: f64,
    /// Contacts that press by themselves, at most.
    pub max_contacts: usize,
    /// Least distance of two of these, m.
    pub spacing_m: f64,
    /// Seed of these.
    pub seed: u64,
}

/// The measuring chain, as [`LiveElectronicsParams`] has it.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "the fields are those of LiveElectronicsParams and what it is made of"
)]
pub struct ElectronicsHeader {
    pub noise_ue: f64,
    pub adc_bits: u32,
    pub headroom: f64,
    pub seed: u64,
    /// Gauge factor, excitation in V, gain and range in V.
    pub bridge: Option<[f64; 4]>,
    pub offset_ue: f64,
    pub walk_ue_per_sqrt_s: f64,
    pub flicker_ue: f64,
    pub temperature_ue_per_k: f64,
    pub temperature_c: Vec<(f64, f64)>,
    /// Share and time in s of each term.
    pub creep: Vec<(f64, f64)>,
}

impl Header {
    pub(super) fn new(picture: &LimbPicture, rig: &RigHeader) -> Self {
        Self {
            version: VERSION,
            title: picture.title.clone(),
            up: picture.up,
            view_from: picture.view_from,
            rig: rig.clone(),
        }
    }
}

impl RigHeader {
    pub(super) fn new(
        electronics: &LiveElectronicsParams,
        device: &RigDeviceParams,
        press: PressOffer,
        hands: &HandsParams,
    ) -> Self {
        Self {
            rate_hz: device.rate_hz,
            drift_ppm: device.drift_ppm,
            names: device.names.clone(),
            has_temperature: device.has_temperature,
            electronics: ElectronicsHeader::new(electronics),
            default_n: press.default_n,
            largest_n: press.max_n,
            max_contacts: hands.max_contacts,
            spacing_m: hands.spacing_m,
            seed: hands.seed,
        }
    }

    pub(crate) fn device(&self) -> RigDeviceParams {
        RigDeviceParams {
            rate_hz: self.rate_hz,
            drift_ppm: self.drift_ppm,
            names: self.names.clone(),
            has_temperature: self.has_temperature,
            ..RigDeviceParams::default()
        }
    }

    pub(crate) fn press(&self) -> PressOffer {
        PressOffer { default_n: self.default_n, max_n: self.largest_n }
    }

    pub(crate) fn hands(&self) -> HandsParams {
        HandsParams {
            max_contacts: self.max_contacts,
            spacing_m: self.spacing_m,
            largest_n: self.largest_n,
            seed: self.seed,
        }
    }
}

impl ElectronicsHeader {
    fn new(params: &LiveElectronicsParams) -> Self {
        let ElectronicsParams { noise_ue, adc_bits, headroom, seed } = params.converter;
        let bridge = |b: BridgeParams| [b.gauge_factor, b.excitation_v, b.gain, b.range_v];
        Self {
            noise_ue,
            adc_bits,
            headroom,
            seed,
            bridge: params.bridge.map(bridge),
            offset_ue: params.offset_ue,
            walk_ue_per_sqrt_s: params.walk_ue_per_sqrt_s,
            flicker_ue: params.flicker_ue,
            temperature_ue_per_k: params.temperature_ue_per_k,
            temperature_c: params.temperature_c.clone(),
            creep: params.creep.iter().map(|term| (term.share, term.time_s)).collect(),
        }
    }

    pub(crate) fn params(&self) -> LiveElectronicsParams {
        let Self { noise_ue, adc_bits, headroom, seed, .. } = *self;
        let bridge = |[gauge_factor, excitation_v, gain, range_v]: [f64; 4]| BridgeParams {
            gauge_factor,
            excitation_v,
            gain,
            range_v,
        };
        let term = |&(share, time_s): &(f64, f64)| CreepTerm { share, time_s };
        LiveElectronicsParams {
            bridge: self.bridge.map(bridge),
            offset_ue: self.offset_ue,
            walk_ue_per_sqrt_s: self.walk_ue_per_sqrt_s,
            flicker_ue: self.flicker_ue,
            temperature_ue_per_k: self.temperature_ue_per_k,
            temperature_c: self.temperature_c.clone(),
            creep: self.creep.iter().map(term).collect(),
            ..LiveElectronicsParams::new(ElectronicsParams { noise_ue, adc_bits, headroom, seed })
        }
    }
}
