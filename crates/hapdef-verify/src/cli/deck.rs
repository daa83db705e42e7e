//! `hapdef-verify deck`: one deck against what another program printed for it.

use std::path::PathBuf;

use anyhow::Result;
use hapdef_report::{MetricContext, MetricLog};
use hapdef_verify::{DeckResults, KnownResults, read_displacements};

use super::context::MetricsArgs;

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
    /// The seed the metrics carry; nothing is drawn at random.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    #[command(flatten)]
    output: MetricsArgs,
}

/// Solves the deck and prints its results beside those that are known.
pub(crate) fn run(args: &DeckArgs) -> Result<()> {
    let (_, results) = DeckResults::of(&args.deck)?;
    let known = KnownResults::of(&args.deck)?;
    let mut log = MetricLog::new(std::io::stdout(), MetricContext::here(args.seed));
    let mass = results.mass_kg.unwrap_or(f64::NAN);
    println!("equations  {}", results.n_equations);
    for (name, what, value, unit, known) in [
        (
            "deck.ke_max_rel_err",
            "largest element stiffness",
            results.ke_max_n_m,
            "N/m",
            args.ke_max.or(known.ke_max_n_m),
        ),
        (
            "deck.ke_min_rel_err",
            "smallest element stiffness",
            results.ke_min_n_m,
            "N/m",
            args.ke_min.or(known.ke_min_n_m),
        ),
        ("deck.mass_rel_err", "mass", mass, "kg", args.mass.or(known.mass_kg)),
        (
            "deck.energy_rel_err",
            "strain energy",
            results.energy_j,
            "J",
            args.energy.or(known.energy_j),
        ),
    ] {
        println!("{what}  {value:.9e} {unit}");
        match known {
            _ if value.is_nan() => log.skipped(name, "the deck states no density")?,
            Some(known) => log.value(name, (value - known).abs() / known.abs(), "1")?,
            None => log.skipped(name, "no reference is known for this deck")?,
        }
    }
    println!("largest |u|  {:.9e} m", results.largest_u_m);
    displacement(args, &results, &known, &mut log)?;
    log.append_to(&args.output.metrics)?;
    Ok(())
}

/// At every node where a reference is given, else the largest.
fn displacement(
    args: &DeckArgs,
    results: &DeckResults,
    known: &KnownResults,
    log: &mut MetricLog<std::io::Stdout>,
) -> Result<()> {
    let name = "deck.u_rel_err";
    match (&args.reference, known.largest_u_m) {
        (Some(_), _) if results.largest_u_m == 0.0 => log.skipped(name, "the deck has no load")?,
        (Some(path), _) => {
            let difference = results.difference(&read_displacements(path)?)?;
            log.value(name, difference, "1")?;
        }
        (None, Some(u)) => log.value(name, (results.largest_u_m - u).abs() / u, "1")?,
        (None, None) => {
            log.skipped(name, "no reference is known for this deck; give --reference")?;
        }
    }
    Ok(())
}
