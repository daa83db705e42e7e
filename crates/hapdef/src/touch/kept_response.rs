//! A response with what may change it in the run's cache: its solves are the longest part of a calibration.

use std::path::Path;

use hapdef_data::{DatasetReader, DatasetWriter, TensorSpec};
use hapdef_inverse::ResponseMap;
use hapdef_sim::{GaugeSite, GaugeStrain};
use nalgebra::Vector3;
use serde_json::{Value, json};

use super::modes::{UncertainParams, UncertainResponse};
use super::response::touchable_skin;
use crate::cache::Stage;
use crate::error::HapdefError;
use crate::limb::Limb;
use crate::run::Run;
use crate::scene::WallSolver;
use crate::stages::keys;

/// Raise when results change for unchanged inputs.
const VERSION: u32 = 1;

const STAGE: &str = "uncertain-response";
const MAP_FILE: &str = "map.safetensors";
const MODES_FILE: &str = "modes.safetensors";
const MAP: &str = "map";
const GAUGE_MODES: [&str; 3] = ["shift_along", "shift_across", "turn"];

impl UncertainResponse {
    /// [`Self::solve`] from the run's cache, where it is kept in 32 bits; and how long it took when it was
    /// solved, s.
    ///
    /// # Errors
    /// As [`Self::solve`]; [`HapdefError::File`], [`HapdefError::Data`].
    pub fn kept(
        run: &Run,
        limb: &Limb,
        sites: &[GaugeSite],
        gauges: &[GaugeStrain],
        params: &UncertainParams,
    ) -> Result<(Self, f64), HapdefError> {
        let stage = run.cache.stage(STAGE, &inputs(run, limb, sites, params), |dir| {
            run.check_stop("the response")?;
            run.say(&format!("solving the response of {} gauges", sites.len()));
            let solved = Self::solve(limb, sites, gauges, params)?;
            write(dir, &solved)?;
            Ok(json!({ "n_values": solved.map.n_values(), "n_stiffness": solved.stiffness_modes.len() }))
        })?;
        Ok((read(&stage, limb, sites.len())?, stage.record.elapsed_s))
    }

    /// Whether [`Self::kept`] has nothing to solve for the scene's own gauges.
    ///
    /// # Errors
    /// [`HapdefError::File`] and [`HapdefError::Stale`] where the cache can't be read.
    pub(crate) fn is_kept(
        run: &Run,
        limb: &Limb,
        params: &UncertainParams,
    ) -> Result<bool, HapdefError> {
        let inputs = inputs(run, limb, &limb.sites, params);
        let look = |_: &Path| Ok(Value::Null);
        Ok(run.cache.looking().stage(STAGE, &inputs, look)?.cached)
    }
}

/// All that the solves depend on, but the number of threads.
fn inputs(run: &Run, limb: &Limb, sites: &[GaugeSite], params: &UncertainParams) -> Value {
    let site = |site: &GaugeSite| {
        let GaugeSite { position, axis, length_m, width_m } = site;
        json!([position.coords.as_slice(), axis.as_slice(), length_m, width_m])
    };
    let UncertainParams { tip_radius_m, refinements, n_stiffness, n_threads: _ } = params;
    json!({
        "version": VERSION,
        "limb": keys::limb(&run.scene, &limb.deck_hash),
        "solver": limb.shell.as_ref().map_or(WallSolver::Solid, |_| WallSolver::Shell),
        "sites": sites.iter().map(site).collect::<Vec<_>>(),
        "tip_radius_m": tip_radius_m,
        "refinements": refinements,
        "n_stiffness": n_stiffness,
    })
}

fn write(dir: &Path, response: &UncertainResponse) -> Result<(), HapdefError> {
    write_maps(&dir.join(MAP_FILE), &[(MAP.to_owned(), &response.map)])?;
    let stiffness = response.stiffness_modes.iter().enumerate();
    let of_gauges = GAUGE_MODES.map(str::to_owned).into_iter().zip(&response.gauge_modes);
    let modes: Vec<_> =
        of_gauges.chain(stiffness.map(|(i, map)| (stiffness_name(i), map))).collect();
    write_maps(&dir.join(MODES_FILE), &modes)
}

/// Maps of one number of values, a tensor `[n_values, n_gauges, 3]` each.
fn write_maps(path: &Path, maps: &[(String, &ResponseMap)]) -> Result<(), HapdefError> {
    let n_values = maps.first().map_or(0, |(_, map)| map.n_values());
    let spec =
        |(name, map): &(String, &ResponseMap)| TensorSpec::f32(name, map.n_gauges() * 3, "µε/N");
    let specs: Vec<TensorSpec> = maps.iter().map(spec).collect();
    let mut writer = DatasetWriter::create(path, n_values, &specs)?;
    for (name, map) in maps {
        let values = map.nodal();
        let numbers: Vec<f32> = values.iter().flat_map(|v| v.iter().map(|x| *x as f32)).collect();
        writer.append(name, &numbers)?;
    }
    writer.finish()?;
    Ok(())
}

fn read(stage: &Stage, limb: &Limb, n_gauges: usize) -> Result<UncertainResponse, HapdefError> {
    let skin = touchable_skin(limb)?;
    let map_of = |reader: &mut DatasetReader, name: &str| -> Result<ResponseMap, HapdefError> {
        let mut numbers = vec![0.0_f32; reader.n() * n_gauges * 3];
        reader.read_rows(name, 0..reader.n(), &mut numbers)?;
        let values = numbers.as_chunks::<3>().0.iter();
        let values: Vec<_> = values.map(|v| Vector3::from(*v).cast::<f64>()).collect();
        Ok(ResponseMap::from_values(skin.clone(), n_gauges, &values)?)
    };
    let mut modes = DatasetReader::open(&stage.dir.join(MODES_FILE))?;
    let n_stiffness = modes.tensor_names().count() - GAUGE_MODES.len();
    let [along, across, turn] = GAUGE_MODES;
    Ok(UncertainResponse {
        map: map_of(&mut DatasetReader::open(&stage.dir.join(MAP_FILE))?, MAP)?,
        gauge_modes: [
            map_of(&mut modes, along)?,
            map_of(&mut modes, across)?,
            map_of(&mut modes, turn)?,
        ],
        stiffness_modes: (0..n_stiffness)
            .map(|i| map_of(&mut modes, &stiffness_name(i)))
            .collect::<Result<_, _>>()?,
    })
}

fn stiffness_name(index: usize) -> String {
    format!("stiffness_{index}")
}
