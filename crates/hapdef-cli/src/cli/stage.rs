//! `hapdef check|simulate|dataset|train|eval`: the pipeline up to a stage.

use anyhow::Result;
use hapdef::plan::{Rates, pipeline_parts_s};
use hapdef::stages::check_rig_mesh;
use hapdef::touch::{LearnedLoads, calibration_in_use};
use hapdef::{DrawnSkin, Limb, Pipeline, Run, Stage, Until};
use hapdef_cli::{SceneArgs, print_json};
use hapdef_contact::printable;

use super::figure::figure;

/// Reads the scene and its limb and says what is there.
pub(crate) fn check(args: &SceneArgs) -> Result<()> {
    let run = args.prepare()?;
    let limb = Limb::load(&run.scene, &run.scene_dir)?;
    println!(
        "{}: {} FE nodes, {} elements, {} surface nodes, {} clamped nodes, {} gauges",
        run.scene.name,
        limb.mesh.nodes().len(),
        limb.mesh.elements().len(),
        limb.n_surface_nodes(),
        limb.clamped.len(),
        limb.gauges.len(),
    );
    limb.wall.iter().for_each(|wall| println!("solved as {wall}"));
    limb.deck_notes.iter().for_each(|note| println!("deck: {}", printable(note)));
    limb.check_held()?;
    limb.check_reached()?;
    say_what_is_drawn(&run, &limb)?;
    if let Some([n_nodes, n_elements]) = check_rig_mesh(&run, &limb)? {
        println!("simulated hardware: {n_nodes} FE nodes, {n_elements} elements of its own");
    }
    if calibration_in_use(&run, &limb)?.is_some() {
        println!("calibration: of this limb and its gauges");
    }
    if let Some(loads) = loads_in_words(&run)? {
        println!("loads: {loads}");
    }
    Ok(())
}

/// What strains the limb beside contacts.
fn loads_in_words(run: &Run) -> Result<Option<String>> {
    let Some(loads) = &run.scene.loads else {
        return Ok(None);
    };
    let Some(file) = &loads.learned else {
        return Ok(Some(format!("{}, their responses computed", loads.loads().len())));
    };
    let learned = LearnedLoads::read(&run.scene_dir.join(file), &run.scene)?;
    let (n, n_frames) = (learned.sd.len(), learned.n_frames);
    let n_given = learned.signals.len();
    if n_given > 0 {
        return Ok(Some(format!(
            "taken off by {n_given} signals of the device, {n} unknown beside them, learned from {n_frames} frames in \
             which nothing touched"
        )));
    }
    Ok(Some(format!("{n}, learned from {n_frames} frames in which nothing touched")))
}

/// How far what the page draws is off what can be touched.
fn say_what_is_drawn(run: &Run, limb: &Limb) -> Result<()> {
    let Some(drawn) = DrawnSkin::load(&run.scene, &run.scene_dir, limb)? else {
        println!("drawn skin: the limb's own, of which the touchable skin is a part");
        return Ok(());
    };
    let (n, n_beside) = (drawn.vertices_m.len(), drawn.moves_with.len());
    println!("drawn skin: {n} vertices, {n_beside} of them beside the touchable skin");
    let (gap_m, at) = drawn.farthest(limb)?;
    let [x, y, z] = (at.coords * 1e3).into();
    println!(
        "the touchable skin is at most {:.1} mm off the drawn one, at ({x:.0}, {y:.0}, {z:.0}) mm",
        gap_m * 1e3
    );
    Ok(())
}

/// Runs every stage up to `until` and prints their records.
pub(crate) fn run_until(run: &Run, until: Until, json: bool) -> Result<()> {
    let limb = Limb::load(&run.scene, &run.scene_dir)?;
    let rates = Rates::recorded(&run.cache, run.threads);
    let parts_s = pipeline_parts_s(run, &limb, &rates)?;
    let done = Pipeline::run_timed(run, &limb, until, &parts_s)?;
    for stage in done.stages() {
        show(stage, json)?;
    }
    Ok(())
}

fn show(stage: &Stage, json: bool) -> Result<()> {
    if json {
        return Ok(print_json(&stage.record, false)?);
    }
    let origin = if stage.cached { "cached" } else { "new" };
    println!("{:10} {origin:6} {:8.1} s", stage.record.stage, stage.record.elapsed_s);
    for (name, value) in stage.record.info.as_object().into_iter().flatten() {
        if !value.is_object() {
            let (name, value) = figure(name, value);
            println!("    {name}: {value}");
        }
    }
    Ok(())
}
