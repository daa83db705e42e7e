//! The paper authors' limb against ANSYS's printout and CalculiX's displacements.

use std::rc::Rc;

use hapdef_mesh::read_displacements;

use super::prelude::*;
use crate::deck::{DeckMetrics, DeckResults, SKIN, WEIGHT, largest_difference};
use crate::memo::Memo;
use crate::shared;

const ANSYS: &str =
    "ANSYS 18.2's printout of the authors' run (2019), as recorded for this project";
const CALCULIX: &str = "CalculiX 2.20 on the same deck, as recorded for this project";

/// A deck, its known metrics, and what its rows compare.
type Deck = (&'static str, DeckMetrics, &'static str);

const SKIN_DECK: Deck = ("02_skin_ds.dat.gz", SKIN, "skin deck");
const WEIGHT_DECK: Deck = ("01_weight_ds.dat.gz", WEIGHT, "weight deck, tractions on curved faces");

/// Name, what is compared, unit, the metric, and the relative error allowed.
type Row = (&'static str, &'static str, &'static str, fn(&DeckMetrics) -> Option<f64>, f64);

/// The rows of a deck, by the source of their references.
const ROWS: [(Deck, &str, &[Row]); 3] = [
    (
        SKIN_DECK,
        ANSYS,
        &[
            ("limb.ke_max", LARGEST_KE, "N/m", |m| m.ke_max_n_m, 1e-9),
            ("limb.ke_min", SMALLEST_KE, "N/m", |m| m.ke_min_n_m, 1e-8),
            ("limb.mass", "Authors' limb, mass", "kg", |m| m.mass_kg, 2e-6),
        ],
    ),
    (
        SKIN_DECK,
        CALCULIX,
        &[
            ("limb.energy", SKIN_ENERGY, "J", |m| m.energy_j, 1e-6),
            ("limb.u", SKIN_U, "m", |m| m.largest_u_m, 1e-6),
        ],
    ),
    (
        WEIGHT_DECK,
        CALCULIX,
        &[
            ("limb.weight_u", WEIGHT_U, "m", |m| m.largest_u_m, 1e-5),
            ("limb.weight_energy", WEIGHT_ENERGY, "J", |m| m.energy_j, 1e-5),
        ],
    ),
];

const LARGEST_KE: &str = "Authors' limb, largest element stiffness";
const SMALLEST_KE: &str = "Authors' limb, smallest element stiffness";
const SKIN_ENERGY: &str = "Authors' limb, strain energy under (10, 0, −15) N";
const SKIN_U: &str = "Authors' limb, largest displacement under (10, 0, −15) N";
const WEIGHT_U: &str = "Authors' limb, largest displacement under the 360 N weight";
const WEIGHT_ENERGY: &str = "Authors' limb, strain energy under the 360 N weight";

/// Rows of the table.
pub(super) fn cases() -> Vec<Case> {
    let decks = Rc::new(Memo::default());
    let case = |deck: Deck, source, &(name, title, unit, metric, rel_err): &Row| {
        let decks = Rc::clone(&decks);
        Case {
            name,
            title,
            quantity: deck.2,
            unit,
            reference: Reference::Published(metric(&deck.1).unwrap_or(f64::NAN)),
            source,
            target: Target::within(rel_err),
            solve: Solve::by(move |_, _| {
                let solved = decks.get(deck.0, || solved(deck.0))?;
                let value = metric(&solved.0.metrics).unwrap_or(f64::NAN);
                Ok(Measured { value, ..solved.1.clone() })
            }),
            ..Case::default()
        }
    };
    let rows = ROWS
        .iter()
        .flat_map(|(deck, source, rows)| rows.iter().map(|row| case(*deck, source, row)));
    let mut cases: Vec<Case> = rows.collect();
    let every_node = Case {
        name: "limb.every_node",
        title: "Authors' limb, displacement at every node",
        quantity: "largest difference / largest displacement, skin deck",
        source: CALCULIX,
        target: Target::within(1e-5),
        solve: Solve::by(move |_, _| {
            let solved = decks.get(SKIN_DECK.0, || self::solved(SKIN_DECK.0))?;
            let reference = read_displacements(&shared("hapdef-shin/ccx_shin_node2984.dat.gz")?)?;
            let value = largest_difference(solved.0.displacement_m.iter().copied(), &reference)?;
            Ok(Measured { value, ..solved.1.clone() })
        }),
        ..Case::default()
    };
    cases.insert(5, every_node);
    cases
}

/// What a deck gives, and the sizes of its mesh.
fn solved(file: &str) -> Result<(DeckResults, Measured), VerifyError> {
    let (deck, results) = DeckResults::of(&shared(&format!("hapdef-shin/{file}"))?)?;
    let sizes = Measured {
        value: f64::NAN,
        mesh: "the authors' own mesh".to_owned(),
        n_nodes: deck.mesh.nodes().len(),
        n_equations: results.n_equations,
        h: 1.0,
    };
    Ok((results, sizes))
}
