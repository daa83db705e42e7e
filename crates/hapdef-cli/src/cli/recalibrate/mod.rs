//! `hapdef recalibrate`: known touches keep the calibration of a scene up to date.

mod args;
mod touches;
mod words;

use std::time::SystemTime;

use anyhow::{Context, Result};
use hapdef::Limb;
use hapdef::touch::{JournalTouch, Recalibrator};
use hapdef_cli::{print_json, shown};

pub(crate) use args::RecalibrateArgs;
use touches::read_touches;
use words::{as_json, print_touches, print_undone};

/// Takes a table of known touches, or undoes some.
pub(crate) fn recalibrate(args: &RecalibrateArgs) -> Result<()> {
    let run = args.scene.prepare()?;
    let limb = Limb::load(&run.scene, &run.scene_dir)?;
    let mut recalibrator = Recalibrator::of_scene(&run, &limb)?;
    let names: Vec<&str> = run.scene.gauges.sites.iter().map(|site| site.name.as_str()).collect();
    let unix_s = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH)?.as_secs();
    if let Some(n_touches) = args.undo {
        let n_undone = recalibrator.undo(n_touches, unix_s)?;
        recalibrator.write()?;
        if args.json {
            return Ok(print_json(&as_json(&recalibrator, &[], n_undone), false)?);
        }
        print_undone(&recalibrator, n_undone);
        return Ok(());
    }
    let table = args.table.as_deref().context("a table of touches, or --undo")?;
    let mut taken: Vec<JournalTouch> = Vec::new();
    for (place, touch) in read_touches(args, table, &names)? {
        let became = recalibrator.touch(&touch, &args.assumed(), unix_s);
        taken.push(became.with_context(|| format!("{}: {place}", shown(table)))?);
    }
    recalibrator.write()?;
    if args.json {
        print_json(&as_json(&recalibrator, &taken, 0), false)?;
    } else {
        print_touches(&recalibrator, &taken, &names);
    }
    Ok(())
}
