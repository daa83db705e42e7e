//! The paper authors' limb against ANSYS's printout and CalculiX's displacements.

use std::rc::Rc;

use crate::case::{Case, Solve};
use crate::deck::{DeckMetrics, DeckResults, SKIN, WEIGHT, largest_difference, read_displacements};
use crate::memo::Memo;
use crate::{Measured, Reference, Target, VerifyError, shared};

const ANSYS: &str =
    "ANSYS 18.2's printout of the authors' run (2019), as recorded for this project";
const CALCULIX: &str = "CalculiX 2.20 on the same deck, as recorded for this project";

/// A deck, its known metrics, and what its rows compare.
type Deck = (&'static str, DeckMetrics, &'static str);

const SKIN_DECK: Deck = ("02_skin_ds.dat.gz", SKIN, "skin deck");
const WEIGHT_DECK: Deck = ("01_weight_ds.dat.gz", WEIGHT, "weight deck, tractions on curved faces");

/// Deck, name, title, unit, the metric, source, and the relative error allowed.
type Row = (
    Deck,
    &'static str,
    &'static str,
    &'static str,
    fn(&DeckMetrics) -> Option<f64>,
    &'static str,
    f64,
);

const ROWS: [Row; 7] = [
    (
        SKIN_DECK,
        "limb.ke_max",
        "Authors' limb, largest element stiffness",
        "N/m",
        |m| m.ke_max_n_m,
        ANSYS,
        1e-9,
    ),
    (
        SKIN_DECK,
        "limb.ke_min",
        "Authors' limb, smallest element stiffness",
        "N/m",
        |m| m.ke_min_n_m,
        ANSYS,
        1e-8,
    ),
    (SKIN_DECK, "limb.mass", "Authors' limb, mass", "kg", |m| m.mass_kg, ANSYS, 2e-6),
    (
        SKIN_DECK,
        "limb.energy",
        "Authors' limb, strain energy under (10, 0, −15) N",
        "J",
        |m| m.energy_j,
        CALCULIX,
        1e-6,
    ),
    (
        SKIN_DECK,
        "limb.u",
        "Authors' limb, largest displacement under (10, 0, −15) N",
        "m",
        |m| m.largest_u_m,
        CALCULIX,
        1e-6,
    ),
    (
        WEIGHT_DECK,
        "limb.weight_u",
        "Authors' limb, largest displacement under the 360 N weight",
        "m",
        |m| m.largest_u_m,
        CALCULIX,
        1e-5,
    ),
    (
        WEIGHT_DECK,
        "limb.weight_energy",
        "Authors' limb, strain energy under the 360 N weight",
        "J",
        |m| m.energy_j,
        CALCULIX,
        1e-5,
    ),
];

/// Rows of the table.
pub(super) fn cases() -> Vec<Case> {
    let decks = Rc::new(Memo::default());
    let row = |(deck, name, title, unit, metric, source, rel_err): Row| {
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
    let mut cases: Vec<Case> = ROWS.map(row).into();
    let every_node = Case {
        name: "limb.every_node",
        title: "Authors' limb, displacement at every node",
        quantity: "largest difference / largest displacement, skin deck",
        source: CALCULIX,
        target: Target::within(1e-5),
        solve: Solve::by(move |_, _| {
            let solved = decks.get(SKIN_DECK.0, || self::solved(SKIN_DECK.0))?;
            let reference = read_displacements(&shared("hapdef-shin/ccx_shin_node2984.dat.gz")?)?;
            let value = largest_difference(&solved.0.displacement_m, &reference)?;
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
