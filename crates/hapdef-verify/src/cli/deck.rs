//! `hapdef-verify deck`: one deck against what another program printed for it.

use std::path::PathBuf;

use anyhow::Result;
use hapdef_mesh::read_displacements;

use super::context::MetricsArgs;
use crate::deck::{DeckMetrics, DeckResults, largest_difference};

/// Arguments of `deck`.
#[derive(clap::Args)]
pub(crate) struct DeckArgs {
    /// The deck (.inp, .dat, .cdb, plain or .gz).
    deck: PathBuf,
    /// Displacements of the deck's load as CalculiX prints them (.dat, plain or .gz).
    #[arg(long)]
    reference: Option<PathBuf>,
    /// Known largest element-stiffness coefficient, N/m.
    #[arg(long)]
    ke_max: Option<f64>,
    /// Known smallest element-stiffness coefficient, N/m.
    #[arg(long)]
    ke_min: Option<f64>,
    /// Known mass, kg.
    #[arg(long)]
    mass: Option<f64>,
    /// Known strain energy, J.
    #[arg(long)]
    energy: Option<f64>,
    #[command(flatten)]
    output: MetricsArgs,
}

/// Metric, what it is, unit, and its value.
type Line = (&'static str, &'static str, &'static str, fn(&DeckMetrics) -> Option<f64>);

const LINES: [Line; 4] = [
    ("deck.ke_max_rel_err", "largest element stiffness", "N/m", |m| m.ke_max_n_m),
    ("deck.ke_min_rel_err", "smallest element stiffness", "N/m", |m| m.ke_min_n_m),
    ("deck.mass_rel_err", "mass", "kg", |m| m.mass_kg),
    ("deck.energy_rel_err", "strain energy", "J", |m| m.energy_j),
];

const UNKNOWN: &str = "no reference is known for this deck";

/// Solves the deck and prints its results beside those that are known.
pub(crate) fn run(args: &DeckArgs) -> Result<()> {
    let (_, results) = DeckResults::of(&args.deck)?;
    let found = DeckMetrics::known(&args.deck)?;
    let known = DeckMetrics {
        ke_max_n_m: args.ke_max.or(found.ke_max_n_m),
        ke_min_n_m: args.ke_min.or(found.ke_min_n_m),
        mass_kg: args.mass.or(found.mass_kg),
        energy_j: args.energy.or(found.energy_j),
        ..found
    };
    let mut log = args.output.log();
    println!("equations  {}", results.n_equations);
    for (name, what, unit, of) in LINES {
        let value = of(&results.metrics);
        println!("{what}  {:.9e} {unit}", value.unwrap_or(f64::NAN));
        match (value, of(&known)) {
            (None, _) => log.skipped(name, "the deck states no density")?,
            (_, None) => log.skipped(name, UNKNOWN)?,
            (Some(value), Some(known)) => {
                log.value(name, (value - known).abs() / known.abs(), "1")?;
            }
        }
    }
    let largest_u_m = results.metrics.largest_u_m.unwrap_or(0.0);
    println!("largest |u|  {largest_u_m:.9e} m");
    // at every node where a reference is given, else the largest
    let name = "deck.u_rel_err";
    match (&args.reference, known.largest_u_m) {
        (Some(_), _) if largest_u_m == 0.0 => log.skipped(name, "the deck has no load")?,
        (Some(path), _) => {
            let reference = read_displacements(path)?;
            log.value(name, largest_difference(results.displacement_m, &reference)?, "1")?;
        }
        (None, Some(u)) => log.value(name, (largest_u_m - u).abs() / u, "1")?,
        (None, None) => log.skipped(name, &format!("{UNKNOWN}; give --reference"))?,
    }
    log.append_to(&args.output.metrics)?;
    Ok(())
}
