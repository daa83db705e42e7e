//! The bundled scene on a limb of other measures.

use std::f64::consts::TAU;
use std::fs;
use std::path::Path;

use hapdef::scene::GaugeEntry;
use hapdef::{HapdefError, Profile, Progress, Run};
use hapdef_mesh::{DeckMaterial, ShinParams, SolidDeck, shin, write_inp};
use hapdef_sim::{GaugeParams, GaugeSite, GaugeStrain};
use nalgebra::{Point3, Rotation3, Vector3};
use serde_json::{Value, json};

use super::trial::Trial;

/// Turns about the limb's axis in which gauges are tried, the golden section of a whole one each.
const MAX_TURNS: usize = 12;
const TURN: f64 = 0.381_966;

/// Makes the scene's files in `folder`, some of the bundled gauges on the limb's wall.
pub(crate) fn prepared(folder: &Path, trial: &Trial) -> Result<Run, HapdefError> {
    let bundled = ShinParams::default();
    let thinner_m = bundled.wall_m - trial.wall_m;
    let params = ShinParams {
        wall_m: trial.wall_m,
        n_sectors: trial.n_sectors,
        n_rib_layers: trial.n_rib_layers,
        panel_cells: (3, 3),
        holes: Vec::new(),
        material: DeckMaterial {
            youngs_modulus_pa: 10f64.powf(trial.log10_e_pa),
            poissons_ratio: trial.nu,
            ..bundled.material
        },
        ..bundled
    };
    let deck = shin(&params)?.deck;
    write_inp(&folder.join("limb.inp"), &deck)?;
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/shin/placed.json");
    let mut scene: Value = serde_json::from_slice(&fs::read(source).unwrap()).unwrap();
    scene["geometry"]["solid_deck"] = json!("limb.inp");
    let sites = serde_json::from_value(scene["gauges"]["sites"].take()).unwrap();
    scene["gauges"]["sites"] = json!(on_wall(&deck, sites, thinner_m, trial));
    scene["estimator"]["noise_ue"] = json!(10f64.powf(trial.log10_noise_ue));
    scene["estimator"]["map_error"] = json!(trial.map_error);
    let most_n = 10f64.powf(trial.log10_force_n.max(0.0) + 0.5);
    scene["contact"]["force_range_n"] = json!([0.0, most_n]);
    let path = folder.join("scene.json");
    fs::write(&path, scene.to_string()).unwrap();
    let (quick, out) = (Profile::quick(), folder.join("out"));
    Run::new(&path, quick, &out, 1, Progress::silent())
}

/// The trial's gauges: `sites` from one of them on, those that lie on the wall of the limb; when they
/// are through, the same turned about the limb's axis.
fn on_wall(
    deck: &SolidDeck,
    sites: Vec<GaugeEntry>,
    thinner_m: f64,
    trial: &Trial,
) -> Vec<GaugeEntry> {
    let faces = deck.mesh.boundary().faces;
    let is_on = |entry: &GaugeEntry| {
        let site = GaugeSite {
            position: Point3::from(entry.position_m),
            axis: Vector3::from(entry.axis),
            length_m: 0.008,
            width_m: 0.005,
        };
        GaugeStrain::with_params(&deck.mesh, &faces, &site, &GaugeParams::default()).is_ok()
    };
    let n = sites.len();
    let all = (0..MAX_TURNS * n).map(|k| {
        let angle = TAU * TURN * (k / n) as f64;
        turned(&sites[(k + trial.first_gauge) % n], angle, thinner_m)
    });
    all.filter(is_on).take(trial.n_gauges).collect()
}

/// A site turned about the y axis, and out by what the wall is thinner.
fn turned(entry: &GaugeEntry, angle: f64, thinner_m: f64) -> GaugeEntry {
    let turn = Rotation3::from_axis_angle(&Vector3::y_axis(), angle);
    let position = Vector3::from(entry.position_m);
    let radial = Vector3::new(position.x, 0.0, position.z);
    let out = radial * (1.0 + thinner_m / radial.norm()) + Vector3::y() * position.y;
    GaugeEntry {
        name: entry.name.clone(),
        position_m: (turn * out).into(),
        axis: (turn * Vector3::from(entry.axis)).into(),
    }
}
