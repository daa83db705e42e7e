//! `hapdef calibrate`: the map that presses of known place and force give.

use std::path::Path;

use anyhow::{Context, Result, ensure};
use hapdef::scene::GaugeEntry;
use hapdef::touch::{CALIBRATION_SITES, Calibration, PressQuality, touchable_skin};
use hapdef::{Limb, Run};
use hapdef_cli::{print_json, shown};
use hapdef_inverse::{CalibrationInfo, Press, Skin};
use nalgebra::Point3;
use serde_json::json;

use super::calibrate_args::CalibrateArgs;
use super::calibrate_live::calibrate_live;
use super::table::{Row, read_table};

/// Corrects the response by a table of presses and writes the result.
pub(crate) fn calibrate(args: &CalibrateArgs) -> Result<()> {
    let source = args.press_source()?;
    ensure!(
        source.is_none() || !hapdef_cli::is_quiet(),
        "--quiet: with --live it says where to press: leave out one of them"
    );
    let run = args.scene.prepare()?;
    let limb = Limb::load(&run.scene, &run.scene_dir)?;
    let (calibration, info) = match &source {
        Some(source) => calibrate_live(args, source, &run, &limb)?,
        None => from_table(args, &run, &limb)?,
    };
    calibration.write(&args.calibration)?;
    if args.json {
        print_json(&as_json(&calibration, &info), false)?;
    } else {
        print(&calibration, &info, &args.calibration);
    }
    Ok(())
}

fn from_table(
    args: &CalibrateArgs,
    run: &Run,
    limb: &Limb,
) -> Result<(Calibration, CalibrationInfo)> {
    let presses = read_presses(args, &touchable_skin(limb)?, &run.scene.gauges.sites)?;
    let quality = PressQuality {
        noise_ue: args.noise_ue,
        position_sd_m: args.position_sd_mm * 1e-3,
        force_sd_n: args.force_sd_n,
    };
    run.say(&format!("calibrating with {} presses", presses.len()));
    Ok(Calibration::fit(run, limb, &presses, &quality, CALIBRATION_SITES)?)
}

fn read_presses(args: &CalibrateArgs, skin: &Skin, gauges: &[GaugeEntry]) -> Result<Vec<Press>> {
    let names: Vec<&str> = gauges.iter().map(|site| site.name.as_str()).collect();
    let rows = read_table(&args.table, &args.topic, &["x_m", "y_m", "z_m", "force_n"], &names)?;
    let press = |row: &Row| {
        let (place, readings) = row.values.split_at(4);
        let position = Point3::new(place[0], place[1], place[2]);
        let off_m = args.off_skin_mm * 1e-3;
        Press::at_position(skin, &position, off_m, place[3], readings.to_vec())
            .with_context(|| format!("{}: {}", shown(&args.table), row.place))
    };
    rows.iter().map(press).collect()
}

fn print(calibration: &Calibration, info: &CalibrationInfo, path: &Path) {
    println!(
        "{} of {} presses used; relative error of the map at presses not used, noise included: \
         {:.1} % before, {:.2} % after",
        info.n_used,
        calibration.n_presses,
        info.relative_error_before * 100.0,
        info.relative_error * 100.0
    );
    for rejected in &info.rejected {
        println!("press {} left out: {:?}", rejected.press + 1, rejected.reason);
    }
    let sds = info.beyond_prior.iter().map(|cause| cause.sds.abs());
    if let Some(worst) = sds.max_by(f64::total_cmp) {
        println!(
            "{} gains and modes are farther from what is expected than 4 standard deviations, up to \
             {worst:.0}: the computed map is off by more than they explain, or a gauge or press is \
             wrong",
            info.beyond_prior.len()
        );
    }
    println!("\npresses  relative error");
    for point in &info.curve {
        println!("{:7}  {:.2} %", point.n_presses, point.relative_error * 100.0);
    }
    for relative in [0.02, 0.01] {
        if let Some(n) = info.presses_for(relative) {
            println!("about {n:.0} presses for {:.0} %", relative * 100.0);
        }
    }
    println!("\nthe next presses help most at (mm)");
    for next in info.next.iter().take(5) {
        let [x, y, z] = (next.position_m.coords * 1e3).into();
        println!("  ({x:.1}, {y:.1}, {z:.1}): ±{:.1} %", next.relative_sd * 100.0);
    }
    println!("\n{}", shown(path));
}

fn as_json(calibration: &Calibration, info: &CalibrationInfo) -> serde_json::Value {
    let curve = info.curve.iter().map(|p| json!([p.n_presses, p.relative_error]));
    let next = info.next.iter().map(|n| {
        json!({"position_m": <[f64; 3]>::from(n.position_m.coords), "relative_sd": n.relative_sd})
    });
    json!({
        "n_presses": calibration.n_presses,
        "n_used": info.n_used,
        "rejected": info.rejected.iter().map(|r| r.press).collect::<Vec<_>>(),
        "relative_error": info.relative_error,
        "relative_error_before": info.relative_error_before,
        "gains": info.gains,
        "n_beyond_prior": info.beyond_prior.len(),
        "curve": curve.collect::<Vec<_>>(),
        "next": next.collect::<Vec<_>>(),
    })
}
