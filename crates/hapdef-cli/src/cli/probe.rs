//! `hapdef probe`: presses of known places and forces on the scene's simulated rig.

use std::fmt::Write as _;
use std::path::PathBuf;

use anyhow::{Context, Result, ensure};
use clap::Args;
use clap::builder::RangedU64ValueParser;
use hapdef::{Limb, live_limb};
use hapdef_cli::{SceneArgs, shown};
use hapdef_rig::live::LiveLimb;
use hapdef_rig::{Electronics, ElectronicsParams};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Least force of a press on the simulated rig, N: less says little.
const LEAST_N: f64 = 2.0;

/// Draws after which contacts may be nearer than the scene's spacing: a skin too small for it has none.
const N_DRAWS: usize = 100;

#[derive(Args)]
#[command(after_help = "Example:\n  \
    hapdef probe fixtures/shin/placed.json presses.csv --presses 300\n\n\
    Simulated: the scene's rig is pressed, not hardware. Columns: x_m, y_m, z_m, force_n of each contact, \
    then the tared reading of each gauge in µε.")]
pub(crate) struct ProbeArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// The table to write.
    table: PathBuf,
    /// Number of presses.
    #[arg(long, default_value_t = 300)]
    presses: usize,
    /// Places pressed at a time, as far apart as the scene's contacts are; a calibration takes one.
    #[arg(long, default_value_t = 1, value_parser = RangedU64ValueParser::<usize>::new().range(1..=8))]
    contacts: usize,
    /// Seed of places and forces.
    #[arg(long, default_value_t = 1)]
    press_seed: u64,
}

/// A contact of a press: the surface node and the force, N.
type Contact = (usize, f64);

/// Presses the scene's simulated rig and writes the table.
pub(crate) fn run(args: &ProbeArgs) -> Result<()> {
    let run = args.scene.prepare()?;
    let limb = Limb::load(&run.scene, &run.scene_dir)?;
    let rig = Rig { real: live_limb(&run, &limb)?, limb: &limb };
    let contact = &run.scene.contact;
    let [low, high] = contact.force_range_n;
    ensure!(low.max(LEAST_N) < high, "contact.force_range_n: expected a force above {LEAST_N} N");
    let presses = drawn(args, &limb, [low.max(LEAST_N), high], contact.min_spacing_m);
    let own = run.scene.rig.electronics.params();
    let params = ElectronicsParams { seed: own.seed.wrapping_add(args.press_seed), ..own };
    let mut electronics = Electronics::new(params, &rig.largest_ue(&presses, high))?;
    let mut text = header(args.contacts, limb.gauges.len());
    let points = limb.surface_points();
    for press in presses {
        let mut readings = rig.readings_ue(&press);
        electronics.measure(&mut readings);
        let of = |(node, force_n): &Contact| {
            let x = points[*node];
            [x.x, x.y, x.z, *force_n]
        };
        let numbers = press.iter().flat_map(of).chain(readings);
        let words: Vec<String> = numbers.map(|v| v.to_string()).collect();
        writeln!(text, "{}", words.join(","))?;
    }
    std::fs::write(&args.table, text).with_context(|| format!("writing {}", shown(&args.table)))?;
    println!("{} simulated presses: {}", args.presses, shown(&args.table));
    Ok(())
}

/// The presses, each of some contacts at least `spacing_m` apart where draws find such.
fn drawn(args: &ProbeArgs, limb: &Limb, range_n: [f64; 2], spacing_m: f64) -> Vec<Vec<Contact>> {
    let mut rng = ChaCha8Rng::seed_from_u64(args.press_seed);
    let points = limb.surface_points();
    let mut press = |_| {
        let mut contacts: Vec<Contact> = Vec::with_capacity(args.contacts);
        while contacts.len() < args.contacts {
            let is_far = |node: usize| {
                contacts
                    .iter()
                    .all(|(other, _)| (points[node] - points[*other]).norm() >= spacing_m)
            };
            let mut node = rng.random_range(0..points.len());
            for _ in 0..N_DRAWS {
                if is_far(node) {
                    break;
                }
                node = rng.random_range(0..points.len());
            }
            contacts.push((node, rng.random_range(range_n[0]..=range_n[1])));
        }
        contacts
    };
    (0..args.presses).map(&mut press).collect()
}

/// What is pressed.
struct Rig<'a> {
    real: LiveLimb,
    limb: &'a Limb,
}

impl Rig<'_> {
    /// Readings per newton against the skin at a node `[n_gauges]`, µε/N.
    fn unit_ue_per_n(&self, node: usize) -> Vec<f64> {
        let n_gauges = self.limb.gauges.len();
        let columns = &self.real.columns_ue_per_n()[node * n_gauges..][..n_gauges];
        columns.iter().map(|c| c.dot(&self.limb.directions[node])).collect()
    }

    /// Readings of a press without noise `[n_gauges]`, µε.
    fn readings_ue(&self, press: &[Contact]) -> Vec<f64> {
        let mut sum = vec![0.0; self.limb.gauges.len()];
        for &(node, force_n) in press {
            let unit = self.unit_ue_per_n(node);
            sum.iter_mut().zip(unit).for_each(|(sum, unit)| *sum += force_n * unit);
        }
        sum
    }

    /// The largest reading of each gauge by a single contact of `most_n` `[n_gauges]`, µε.
    fn largest_ue(&self, presses: &[Vec<Contact>], most_n: f64) -> Vec<f64> {
        let mut largest = vec![0.0_f64; self.limb.gauges.len()];
        for (node, _) in presses.iter().flatten() {
            let unit = self.unit_ue_per_n(*node);
            largest.iter_mut().zip(unit).for_each(|(most, unit)| *most = most.max(unit.abs()));
        }
        largest.iter().map(|unit| unit * most_n).collect()
    }
}

fn header(n_contacts: usize, n_gauges: usize) -> String {
    let contact = |i: usize| match i {
        0 => "x_m,y_m,z_m,force_n".to_owned(),
        _ => format!("x{0}_m,y{0}_m,z{0}_m,force{0}_n", i + 1),
    };
    let contacts = (0..n_contacts).map(contact);
    let names: Vec<String> = contacts.chain((0..n_gauges).map(|g| format!("g{g}_ue"))).collect();
    names.join(",") + "\n"
}
