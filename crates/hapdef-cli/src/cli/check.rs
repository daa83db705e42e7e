//! `hapdef check`: a scene and its limb, without solving anything.

use anyhow::Result;
use clap::Args;
use hapdef::stages::check_rig_mesh;
use hapdef::touch::{LearnedLoads, calibration_in_use};
use hapdef::{DrawnSkin, Limb, Run};
use hapdef_cli::{SceneArgs, print_json};
use hapdef_contact::printable;
use serde::Serialize;

#[derive(Args)]
#[command(after_help = "Example:\n  hapdef check fixtures/shin/scene.json")]
pub(crate) struct CheckArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Print what is there as JSON.
    #[arg(long)]
    json: bool,
}

/// Reads the scene and its limb and says what is there.
pub(crate) fn run(args: &CheckArgs) -> Result<()> {
    let run = args.scene.prepare()?;
    let limb = Limb::load(&run.scene, &run.scene_dir)?;
    let mut checked = Checked::of_limb(&run, &limb);
    if !args.json {
        checked.print_limb();
    }
    limb.check_held()?;
    limb.check_reached()?;
    checked.look_further(&run, &limb)?;
    if args.json {
        return Ok(print_json(&checked, false)?);
    }
    checked.print_rest();
    Ok(())
}

/// What is there.
#[derive(Serialize)]
struct Checked {
    scene: String,
    n_fe_nodes: usize,
    n_elements: usize,
    n_surface_nodes: usize,
    n_clamped_nodes: usize,
    n_gauges: usize,
    /// What the wall of a skin is solved as, in words.
    solved_as: Option<String>,
    deck_notes: Vec<String>,
    /// Nothing where the limb's own skin is drawn, of which the touchable one is a part.
    drawn_skin: Option<Drawn>,
    /// Nodes and elements of the simulated hardware's own mesh, where it has one.
    rig_mesh: Option<[usize; 2]>,
    /// A calibration is in use, and it is of this limb and its gauges.
    is_calibrated: bool,
    /// What strains the limb beside contacts, in words.
    loads: Option<String>,
}

/// What the page draws beside what can be touched.
#[derive(Serialize)]
struct Drawn {
    n_vertices: usize,
    n_beside_touchable: usize,
    /// How far the touchable skin is off it, m, and where.
    farthest_m: f64,
    farthest_at_m: [f64; 3],
}

impl Checked {
    fn of_limb(run: &Run, limb: &Limb) -> Self {
        Self {
            scene: run.scene.name.clone(),
            n_fe_nodes: limb.mesh.nodes().len(),
            n_elements: limb.mesh.elements().len(),
            n_surface_nodes: limb.n_surface_nodes(),
            n_clamped_nodes: limb.clamped.len(),
            n_gauges: limb.gauges.len(),
            solved_as: limb.wall.as_ref().map(ToString::to_string),
            deck_notes: limb.deck_notes.clone(),
            drawn_skin: None,
            rig_mesh: None,
            is_calibrated: false,
            loads: None,
        }
    }

    /// The drawn skin, the rig's mesh, the calibration and the loads.
    fn look_further(&mut self, run: &Run, limb: &Limb) -> Result<()> {
        self.drawn_skin = drawn(run, limb)?;
        self.rig_mesh = check_rig_mesh(run, limb)?;
        self.is_calibrated = calibration_in_use(run, limb)?.is_some();
        self.loads = loads_in_words(run)?;
        Ok(())
    }

    fn print_limb(&self) {
        println!(
            "{}: {} FE nodes, {} elements, {} surface nodes, {} clamped nodes, {} gauges",
            self.scene,
            self.n_fe_nodes,
            self.n_elements,
            self.n_surface_nodes,
            self.n_clamped_nodes,
            self.n_gauges,
        );
        self.solved_as.iter().for_each(|wall| println!("solved as {wall}"));
        self.deck_notes.iter().for_each(|note| println!("deck: {}", printable(note)));
    }

    fn print_rest(&self) {
        match &self.drawn_skin {
            None => println!("drawn skin: the limb's own, of which the touchable skin is a part"),
            Some(drawn) => drawn.print(),
        }
        if let Some([n_nodes, n_elements]) = self.rig_mesh {
            println!("simulated hardware: {n_nodes} FE nodes, {n_elements} elements of its own");
        }
        if self.is_calibrated {
            println!("calibration: of this limb and its gauges");
        }
        self.loads.iter().for_each(|loads| println!("loads: {loads}"));
    }
}

impl Drawn {
    fn print(&self) {
        println!(
            "drawn skin: {} vertices, {} of them beside the touchable skin",
            self.n_vertices, self.n_beside_touchable
        );
        let [x, y, z] = self.farthest_at_m.map(|v| v * 1e3);
        println!(
            "the touchable skin is at most {:.1} mm off the drawn one, at ({x:.0}, {y:.0}, {z:.0}) mm",
            self.farthest_m * 1e3
        );
    }
}

/// How far what the page draws is off what can be touched.
fn drawn(run: &Run, limb: &Limb) -> Result<Option<Drawn>> {
    let Some(drawn) = DrawnSkin::load(&run.scene, &run.scene_dir, limb)? else {
        return Ok(None);
    };
    let (farthest_m, at) = drawn.farthest(limb)?;
    Ok(Some(Drawn {
        n_vertices: drawn.vertices_m.len(),
        n_beside_touchable: drawn.moves_with.len(),
        farthest_m,
        farthest_at_m: at.coords.into(),
    }))
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
